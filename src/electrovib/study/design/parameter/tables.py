"""The result of the search for one parameter as tables of words."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from electrovib.core.units import format_quantity
from electrovib.study.reproduction import Table

if TYPE_CHECKING:
    from electrovib.study.design.parameter.result import DesignedParameter


def tables_of(found: DesignedParameter) -> list[Table]:
    """Lay solutions, percentiles and elasticities out."""
    wanted, spread = found.wanted, found.distribution
    solutions = tuple(
        (
            wanted.parameter(each.value)
            + ("" if each.until is None else f" to {wanted.parameter(each.until)}"),
            wanted.quantity(each.reached),
            "; ".join(row.text for row in each.failed) or "no limit exceeded",
        )
        for each in found.solutions
    )
    percentiles = (
        ()
        if spread is None
        else tuple(
            (f"{percent} %", wanted.parameter(value))
            for percent, value in spread.percentiles().items()
            if math.isfinite(value)
        )
    )
    influences = tuple(
        (each.path, format_quantity(each.at, each.unit, digits=4), f"{each.value:+.3g}")
        for each in found.influences
        if abs(each.value) >= 0.01
    )
    every = [
        Table(f"Values of {wanted.free}", (wanted.free, wanted.name, "limits"), solutions),
        Table(f"Distribution of {wanted.free}", ("percentile", wanted.free), percentiles),
        Table(f"Elasticities of {wanted.free}", ("parameter", "value", "elasticity"), influences),
    ]
    return [table for table in every if table.rows]
