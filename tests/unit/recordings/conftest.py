"""Makes the synthetic recordings beside the tests importable, and writes tables of columns."""

import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parent))


@pytest.fixture
def table(tmp_path):
    """Write columns below a heading into a file, which has commas between them."""

    def write(heading, *columns, name="a.csv"):
        rows = np.column_stack(columns)
        np.savetxt(tmp_path / name, rows, delimiter=",", header=heading, comments="")
        return tmp_path / name

    return write
