"""Result of the design of a plate: the best candidate, what binds there, the Pareto set, and all in sentences and tables."""

from __future__ import annotations

import functools
import math
from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar, Final

import numpy as np

from electrovib.core.answer import Document, Drawing, Page, Table, as_sentence
from electrovib.core.arrays import Real
from electrovib.core.units import KINDS
from electrovib.data.atomic import Form, csv_text
from electrovib.solve.quantities.answer import validity
from electrovib.studies.check import result
from electrovib.studies.design.result import Designed

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from electrovib.core.diagnostics import Diagnostic
    from electrovib.scenario import Scenario
    from electrovib.studies.check import CheckRow
    from electrovib.studies.design.plate.function import Objective, PlateCandidate

RELAXED: Final = 1.1
"""Factor by which the binding limit is relaxed, to state what that gains; a choice."""
SAME: Final = 1e-9
"""Relative difference up to which two values count as equal: rounding."""
MOST_SHOWN: Final = 12
"""Largest number of members of the Pareto set that a table shows."""


@dataclass(frozen=True, kw_only=True)
class Gain:
    """What is reached with one limit relaxed and all others kept, or with several if no single one gains anything.

    `relaxed` is the best candidate with the limit `RELAXED` times as large, None if it gains nothing or there
    are several; `without` is that without the limit.
    """

    limits: tuple[str, ...]
    relaxed: PlateCandidate | None
    without: PlateCandidate


@dataclass(frozen=True, kw_only=True, repr=False)
class PlateDesign(Designed):
    """Candidates of a plate, compared with every limit.

    - `base`: the scenario as it was given; `layer`: whose material is varied, empty where the material is
      kept.
    - `axes`, `units`: dotted path to the values that were asked for, in SI, and to their unit.
    - `objectives`: the first one decides which candidate is the best.
    - `candidates`: all of them.
    - `check`: `electrovib.check` of the best candidate; None if there is none.
    - `notes`: what was assumed, and what was not compared.
    """

    FILES: ClassVar = {"candidates.csv": Form.TABLE} | dict(Designed.FILES)
    form = "plate"
    base: Scenario
    layer: str
    axes: Mapping[str, Real]
    units: Mapping[str, str]
    objectives: tuple[Objective, ...]
    candidates: tuple[PlateCandidate, ...]
    notes: tuple[str, ...]

    @functools.cached_property
    def allowed(self) -> tuple[PlateCandidate, ...]:
        """Candidates that exceed no limit."""
        return tuple(each for each in self.candidates if each.is_allowed)

    @functools.cached_property
    def best(self) -> PlateCandidate | None:
        """Best candidate within all limits; None if there is none."""
        return best_of(self.candidates, self.objectives)

    @functools.cached_property
    def pareto(self) -> tuple[PlateCandidate, ...]:
        """Candidates within all limits of which no other one is better in one objective and no worse in the others.

        They are in order from the best to the worst in the first objective.
        """
        costs = np.array([[one.cost(each) for one in self.objectives] for each in self.allowed])
        kept = pareto_set(costs.reshape(len(self.allowed), len(self.objectives)))
        found = [each for each, is_kept in zip(self.allowed, kept.tolist(), strict=True) if is_kept]
        return tuple(sorted(found, key=self.objectives[0].cost))

    @functools.cached_property
    def gains(self) -> tuple[Gain, ...]:
        """Limits that bind at the best candidate, and what is reached with one of them relaxed."""
        return () if self.best is None else tuple(gains_of(self.best, self.candidates, self.objectives))

    @property
    def scenario(self) -> Scenario | None:
        """Scenario of the best candidate; None if there is none."""
        return None if self.check is None else self.check.scenario

    @property
    def diagnostics(self) -> tuple[Diagnostic, ...]:
        """Warnings of the best candidate, or of the scenario where there is none, beyond those that the limits state."""
        return result.not_in_rows(validity(self.base)) if self.best is None else self.best.diagnostics

    @property
    def document(self) -> Document:
        """What is best and what binds, the limits there, the Pareto set, and the check of the best plate."""
        best = self.best
        said = _none(self) if best is None else _answer(self, best)
        tables = [] if best is None else [result.limits_table(f"Limits at {place_of(self, best)}", best.rows)]
        tables += [_pareto_table(self)] if self.pareto else []
        tables += [_forbidden_table(self)] if len(self.allowed) < len(self.candidates) else []
        caption = (
            "Every sign is one candidate. No candidate on the line can be improved in one objective without loss in the other;"
            " the star is the best one in the first objective."
        )
        figure = Drawing(
            id="pareto", title="Candidates and Pareto set", caption=caption, plot="trade_off", of=self
        )
        pages = [] if self.check is None else [Page("Check of the best plate", self.check.notes)]
        found = self._document(said, remarks=self.notes, tables=tables, figures=[figure], pages=pages)
        title = f"Design of the plate: {self.base.titled() or 'a scenario'}"
        return replace(found, title=title, brief=False)

    def content(self, name: str) -> str:
        """Write a row for each candidate, with every objective and every limit, or all numbers as JSON."""
        if not name.endswith(".csv"):
            return super().content(name)
        units = {row.quantity: row.unit for each in self.candidates for row in each.rows}
        rows = [self._cells(each, units) for each in self.candidates]
        remarks = [" ".join(self.document.sentences), *self.notes]
        headings = [heading for heading, _ in rows[0]]
        cells = [[cell for _, cell in row] for row in rows]
        return csv_text(headings, cells, remarks=remarks, diagnostics=self.diagnostics)

    def _cells(self, each: PlateCandidate, units: Mapping[str, str]) -> list[tuple[str, object]]:
        """Return all of a candidate, each with its heading, and the limits of the quantities with these units."""
        yes = {True: "yes", False: "no"}
        found: list[tuple[str, object]] = [("material", each.material)]
        found += [(f"{path} [{self.units[path]}]", each.at[path]) for path in self.axes]
        found += [(f"{one.name} [{one.unit}]", each.values[one.name]) for one in self.objectives]
        by_quantity = {row.quantity: row for row in each.rows}
        for name, unit in units.items():
            heads = f"{name} [{unit}]", f"limit of {name} [{unit}]", f"{name}: limit/value", f"{name}: state"
            row = by_quantity.get(name)
            cells = (row.value, row.limit, row.margin, row.state) if row else ("",) * len(heads)
            found += zip(heads, cells, strict=True)
        return [
            *found,
            ("within the limits", yes[each.is_allowed]),
            ("forbidden by", "; ".join(each.forbidden_by)),
            ("Pareto set", yes[any(each is one for one in self.pareto)]),
            ("best", yes[each is self.best]),
            ("refined", yes[each.refined]),
            ("strength in doubt", "; ".join(each.doubts)),
        ]

    def numbers(self) -> dict[str, Any]:
        """Return all candidates as nested tables."""
        efficient = {id(each) for each in self.pareto}
        return {
            "objectives": {each.name: {"unit": each.unit, "goal": each.goal} for each in self.objectives},
            "candidates": [
                {
                    "material": each.material,
                    "at": each.at,
                    "values": each.values,
                    "forbidden_by": each.forbidden_by,
                    "is_efficient": id(each) in efficient,
                    "is_best": each is self.best,
                }
                for each in self.candidates
            ],
        }


def best_of(
    candidates: Sequence[PlateCandidate],
    objectives: Sequence[Objective],
    *,
    relaxed: Collection[str] = (),
    factor: float = math.inf,
) -> PlateCandidate | None:
    """Find the candidate within the limits that is best in the first objective; of equal ones, in the next.

    Limits of the `relaxed` quantities are multiplied by `factor`, or omitted where it is infinite.
    """
    known = [each for each in candidates if not math.isnan(each.values[objectives[0].name])]
    left = [each for each in known if each.is_allowed_with(relaxed, factor)]
    for objective in objectives:
        costs = [objective.cost(each) for each in left]
        least = min((cost for cost in costs if not math.isnan(cost)), default=math.nan)
        if not math.isnan(least):
            bound = least + SAME * abs(least)
            left = [each for each, cost in zip(left, costs, strict=True) if cost <= bound]
    return left[0] if left else None


def gains_of(
    best: PlateCandidate, candidates: Sequence[PlateCandidate], objectives: Sequence[Objective]
) -> list[Gain]:
    """Find the limits that bind: those without which a candidate would be better in the first objective than the best one.

    The largest gain comes first. Where no single limit gains anything, the limits that the best of all
    candidates exceeds together are returned.
    """
    first = objectives[0]

    def better(relaxed: Collection[str], factor: float = math.inf) -> PlateCandidate | None:
        """Return the best candidate with relaxed limits if it is better by more than rounding."""
        found = best_of(candidates, objectives, relaxed=relaxed, factor=factor)
        least = first.cost(best) - SAME * abs(first.cost(best))
        return found if found is not None and first.cost(found) < least else None

    found = []
    for name in {each.forbidden_by[0]: None for each in candidates if len(each.forbidden_by) == 1}:
        without = better([name])
        if without is not None:
            found.append(Gain(limits=(name,), relaxed=better([name], RELAXED), without=without))
    if not found:
        top = better({name for each in candidates for name in each.forbidden_by})
        found += [] if top is None else [Gain(limits=top.forbidden_by, relaxed=None, without=top)]
    return sorted(found, key=lambda gain: first.cost(gain.without))


def pareto_set(costs: ArrayLike) -> NDArray[np.bool_]:
    """Find the points that no other point dominates, with `costs` (n, objectives) that are each to be minimised.

    A point is dominated by one that is at most as large in every objective and smaller in one; equal points
    are efficient together, a point with NaN is not. In lexicographic order a point can be dominated by an
    earlier one only, and domination is transitive, so each point is compared with the efficient points before
    it.
    """
    values = np.asarray(costs, dtype=float)
    found = np.zeros(len(values), dtype=bool)
    known = np.flatnonzero(~np.any(np.isnan(values), axis=1))
    for place in known[np.lexsort(values[known].T[::-1])].tolist():
        point, before = values[place], values[found]
        found[place] = not np.any(np.all(before <= point, axis=1) & np.any(before < point, axis=1))
    return found


def plain(name: str) -> str:
    """Write the name of an objective or of a limit for people; a dotted path stays as it is."""
    return name if "." in name else name.replace("_", " ")


def place_of(design: PlateDesign, candidate: PlateCandidate) -> str:
    """Write material and parameters of a candidate."""
    parts = [candidate.material] if candidate.material else []
    parts += [f"{path} = {result.shown(value, design.units[path])}" for path, value in candidate.at.items()]
    return ", ".join(parts)


def _answer(design: PlateDesign, best: PlateCandidate) -> list[str]:
    first = design.objectives[0]
    ends = [] if design.gains else _ends(design, best)
    place = ("", "an end of the ranges: ", "a corner of the ranges: ")[min(len(ends), 2)]
    row = result.nearest_limit(best.rows)
    where = f"{result.shown(best.values[first.name], first.unit)}, at {place}{place_of(design, best)}"
    shown_safe = result.state_of(best.rows) == result.PASS
    which = "within all limits" if shown_safe else "of a plate that exceeds no limit it was compared with"
    sentences = [
        f"The {first.goal} {plain(first.name)} {which} is {where}.",
        _binding(design, best, ends),
        *([f"Closest limit: {_ratio(row)} ({_at_limit(row)})."] if row else []),
        *map(as_sentence, result.not_shown(best.rows)),
        *([] if shown_safe else _safest(design)),
        _counts(design),
    ]
    if design.failed:
        names = ", ".join(row.quantity for row in design.failed)
        sentences.append(f"The full check of this plate fails: {names}.")
    return sentences


def _safest(design: PlateDesign) -> list[str]:
    """Return the best candidate that is within all limits, beside a better one that is not shown to be safe."""
    safe = best_of(
        [each for each in design.candidates if result.state_of(each.rows) == result.PASS], design.objectives
    )
    if safe is None:
        return []
    first = design.objectives[0]
    return [
        f"Within all limits: {result.shown(safe.values[first.name], first.unit)}, at {place_of(design, safe)}."
    ]


def _none(design: PlateDesign) -> list[str]:
    count = len(design.candidates)
    if design.allowed:
        name = plain(design.objectives[0].name)
        return [f"{name} is not known for any of the {count} candidates that are within the limits."]
    by = Counter(name for each in design.candidates for name in each.forbidden_by)
    name, most = by.most_common(1)[0]
    least = min(design.candidates, key=_excess)
    worst = ", ".join(
        f"{row.quantity} {result.shown(row.value or None, row.unit)} (limit {result.shown(row.limit or None, row.unit)})"
        for row in least.rows
        if row.quantity in least.forbidden_by
    )
    return [
        f"None of the {count} candidates is within the limits; {name} forbids {most} of them.",
        f"The one that exceeds them least is at {place_of(design, least)}: {worst}.",
    ]


def _excess(candidate: PlateCandidate) -> float:
    """Return the largest value over its limit [1]."""
    margins = [row.margin for row in candidate.rows if row.quantity in candidate.forbidden_by]
    return max((1 / each if each else math.inf for each in margins), default=math.inf)


def _binding(design: PlateDesign, best: PlateCandidate, ends: list[str]) -> str:
    if not design.gains:
        decides = f"{' and '.join(ends)}, so the ranges decide" if ends else "it lies inside the ranges"
        return f"No limit binds: {decides}."
    gain, first = design.gains[0], design.objectives[0]
    if len(gain.limits) > 1:
        return as_sentence(
            f"{' and '.join(gain.limits)} bind together: without all of them the candidates reach"
            f" {_reached(gain.without, best, first)}, and relaxing one alone gains nothing"
        )
    name = gain.limits[0]
    row = next(row for row in best.rows if row.quantity == name)
    percent = f"{100 * (RELAXED - 1):.0f} %"
    slightly = f"relaxing this limit by {percent} admits no better one of these candidates"
    if gain.relaxed is not None:
        slightly = f"relaxed by {percent} it admits {_reached(gain.relaxed, best, first)}"
    without = f"without it {_reached(gain.without, best, first)}, at {place_of(design, gain.without)}"
    return as_sentence(f"{name} binds ({_at_limit(row)}): {slightly}, {without}")


def _reached(candidate: PlateCandidate, best: PlateCandidate, first: Objective) -> str:
    """Write the objective of a candidate and its change relative to the best one."""
    value, reference = candidate.values[first.name], best.values[first.name]
    text = result.shown(value, first.unit)
    if not reference or not math.isfinite(value / reference) or first.unit not in KINDS:
        return text
    ratio = value / reference
    return f"{text} ({ratio:.3g} times)" if ratio >= 2 else f"{text} ({100 * (ratio - 1):+.3g} %)"


def _at_limit(row: CheckRow) -> str:
    return f"{result.shown(row.value, row.unit)} of {result.shown(row.limit, row.unit)}"


def _ends(design: PlateDesign, best: PlateCandidate) -> list[str]:
    """State at which ends of the ranges the best candidate lies."""
    return [
        f"{path} has the {which} of its values"
        for path, value in best.at.items()
        for which, edge in (("smallest", np.min(design.axes[path])), ("largest", np.max(design.axes[path])))
        if len(design.axes[path]) > 1 and abs(value - edge) <= SAME * abs(edge)
    ]


def _ratio(row: CheckRow) -> str:
    """Write the name of a limit and the ratio of limit and value; a limit that decides nothing is marked."""
    return f"{row.quantity}, {row.margin or 0.0:.3g}{f' ({result.UNCERTAIN})' if row.state == result.UNKNOWN else ''}"


def _counts(design: PlateDesign) -> str:
    words = ", ".join(f"{each.goal} {plain(each.name)}" for each in design.objectives)
    count, allowed, efficient_ones = len(design.candidates), len(design.allowed), len(design.pareto)
    text = f"{allowed} of {count} candidates {'exceeds' if allowed == 1 else 'exceed'} no limit that they were compared with"
    if safe := sum(result.state_of(each.rows) == result.PASS for each in design.allowed):
        text += f", and {safe} of them {'is' if safe == 1 else 'are'} within all limits"
    else:
        text += ", none of them is shown to be safe"
    if len(design.objectives) < 2:
        return f"{text}."
    return f"{text}; {efficient_ones} of them {'is' if efficient_ones == 1 else 'are'} the Pareto set of {words}."


def _pareto_table(design: PlateDesign) -> Table:
    count = min(len(design.pareto), MOST_SHOWN)
    chosen = [
        design.pareto[place] for place in np.round(np.linspace(0, len(design.pareto) - 1, count)).astype(int)
    ]
    has_material = any(each.material for each in design.candidates)
    names = [*design.axes, *(plain(each.name) for each in design.objectives)]
    headings = (*["material"] * has_material, *names, "closest limit", "strength")
    rows = []
    for each in chosen:
        numbers = [(each.at[path], design.units[path]) for path in design.axes]
        numbers += [(each.values[one.name], one.unit) for one in design.objectives]
        nearest = result.nearest_limit(each.rows)
        row = [*[each.material] * has_material, *(result.shown(*number) for number in numbers)]
        rows.append((*row, _ratio(nearest) if nearest else "", "in doubt" if each.doubts else ""))
    shown_of = "" if len(chosen) == len(design.pareto) else f", {len(chosen)} of {len(design.pareto)}"
    caption = (
        "Closest limit: the one with the smallest limit/value, and that ratio; of uncertain standing: it is unverified, or may"
        " not apply. Strength in doubt: the breakdown strength is unverified, or was not measured on a layer of"
        " this thickness. The CSV file has every candidate."
    )
    return Table(f"Pareto set{shown_of}", headings, tuple(rows), caption=caption)


def _forbidden_table(design: PlateDesign) -> Table:
    by = Counter(name for each in design.candidates for name in each.forbidden_by)
    alone = Counter(each.forbidden_by[0] for each in design.candidates if len(each.forbidden_by) == 1)
    rows = tuple((name, str(count), str(alone[name])) for name, count in by.most_common())
    title = (
        f"What forbids {len(design.candidates) - len(design.allowed)} of {len(design.candidates)} candidates"
    )
    return Table(title, ("limit", "candidates", "of these by it alone"), rows)
