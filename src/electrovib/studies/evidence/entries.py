"""What the file of a measurement, or of a publication with several, may state: one declaration, its JSON schema too."""

from __future__ import annotations

import json
from typing import Any, Final, Literal

from pydantic import BaseModel, ConfigDict, Field

from electrovib.scenario.toml import SCHEMA
from electrovib.studies.evidence.measurement import DATA, HOW, SPREADS

Number = float | str
"""A number in SI, or a text with a unit."""


class Entries(BaseModel):
    """One measurement: numbers are in SI, or texts with a unit."""

    model_config = ConfigDict(extra="forbid", title="measurement")

    title: str = Field(examples=["attraction over voltage, one finger"], description="what was measured")
    source: str = Field(
        examples=["our tribometer, March 2026"], description="where in the publication it stands"
    )
    group: str = Field(examples=["our laboratory"], description="the people who measured")
    scenario: str | dict[str, Any] = Field(
        examples=["vezzoli_2014/fig6_gap", "my_screen.toml"],
        description="set-up: a scenario of a paper, a file or a table",
    )
    quantity: str = Field(
        examples=["peak electrostatic_force"], description="a quantity of a run, or one that is computed"
    )
    values: Number | list[Number] = Field([], examples=[["1.1 mN", "4.2 mN"]], description="all above 0")
    spread: Number | list[Number] = Field(
        [], examples=["10 %"], description="standard deviation, over the value or in its unit"
    )
    spread_of: str = Field(
        examples=[SPREADS[1]],
        description="between what it is, or 'a choice'",
        json_schema_extra={"enum": list(SPREADS)},
    )
    over: str = Field("", examples=["drive.high"], description="dotted path of what was varied")
    at: Number | list[Number] = Field([], examples=[["500 V", "1 kV"]], description="its values")
    printed_range: list[Number] = Field(
        [], description="in place of `values`, least and largest: their geometric mean"
    )
    runs: list[list[Number]] = Field(
        [],
        description="in place of `values`, a row for each run: mean and deviation, which is at least `spread`",
    )
    devices: list[Number] = Field(
        [], description="in place of `values`, one condition on several devices: geometric mean and deviation"
    )
    line: list[Number] = Field(
        [],
        description="in place of `values`, a fitted straight line over `at`: start, its error, slope, its error, in SI",
    )
    how: str = Field(DATA, description="how the numbers came here", json_schema_extra={"enum": list(HOW)})
    status: str = Field("full text", description="how the publication was read")
    changes: dict[str, Any] = Field({}, description="changes of the scenario, by dotted path")
    per: str = Field("", description="second quantity, by which the first is divided")
    scale: Number = Field(1.0, description="factor on the computed quantity")
    unit: str = Field("", description="SI unit of the values; that of the quantity if absent")
    unknown: dict[str, Any] = Field({}, description="distributions of what is not printed, by dotted path")
    of_model: dict[str, dict[str, Any]] = Field(
        {}, description="the same of one model, by its name; false for a layer that it replaces"
    )
    made: list[str] = Field(
        [], description="models that were made from these numbers, which they cannot judge"
    )
    judges: str = Field("force", description="path of the model whose candidates are compared")
    on: str = Field("finger", description="what was attracted")
    note: str = Field("", description="a trap, such as a contradiction with another source")
    cause: str = Field(
        "", description="of what no candidate reaches: likely cause, and the experiment that would decide"
    )


Part = dict[str, Any]
"""Entries of a measurement, some of them."""


class MeasurementFile(Entries):
    """One measurement; or several in `measurements`, with the entries of all of them beside it."""

    model_config = ConfigDict(extra="forbid", title="file of measurements")

    schema_: Literal[1] = Field(SCHEMA, alias="schema", description="version of this form")
    shared: dict[str, Part] = Field({}, description="entries that a measurement takes by `shares`, by name")
    shares: list[str] = Field(
        [], description="names in `shared`, of another publication as author_year/name; tables are joined"
    )
    measurements: dict[str, Part] = Field(
        {}, description="several measurements by name; entries beside this hold for all"
    )


ENTRIES: Final = ("schema", *Entries.model_fields)
"""Names of what a measurement may state."""
TABLES: Final = tuple(name for name, each in Entries.model_fields.items() if each.default == {})
"""Those of them that are tables."""
IN_PLACE_OF_VALUES: Final = ("printed_range", "runs", "devices", "line")
NEEDED: Final = {
    name: f"{name} = {' or '.join(map(json.dumps, each.examples))}"
    for name, each in Entries.model_fields.items()
    if each.examples
}
"""What a measurement has to state, `over` and `at` where it has several points, with an example of each."""


def usual() -> dict[str, Any]:
    """Return what a measurement states where its file does not, but what is needed."""
    return {name: each.default for name, each in Entries.model_fields.items() if name not in NEEDED}


def measurement_schema() -> dict[str, Any]:
    """Return the JSON schema of the file of a measurement or publication, for editors that complete and check TOML."""
    found = MeasurementFile.model_json_schema()
    one = found.pop("required")
    return found | {"anyOf": [{"required": one}, {"required": ["measurements"]}]}
