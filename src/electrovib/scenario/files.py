"""Numbers of the files that a scenario names: read together with the scenario, never by a model."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeVar

from electrovib.core.errors import DataFileError, InputError, NoColumnError, Problem
from electrovib.core.files import note_input
from electrovib.core.mistakes import shown
from electrovib.core.model import Model, read_model
from electrovib.data.registry import read_columns

M = TypeVar("M", bound=Model)


def read_part(kind: type[M], content: object, *, folder: Path | None = None) -> M:
    """Build a scenario, or a part of one, from tables and the files that they name, and list every mistake at once."""
    faults: list[Problem] = []
    filled = _filled(kind, content, folder or Path(), "", faults)
    try:
        built = read_model(kind, filled)
    except InputError as error:
        unread = {fault.path for fault in faults}  # such a model complains that it has no numbers
        raise InputError([*faults, *(each for each in error.problems if each.path not in unread)]) from None
    if faults:
        raise InputError(faults)
    return built


def _filled(kind: type[Model] | None, content: Any, folder: Path, path: str, faults: list[Problem]) -> Any:
    """Copy tables and add the numbers of their files; tables that name no known model are left to validation."""
    start = f"{path}." if path else ""
    if isinstance(content, (list, tuple)) and any(isinstance(item, Mapping) for item in content):
        return [_filled(kind, item, folder, f"{start}{index}", faults) for index, item in enumerate(content)]
    model = kind.chosen(content) if kind is not None and isinstance(content, Mapping) else None
    if model is None:
        return content
    table = {
        name: _filled(model.part(str(name)), item, folder, f"{start}{name}", faults)
        for name, item in content.items()
    }
    if model.file_columns(table):
        try:
            table |= _read(folder / str(table["file"]), model, table)
        except DataFileError as error:
            value = shown({"model": model.__name__, **table})
            faults += [Problem(str(each), path=path, value=value) for each in error.problems]
    return table


def _read(file: Path, model: type[Model], table: Mapping[str, Any]) -> dict[str, Any]:
    """Read the columns of a model's file, in the first form in which it has them."""
    note_input(file)
    missing: list[DataFileError] = []
    for variant in ({}, *model.file_variants(table)):
        columns = model.file_columns({**table, **variant})
        asked = {name: (each.name, each.unit) for name, each in columns.items()}
        try:
            return {**variant, **read_columns(file, asked)}
        except NoColumnError as error:
            more = "".join(each.otherwise for each in columns.values() if each.name == error.column)
            more = more or _how_to_name(model, table, error.column, file)
            missing.append(DataFileError(problem.followed_by(more) for problem in error.problems))
    raise missing[0]


def _how_to_name(model: type[Model], table: Mapping[str, Any], column: str, file: Path) -> str:
    """Name the parameter that chooses a column, and the command that reads what an instrument writes around a table."""
    defaults = {name: field.default for name, field in model.model_fields.items() if name.endswith("_column")}
    key = next((name for name, default in defaults.items() if table.get(name, default) == column), "")
    if not key:
        return ""
    if file.suffix.lower() in (".nc", ".mat"):
        return f' Name another by {key} = "...".'
    return (
        f" Name another by {key} = \"...\"; if these are not the headings, 'electrovib import {file.name}' reads what an"
        " instrument writes above them."
    )
