"""What the answer to every inverse question offers, and that of the search for one parameter, in sentences and tables."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any, ClassVar, Final

import numpy as np

from electrovib.core.answer import REFERENCE, Answer, Curve, Document, Panel, Table, as_sentence
from electrovib.core.deprecation import former_attribute
from electrovib.core.diagnostics import Diagnostic
from electrovib.core.paths import words_at
from electrovib.data.atomic import Form, json_text, plain, unsigned
from electrovib.scenario import Scenario
from electrovib.scenario.toml import to_toml
from electrovib.studies.check import CheckResult, CheckRow, LimitsSource
from electrovib.studies.check.result import UNKNOWN, not_shown
from electrovib.studies.design.limits import Obtainable
from electrovib.studies.design.search import Function, Point, Root
from electrovib.studies.design.wanted import Wanted
from electrovib.studies.sensitivity import Elasticity
from electrovib.studies.widths import Width, sentences


@dataclass(frozen=True, kw_only=True, repr=False)
class Designed(Answer):
    """Result of a design; `limits` are the further ones that were given, which hold for all that is written of it too.

    `widths` say by what a value is uncertain that depends on people: see `electrovib.studies.widths`; `check` compares the result
    with the limits.
    """

    FILES: ClassVar[Mapping[str, str | None]] = {"design.json": Form.DESIGN, "scenario.toml": Form.SCENARIO}
    limits: tuple[LimitsSource, ...] = ()
    widths: tuple[Width, ...] = ()
    check: CheckResult | None = None
    form: ClassVar[str]
    """What was sought, as a file of all numbers names it."""
    answer = former_attribute("answer", "document.sentences", lambda self: " ".join(self.document.sentences))
    verdict = former_attribute(
        "verdict", "document.text", lambda self: (*self.document.sentences, *self.document.warnings)
    )
    lines = former_attribute("lines", "document", lambda self: self._lines)
    sentences = former_attribute("sentences", "document.sentences", lambda self: self.document.sentences)
    details = former_attribute("details", "document.remarks", lambda self: self.document.remarks)
    tables = former_attribute("tables", "document.tables", lambda self: self.document.tables)
    figures = former_attribute("figures", "document.figures", lambda self: self.document.figures)

    @property
    @abstractmethod
    def scenario(self) -> Scenario | None:
        """Scenario with the result in it, which can be simulated; None if there is none."""

    @property
    def failed(self) -> tuple[CheckRow, ...]:
        """Limits that the result exceeds."""
        return () if self.check is None else self.check.forbidding

    @property
    def is_achieved(self) -> bool:
        """Whether the result gives what is wanted, within the limits."""
        return self.check is not None and not self.failed

    @property
    def diagnostics(self) -> Sequence[Diagnostic]:
        """Diagnostics of that scenario beyond those that the comparison with the limits states."""
        return () if self.check is None else self.check.diagnostics

    @abstractmethod
    def numbers(self) -> dict[str, Any]:
        """Return all numbers as nested tables, in SI."""

    @property
    def _lines(self) -> list[str]:
        said = self.document
        return [*said.sentences, *said.warnings, *said.remarks]

    def _document(self, sentences: Sequence[str], **parts: Any) -> Document:
        """Return the document of a design: sentences that are needed first, and its other parts."""
        titled = (self.scenario and self.scenario.titled()) or self.form
        return Document(
            title=f"Design: {titled}", sentences=sentences, diagnostics=self.diagnostics, brief=True, **parts
        )

    @property
    def files(self) -> Mapping[str, str | None]:
        """Files of the numbers; that of the scenario where there is a result."""
        return {name: form for name, form in self.FILES.items() if self.scenario or form != Form.SCENARIO}

    def content(self, name: str) -> str:
        """Write all numbers as JSON, or the scenario with the result."""
        if name.endswith(".json") or self.scenario is None:
            return json_text(Form.DESIGN, self.to_dict())
        return f"# {unsigned(Form.SCENARIO)}\n{to_toml(self.scenario)}"

    def to_dict(self) -> dict[str, Any]:
        """Return everything as nested tables with numbers in SI; what is not known or infinite is None."""
        found = {"form": self.form, **self.numbers(), "is_achieved": self.is_achieved}
        found["widths"] = [asdict(each) for each in self.widths]
        words = {"diagnostics": [each.to_dict() for each in self.diagnostics], "text": self._lines}
        return {name: plain(value) for name, value in found.items()} | words


_SHOWN: Final = 3.0
"""Largest value of the parameter in the figure, over the largest solution."""
_MOST_INFLUENCES: Final = 6
_NEGLIGIBLE: Final = 0.01
"""Elasticity below which a parameter is not listed."""


@dataclass(frozen=True)
class FoundValue:
    """A root of the search, compared with the limits; `check` is None where that cannot be done, and `problem` says why."""

    root: Root
    check: CheckResult | None
    problem: str = ""

    @property
    def value(self) -> float:
        """Value of the free parameter; of an interval its first end."""
        return self.root.value

    @property
    def failed(self) -> tuple[CheckRow, ...]:
        """Limits that are exceeded."""
        return () if self.check is None else self.check.forbidding

    @property
    def is_allowed(self) -> bool:
        """Whether no limit is exceeded, as far as they could be compared."""
        return not self.failed

    def numbers(self) -> dict[str, Any]:
        """Return all numbers as a table."""
        return {
            "value": self.value,
            "until": self.root.until,
            "is_extreme": self.root.is_extreme,
            "quantity": self.root.reached,
            "is_allowed": self.is_allowed,
            "limits": None if self.check is None else self.check.to_dict()["limits"],
            "not_compared": self.problem or None,
        }


@dataclass(frozen=True, kw_only=True)
class Explored:
    """Where the quantity was computed, at `count` values of the free parameter.

    `points` are such a value and the quantity there, in the order of the values, `refused` has the reasons where nothing could be
    computed, and `unknown` values have no known quantity. The quantity passes the wanted value discontinuously at the `jumps`,
    and `beyond` the listed solutions; `is_settled` is False if finer values kept showing further ones.
    """

    count: int
    points: tuple[Point, ...]
    refused: dict[float, str]
    unknown: int
    jumps: tuple[float, ...]
    beyond: int
    is_settled: bool

    @classmethod
    def of(cls, function: Function, jumps: list[float], *, beyond: int, is_settled: bool) -> Explored:
        """Return what a search has computed of a function."""
        points = tuple(sorted(function.known))
        return cls(
            count=len(function.values),
            points=points,
            refused=dict(function.refused),
            unknown=len(function.values) - len(points) - len(function.refused),
            jumps=tuple(jumps),
            beyond=beyond,
            is_settled=is_settled,
        )

    @property
    def ends(self) -> tuple[Point, Point]:
        """Points with the smallest and with the largest quantity."""
        by_quantity = sorted(self.points, key=lambda point: point[1])
        return by_quantity[0], by_quantity[-1]

    @property
    def is_all(self) -> bool:
        """Whether every solution that was seen is listed, and none appeared between finer values."""
        return self.is_settled and not self.beyond

    def numbers(self) -> dict[str, Any]:
        """Return all numbers as a table."""
        lowest, highest = (dict(zip(("at", "quantity"), point, strict=True)) for point in self.ends)
        return {
            "lowest": lowest,
            "highest": highest,
            "discontinuities": self.jumps,
            "is_all": self.is_all,
            "beyond": self.beyond,
            "evaluations": self.count,
        }


@dataclass(frozen=True, kw_only=True, repr=False)
class DesignedParameter(Designed):
    """Values of one parameter that give a wanted quantity.

    - `base`: scenario from which the search began.
    - `wanted`: quantity, its value, and the free parameter with its range.
    - `solutions`: those within the limits first, and of these those with the sign of the value in the
      scenario, the nearest to it first.
    - `explored`: where the quantity was computed.
    - `obtainable`: nearest value of the quantity within the limits, where no solution is allowed; else None.
    - `influences`: how the first solution follows other parameters, the largest first.
    - `diagnostics`: of the first solution, else of the scenario as it is, beyond those that the check states.
    """

    form = "parameter"
    base: Scenario
    wanted: Wanted
    solutions: tuple[FoundValue, ...]
    explored: Explored
    obtainable: Obtainable | None
    influences: tuple[Elasticity, ...]
    diagnostics: tuple[Diagnostic, ...] = ()

    @property
    def best(self) -> FoundValue | None:
        """First solution within the limits; None if there is none."""
        return next((each for each in self.solutions if each.is_allowed), None)

    @property
    def value(self) -> float:
        """First value of the free parameter within the limits, in its SI unit; NaN if there is none."""
        return math.nan if self.best is None else self.best.value

    @property
    def values(self) -> tuple[float, ...]:
        """All values of the free parameter within the limits, in its SI unit."""
        return tuple(each.value for each in self.solutions if each.is_allowed)

    @property
    def scenario(self) -> Scenario | None:
        """Scenario with the first value within the limits; None if there is none."""
        return None if self.best is None else self.base.replace({self.wanted.free: self.best.value})

    @property
    def is_achieved(self) -> bool:
        """Whether a value gives the wanted quantity within the limits."""
        return self.best is not None

    @property
    def document(self) -> Document:
        """The answer, other solutions, limits and widths; the quantity over the parameter; what the value depends on."""
        said = (*_answer(self), *_others(self), *_limits(self), *sentences(self.widths))
        return self._document(
            said,
            remarks=(*_influences(self), *_how(self)),
            figures=[self._figure()],
            tables=[table for table in _tables(self) if table.rows],
        )

    def _figure(self) -> Panel:
        """The quantity over the free parameter, with the wanted value and the values that give it."""
        wanted, points = self.wanted, self.explored.points
        solved = np.array([(each.value, each.root.reached) for each in self.solutions]).reshape(-1, 2).T
        most = _SHOWN * np.max(np.abs(solved[0]), initial=0.0) or math.inf
        x, y = np.array([point for point in points if abs(point[0]) <= most]).reshape(-1, 2).T
        name, free = words_at(None, wanted.name), words_at(self.base, wanted.free)
        curves = (
            Curve(label=name, x=x, y=y),
            Curve(label="computed", x=x, y=y, kind="points", look=0),  # between them the line is no law
            Curve(label="wanted", x=x, y=np.full_like(y, wanted.value), kind="dashed", look=REFERENCE),
            Curve(label="solutions", x=solved[0], y=solved[1], kind="points", look=1),
        )
        return Panel(
            id="quantity", title=f"{name[0].upper()}{name[1:]} over the {free}", x=(free, wanted.declared.unit),
            y=(name, wanted.unit), curves=curves, caption=f"Computed at {len(points)} values of {wanted.free}.",
        )  # fmt: skip

    def numbers(self) -> dict[str, Any]:
        """Return all numbers as nested tables."""
        wanted, nearest = self.wanted, self.obtainable
        within = nearest and {
            "at": nearest.value,
            "quantity": nearest.reached,
            "limit": nearest.row and nearest.row.text,
        }
        return {
            "quantity": {"name": wanted.name, "unit": wanted.unit, "wanted": wanted.value},
            "free": wanted.free_numbers(),
            "value": self.value,
            "solutions": [each.numbers() for each in self.solutions],
            "reachable": self.explored.numbers(),
            "obtainable_within_limits": within,
            "elasticities": {each.path: each.value for each in self.influences},
            "scenario": self.scenario and self.scenario.to_dict(),
        }


def _answer(found: DesignedParameter) -> list[str]:
    wanted, best = found.wanted, found.best
    aim = f"{wanted.name} = {wanted.quantity(wanted.value)}"
    if best is not None:
        return [f"{wanted.free} = {_span(found, best)} gives {aim}{_extreme(best)}."]
    reach = f"from {wanted.parameter(wanted.low)} to {wanted.parameter(wanted.high)}"
    if found.solutions:
        lines = [f"No value of {wanted.free} {reach} gives {aim} within the limits."]
        for each in found.solutions:
            lines += [f"{_span(found, each)} would, but {row.text}." for row in each.failed]
        return [*lines, *_obtainable(found)]
    low, high = found.explored.ends
    lines = [
        f"No value of {wanted.free} {reach} gives {aim}: it reaches from {wanted.quantity(low[1])} (at"
        f" {wanted.parameter(low[0])}) to {wanted.quantity(high[1])} (at {wanted.parameter(high[0])})."
    ]
    if not low[1] <= wanted.value <= high[1]:
        at, reached = low if wanted.value < low[1] else high
        lines.append(f"Nearest: {wanted.quantity(reached)} at {wanted.free} = {wanted.parameter(at)}.")
    return [*lines, *_obtainable(found)]


def _obtainable(found: DesignedParameter) -> list[str]:
    wanted, near = found.wanted, found.obtainable
    if near is None:
        return ["Every value that could be computed exceeds a limit."] if found.solutions else []
    if not found.solutions and near.row is None:
        return []  # the nearest value of all, which is stated already
    word = "at most" if near.reached < wanted.value else "at least"
    bound = f", where {near.row.text}" if near.row is not None else ""
    return [
        f"Within the limits {wanted.name} is {word} {wanted.quantity(near.reached)}, at {wanted.free} ="
        f" {wanted.parameter(near.value)}{bound}."
    ]


def _others(found: DesignedParameter) -> list[str]:
    others = [each for each in found.solutions if each is not found.best] if found.best else []
    if not others:
        return []
    words = []
    for each in others:
        forbidden = f" (forbidden: {each.failed[0].text})" if each.failed else ""
        words.append(f"{_span(found, each)}{_extreme(each)}{forbidden}")
    listed, explored, share = len(found.solutions), found.explored, ""
    if not explored.is_all:
        least = "" if explored.is_settled else "at least "
        share = f" ({listed} with the first, of {least}{listed + explored.beyond}; a narrower range finds the others)"
    return [f"Other solutions{share}: {'; '.join(words)}."]


def _span(found: DesignedParameter, each: FoundValue) -> str:
    first, until = found.wanted.parameter(each.value), each.root.until
    return first if until is None else f"any value from {first} to {found.wanted.parameter(until)}"


def _extreme(each: FoundValue) -> str:
    return ", which is an extreme value of the quantity" if each.root.is_extreme else ""


def _limits(found: DesignedParameter) -> list[str]:
    """Return the nearest limit of the first solution, what could not be compared, and what is not declared."""
    best = found.best
    if best is None:
        return []
    if best.check is None:
        return [f"The limits could not be compared: {best.problem}"]
    rows, lines = best.check.rows, []
    if judged := [row for row in rows if row.margin and row.state != UNKNOWN]:
        row = min(judged, key=lambda row: row.margin or math.inf)
        lines.append(f"Nearest limit: {row.text} ({1 / (row.margin or math.inf):.3g} of that limit).")
    open_ones = [row for row in rows if row.state == UNKNOWN and row.limit is not None and not row.remedy]
    lines += [f"Not judged: {row.text}." for row in open_ones]
    return [*lines, *map(as_sentence, not_shown(rows))]


def _influences(found: DesignedParameter) -> list[str]:
    listed = [f"{each.path} ({each.shown}) {each.value:+.2g}" for each in _notable(found)[:_MOST_INFLUENCES]]
    if not listed:
        return []
    of, same = found.wanted.free, found.wanted.name
    return [
        f"Elasticities of {of} (its relative change over that of the parameter, for the same {same}): {', '.join(listed)}."
    ]


def _notable(found: DesignedParameter) -> list[Elasticity]:
    return [each for each in found.influences if abs(each.value) >= _NEGLIGIBLE]


def _how(found: DesignedParameter) -> list[str]:
    wanted, explored = found.wanted, found.explored
    lines = [
        f"The quantity was computed at {explored.count} values from {wanted.parameter(wanted.low)} to"
        f" {wanted.parameter(wanted.high)}; a pair of solutions between two neighbouring values can be missed, which a narrower"
        " range finds."
    ]
    if explored.jumps:
        at = ", ".join(wanted.parameter(each) for each in explored.jumps)
        lines.append(f"The quantity passes the wanted value discontinuously at {wanted.free} = {at}.")
    if explored.refused:
        ends = sorted(explored.refused)
        count = (
            f"{len(ends)} of these values, from {wanted.parameter(ends[0])} to {wanted.parameter(ends[-1])}"
        )
        lines.append(f"Not computed at {count}, for instance: {explored.refused[ends[0]]}")
    if explored.unknown:
        lines.append(f"The quantity is not known at {explored.unknown} of these values.")
    return lines


def _tables(found: DesignedParameter) -> list[Table]:
    wanted = found.wanted
    solution: dict[str, Callable[[FoundValue], str]] = {
        wanted.free: lambda each: _span(found, each).removeprefix("any value from "),
        wanted.name: lambda each: wanted.quantity(each.root.reached),
        "limits": lambda each: "; ".join(row.text for row in each.failed) or "no limit exceeded",
    }
    influence: dict[str, Callable[[Elasticity], str]] = {
        "parameter": lambda each: each.path,
        "value": lambda each: each.shown,
        "elasticity": lambda each: f"{each.value:+.3g}",
    }
    return [
        Table.of(f"Values of {wanted.free}", found.solutions, solution),
        Table.of(f"Elasticities of {wanted.free}", _notable(found), influence),
    ]
