"""Limits declared in several places, of which the strictest counts, and a drive compared with them, in words."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, ClassVar, Final, Self, TypeAlias

from electrovib.core.answer import Answer, Document, Drawing, Table
from electrovib.core.citation import UNVERIFIED
from electrovib.core.deprecation import former_attribute
from electrovib.core.diagnostics import Diagnostic
from electrovib.core.errors import InputError, refuse
from electrovib.core.model import read_model
from electrovib.core.parsing import read_toml_file
from electrovib.core.units import format_quantity
from electrovib.data.atomic import Form, csv_text, json_text
from electrovib.physics.limits import MEAN_SQUARES, PEAKS, TITLES, WORDS, Limits, unit_of_limit
from electrovib.physics.safety import AIR, BARE_ELECTRODE, FILM, GAP_CLOSED
from electrovib.scenario import Scenario
from electrovib.solve.quantities.answer import validity

NEEDED: Final = ("voltage", "current")
"""Limits without which nothing that can be played is written or played."""
LINES_TO_ADD: Final = 'limits = { voltage = "1 kV", current = "250 uA" }'
"""Line of a scenario, or of a file of limits, that declares what is needed, with the values of Vezzoli et al. 2014."""
LimitsSource: TypeAlias = "str | Path | Mapping[str, Any] | Limits | LimitsFrom | None"
"""Limits from a TOML file, a table, a `Limits`, or a `LimitsFrom`, which also names where they are declared."""


@dataclass(frozen=True)
class LimitsFrom:
    """Limits of one place, named as it is shown: ``the scenario``, a file; `notes` has the stated source of a limit."""

    place: str
    limits: Limits
    notes: Mapping[str, str] | None = None


@dataclass(frozen=True)
class DeclaredLimit:
    """The strictest limit of one quantity in its unit; `source` also has the less strict values of other places."""

    name: str
    value: float
    source: str


def limits_from(source: LimitsSource) -> LimitsFrom:
    """Read limits from one place; a TOML file has them alone or in a table ``[limits]``, and None declares none."""
    if source is None:
        return LimitsFrom("", Limits())
    if isinstance(source, LimitsFrom):
        return source
    if isinstance(source, Limits):
        return LimitsFrom("limits", source)
    if isinstance(source, Mapping):
        return LimitsFrom("limits", _built(source, ""))
    if not isinstance(source, str | Path):
        why = f"expected a TOML file or a table such as {LINES_TO_ADD}, not a {type(source).__name__}"  # type: ignore[unreachable]
        raise InputError(why, path="limits")
    tables = read_toml_file(
        Path(source), kind="a file of limits", advice=f"Give a TOML file with {LINES_TO_ADD}"
    )
    return LimitsFrom(str(source), _built(tables, f"{source}: "))


def limits_of(scenario: Scenario) -> LimitsFrom:
    """Return the limits of a scenario, with the sources that it states for them."""
    notes = {name: scenario.sources.get(f"limits.{name}", "") for name in WORDS}
    return LimitsFrom("the scenario", scenario.limits, notes)


def strictest(places: Iterable[LimitsFrom]) -> dict[str, DeclaredLimit]:
    """Combine limits of several places: of each quantity the smallest counts, of equal ones the first is named."""
    given = list(places)
    found = {}
    for name in WORDS:
        values = [(getattr(each.limits, name), each) for each in given]
        declared = sorted(
            ((value, each) for value, each in values if value is not None), key=lambda pair: pair[0]
        )
        if not declared:
            continue
        (value, first), *others = declared
        text = f"limits.{name} of {first.place}"
        if note := (first.notes or {}).get(name):
            text += f" ({note})"
        more = [
            f"{format_quantity(other, unit_of_limit(name), digits=6)} of {each.place}"
            for other, each in others
        ]
        found[name] = DeclaredLimit(
            name, value, text + (f"; also declared: {', '.join(more)}" if more else "")
        )
    return found


def refuse_unlimited(
    declared: Mapping[str, DeclaredLimit], *, what: str = "a waveform that can be played"
) -> None:
    """Refuse to continue unless the largest voltage and the largest current are declared."""
    missing = [name for name in NEEDED if name not in declared]
    if missing:
        words = " and ".join(f"limits.{name} ({WORDS[name]})" for name in missing)
        verb = "is" if len(missing) == 1 else "are"
        raise InputError(
            f"{words} {verb} not declared, and {what} needs the largest voltage and the largest"
            " current; nothing was written. Add to the scenario, before its first"
            f" table, or to the file of --limits, with the values of your set-up: {LINES_TO_ADD}; or --set limits.voltage=..."
        )


def _built(content: Mapping[str, Any], start: str) -> Limits:
    inner = content.get("limits")
    table = inner if isinstance(inner, Mapping) else content
    if table is inner and (beside := [name for name in WORDS if name in content]):
        raise InputError(
            "stands beside a table 'limits'; put it into that table", path=f"{start}limits.{beside[0]}"
        )
    table = {name: value for name, value in table.items() if name != "schema"}
    try:
        return read_model(Limits, table)
    except InputError as error:
        raise InputError(each.within(f"{start}limits") for each in error.problems) from None


PASS: Final = "pass"  # noqa: S105  # the state of a row
FAIL: Final = "fail"
UNKNOWN: Final = "unknown"
STATES: Final = (PASS, UNKNOWN, FAIL)
"""From best to worst."""
OUTCOMES: Final = {PASS: "within all limits", UNKNOWN: "not shown to be safe", FAIL: "exceeded"}
"""What the state of all rows together says of a set-up."""
UNCERTAIN: Final = "of uncertain standing"
"""A limit that is unverified, or may not apply to this layer."""
HARDWARE: Final = "no claim of medical safety: only hardware that limits the current protects a person"
"""What a check in a few lines says of its own meaning."""
BREAKDOWN: Final = (FILM, *AIR, BARE_ELECTRODE)
"""Beginnings of the names of the diagnostics of breakdown."""
ASKED: Final = "asked "
"""Beginning of the names of what a drive asks of the amplifier; its own limits of them refuse no file."""


@dataclass(frozen=True, kw_only=True)
class CheckRow:
    """One quantity and its limit, both in the SI unit `unit`.

    - `value`: the largest value reached; infinite where it has no bound, None where it is not known.
    - `limit`: None where none is declared or known.
    - `source`: who declared the limit, or where it was published; how to declare it where there is none.
    - `state`: ``"pass"``, also at exactly the limit; ``"fail"`` above it; or ``"unknown"``.
    - `text`: one sentence about the comparison, with its conditions.
    - `remedy`: what to declare or to measure, where the row leaves open whether the set-up is safe; else empty.
    - `area`: share of the contact area above the limit [1], where a film is above it and a declared law of rough contact
      states local gaps; else None. It loosens no limit.
    """

    quantity: str
    value: float | None
    limit: float | None
    unit: str
    source: str
    state: str
    text: str
    remedy: str = ""
    area: float | None = None

    @property
    def named(self) -> str:
        """The quantity, and on how much of the contact area it is above its limit, where a law states it."""
        where = "" if self.area is None else f" (on {100 * self.area:.3g} % of the area)"
        return f"{self.quantity}{where}"

    @property
    def forbids(self) -> bool:
        """Whether the limit is exceeded; the strength of a film also where its standing is uncertain, or the field not known."""
        held = self.limit is None or (self.margin is not None and self.margin >= 1)
        return self.state == FAIL or (self.quantity.startswith(FILM) and not held)

    @property
    def is_refused(self) -> bool:
        """Whether the limit is exceeded, or was declared and could not be compared, so that no file is written."""
        if self.quantity.startswith(ASKED):
            return False
        return self.forbids or (self.state == UNKNOWN and self.value is None and self.limit is not None)

    @property
    def margin(self) -> float | None:
        """Limit over value [1], 1 at the limit; None where one of them is not known."""
        if self.value is None or self.limit is None:
            return None
        return math.inf if self.value == 0 else self.limit / self.value


@dataclass(frozen=True, kw_only=True)
class CheckNumber:
    """A number that has no limit of its own, in its SI unit; None where it is not known."""

    quantity: str
    value: float | None
    unit: str

    @classmethod
    def of(cls, quantity: str, value: float, unit: str) -> Self:
        """Return a value without a limit, which may be NaN."""
        return cls(quantity=quantity, value=None if math.isnan(value) else value, unit=unit)


@dataclass(frozen=True, kw_only=True, repr=False)
class CheckResult(Answer):
    """Largest values of a drive in a scenario compared with limits.

    - `title`: of the scenario, and the drive where it is another one.
    - `duration`: time from 0 up to which the drive was checked [s].
    - `rows`: declared limits, then breakdown of each layer and of air.
    - `comparisons`: published currents, which do not decide whether the check fails.
    - `numbers`: root-mean-square values and slew rate.
    - `notes`: what was assumed, and what the check does not state.
    - `scenario`: experiment with the drive that was checked.
    """

    FILES: ClassVar = {"check.csv": Form.TABLE, "check.json": Form.CHECK}
    title: str
    duration: float
    rows: tuple[CheckRow, ...]
    comparisons: tuple[CheckRow, ...]
    numbers: tuple[CheckNumber, ...]
    notes: tuple[str, ...]
    scenario: Scenario
    verdict = former_attribute("verdict", "headline", lambda self: self.headline)
    sentences = former_attribute("sentences", "document.sentences", lambda self: self._sentences)
    tables = former_attribute("tables", "document.tables", lambda self: self.document.tables)

    @property
    def diagnostics(self) -> tuple[Diagnostic, ...]:
        """Diagnostics of the scenario that no row states."""
        return not_in_rows(validity(self.scenario))

    @property
    def state(self) -> str:
        """Return ``"fail"`` for exceeded, ``"unknown"`` for not shown to be safe, ``"pass"`` for within all limits."""
        return state_of(self.rows)

    @property
    def failed(self) -> tuple[CheckRow, ...]:
        """Rows whose limit is exceeded."""
        return tuple(row for row in self.rows if row.state == FAIL)

    @property
    def forbidding(self) -> tuple[CheckRow, ...]:
        """Rows that forbid a design or a file to be played."""
        return tuple(row for row in self.rows if row.forbids)

    @property
    def headline(self) -> str:
        """One sentence with the outcome."""
        outcome = OUTCOMES[self.state]
        if self.failed:
            names = "; ".join(row.named for row in self.failed)
            return f"{outcome}: {len(self.failed)} of {len(self.rows)} limits: {names}"
        names = "; ".join(row.named for row in self.rows if row.remedy)
        return f"{outcome}: {names}" if names else outcome

    @property
    def _sentences(self) -> list[str]:
        """The headline, the closest limit, what is not shown to be safe, and what was not compared."""
        lines = [f"{self.headline} ({self.title})"]
        if row := nearest_limit(self.rows):
            doubt = f", {UNCERTAIN}" if row.state == UNKNOWN else ""
            lines.append(
                f"closest limit: {row.quantity}, {shown(row.value, row.unit)} of {shown(row.limit, row.unit)}, limit/value"
                f" {row.margin or 0.0:.3g}{doubt}"
            )
        lines += not_shown(self.rows)
        undeclared = [row.quantity for row in self.rows if row.limit is None and not row.remedy]
        lines += [f"not compared: {', '.join(undeclared)}"] if undeclared else []
        asked = [
            f"{each.quantity.removeprefix(ASKED)} {shown(each.value, each.unit)}"
            for each in self.numbers
            if each.quantity.startswith(ASKED)
        ]
        of = "an amplifier, without stray capacitance"
        if self.scenario.circuit.supply.stray_capacitance:
            of = "the amplifier, stray capacitance included"
        return [*lines, f"asked of {of}: {', '.join(asked)} (rms voltage times rms current)"]

    @property
    def document(self) -> Document:
        """The sentences; limits, comparisons and numbers in tables; the notes."""
        numbers = tuple((each.quantity, shown(each.value, each.unit)) for each in self.numbers)
        tables = [
            limits_table(self.title, self.rows),
            limits_table(
                "Comparison with published currents, which decides nothing",
                self.comparisons,
                states={PASS: "below", FAIL: "above"},
            ),
            Table("Values without a limit", ("quantity", "value"), numbers),
        ]
        return Document(
            title=f"Check of {self.title}",
            sentences=[*self._sentences, HARDWARE],
            diagnostics=self.diagnostics,
            figures=[Drawing(id="limits", title="Every value over its limit", plot="limits", of=self)],
            tables=tables,
            remarks=self.notes,
            brief=True,
        )

    def content(self, name: str) -> str:
        """Write a row for each limit, comparison and number as CSV, or everything as JSON."""
        if name.endswith(".json"):
            return json_text(Form.CHECK, self.to_dict())
        rows: list[list[object]] = [
            [kind, row.quantity, row.value, row.limit, row.unit, row.margin, row.state, row.source]
            for kind, some in (("limit", self.rows), ("comparison", self.comparisons))
            for row in some
        ]
        rows += [["number", each.quantity, each.value, "", each.unit, "", "", ""] for each in self.numbers]
        return csv_text(
            ["kind", "quantity", "value", "limit", "unit", "margin", "state", "source"],
            rows,
            remarks=[f"{self.title}: {self.state}"],
            diagnostics=self.diagnostics,
        )

    def refuse(self, consequence: str = "Nothing was written") -> None:
        """Raise an error if a limit is exceeded, or a declared one could not be compared."""
        refused = sorted((row for row in self.rows if row.is_refused), key=lambda row: row.state != FAIL)
        problems = [f"{'; '.join(filter(None, (row.text, row.remedy)))}. {consequence}" for row in refused]
        refuse(problems)

    def value(self, quantity: str) -> float | None:
        """Return the value of a row or number such as ``"peak voltage"``, in its unit; None where it is not known."""
        both: list[CheckRow | CheckNumber] = [*self.rows, *self.numbers]
        for each in both:
            if each.quantity == quantity:
                return each.value
        raise KeyError(quantity)

    def to_dict(self) -> dict[str, Any]:
        """Return everything as nested tables; an infinite number is the text ``"infinite"``."""

        def plain(value: Any) -> Any:
            return "infinite" if isinstance(value, float) and math.isinf(value) else value

        def table(each: CheckRow | CheckNumber) -> dict[str, Any]:
            content = asdict(each)
            if isinstance(each, CheckRow):
                content["margin"] = each.margin
            return {name: plain(value) for name, value in content.items()}

        return {
            "title": self.title,
            "duration": self.duration,
            "state": self.state,
            "outcome": OUTCOMES[self.state],
            "limits": [table(row) for row in self.rows],
            "comparisons": [table(row) for row in self.comparisons],
            "numbers": [table(number) for number in self.numbers],
            "notes": list(self.notes),
            "diagnostics": [each.to_dict() for each in self.diagnostics],
        }


def not_in_rows(diagnostics: Iterable[Diagnostic]) -> tuple[Diagnostic, ...]:
    """Return the diagnostics that the rows of a check do not state: all but those of breakdown and of declared limits."""
    return tuple(
        each for each in diagnostics if each.name not in TITLES and not each.name.startswith(BREAKDOWN)
    )


def shown(value: float | None, unit: str) -> str:
    """Write a value with its unit for people: ``1 kV``; ``no bound`` and ``not known`` where there is no number."""
    if value is None or math.isnan(value):
        return "not known"
    if math.isinf(value):
        return "no bound"
    return f"{value:.4g} dB" if unit == "dB" else format_quantity(value, unit, digits=4)


def nearest_limit(rows: Iterable[CheckRow]) -> CheckRow | None:
    """Return the comparison whose value is nearest to its limit, or exceeds it most, whatever the status of that limit."""
    compared = [row for row in rows if row.margin is not None]
    return min(compared, key=lambda row: row.margin or 0.0, default=None)


def limits_table(title: str, rows: Iterable[CheckRow], states: Mapping[str, str] | None = None) -> Table:
    """Return rows in words; `states` has other words for their states."""
    columns: dict[str, Callable[[CheckRow], str]] = {
        "state": lambda row: (states or {}).get(row.state, row.state),
        "quantity": lambda row: row.quantity,
        "largest": lambda row: shown(row.value, row.unit),
        "limit": lambda row: "" if row.limit is None else shown(row.limit, row.unit),
        "limit/value": lambda row: "" if row.margin is None else f"{row.margin:.3g}",
        "source of the limit": lambda row: row.source,
    }
    return Table.of(title, rows, columns, looks={0: "state"})


ONLY_DECLARED: Final = (*MEAN_SQUARES, "slew_rate")
"""Limits that have no row where nobody declares them."""
_STATES: Final = {"ok": PASS, "warning": FAIL, "unknown": UNKNOWN}


def limited_quantity(name: str) -> str:
    """Return the name by which `electrovib.check` has the quantity of a limit: ``"peak voltage"`` for ``"voltage"``."""
    words = name.replace("_", " ")
    return f"peak {words}" if name in PEAKS else words


def limit_row(name: str, value: float | None, limit: DeclaredLimit | None, *, words: str = "") -> CheckRow:
    """Return the row of a limit; the value is infinite without a bound, NaN or None where it is not known."""
    remedy = ""
    unit, words = unit_of_limit(name), words or WORDS[name]
    if value is None or math.isnan(value):
        value, reached = None, "is not known"
    elif math.isinf(value):
        where = "a discontinuity" if name == "slew_rate" else "a discontinuity without a series resistance"
        reached = f"has no bound ({where})"
    else:
        reached = f"reaches {format_quantity(value, unit, digits=6)}"
    if limit is None:
        state, text = UNKNOWN, f"{words} {reached}; limits.{name} is not declared"
        remedy = f"declare limits.{name}, the largest that your set-up allows" if name in NEEDED else ""
    else:
        state = state_at(value, limit.value)
        word = {UNKNOWN: "not compared with", PASS: "within", FAIL: "above"}[state]
        remedy = f"limits.{name} is declared, and the largest value is not known" if state == UNKNOWN else ""
        text = f"{words} {reached}, {word} {format_quantity(limit.value, unit, digits=6)}: {limit.source}"
    return CheckRow(
        quantity=limited_quantity(name),
        value=value,
        limit=None if limit is None else limit.value,
        unit=unit,
        source=f"not declared; add limits.{name}" if limit is None else limit.source,
        state=state,
        text=text,
        remedy=remedy,
    )


def state_at(value: float | None, limit: float) -> str:
    """Return the state of a value beside its limit; one at exactly the limit passes."""
    return UNKNOWN if value is None else PASS if value <= limit else FAIL


def breakdown_row(found: Diagnostic) -> CheckRow:
    """Return the row of a diagnostic of breakdown.

    A limit that was cited from memory decides nothing, whichever side of it the value is on. That of Paschen's law depends on
    such a value only through the logarithm of a logarithm: a field above it fails, one within it is not known to pass.
    """
    state = _STATES[found.state]
    is_film, is_known = found.name.startswith(FILM), found.value is not None
    if UNVERIFIED in found.text and not (state == FAIL and found.name == "Paschen"):
        state = UNKNOWN
    remedy = ""
    if state == UNKNOWN and is_film:
        layer = found.name.removeprefix(f"{FILM}, ").removesuffix(GAP_CLOSED)
        remedy = f"declare stack.{layer}.breakdown_field, measured on such a film"
        if found.limit is not None and not is_known:
            remedy = "films in series of which one leaks have no known bound: give that one a conductivity in place of the leak"
    elif found.name == BARE_ELECTRODE:
        remedy = "add a film, or the resistor in front of the plate that 'electrovib check --series-resistor' computes"
    elif state == UNKNOWN and (found.state == "warning" or (not is_known and "not compared" in found.text)):
        remedy = "look for discharges in the gap (light, pulses of current) on the real set-up, or lower the voltage"
    return CheckRow(
        quantity=found.name,
        value=found.value,
        limit=found.limit,
        unit=found.unit,
        source=found.text.partition(": ")[2] or found.text,
        state=state,
        text=found.text,
        remedy=remedy,
        area=found.area,
    )


def state_of(rows: Iterable[CheckRow]) -> str:
    """Return the worst of all rows: fail for a limit exceeded, unknown where one leaves open whether the set-up is safe."""
    found = list(rows)
    if any(row.state == FAIL for row in found):
        return FAIL
    return UNKNOWN if not found or any(row.remedy for row in found) else PASS


def not_shown(rows: Iterable[CheckRow]) -> list[str]:
    """Return a sentence for each cause for which a set-up is not shown to be safe, with what to declare or to measure."""
    causes: dict[str, CheckRow] = {row.remedy: row for row in rows if row.remedy}
    return [f"{OUTCOMES[UNKNOWN]}: {row.text}; {remedy}" for remedy, row in causes.items()]
