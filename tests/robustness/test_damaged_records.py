"""Damaged files of instruments are read or refused in one sentence; longer in benchmarks/damaged_records.py."""

import numpy as np
import pytest
from damaged_records import mutated, read_damaged, whole_files

FILES = whole_files()
GUARDED = (".h5", ".mat")
"""Read in a process of their own, which takes half a second each time."""


@pytest.mark.slow
@pytest.mark.parametrize("name", FILES)
def test_damaged_files_are_read_or_refused(tmp_path, name):
    path = tmp_path / name
    path.write_bytes(FILES[name])
    assert read_damaged(path) == "read"
    for number in range(2 if name.endswith(GUARDED) else 40):
        random = np.random.default_rng([11, number, *name.encode()])
        path.write_bytes(mutated(FILES[name], random))
        assert read_damaged(path) in ("read", "refused")
