"""The widths of a designed value: what is needed at the ends of the thresholds, and for a force that the law misses."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection
from dataclasses import replace
from typing import TYPE_CHECKING, TypeAlias

from electrovib.physics.perception import Perception
from electrovib.studies import widths
from electrovib.studies.widths import Width

if TYPE_CHECKING:
    from electrovib.scenario import Scenario
    from electrovib.studies.design.wanted import Wanted

Sampled: TypeAlias = tuple[float, float, float]
"""Lower end for the number of draws, value, and upper end; NaN where no value gives what is wanted."""


def widths_of(
    scenario: Scenario,
    wanted: Wanted,
    main: Sampled,
    *,
    sampling: Width,
    drawn: Collection[str],
    needed: Callable[[Wanted, float], Sampled],
) -> tuple[Width, ...]:
    """Return the widths of the value `main`; `needed` computes it for another quantity, where the force has a factor."""
    unit, known = wanted.declared.unit, widths.factor_of(scenario, wanted.name)
    is_felt, factor = wanted.name == widths.LEVEL, known or 1.0
    names = (widths.HIGHEST_LEVEL, widths.LOWEST_LEVEL) if is_felt else (wanted.name, wanted.name)
    best, worst = (replace(wanted, name=name) for name in names)

    def alone(*cases: tuple[Wanted, float]) -> tuple[float, float]:
        return _between(*((value,) * 3 for _, value, _ in (main, *(needed(*case) for case in cases))))

    found, apart = [sampling], list[Width]()
    if is_felt:
        person = scenario.perception or Perception()
        has_skin = bool(person.compliance or scenario.finger)
        interval = alone((best, 1.0), (worst, 1.0))
        found.append(widths.threshold_width(person, interval, unit=unit, has_skin=has_skin))
        apart = [] if "perception.threshold" in drawn else [widths.BETWEEN_PEOPLE]
    missed = alone((wanted, factor), (wanted, 1 / factor)) if known else None
    found.append(widths.law_width(type(scenario.force).__name__, known, missed, unit=unit))
    parts = [each.name for each in found if each.interval and (each is not sampling or main[0] < main[2])]
    if len(parts) > 1:
        interval = _between(main, needed(best, factor), needed(worst, 1 / factor))
        text = ", ".join(parts)
        found.append(Width(name=widths.TOGETHER, text=text, interval=interval, unit=unit))
    return (*found, *apart)


def _between(main: Sampled, first: Sampled, second: Sampled) -> tuple[float, float]:
    """Return the ends of three values; NaN on the side on which no value gives what is wanted."""
    known = [each for each in (first, second) if not math.isnan(each[1])]
    low, high = min(each[0] for each in (main, *known)), max(each[2] for each in (main, *known))
    if len(known) == 2:
        return low, high
    is_below = bool(known) and known[0][1] < main[1]
    return low if is_below else math.nan, high if known and not is_below else math.nan
