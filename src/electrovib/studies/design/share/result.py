"""Result of the search for a value for a share of a population, in sentences and numbers."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.core.answer import REFERENCE, Curve, Panel
from electrovib.core.paths import words_at
from electrovib.core.units import format_quantity
from electrovib.scenario import Scenario
from electrovib.scenario.space import Space
from electrovib.solve.quantities.answer import validity
from electrovib.studies.check import CheckResult, CheckRow
from electrovib.studies.check.result import not_in_rows, not_shown, shown
from electrovib.studies.design.result import Designed
from electrovib.studies.design.wanted import Wanted
from electrovib.studies.widths import sentences

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.core.diagnostics import Diagnostic


@dataclass(frozen=True, kw_only=True)
class ShareAt:
    """Share of the fingers that have the wanted quantity at one value of the free parameter.

    `share` is that of the draws from which the value was found; `fresh_share` that of as many further draws, and `interval` its
    95 % confidence interval (Clopper and Pearson).
    """

    value: float
    share: float
    fresh_share: float
    interval: tuple[float, float]


@dataclass(frozen=True, kw_only=True, repr=False)
class DesignedForShare(Designed):
    """Value of one parameter at which a quantity is as wanted for a share of a population.

    - `base`, `space`: the values that all fingers share, and distributions of what differs between them.
    - `wanted`: quantity with its smallest and its largest wanted value, which may be infinite, and the free parameter.
    - `share`: the wanted one; `n`, `seed`: number of draws, and their seed.
    - `found`: the value; None if the share is not reached anywhere in the range.
    - `ranges`: where the wanted share of the draws is reached; `others`: share of the draws to the value at which it is just
      reached, NaN where it never is; empty for a band.
    - `top`: `found`, or the value with the largest share where the wanted one is not reached; None if no draw
      has the wanted quantity.
    - `shares`: values of the parameter, and the share of the draws at each.
    - `check`: of the draw that comes nearest to a limit, or exceeds it most, at `top`; `checked`: number of
      draws that were compared with the limits; `unchecked`: why they cannot be compared.
    - `within`: largest share within the limits, where the value exceeds one.
    """

    form = "parameter for a share of a population"
    base: Scenario
    wanted: Wanted
    space: Space
    share: float
    n: int
    seed: int
    found: ShareAt | None
    ranges: tuple[tuple[float, float], ...]
    others: Mapping[float, float]
    top: ShareAt | None
    shares: tuple[Real, Real]
    method: str
    check: CheckResult | None = None
    checked: int = 0
    unchecked: str = ""
    within: ShareAt | None = None

    @property
    def value(self) -> float:
        """Value of the free parameter within the limits, in its SI unit; NaN if there is none."""
        return self.found.value if self.found is not None and self.is_achieved else math.nan

    @property
    def value_interval(self) -> tuple[float, float]:
        """95 % interval of the value for the number of draws; NaN without a value, infinite where they are too few for an end."""
        return (math.nan, math.nan) if self.found is None else self.widths[0].interval or (math.nan, math.nan)

    @property
    def failed(self) -> tuple[CheckRow, ...]:
        """Limits that are exceeded at the value."""
        return () if self.check is None else self.check.forbidding

    @property
    def is_achieved(self) -> bool:
        """Whether the share is reached and no limit is exceeded."""
        return self.found is not None and not self.failed

    @property
    def scenario(self) -> Scenario | None:
        """Scenario with the value; None if the share is not reached within the limits."""
        return self.base.replace({self.wanted.free: self.value}) if self.is_achieved else None

    @property
    def diagnostics(self) -> tuple[Diagnostic, ...]:
        """Diagnostics of the scenario with its own values and the value that was found, beyond those that the check states."""
        judged = self.base if self.top is None else self.base.replace({self.wanted.free: self.top.value})
        return not_in_rows(validity(judged))

    @property
    def sentences(self) -> tuple[str, ...]:
        """The answer, its uncertainty and the limits."""
        return (_answer(self), *_uncertainty(self), *_limits(self))

    @property
    def details(self) -> tuple[str, ...]:
        """The values for other shares, how the quantity of each draw was computed, and what of the space is unverified."""
        known = {share: value for share, value in self.others.items() if math.isfinite(value)}
        others = ", ".join(f"{_percent(share)}: {_number(self, value)}" for share, value in known.items())
        return (
            *([f"{self.wanted.free} at which a share of the draws has it: {others}."] if known else []),
            f"{self.n} draws, seed {self.seed}; the quantity of each: {self.method}.",
            *self.space.remarks,
        )

    @property
    def figures(self) -> tuple[Panel, ...]:
        """The share of the draws over the free parameter, with the wanted one and the value."""
        free, (x, y) = self.wanted.free, self.shares
        at = np.array([] if self.top is None else [(self.top.value, self.top.share)]).reshape(-1, 2).T
        curves = (
            Curve(label="share of the draws", x=x, y=y),
            Curve(label="wanted", x=x, y=np.full_like(y, self.share), kind="dashed", look=REFERENCE),
            Curve(label="value", x=at[0], y=at[1], kind="points", look=1),
        )  # fmt: skip
        title = f"Share of the fingers with {wish(self)}"
        log = len(x) > 0 and x[0] > 0 and x[-1] > 30 * x[0]
        x_axis, said = (words_at(self.base, free), self.wanted.declared.unit), f"{self.n} draws."
        return (
            Panel(
                id="share", title=title, caption=said, x=x_axis, y=("share", "1"), curves=curves, log_x=log
            ),
        )

    def numbers(self) -> dict[str, Any]:
        """Return all numbers as nested tables."""
        wanted = self.wanted
        return {
            "quantity": {"name": wanted.name, "unit": wanted.unit, "low": wanted.value, "high": wanted.upper},
            "free": wanted.free_numbers(),
            "share": self.share,
            "space": self.space.as_table(),
            "n": self.n,
            "seed": self.seed,
            "value": self.value,
            "found": self.found and vars(self.found),
            "value_interval": self.value_interval,
            "ranges": self.ranges,
            "values_for_shares": {f"{each:g}": value for each, value in self.others.items()},
            "largest_share": None if self.found or not self.top else vars(self.top),
            "largest_share_within_limits": self.within and vars(self.within),
            "limits": self.check and self.check.to_dict()["limits"],
            "draws_compared_with_limits": self.checked,
            "method": self.method,
            "scenario": self.scenario and self.scenario.to_dict(),
        }


def wish(design: DesignedForShare) -> str:
    """Return the wanted quantity in words."""
    name = design.wanted.name.replace("_", " ")
    low, high = (
        design.wanted.quantity(each) if math.isfinite(each) else ""
        for each in (design.wanted.value, design.wanted.upper)
    )
    return f"{name} from {low} to {high}" if high else f"{name} of at least {low}"


def _answer(design: DesignedForShare) -> str:
    wanted, found, top = design.wanted, design.found, design.top
    if top is None:
        reach = f"from {wanted.parameter(wanted.low)} to {wanted.parameter(wanted.high)}"
        return f"No draw has a {wish(design)} for {wanted.free} {reach}."
    if found is None:
        return (
            f"A {wish(design)} is not reached for {_percent(design.share)} of the population: the largest share is"
            f" {_percent(top.share)}, at {_place(design, top)} (95 % interval of the share {_interval(top)})."
        )
    text = (
        f"{_place(design, found)} gives a {wish(design)} for {_percent(found.share)} of the draws; wanted:"
        f" {_percent(design.share)}."
    )
    if design.failed:
        text += f" It exceeds the limits: {', '.join(row.quantity for row in design.failed)}."
    return text


def _uncertainty(design: DesignedForShare) -> list[str]:
    widths = sentences(design.widths)
    if design.found is None:
        return [*widths]
    ranges = " and ".join(_range(design, low, high) for low, high in design.ranges)
    return [
        f"{widths[0]} The share is reached from {ranges}.",
        *widths[1:],
        f"Of {design.n} further draws {_percent(design.found.fresh_share)} have it there: 95 % interval of the share of the"
        f" population {_interval(design.found)}.",
    ]


def _range(design: DesignedForShare, low: float, high: float) -> str:
    """Write a range; an end that is only the end of the search is called so."""
    begins = "the beginning of the searched range, " if low <= design.wanted.low else ""
    ends = "the end of the searched range, " if high >= design.wanted.high else ""
    return f"{begins}{_number(design, low)} to {ends}{_number(design, high)}"


def _limits(design: DesignedForShare) -> list[str]:
    if design.check is None:
        return [f"The limits could not be compared: {design.unchecked}"] if design.unchecked else []
    lines = [
        f"{row.text} ({shown(row.value, row.unit)} of {shown(row.limit, row.unit)})" for row in design.failed
    ]
    if design.within is not None:
        each = design.within
        lines.append(
            f"Within the limits the largest share of the draws is {_percent(each.share)}, at {_place(design, each)}"
            f" (95 % interval of the share of the population {_interval(each)})."
        )
    elif design.failed:
        lines.append("No value that was tried is within the limits.")
    lines += [f"{each[0].upper()}{each[1:]}." for each in not_shown(design.check.rows)]
    lines.append(
        f"The limits were compared for the scenario as it is and for {design.checked} draws, those with the largest quantity and"
        " those at either end of every drawn parameter, not for all draws."
    )
    return lines


def _place(design: DesignedForShare, at: ShareAt) -> str:
    return f"{design.wanted.free} = {_number(design, at.value)}"


def _number(design: DesignedForShare, value: float) -> str:
    return format_quantity(value, design.wanted.declared.unit, digits=4)


def _percent(share: float) -> str:
    return f"{100 * share:.4g} %"


def _interval(each: ShareAt) -> str:
    return f"{100 * each.interval[0]:.3g} to {100 * each.interval[1]:.3g} %"
