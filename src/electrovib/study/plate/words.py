"""Sentences and tables of the design of a plate."""

from __future__ import annotations

import math
from collections import Counter
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.units import KINDS, format_quantity
from electrovib.study.check.result import UNKNOWN
from electrovib.study.check.rows import not_compared
from electrovib.study.plate.choice import RELAXED, SAME
from electrovib.study.reproduction import Table

if TYPE_CHECKING:
    from electrovib.study.check import CheckRow
    from electrovib.study.plate.candidates import PlateCandidate
    from electrovib.study.plate.choice import Gain
    from electrovib.study.plate.objectives import Objective
    from electrovib.study.plate.result import PlateDesign

MOST_SHOWN: Final = 12
"""Largest number of members of the Pareto set that a table shows."""


def shown(value: float, unit: str) -> str:
    """Write a value with its unit."""
    if math.isnan(value):
        return "not known"
    if math.isinf(value):
        return "no bound"
    return format_quantity(value, unit, digits=4) if unit in KINDS else f"{value:.4g} {unit}".strip()


def plain(name: str) -> str:
    """Write the name of an objective or of a limit for people; a dotted path stays as it is."""
    return name if "." in name else name.replace("_", " ")


def place_of(design: PlateDesign, candidate: PlateCandidate) -> str:
    """Write material and parameters of a candidate."""
    parts = [candidate.material] if candidate.material else []
    parts += [f"{path} = {shown(value, design.units[path])}" for path, value in candidate.at.items()]
    return ", ".join(parts)


def answer(design: PlateDesign) -> str:
    """Return the sentences with which a result begins: best candidate, binding limit, gain, counts and doubts."""
    best, first = design.best, design.objectives[0]
    if best is None:
        return _none(design)
    value = shown(best.values[first.name], first.unit)
    ends = [] if design.gains else _ends(design, best)
    place = ("", "an end of the ranges: ", "a corner of the ranges: ")[min(len(ends), 2)]
    where = f"{value}, at {place}{place_of(design, best)}"
    sentences = [
        f"The {first.goal} {plain(first.name)} within the limits is {where}.",
        _binding(design, best, ends),
        *_nearest(best),
        *not_compared(best.rows),
        _counts(design),
        *_doubts(best),
    ]
    if design.check is not None and design.check.failed:
        names = ", ".join(row.quantity for row in design.check.failed)
        sentences.append(f"The full check of this plate fails: {names}.")
    return " ".join(sentences)


def _none(design: PlateDesign) -> str:
    count = len(design.candidates)
    if design.allowed:
        return f"{plain(design.objectives[0].name)} is not known for any of the {count} candidates that are within the limits."
    by = Counter(name for each in design.candidates for name in each.forbidden_by)
    name, most = by.most_common(1)[0]
    least = min(design.candidates, key=_excess)
    worst = ", ".join(
        f"{row.quantity} {shown(row.value or math.nan, row.unit)} (limit {shown(row.limit or math.nan, row.unit)})"
        for row in least.rows
        if row.quantity in least.forbidden_by
    )
    return (
        f"None of the {count} candidates is within the limits; {name} forbids {most} of them. The one that exceeds them least"
        f" is at {place_of(design, least)}: {worst}."
    )


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
        return (
            f"{_capital(' and '.join(gain.limits))} bind together: without all of them the candidates reach"
            f" {_reached(design, gain.without, best, first)}, and relaxing one alone gains nothing."
        )
    name = gain.limits[0]
    row = next(row for row in best.rows if row.quantity == name)
    at = f" ({_at_limit(row.value, row.limit, row.unit)})"
    without = f"without it {_reached(design, gain.without, best, first)}, at {place_of(design, gain.without)}"
    return f"{_capital(name)} binds{at}: {_slightly(design, gain, best, first)}, {without}."


def _slightly(design: PlateDesign, gain: Gain, best: PlateCandidate, first: Objective) -> str:
    percent = f"{100 * (RELAXED - 1):.0f} %"
    if gain.relaxed is None:
        return f"relaxing this limit by {percent} admits no better one of these candidates"
    return f"relaxed by {percent} it admits {_reached(design, gain.relaxed, best, first)}"


def _reached(design: PlateDesign, candidate: PlateCandidate, best: PlateCandidate, first: Objective) -> str:
    """Write the objective of a candidate and its change relative to the best one."""
    del design
    value, reference = candidate.values[first.name], best.values[first.name]
    text = shown(value, first.unit)
    if not reference or not math.isfinite(value / reference) or first.unit not in KINDS:
        return text
    ratio = value / reference
    return f"{text} ({ratio:.3g} times)" if ratio >= 2 else f"{text} ({100 * (ratio - 1):+.3g} %)"


def _at_limit(value: float | None, limit: float | None, unit: str) -> str:
    return f"{shown(math.nan if value is None else value, unit)} of {shown(math.nan if limit is None else limit, unit)}"


def _ends(design: PlateDesign, best: PlateCandidate) -> list[str]:
    """State at which ends of the ranges the best candidate lies."""
    ends = []
    for path, value in best.at.items():
        values = np.asarray(design.axes[path])
        if len(values) < 2:
            continue
        for which, edge in (("smallest", float(np.min(values))), ("largest", float(np.max(values)))):
            if abs(value - edge) <= SAME * abs(edge):
                ends.append(f"{path} has the {which} of its values")
    return ends


def nearest_limit(candidate: PlateCandidate) -> CheckRow | None:
    """Return the comparison whose value is nearest to its limit, or exceeds it most, whatever the status of that limit."""
    compared = [row for row in candidate.rows if row.margin is not None]
    return min(compared, key=lambda row: row.margin or 0.0, default=None)


def _nearest(best: PlateCandidate) -> list[str]:
    row = nearest_limit(best)
    if row is None:
        return []
    return [f"Closest limit: {_ratio(row)} ({_at_limit(row.value, row.limit, row.unit)})."]


def _ratio(row: CheckRow) -> str:
    """Write the name of a limit and the ratio of limit and value; a limit that decides nothing is marked."""
    return f"{row.quantity}, {row.margin or 0.0:.3g}{' (not judged)' if row.state == UNKNOWN else ''}"


def _counts(design: PlateDesign) -> str:
    words = ", ".join(f"{each.goal} {plain(each.name)}" for each in design.objectives)
    count, allowed, efficient_ones = len(design.candidates), len(design.allowed), len(design.pareto)
    text = f"{allowed} of {count} candidates {'is' if allowed == 1 else 'are'} within the limits"
    if len(design.objectives) < 2:
        return f"{text}."
    return f"{text}, {efficient_ones} of them {'is' if efficient_ones == 1 else 'are'} the Pareto set of {words}."


def _doubts(best: PlateCandidate) -> list[str]:
    return [
        f"This rests on a breakdown strength that is unverified or may not apply here: {text}."
        for text in best.doubts
    ]


def tables(design: PlateDesign) -> tuple[Table, ...]:
    """Lay a result out: limits at the best candidate, the Pareto set, and how many candidates each limit forbids."""
    found = []
    if design.best is not None:
        found.append(_limits_table(design, design.best))
    if design.pareto:
        found.append(_pareto_table(design))
    if len(design.allowed) < len(design.candidates):
        found.append(_forbidden_table(design))
    return tuple(found)


def _limits_table(design: PlateDesign, best: PlateCandidate) -> Table:
    rows = tuple(
        (
            row.state,
            row.quantity,
            shown(math.nan if row.value is None else row.value, row.unit),
            "" if row.limit is None else shown(row.limit, row.unit),
            "" if row.margin is None else f"{row.margin:.3g}",
            row.source,
        )
        for row in best.rows
    )
    headings = ("state", "quantity", "largest", "limit", "limit/value", "source of the limit")
    return Table(f"Limits at {place_of(design, best)}", headings, rows)


def _pareto_table(design: PlateDesign) -> Table:
    chosen = design.pareto
    if len(chosen) > MOST_SHOWN:
        places = np.unique(np.round(np.linspace(0, len(chosen) - 1, MOST_SHOWN)).astype(int))
        chosen = tuple(chosen[place] for place in places)
    material = ["material"] if any(each.material for each in design.candidates) else []
    headings = (
        *material,
        *design.axes,
        *(plain(each.name) for each in design.objectives),
        "closest limit",
        "strength",
    )
    rows = []
    for each in chosen:
        nearest = nearest_limit(each)
        rows.append(
            (
                *([each.material] if material else []),
                *(shown(each.at[path], design.units[path]) for path in design.axes),
                *(shown(each.values[one.name], one.unit) for one in design.objectives),
                "" if nearest is None else _ratio(nearest),
                "in doubt" if each.doubts else "",
            )
        )
    shown_of = "" if len(chosen) == len(design.pareto) else f", {len(chosen)} of {len(design.pareto)}"
    caption = (
        "Closest limit: the one with the smallest limit/value, and that ratio; not judged: it is unverified, or may not apply."
        " Strength in doubt: the breakdown strength is"
        " unverified, or was not measured on a layer of this thickness. The CSV file has every candidate."
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


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]
