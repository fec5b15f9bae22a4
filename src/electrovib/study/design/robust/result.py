"""Result of a design for a share of a population."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from electrovib.solve.quantities.answer import validity
from electrovib.study.check.result import not_in_rows
from electrovib.study.design.robust.words import lines_of, verdict_of

if TYPE_CHECKING:
    from electrovib.core.diagnostics import Diagnostic
    from electrovib.scenario import Scenario
    from electrovib.scenario.space import Space
    from electrovib.study.check import CheckResult, CheckRow, LimitsSource
    from electrovib.study.design.parameter.wanted import Wanted


@dataclass(frozen=True, kw_only=True)
class ShareAt:
    """Share of the fingers that have the wanted quantity at one value of the free parameter.

    `share` is that of the draws from which the value was found; `fresh_share`, of as many further draws, is
    no estimate at a value chosen with the same draws; `interval` is its 95 % confidence interval (Clopper and
    Pearson).
    """

    value: float
    share: float
    fresh_share: float
    interval: tuple[float, float]


@dataclass(frozen=True, kw_only=True)
class DesignedForShare:
    """Value of one parameter at which a quantity is as wanted for a share of a population.

    - `base`, `space`: the values that all fingers share, and distributions of what differs between them.
    - `wanted`, `band`: quantity and free parameter, and smallest and largest wanted value, the largest may be
      infinite.
    - `share`: the wanted one; `n`, `seed`: number of draws, and their seed.
    - `found`: the value; None if the share is not reached anywhere in the range.
    - `value_interval`: 95 % confidence interval of the value, for the finite number of draws; NaN without a
      value, infinite where the sample is too small for an end.
    - `ranges`: where the wanted share of the draws is reached.
    - `top`: `found`, or the value with the largest share where the wanted one is not reached; None if no draw
      has the wanted quantity.
    - `check`: of the draw that comes nearest to a limit, or exceeds it most, at `top`; `checked`: number of
      draws that were compared with the limits.
    - `within`: largest share within the limits, where the value exceeds one.
    - `method`: how the quantity of each finger was computed; `limits`: further limits that were given.
    """

    base: Scenario
    wanted: Wanted
    band: tuple[float, float]
    space: Space
    share: float
    n: int
    seed: int
    found: ShareAt | None
    value_interval: tuple[float, float]
    ranges: tuple[tuple[float, float], ...]
    top: ShareAt | None
    check: CheckResult | None
    checked: int
    within: ShareAt | None
    method: str
    limits: tuple[LimitsSource, ...]

    @property
    def value(self) -> float:
        """Value of the free parameter within the limits, in its SI unit; NaN if there is none."""
        return self.found.value if self.found is not None and self.is_achieved else math.nan

    @property
    def failed(self) -> tuple[CheckRow, ...]:
        """Limits that are exceeded at the value."""
        return () if self.check is None else self.check.failed

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
    def verdict(self) -> tuple[str, ...]:
        """The sentences among `lines` that are needed first, warnings included."""
        return verdict_of(self)

    @property
    def lines(self) -> tuple[str, ...]:
        """Sentences and numbers for people, the answer first."""
        return lines_of(self)

    def __str__(self) -> str:
        return "\n".join(self.lines)

    def to_dict(self) -> dict[str, Any]:
        """Return everything as nested tables with numbers in SI; what is not known or infinite is None."""
        wanted = self.wanted
        return {
            "form": "parameter for a share of a population",
            "quantity": {
                "name": wanted.name,
                "unit": wanted.unit,
                "low": self.band[0],
                "high": _plain(self.band[1]),
            },
            "free": {
                "path": wanted.free,
                "unit": wanted.declared.unit,
                "in_the_scenario": wanted.begin,
                "low": wanted.low,
                "high": wanted.high,
            },
            "share": self.share,
            "space": self.space.as_table(),
            "n": self.n,
            "seed": self.seed,
            "value": _plain(self.value),
            "found": _table(self.found),
            "value_interval": [_plain(each) for each in self.value_interval],
            "ranges": [list(each) for each in self.ranges],
            "largest_share": None if self.found is not None else _table(self.top),
            "largest_share_within_limits": _table(self.within),
            "is_achieved": self.is_achieved,
            "limits": None if self.check is None else self.check.to_dict()["limits"],
            "draws_compared_with_limits": self.checked,
            "method": self.method,
            "scenario": None if self.scenario is None else self.scenario.to_dict(),
            "diagnostics": [each.to_dict() for each in self.diagnostics],
            "text": list(self.lines),
        }


def _plain(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _table(each: ShareAt | None) -> dict[str, Any] | None:
    if each is None:
        return None
    return {
        "value": each.value,
        "share": each.share,
        "fresh_share": each.fresh_share,
        "interval": list(each.interval),
    }
