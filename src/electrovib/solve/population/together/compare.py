"""Comparison of fingers in arrays with the same fingers one by one, before arrays are used."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.errors import ElectrovibError
from electrovib.core.paths import quantity_at
from electrovib.solve.population.together.refusal import NotTogetherError

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.scenario import Scenario
    from electrovib.solve.population.one_by_one import OneByOne
    from electrovib.solve.population.together.over_frequency import OverFrequency
    from electrovib.solve.population.together.over_time import OverTime

AGREE: Final = 1e-11
"""Largest difference over the peak of a signal; a formula that is no formula of one finger differs by more."""
_NUDGE: Final = 0.05
_FAINT: Final = 1e-9
"""Share of the largest value that is compared for a parameter whose value is 0."""


def compare(together: OverTime | OverFrequency, alone: OneByOne, scenario: Scenario) -> None:
    """Refuse arrays whose fingers differ from the same fingers one by one."""
    draws = _two(alone, scenario)
    try:
        expected = alone.signals(draws)
    except ElectrovibError as error:
        raise NotTogetherError(f"not all values next to those of the scenario are allowed: {error}") from None
    try:
        found = together.signals(draws)
    except (TypeError, ValueError, AttributeError, AssertionError) as error:
        raise NotTogetherError(
            f"a formula of the scenario does not run on arrays ({type(error).__name__})"
        ) from None
    for name, rows in expected.items():
        for mine, its in zip(found[name], rows, strict=True):
            if not _agree(mine, its):
                raise NotTogetherError(f"{name} in arrays differs from that of one finger")


def _two(alone: OneByOne, scenario: Scenario) -> dict[str, Real]:
    """Return the values of the scenario, and values next to them within the ranges."""
    found = {}
    for path, value in alone.prepared.begin.items():
        if not isinstance(value, float):
            raise NotTogetherError(f"{path} has no value in the scenario")
        quantity = quantity_at(scenario, path)
        step = _NUDGE * abs(value) or _FAINT * max(abs(quantity.low), abs(quantity.high))
        found[path] = np.array([value, value - step if value + step > quantity.high else value + step])
    return found


def _agree(mine: Any, its: Any) -> bool:
    """Return whether the signals of one finger agree, NaN included."""
    unknown = np.isnan(its)
    if not np.array_equal(unknown, np.isnan(mine)):
        return False
    peak = float(np.max(np.abs(its[~unknown]), initial=0.0))
    return bool(np.all(np.abs(mine[~unknown] - its[~unknown]) <= AGREE * peak))
