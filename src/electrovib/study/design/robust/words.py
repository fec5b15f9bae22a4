"""Sentences of a design for a share of a population."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from electrovib.core.diagnostics import warning_lines
from electrovib.core.units import format_quantity
from electrovib.study.check.result import shown

if TYPE_CHECKING:
    from electrovib.study.design.robust.result import DesignedForShare, ShareAt


def lines_of(design: DesignedForShare) -> tuple[str, ...]:
    """Write a result for people."""
    drawn = f"{design.n} draws, seed {design.seed}; the quantity of each: {design.method}."
    return (*verdict_of(design), drawn, *design.space.remarks)


def verdict_of(design: DesignedForShare) -> tuple[str, ...]:
    """Return the sentences that a user needs first: the answer, its uncertainty, the limits, and warnings."""
    lines = [_answer(design)]
    if design.found is not None:
        lines += _uncertainty(design, design.found)
    lines += [*_limits(design), *warning_lines(design.diagnostics, brief=True)]
    return tuple(lines)


def wish(design: DesignedForShare) -> str:
    """Return the wanted quantity in words."""
    name = design.wanted.name.replace("_", " ")
    low, high = (design.wanted.quantity(each) if math.isfinite(each) else "" for each in design.band)
    return f"{name} from {low} to {high}" if high else f"{name} of at least {low}"


def _answer(design: DesignedForShare) -> str:
    wanted = design.wanted
    if design.found is None:
        if design.top is None:
            text = f"No draw has a {wish(design)}"
            return f"{text} for {wanted.free} from {wanted.parameter(wanted.low)} to {wanted.parameter(wanted.high)}."
        top = design.top
        return (
            f"A {wish(design)} is not reached for {_percent(design.share)} of the population: the largest share is"
            f" {_percent(top.share)}, at {wanted.free} = {_number(design, top.value)} (95 % interval of the share"
            f" {_interval(top)})."
        )
    at = f"{wanted.free} = {_number(design, design.found.value)}"
    text = f"{at} gives a {wish(design)} for {_percent(design.found.share)} of the draws; wanted: {_percent(design.share)}."
    if design.failed:
        names = ", ".join(row.quantity for row in design.failed)
        text += f" It exceeds the limits: {names}."
    return text


def _uncertainty(design: DesignedForShare, found: ShareAt) -> list[str]:
    low, high = (
        _number(design, each) if math.isfinite(each) else "no bound (too few draws)"
        for each in design.value_interval
    )
    ranges = " and ".join(_range(design, low, high) for low, high in design.ranges)
    return [
        f"95 % interval of the value for {design.n} draws: {low} to {high}. The share is reached from {ranges}.",
        f"Of {design.n} further draws {_percent(found.fresh_share)} have it there: 95 % interval of the share of the"
        f" population {_interval(found)}.",
    ]


def _range(design: DesignedForShare, low: float, high: float) -> str:
    """Write a range; an end that is only the end of the search is called so."""
    begins = "the beginning of the searched range, " if low <= design.wanted.low else ""
    ends = "the end of the searched range, " if high >= design.wanted.high else ""
    return f"{begins}{_number(design, low)} to {ends}{_number(design, high)}"


def _limits(design: DesignedForShare) -> list[str]:
    if design.check is None:
        return []
    lines = [
        f"{row.text} ({shown(row.value, row.unit)} of {shown(row.limit, row.unit)})" for row in design.failed
    ]
    if design.within is not None:
        each = design.within
        lines.append(
            f"Within the limits the largest share of the draws is {_percent(each.share)}, at {design.wanted.free} ="
            f" {_number(design, each.value)} (95 % interval of the share of the population {_interval(each)})."
        )
    elif design.failed:
        lines.append("No value that was tried is within the limits.")
    lines.append(
        f"The limits were compared for the scenario as it is and for the {design.checked} draws with the largest quantity, not"
        " for all draws."
    )
    return lines


def _number(design: DesignedForShare, value: float) -> str:
    return format_quantity(value, design.wanted.declared.unit, digits=4)


def _percent(share: float) -> str:
    return f"{100 * share:.4g} %"


def _interval(each: ShareAt) -> str:
    return f"{100 * each.interval[0]:.3g} to {100 * each.interval[1]:.3g} %"
