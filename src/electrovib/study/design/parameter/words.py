"""The result of the search for one parameter in sentences, the answer first."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

from electrovib.core.diagnostics import warning_lines
from electrovib.core.units import format_quantity
from electrovib.study.check.result import UNKNOWN
from electrovib.study.check.rows import not_compared

if TYPE_CHECKING:
    from electrovib.study.check import CheckRow
    from electrovib.study.design.parameter.result import DesignedParameter, FoundValue

_MOST_INFLUENCES: Final = 6
_NEGLIGIBLE: Final = 0.01
"""Elasticity below which a parameter is not listed."""


def lines_of(found: DesignedParameter) -> tuple[str, ...]:
    """Return a result in sentences."""
    return (*verdict_of(found), *_influences(found), *_how(found))


def verdict_of(found: DesignedParameter) -> tuple[str, ...]:
    """Return the sentences that a user needs first: the answer, other solutions, limits, the spread, and warnings."""
    warned = warning_lines(found.diagnostics, brief=True)
    return (*_answer(found), *_others(found), *_limits(found), *_spread(found), *warned)


def _answer(found: DesignedParameter) -> list[str]:
    wanted, best = found.wanted, found.best
    aim = f"{wanted.name} = {wanted.quantity(wanted.value)}"
    if best is not None:
        return [f"{wanted.free} = {_span(found, best)} gives {aim}{_extreme(best)}."]
    reach = f"from {wanted.parameter(wanted.low)} to {wanted.parameter(wanted.high)}"
    if not found.solutions:
        (low_at, low), (high_at, high) = found.explored.lowest, found.explored.highest
        near = (low_at, low) if wanted.value < low else (high_at, high) if wanted.value > high else None
        lines = [
            f"No value of {wanted.free} {reach} gives {aim}: it reaches from {wanted.quantity(low)} (at"
            f" {wanted.parameter(low_at)}) to {wanted.quantity(high)} (at {wanted.parameter(high_at)})."
        ]
        if near is not None:
            lines.append(
                f"Nearest: {wanted.quantity(near[1])} at {wanted.free} = {wanted.parameter(near[0])}."
            )
        return [*lines, *_obtainable(found)]
    lines = [f"No value of {wanted.free} {reach} gives {aim} within the limits."]
    for each in found.solutions:
        lines += [f"{_span(found, each)} would, but {row.text}." for row in each.failed]
    return [*lines, *_obtainable(found)]


def _obtainable(found: DesignedParameter) -> list[str]:
    wanted, near = found.wanted, found.obtainable
    if near is None:
        if found.explored.count and found.solutions:
            return ["Every value that could be computed exceeds a limit."]
        return []
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
    return [f"Other solutions{_share_listed(found)}: {'; '.join(words)}."]


def _share_listed(found: DesignedParameter) -> str:
    """Return how many of all solutions are listed, in parentheses; nothing if all of them are."""
    listed, explored = len(found.solutions), found.explored
    if explored.is_all:
        return ""
    least = "" if explored.is_settled else "at least "
    return f" ({listed} with the first, of {least}{listed + explored.beyond}; a narrower range, between, finds the others)"


def _span(found: DesignedParameter, each: FoundValue) -> str:
    first = found.wanted.parameter(each.value)
    return first if each.until is None else f"any value from {first} to {found.wanted.parameter(each.until)}"


def _extreme(each: FoundValue) -> str:
    return ", which is an extreme value of the quantity" if each.is_extreme else ""


def _limits(found: DesignedParameter) -> list[str]:
    """Return the nearest limit of the first solution, what could not be compared, and what is not declared."""
    best = found.best
    if best is None:
        return []
    if best.check is None:
        return [f"The limits could not be compared: {best.problem}"]
    judged = [row for row in best.check.rows if row.value is not None and row.limit and row.state != UNKNOWN]
    lines = []
    if judged:
        row = max(judged, key=_share)
        lines.append(f"Nearest limit: {row.text} ({_share(row):.3g} of that limit).")
    open_rows = [row for row in best.check.rows if row.state == UNKNOWN and row.limit is not None]
    lines += [f"Not judged: {row.text}." for row in open_rows]
    lines += not_compared(best.check.rows)
    return lines


def _share(row: CheckRow) -> float:
    assert row.value is not None
    assert row.limit
    return row.value / row.limit


def _influences(found: DesignedParameter) -> list[str]:
    listed = [each for each in found.influences if abs(each.value) >= _NEGLIGIBLE][:_MOST_INFLUENCES]
    if not listed:
        return []
    words = ", ".join(
        f"{each.path} ({format_quantity(each.at, each.unit, digits=4)}) {each.value:+.2g}" for each in listed
    )
    return [
        f"Elasticities of {found.wanted.free} (its relative change over that of the parameter, for the same"
        f" {found.wanted.name}): {words}."
    ]


def _spread(found: DesignedParameter) -> list[str]:
    spread = found.distribution
    if spread is None:
        return []
    count = len(spread.values)
    how = "linear propagation from the medians" if spread.is_linear else "each draw solved anew"
    named = f"'{spread.title}'" if spread.title else "the space"
    values = ", ".join(
        f"{percent} %: {found.wanted.parameter(float(f'{value:.4g}'))}"
        for percent, value in spread.percentiles().items()
        if math.isfinite(value)
    )
    lines = [
        f"Distribution of {found.wanted.free} over {count} draws from {named} (seed {spread.seed}, {how}): {values or 'none'}."
    ]
    if spread.unsolved:
        lines.append(
            f"{spread.unsolved} of {count} draws have no value in the range; the percentiles are those of the others."
        )
    return [*lines, *spread.remarks]


def _how(found: DesignedParameter) -> list[str]:
    wanted, explored = found.wanted, found.explored
    lines = [
        f"The quantity was computed at {explored.count} values from {wanted.parameter(wanted.low)} to"
        f" {wanted.parameter(wanted.high)}; a pair of solutions between two neighbouring values can be missed, which a narrower"
        " range (between) finds."
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
