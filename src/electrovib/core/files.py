"""Files by the names that a user gives: what stands there, the columns that a model declares, and the list of what is read."""

from __future__ import annotations

import stat
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Final

from electrovib.core.budget import holding

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

UNREAD: Final = "its file is read with a scenario; alone, read it with electrovib.scenario.read_part"
"""Advice of an error where a model names a file that has not been read."""
_inputs: ContextVar[list[Path] | None] = ContextVar("inputs", default=None)


@dataclass(frozen=True)
class FileColumn:
    """A column of a file that a model needs: declared by the model, read together with the scenario.

    `name` is the heading, or the number of the column from 0; `unit` holds where the file states none;
    `otherwise` says what the user can do if there is no such column.
    """

    name: str | int
    unit: str
    otherwise: str = ""


class DeclaresFile:
    """Declarations of a class whose parameters can be read from the ``file`` that its table names."""

    unit_of_columns: ClassVar[str] = ""
    """Parameter with the unit of the columns that have none of their own."""

    @classmethod
    def file_columns(cls, table: Mapping[str, Any]) -> Mapping[str, FileColumn]:
        """Return the columns of the file from which parameters are read: ``x_samples`` from ``x_column`` in ``x_unit``.

        Parameters
        ----------
        table : mapping
            Table of the model, not yet validated.

        Returns
        -------
        mapping of str to FileColumn
            Parameter to column; empty if nothing has to be read, or if the table is wrong, which its validation reports.
        """
        from electrovib.core.quantity import takes_unit

        fields: Mapping[str, Any] = getattr(cls, "model_fields", {})
        given = {name: field.default for name, field in fields.items()} | dict(table)
        samples = [name for name in fields if name.removesuffix("_samples") + "_column" in fields]
        if not given.get("file") or not samples or any(name in table for name in samples):
            return {}
        found = {}
        for name in samples:
            column, unit = (name.replace("_samples", end) for end in ("_column", "_unit"))
            unit = unit if unit in fields else cls.unit_of_columns
            if given[column] is None and fields[column].default is None:
                continue
            if not isinstance(given[column], str | int) or (
                unit and not takes_unit(fields[unit], given[unit])
            ):
                return {}
            found[name] = FileColumn(given[column], given[unit] if unit else "1")
        return found

    @classmethod
    def file_variants(cls, table: Mapping[str, Any]) -> tuple[Mapping[str, Any], ...]:
        """Return parameters with which to read the file of a table if it has not the columns of `file_columns`.

        Parameters
        ----------
        table : mapping
            Table of the model, not yet validated.

        Returns
        -------
        parameters : tuple of mapping
            The first whose columns are in the file is added to the table.
        """
        del table
        return ()


def kind_of(path: str | Path) -> str:
    """Return what stands at a path: ``"file"``, ``"folder"`` or ``"other"``; empty for nothing, as under too long a name."""
    try:
        mode = Path(path).stat().st_mode
    except (OSError, ValueError):
        return ""
    return "folder" if stat.S_ISDIR(mode) else "file" if stat.S_ISREG(mode) else "other"


@contextmanager
def inputs_noted() -> Iterator[list[Path]]:
    """Collect the files that are read in the block, so that no output replaces one of them."""
    found: list[Path] = []
    with holding(_inputs, found):
        yield found


def note_input(path: Path) -> None:
    """Add a file to the list of `inputs_noted`."""
    found = _inputs.get()
    if found is not None:
        found.append(path)
