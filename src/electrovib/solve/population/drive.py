"""The drive of many fingers as a sum of drives with one timing, each times the value of a parameter."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, TypeAlias

import numpy as np

from electrovib.core.errors import InputError
from electrovib.core.paths import quantity_at
from electrovib.physics.drive.parts import Part
from electrovib.solve.stack.transfer import NotInArraysError

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from electrovib.core.arrays import Real
    from electrovib.scenario import Scenario

_SAME: Final = 1e-13
"""Difference over the largest number up to which two drives agree."""
_TEST_FACTORS: Final = ((0.53, 0.75, 0.11), (0.97, 0.51, 0.37), (0.81, 0.93, 0.73))
"""Factors of a value at which a drive is compared with a linear one, for paths in turn; of the largest value for a 0."""

SharedDrive: TypeAlias = "dict[str, tuple[Part, ...]]"
"""A drive as the sum of its values times these, by the paths of its parameters; of the empty path the value is 1."""


def shared_drive(scenario: Scenario, begin: Mapping[str, float]) -> SharedDrive:
    """Find the fixed drives whose sum is the drive of every finger, with the values of its free parameters in the scenario."""
    parts = scenario.drive.parts()
    if not begin:
        return {"": parts}
    base = _levels(parts)
    slopes, rest = {}, base
    for path in begin:
        nudged = 0.5 * begin[path] or 0.5 * quantity_at(scenario, path).high
        other = _with(scenario, {**begin, path: nudged}, parts)  # a level may follow another
        slopes[path] = (other - base) / (nudged - begin[path])
        rest = rest - slopes[path] * begin[path]
    sizes = [float(np.max(np.abs(slope))) * abs(begin[path]) for path, slope in slopes.items()]
    size = max([float(np.max(np.abs(base), initial=0.0)), *sizes])
    for factors in _TEST_FACTORS:
        point = {
            path: begin[path] * factors[place % 2] or factors[2] * quantity_at(scenario, path).high
            for place, path in enumerate(begin)
        }
        expected = rest + sum(slopes[path] * point[path] for path in begin)
        seen = _with(scenario, point, parts)
        if np.any(np.abs(seen - expected) > _SAME * max(size, float(np.max(np.abs(seen), initial=0.0)))):
            raise NotInArraysError(f"the drive is not linear in {', '.join(begin)}")
    rows = slopes if np.all(np.abs(rest) <= _SAME * size) else {"": rest} | slopes
    return {path: _with_levels(parts, row) for path, row in rows.items()}


def _with(scenario: Scenario, point: Mapping[str, float], parts: Sequence[Part]) -> Real:
    """Return the levels at other values of the parameters, where the timing has to be that of these parts."""
    try:
        changed = scenario.replace(dict(point)).drive.parts()
    except InputError as error:
        listed = ", ".join(point)
        raise NotInArraysError(f"the range of {listed} depends on other parameters: {error}") from None
    if len(changed) != len(parts) or not all(map(_is_alike, changed, parts)):
        raise NotInArraysError(f"{', '.join(point)} changes more of the drive than its amplitude")
    return _levels(changed)


def _is_alike(one: Part, other: Part) -> bool:
    """Return whether two parts differ in their levels alone."""
    return type(one) is type(other) and all(map(np.array_equal, one.timing, other.timing))


def _levels(parts: Sequence[Part]) -> Real:
    """Return the levels of all parts in one row."""
    return np.concatenate([np.zeros(0), *(part.levels for part in parts)])


def _with_levels(parts: Sequence[Part], row: Real) -> tuple[Part, ...]:
    """Return parts with the timing of some and other levels."""
    ends = np.cumsum([len(part.levels) for part in parts])
    return tuple(part.with_levels(own) for part, own in zip(parts, np.split(row, ends[:-1]), strict=True))
