"""What the file of a measurement, or of a publication with several, may state: a declaration, its JSON schema, and its parts."""

from __future__ import annotations

import functools
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Final, Literal

import numpy as np
import pydantic
from pydantic import BaseModel, ConfigDict, Field, StrictFloat, StrictStr, ValidationError
from pydantic_core import PydanticCustomError

from electrovib.core.discovery import paper_folders
from electrovib.core.errors import InputError, gathered, nearest, refuse
from electrovib.core.mistakes import read_entries, shown
from electrovib.core.parsing import read_toml_file
from electrovib.scenario.toml import SCHEMA
from electrovib.studies.evidence.measurement import BOUNDS, DATA, HOW, SPREADS


def _expected(what: str) -> pydantic.WrapValidator:
    """Say in one sentence what is expected where several types are allowed."""

    def read(value: Any, handler: Any) -> Any:
        try:
            return handler(value)
        except ValidationError:
            raise PydanticCustomError("expected", "expected {what}", {"what": what}) from None

    return pydantic.WrapValidator(read)


Number = Annotated[StrictFloat | StrictStr, _expected("a number in SI, or a text with a unit")]
Several = Annotated[Number | list[Number], _expected("a number, a text with a unit, or one list of them")]
Plain = Annotated[float, _expected("a plain number")]
IN_PLACE_OF_VALUES: Final = ("printed_range", "runs", "devices", "line")
COLUMNS: Final = {"value": "values", "at": "at", "spread": "spread"}
"""Columns of a table of points, to the entries that they become."""
_OF_TABLE: Final = {
    "values": '--column value="force [mN]"',
    "spread": '--column spread="deviation [mN]", or --set spread="10 %"',
    "at": '--column at="voltage [V]"',
}
"""How these are stated where a measurement is made of a table of points."""


class Entries(BaseModel):
    """One measurement: numbers are in SI, or texts with a unit."""

    model_config = ConfigDict(extra="forbid", use_attribute_docstrings=True, title="measurement")

    title: str = Field(examples=["attraction over voltage, one finger"])
    """what was measured"""
    source: str = Field(examples=["our tribometer, March 2026"])
    """where in the publication it stands"""
    group: str = Field(examples=["our laboratory"])
    """the people who measured"""
    scenario: Annotated[str | dict[str, Any], _expected("a scenario of a paper, a file or a table")] = Field(
        examples=["vezzoli_2014/fig6_gap", "my_screen.toml"]
    )
    """set-up: a scenario of a paper, a file or a table"""
    quantity: str = Field(examples=["peak electrostatic_force"])
    """a quantity of a run, or one that is computed"""
    printed_range: list[Number] = []
    """in place of `values`, least and largest: their geometric mean"""
    runs: list[list[Number]] = []
    """in place of `values`, a row for each run: mean and deviation, which is at least `spread`"""
    devices: list[Number] = []
    """in place of `values`, one condition on several devices: geometric mean and deviation"""
    line: list[Number] = []
    """in place of `values`, a fitted straight line over `at`: start, its error, slope, its error, in SI"""
    values: Several = Field([], validate_default=True, examples=[["1.1 mN", "4.2 mN"]])
    """all above 0"""
    spread: Several = Field([], validate_default=True, examples=["10 %"])
    """standard deviation, over the value or in its unit"""
    spread_of: str = Field(examples=[SPREADS[1]], json_schema_extra={"enum": list(SPREADS)})
    """between what it is, or 'a choice'"""
    bound: str = Field("", json_schema_extra={"enum": list(BOUNDS)})
    """of values that bound the quantity from below ('at least') or from above ('at most')"""
    error_of: str = ""
    """the fitted line, figure or table whose errors all numbers share, so that they count as one"""
    same_as: str = ""
    """another measurement of this file that has these values too, which count once"""
    at: Several = Field([], validate_default=True, examples=[["500 V", "1 kV"]])
    """its values"""
    over: str = Field("", validate_default=True, examples=["drive.high"])
    """dotted path of what was varied"""
    how: str = Field(DATA, json_schema_extra={"enum": list(HOW)})
    """how the numbers came here"""
    status: str = "full text"
    """how the publication was read"""
    changes: dict[str, Any] = {}
    """changes of the scenario, by dotted path"""
    per: str = ""
    """second quantity, by which the first is divided"""
    per_changes: dict[str, Any] = {}
    """changes under which the second quantity is computed, or the same where `per` names none"""
    scale: Plain = 1.0
    """factor on the computed quantity"""
    unit: str = Field("", validate_default=True, examples=["Pa"])
    """SI unit of the values; that of the quantity if absent, but needed beside a scale"""
    unknown: dict[str, Any] = {}
    """distributions of what is not printed, by dotted path"""
    of_model: dict[str, Any] = {}
    """the same of one model, by its name; false for a layer that it replaces"""
    calibrated_by: list[str] = []
    """other measurements of this file, each of which alone calibrates a model before it predicts this one"""
    calibrated_at: Several = []
    """values of `at` that calibrate the others"""
    made: list[str] = []
    """models that were made from these numbers, which they cannot judge"""
    judges: str = "force"
    """path of the model whose candidates are compared"""
    on: str = "finger"
    """what was attracted"""
    note: str = ""
    """a trap, such as a contradiction with another source"""
    cause: str = ""
    """of what no candidate reaches: likely cause, and the experiment that would decide"""

    @pydantic.field_validator("values", "spread", "at", "over", "unit")
    @classmethod
    def _needed(cls, value: Any, info: pydantic.ValidationInfo) -> Any:
        """Refuse an entry that is missing because of those before it; the context has the columns of a table of points."""
        columns, name = info.context, str(info.field_name)
        given = {key for key, each in info.data.items() if each not in ("", [])}
        replaced, values = given & set(IN_PLACE_OF_VALUES), info.data.get("values")
        several = columns is not None or {"runs", "line", "at"} & given or np.size(values or 0) > 1
        needed = {
            "values": not replaced,
            "spread": replaced <= {"printed_range"},
            "at": several,
            "over": several,
            "unit": info.data.get("scale", 1) != 1,
        }
        if value in ("", []):
            if needed[name] and name not in {COLUMNS[each] for each in columns or ()}:
                example = (_OF_TABLE if columns is not None else {}).get(name) or EXAMPLES[name]
                why = "missing beside scale" if name == "unit" else "missing"
                raise PydanticCustomError("needed", "{why}, for instance {it}", {"why": why, "it": example})
        elif name == "values" and replaced:
            why = "{others} stands in their place; state one of both"
            raise PydanticCustomError("needed", why, {"others": ", ".join(replaced)})
        return value


Part = dict[str, Any]
"""Entries of a measurement, some of them."""


class MeasurementFile(Entries):
    """One measurement; or several in `measurements`, with the entries of all of them beside it."""

    model_config = ConfigDict(extra="forbid", use_attribute_docstrings=True, title="file of measurements")

    schema_: Literal[1] = Field(SCHEMA, alias="schema")
    """version of this form"""
    shared: dict[str, Part] = {}
    """entries that a measurement takes by `shares`, by name"""
    shares: list[str] = []
    """names in `shared`, of another publication as author_year/name; tables are joined"""
    measurements: dict[str, Part] = {}
    """several measurements by name; entries beside this hold for all"""


_OF_FILE: Final = ("schema", "shared", "measurements")
ENTRIES: Final = ("schema", *Entries.model_fields)
"""Names of what a measurement may state."""
TABLES: Final = tuple(name for name, each in Entries.model_fields.items() if each.default == {})
"""Those of them that are tables."""
EXAMPLES: Final = {
    name: f"{name} = {' or '.join(map(json.dumps, each.examples))}"
    for name, each in Entries.model_fields.items()
    if each.examples
}
"""An example of each entry that may have to be stated."""


def entries_of(content: Mapping[str, Any], columns: Mapping[str, str] | None = None) -> Entries:
    """Read the entries of a measurement, or those beside the columns of a table of points; every mistake at once."""
    return read_entries(Entries, content, of="a measurement", beside=columns)


def measurement_schema() -> dict[str, Any]:
    """Return the JSON schema of the file of a measurement or publication, for editors that complete and check TOML."""
    found = MeasurementFile.model_json_schema()
    one = found.pop("required")
    entries = {name: each for name, each in found["properties"].items() if name not in _OF_FILE}
    part = {"type": "object", "properties": entries, "additionalProperties": False}
    for name in ("shared", "measurements"):
        found["properties"][name]["additionalProperties"] = {"$ref": "#/$defs/part"}
    return found | {"$defs": {"part": part}, "anyOf": [{"required": one}, {"required": ["measurements"]}]}


FOLDER = "measured"


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
