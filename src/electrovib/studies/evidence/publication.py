"""Several measurements in one file, and those of all publications: ``measured/NAME.toml`` in a folder of papers."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from electrovib.core.discovery import paper_folders
from electrovib.core.errors import InputError, gathered, nearest, refuse
from electrovib.core.mistakes import shown
from electrovib.core.parsing import read_toml_file

FOLDER = "measured"
_OF_FILE = ("schema", "shared", "measurements")


@functools.cache
def publication_files() -> dict[str, Path]:
    """Return the files of all publications by name, those of electrovib and those of other packages."""
    found = [file for folder in paper_folders() for file in sorted((folder / FOLDER).glob("*.toml"))]
    return {file.stem: file for file in reversed(found)}


@functools.cache
def tables_of(name: str) -> Mapping[str, Any]:
    """Read the file of a publication."""
    files = publication_files()
    if name not in files:
        raise InputError(f"no file of measurements is called '{name}'.{nearest(name, files)}")
    return read_toml_file(files[name], kind="a measurement", advice="Name a TOML file.")


def parts(content: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """Return the entries of each measurement of a file by name, with those that it shares; of one alone under ``""``."""
    common = {name: each for name, each in content.items() if name not in _OF_FILE}
    several = _table("measurements", content.get("measurements", {"": {}}))
    if not several:
        raise InputError(
            "empty; it has a table for each measurement, such as [measurements.pen]", path="measurements"
        )
    found = {}
    problems: list[str] = []
    for name, own in several.items():
        with gathered(problems, within=f"measurements.{name}" if name else ""):
            found[name] = {"schema": content.get("schema")} | _whole(common, own, content)
    refuse(problems)
    return found


def _whole(common: Mapping[str, Any], own: Any, content: Mapping[str, Any]) -> dict[str, Any]:
    """Join what all measurements of a file state, what one of them shares, and what is its own, in this order."""
    found: dict[str, Any] = {}
    own = _table("", own)
    names = [name for table in (common, own) for name in _names(table.get("shares", []))]
    for table in (common, *(_shared(name, content) for name in names), own):
        _join(found, table)
    return found


def _shared(name: str, content: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return entries that are shared, by their name in this file or as author_year/name."""
    publication, _, own = name.rpartition("/")
    known = _table("shared", (tables_of(publication) if publication else content).get("shared", {}))
    if own not in known:
        raise InputError(f"no shared entries are called '{own}'.{nearest(own, known)}", path="shares")
    return _table(f"shared.{own}", known[own])


def _join(found: dict[str, Any], more: Mapping[str, Any]) -> None:
    """Put entries into others: tables are joined key by key, notes follow each other, anything else is replaced."""
    for name, each in more.items():
        held = found.get(name)
        if isinstance(held, dict) and isinstance(each, Mapping):
            found[name] = {key: dict(one) if isinstance(one, dict) else one for key, one in held.items()}
            if name == "of_model":
                _join(found[name], each)
            else:
                found[name] |= each
        elif name == "note" and held:
            found[name] = f"{held} {each}"
        elif name != "shares":
            found[name] = each


def _table(name: str, given: Any) -> Mapping[str, Any]:
    if not isinstance(given, Mapping):
        raise InputError("expected a table", path=name, value=shown(given))
    return given


def _names(given: Any) -> list[str]:
    if not isinstance(given, list) or not all(isinstance(each, str) for each in given):
        raise InputError("expected a list of names", path="shares", value=shown(given))
    return given
