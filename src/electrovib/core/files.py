"""Files that are read: what a model declares of a file's columns, and a list of all inputs."""

from __future__ import annotations

from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

UNREAD: Final = "its file is read with a scenario; alone, read it with electrovib.scenario.read_part"
"""What to do about a model that names a file, where nobody has read it."""
_inputs: ContextVar[list[Path] | None] = ContextVar("inputs", default=None)


@dataclass(frozen=True)
class FileColumn:
    """A column of a file that a model needs; the model declares it, and whoever reads a scenario reads it.

    Parameters
    ----------
    name : str or int
        Heading, or number from 0.
    unit : str
        Of its numbers where the file names none.
    otherwise : str
        What can be done if there is no such column.
    """

    name: str | int
    unit: str
    otherwise: str = ""


@contextmanager
def inputs_noted() -> Iterator[list[Path]]:
    """Collect the files that are read in the block, so that no output replaces one of them.

    Yields
    ------
    list of Path
        Grows while files are read.
    """
    found: list[Path] = []
    token = _inputs.set(found)
    try:
        yield found
    finally:
        _inputs.reset(token)


def note_input(path: Path) -> None:
    """Tell `inputs_noted` that a file is read."""
    found = _inputs.get()
    if found is not None:
        found.append(path)
