"""Where files named inside a scenario are looked for, and how a model asks for their numbers."""

from __future__ import annotations

import importlib
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from typing import TYPE_CHECKING

from pydantic_core import PydanticCustomError

from electrovib.core.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    import numpy as np
    from numpy.typing import NDArray

_folder: ContextVar[Path] = ContextVar("folder", default=Path())
_inputs: ContextVar[list[Path] | None] = ContextVar("inputs", default=None)


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


@contextmanager
def relative_to(folder: Path) -> Iterator[None]:
    """Look for relative file names in this folder while a scenario is being read."""
    token = _folder.set(folder)
    try:
        yield
    finally:
        _folder.reset(token)


def read_columns(name: str, wanted: Mapping[str, tuple[str | int, str]]) -> dict[str, NDArray[np.float64]]:
    """Read named columns of a file for a model.

    Parameters
    ----------
    name : str
        File, relative to the scenario's own folder.
    wanted : mapping
        Parameter name to (column name or number, unit when the heading has none).

    Returns
    -------
    dict of str to array
        SI.

    Raises
    ------
    PydanticCustomError
        So that the message joins the scenario's other mistakes.
    """
    reader = importlib.import_module("electrovib.data.columns")  # found late: models know no files
    note_input(_folder.get() / name)
    try:
        columns: dict[str, NDArray[np.float64]] = reader.read_columns(_folder.get() / name, wanted)
    except InputError as error:
        missing = getattr(error, "column", None)
        raise PydanticCustomError("file", "{why}", {"why": str(error), "missing_column": missing}) from None
    return columns
