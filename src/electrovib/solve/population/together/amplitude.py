"""A drive whose amplitude differs between fingers, as a sum of fixed drives."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.errors import InputError
from electrovib.core.paths import quantity_at, value_at
from electrovib.solve.population.together.excitation import Excitation, excitation
from electrovib.solve.population.together.refusal import NotTogetherError

if TYPE_CHECKING:
    from collections.abc import Mapping

    from electrovib.core.arrays import Real
    from electrovib.scenario import Scenario

_SAME: Final = 1e-13
"""Difference over the largest number up to which two drives agree."""
_LOOKS: Final = ((0.53, 0.75, 0.11), (0.97, 0.51, 0.37), (0.81, 0.93, 0.73))
"""Factors of a value at which a drive is compared with a linear one, for paths in turn; of the largest value for a 0."""


@dataclass(frozen=True, eq=False, kw_only=True)
class SharedDrive:
    """A drive v = fixed + sum of value times share over the free parameters of the drive.

    Parameters
    ----------
    fixed : Excitation or None
        Part that all fingers share; None where it is 0.
    shares : mapping of str to Excitation
        Dotted path of a free parameter to the drive per unit of it.
    """

    fixed: Excitation | None
    shares: Mapping[str, Excitation]

    def terms(self, columns: Mapping[str, Real]) -> list[tuple[Any, Excitation]]:
        """Return factors and drives whose products add up to the drive of each finger."""
        found: list[tuple[Any, Excitation]] = [] if self.fixed is None else [(1.0, self.fixed)]
        return found + [(columns[path], share) for path, share in self.shares.items()]


def shared_drive(scenario: Scenario, free: tuple[str, ...], time: Real, *, settled: bool) -> SharedDrive:
    """Find the fixed drives whose sum is the drive of every finger.

    `time` (n,) [s].
    """
    base = excitation(scenario.drive, time, settled=settled)
    if not free:
        return SharedDrive(fixed=base, shares={})
    begin = {path: _value(scenario, path) for path in free}
    start = base.numbers()
    slopes, rest = {}, start
    for path in free:
        nudged = _nudged(scenario, path, begin[path])
        other = _with(
            scenario, begin | {path: nudged}, base, time, settled=settled
        )  # a level may follow another
        slopes[path] = (other.numbers() - start) / (nudged - begin[path])
        rest = rest - slopes[path] * begin[path]
    size = float(np.max(np.abs(start), initial=0.0))
    size = max([size, *(float(np.max(np.abs(slope))) * abs(begin[path]) for path, slope in slopes.items())])
    for look in _LOOKS:
        point = {
            path: begin[path] * look[place % 2] or look[2] * quantity_at(scenario, path).high
            for place, path in enumerate(free)
        }
        expected = rest + sum(slopes[path] * point[path] for path in free)
        seen = _with(scenario, point, base, time, settled=settled).numbers()
        if np.any(np.abs(seen - expected) > _SAME * max(size, float(np.max(np.abs(seen), initial=0.0)))):
            raise NotTogetherError(f"the drive is not linear in {', '.join(free)}")
    fixed = None if np.all(np.abs(rest) <= _SAME * size) else base.with_numbers(rest)
    return SharedDrive(fixed=fixed, shares={path: base.with_numbers(slope) for path, slope in slopes.items()})


def _with(
    scenario: Scenario, point: Mapping[str, float], base: Excitation, time: Real, *, settled: bool
) -> Excitation:
    """Return the drive at other values of its parameters, which has to have the shape of the first."""
    try:
        changed = scenario.replace(dict(point)).drive
    except InputError as error:
        listed = ", ".join(point)
        raise NotTogetherError(f"the range of {listed} depends on other parameters: {error}") from None
    found = excitation(changed, time, settled=settled)
    if not found.has_shape_of(base):
        raise NotTogetherError(f"{', '.join(point)} changes more of the drive than its amplitude")
    return found


def _value(scenario: Scenario, path: str) -> float:
    value = value_at(scenario, path)
    if not isinstance(value, float):
        raise NotTogetherError(f"{path} has no value in the scenario")
    return value


def _nudged(scenario: Scenario, path: str, value: float) -> float:
    """Return another value within the range of a parameter: half of it, or a share of the range for 0."""
    if value:
        return 0.5 * value
    return 0.5 * quantity_at(scenario, path).high
