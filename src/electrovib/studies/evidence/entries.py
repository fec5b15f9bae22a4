"""What the file of a measurement, or of a publication with several, may state: one declaration, and its JSON schema."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from typing import Annotated, Any, Final, Literal, Self

from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    ModelWrapValidatorHandler,
    StrictFloat,
    StrictStr,
    ValidationError,
    ValidationInfo,
    WrapValidator,
    model_validator,
)
from pydantic_core import InitErrorDetails, PydanticCustomError

from electrovib.core.mistakes import read_entries
from electrovib.scenario.toml import SCHEMA
from electrovib.studies.evidence.measurement import DATA, HOW, SPREADS


def _expected(what: str) -> WrapValidator:
    """Say in one sentence what is expected where several types are allowed."""

    def read(value: Any, handler: Any) -> Any:
        try:
            return handler(value)
        except ValidationError:
            raise PydanticCustomError("expected", "expected {what}", {"what": what}) from None

    return WrapValidator(read)


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

    model_config = ConfigDict(extra="forbid", title="measurement")

    title: str = Field(examples=["attraction over voltage, one finger"], description="what was measured")
    source: str = Field(
        examples=["our tribometer, March 2026"], description="where in the publication it stands"
    )
    group: str = Field(examples=["our laboratory"], description="the people who measured")
    scenario: Annotated[str | dict[str, Any], _expected("a scenario of a paper, a file or a table")] = Field(
        examples=["vezzoli_2014/fig6_gap", "my_screen.toml"],
        description="set-up: a scenario of a paper, a file or a table",
    )
    quantity: str = Field(
        examples=["peak electrostatic_force"], description="a quantity of a run, or one that is computed"
    )
    values: Several = Field([], examples=[["1.1 mN", "4.2 mN"]], description="all above 0")
    spread: Several = Field(
        [], examples=["10 %"], description="standard deviation, over the value or in its unit"
    )
    spread_of: str = Field(
        examples=[SPREADS[1]],
        description="between what it is, or 'a choice'",
        json_schema_extra={"enum": list(SPREADS)},
    )
    over: str = Field("", examples=["drive.high"], description="dotted path of what was varied")
    at: Several = Field([], examples=[["500 V", "1 kV"]], description="its values")
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
    scale: Plain = Field(1.0, description="factor on the computed quantity")
    unit: str = Field("", description="SI unit of the values; that of the quantity if absent")
    unknown: dict[str, Any] = Field({}, description="distributions of what is not printed, by dotted path")
    of_model: dict[str, Any] = Field(
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

    @model_validator(mode="wrap")
    @classmethod
    def _together(cls, content: Any, handler: ModelWrapValidatorHandler[Self], info: ValidationInfo) -> Self:
        """Tell what is missing because of other entries together with every other mistake, in the order of the entries."""
        wrong: list[tuple[str, str, tuple[int | str, ...], Any]] = []
        if isinstance(content, Mapping) and "measurements" not in content:
            wrong = [("needed", why, (name,), None) for name, why in _needed(content, info.context)]
        try:
            found = handler(content)
            if not wrong:
                return found
        except ValidationError as error:
            told = error.errors(include_url=False)
            wrong += [(each["type"], each["msg"], each["loc"], each["input"]) for each in told]
        order = [*cls.model_fields]
        wrong.sort(key=lambda each: order.index(str(each[2][0])) if each[2][0] in order else -1)
        raise ValidationError.from_exception_data(
            cls.__name__,
            [
                InitErrorDetails(type=PydanticCustomError(kind, "{why}", {"why": why}), loc=loc, input=given)
                for kind, why, loc, given in wrong
            ],
        )


def _needed(content: Mapping[str, Any], columns: Mapping[str, str] | None) -> Iterator[tuple[str, str]]:
    """Find what has to be stated because of what else is, or is not, with the reason; `columns` of a table of points."""
    has = {name for name, each in content.items() if each not in ("", [])}
    has |= {COLUMNS[each] for each in columns or ()}
    replaced, values = has & set(IN_PLACE_OF_VALUES), content.get("values")
    needed = set() if replaced else {"values"}
    needed |= {"spread"} if replaced <= {"printed_range"} else set()
    if (
        columns is not None
        or {"over", "at", "runs", "line"} & has
        or (isinstance(values, list) and len(values) > 1)
    ):
        needed |= {"over", "at"}
    examples = EXAMPLES | (_OF_TABLE if columns is not None else {})
    yield from ((name, f"missing, for instance {examples[name]}") for name in needed - has)
    if "unit" not in has and content.get("scale", 1) != 1:
        yield "unit", 'missing beside scale, for instance unit = "Pa"'
    if "values" in content:
        yield from ((name, "stands in the place of values; state one of both") for name in replaced)


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
EXAMPLES: Final = {
    name: f"{name} = {' or '.join(map(json.dumps, each.examples))}"
    for name, each in Entries.model_fields.items()
    if each.examples
}
"""What a measurement has to state, `over` and `at` where it has several points, with an example of each."""


def entries_of(content: Mapping[str, Any], columns: Mapping[str, str] | None = None) -> Entries:
    """Read the entries of a measurement, or those beside the columns of a table of points; every mistake at once."""
    return read_entries(Entries, content, of="a measurement", beside=columns)


def measurement_schema() -> dict[str, Any]:
    """Return the JSON schema of the file of a measurement or publication, for editors that complete and check TOML."""
    found = MeasurementFile.model_json_schema()
    one = found.pop("required")
    return found | {"anyOf": [{"required": one}, {"required": ["measurements"]}]}
