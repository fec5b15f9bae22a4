"""What a scenario takes by name: numbers of files, and materials and stacks of the library or of a paper."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeVar

from electrovib.core.discovery import offers, paper
from electrovib.core.errors import DataFileError, InputError, NoColumnError, NoHeadingsError, Problem
from electrovib.core.files import note_input
from electrovib.core.mistakes import shown
from electrovib.core.model import Model, read_model
from electrovib.core.tables import Changed
from electrovib.physics.material.library import Substance
from electrovib.physics.skin import Skin
from electrovib.scenario.sources import is_default

M = TypeVar("M", bound=Model)


def read_part(kind: type[M], content: object, *, folder: Path | None = None) -> M:
    """Build a scenario, or a part of one, from tables and the files that they name, and list every mistake at once."""
    opened, faults = Changed(), list[Problem]()
    tables = opened.opened(kind, content, "")
    if opened.offers and "sources" in kind.model_fields and isinstance(tables.get("sources", {}), dict):
        tables["sources"] = sources_of_offers(opened) | tables.get("sources", {})
    for path, model, table in opened.unread:
        try:
            table.update(_read((folder or Path()) / str(table["file"]), model, table))
        except DataFileError as error:
            value = shown({"model": model.__name__, **table})
            faults += [Problem(str(each), path=path, value=value) for each in error.problems]
    try:
        built = read_model(kind, tables)
    except InputError as error:
        unread = {fault.path for fault in faults}  # such a model complains that it has no numbers
        raise InputError([*faults, *(each for each in error.problems if each.path not in unread)]) from None
    if faults:
        raise InputError(faults)
    return built


def _read(file: Path, model: type[Model], table: Mapping[str, Any]) -> dict[str, Any]:
    """Read the columns of a model's file, in the first form in which it has them."""
    from electrovib.data.registry import read_columns

    note_input(file)
    missing: list[DataFileError] = []
    for variant in ({}, *model.file_variants(table)):
        columns = model.file_columns({**table, **variant})
        asked = {name: (each.name, each.unit) for name, each in columns.items()}
        try:
            return {**variant, **read_columns(file, asked)}
        except NoColumnError as error:
            more = "".join(each.otherwise for each in columns.values() if each.name == error.column)
            more = more or _how_to_name(model, table, error, file)
            missing.append(DataFileError(problem.followed_by(more) for problem in error.problems))
    raise missing[0]


def _how_to_name(model: type[Model], table: Mapping[str, Any], error: NoColumnError, file: Path) -> str:
    """Name the parameter that chooses a column, and the command that reads what an instrument writes around a table."""
    defaults = {name: field.default for name, field in model.model_fields.items() if name.endswith("_column")}
    key = next((name for name, default in defaults.items() if table.get(name, default) == error.column), "")
    if not key:
        return ""
    if isinstance(error, NoHeadingsError):
        numbers = ", ".join(f"{name} = {number}" for number, name in enumerate(defaults))
        return f" In the table of the model: {numbers}."
    if file.suffix.lower() in (".nc", ".mat"):
        return f' Name another by {key} = "...".'
    return (
        f" Name another by {key} = \"...\"; if these are not the headings, 'electrovib import {file.name}' reads what an"
        " instrument writes above them."
    )


def skins() -> dict[str, Skin]:
    """Collect the skins that papers publish, by the ``author_year/name`` that a scenario may give in place of a material."""
    return offers(("skins",))


def sources_of_offers(changed: Changed) -> dict[str, str]:
    """Return the source of each value that was given by the name of a material or a stack, unless it was given anew as well."""
    found: dict[str, str] = {}
    for path, (kind, name) in changed.offers.items():
        anew = [each.removesuffix(".model") for each in changed.stored if each.startswith(f"{path}.")]
        stated = sources_of_offer(path, kind, name)
        found |= {
            where: text
            for where, text in stated.items()
            if not f"{where}.".startswith(tuple(f"{each}." for each in anew))
        }
    return found


def sources_of_offer(path: str, kind: type[Model], name: str) -> dict[str, str]:
    """Return the name, the source and its status for each parameter that something ready-made gives in the place of a table.

    The breakdown strengths of a material of the library stand under the path of ``substance``.
    """
    offer, found = kind.offer(name), dict[str, str]()
    model = kind.from_offer(offer)
    for inner, number, _ in model.parameters():
        if number is not None and not is_default(model, inner, number):
            found[f"{path}.{inner}"] = f"{name}: {_source(offer, name, path, inner)}"
    if isinstance(offer, Substance) and offer.strengths:
        found[f"{path}.substance"] = f"{name}: {offer.strength_words}"
    return found


def _source(offer: Any, name: str, path: str, inner: str) -> str:
    """Return the source of a value of an offer, and its status."""
    if isinstance(offer, Skin):
        return f"{offer.source} ({offer.status}; {offer.note})"
    if isinstance(offer, Substance):
        return offer.origin(inner)[0]
    module = paper(name.partition("/")[0])
    own: str | None = getattr(offer, "sources", {}).get(f"{path}.{inner}")
    return own or f"{module.CITATION} ({module.STATUS})"
