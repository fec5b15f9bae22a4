"""A reader that asks for more than it may have, for the test of the limits."""

from electrovib.apps.explorer.reading import _limit_children_and_files


def contents(path, *, columns, step, title):
    """Take memory or time, or write a file, as the name of the file states."""
    import numpy as np

    _limit_children_and_files(path.parent)
    if path.stem == "memory":
        yield "size", float(np.ones(100_000_000).sum())
    elif path.stem == "file":
        path.with_name("written").write_bytes(b"0")
        yield "size", 1
    while True:
        pass
