"""Makes the Traces beside the tests importable, and reads HDF5 and MATLAB files without a new interpreter for each."""

import sys
from pathlib import Path

import pytest
from forked import read_forked

from electrovib.data.readers import hdf5, matlab

sys.path.insert(0, str(Path(__file__).parent))


@pytest.fixture(scope="module")
def forked():
    """Read in a forked process, which takes a hundredth of the time of the guarded one; that has tests in test_guarded.py."""
    with pytest.MonkeyPatch.context() as patch:
        for reader in (hdf5, matlab):
            patch.setattr(reader, "read_guarded", read_forked)
        yield
