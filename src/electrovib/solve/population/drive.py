"""The drive that fingers share: parts whose amplitudes are linear in the values that differ between fingers."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final, TypeAlias

import numpy as np

from electrovib.core.errors import InputError
from electrovib.core.paths import quantity_at
from electrovib.physics.drive.parts import Linear, Tones
from electrovib.solve.stack.transfer import NotInArraysError

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from electrovib.core.arrays import Real
    from electrovib.physics.drive.base import Drive
    from electrovib.scenario import Scenario

Parts: TypeAlias = "Sequence[Linear | Tones]"
SharedDrive: TypeAlias = "dict[str, Parts]"
"""A drive as the sum of its values times these parts, by the paths of its parameters; of the empty path the value is 1."""
Terms: TypeAlias = "list[tuple[Any, Parts]]"
"""Factors, 1 or a column (fingers, 1), and the parts of drives, whose sum is the drive."""
MOST_CORNERS: Final = 20_000
"""Corners of a part up to the last output time beyond which fingers are computed one by one."""
_SAME: Final = 1e-13
"""Difference over the largest number up to which two drives agree."""
_LOOKS: Final = ((0.53, 0.75, 0.11), (0.97, 0.51, 0.37), (0.81, 0.93, 0.73))
"""Factors of a value at which a drive is compared with a linear one, for paths in turn; of the largest value for a 0."""


def parts_of(drive: Drive, end: float) -> Parts:
    """Return the parts of a drive, straight pieces and sines; `end` is the last output time [s]."""
    every, kind = drive.parts(), type(drive).__name__
    parts = [part for part in every if isinstance(part, Linear | Tones)]
    if len(parts) < len(every):
        raise NotInArraysError(f"{kind} is neither made of straight pieces nor of sines")
    if any(part.count_breaks(end) > MOST_CORNERS for part in parts):
        raise NotInArraysError(f"{kind} has more than {MOST_CORNERS} corners up to the last output time")
    return parts


def shared_drive(scenario: Scenario, begin: Mapping[str, float], end: float) -> SharedDrive:
    """Find the fixed drives whose sum is the drive of every finger, with the values of its free parameters in the scenario.

    `end` is the last output time [s].
    """
    parts = parts_of(scenario.drive, end)
    if not begin:
        return {"": parts}
    base = _amplitudes(parts)
    slopes, rest = {}, base
    for path in begin:
        nudged = 0.5 * begin[path] or 0.5 * quantity_at(scenario, path).high
        other = _with(scenario, {**begin, path: nudged}, parts, end)  # a level may follow another
        slopes[path] = (other - base) / (nudged - begin[path])
        rest = rest - slopes[path] * begin[path]
    sizes = [float(np.max(np.abs(slope))) * abs(begin[path]) for path, slope in slopes.items()]
    size = max([float(np.max(np.abs(base), initial=0.0)), *sizes])
    for look in _LOOKS:
        point = {
            path: begin[path] * look[place % 2] or look[2] * quantity_at(scenario, path).high
            for place, path in enumerate(begin)
        }
        expected = rest + sum(slopes[path] * point[path] for path in begin)
        seen = _with(scenario, point, parts, end)
        if np.any(np.abs(seen - expected) > _SAME * max(size, float(np.max(np.abs(seen), initial=0.0)))):
            raise NotInArraysError(f"the drive is not linear in {', '.join(begin)}")
    rows = slopes if np.all(np.abs(rest) <= _SAME * size) else {"": rest} | slopes
    return {path: _with_amplitudes(parts, row) for path, row in rows.items()}


def _with(scenario: Scenario, point: Mapping[str, float], base: Parts, end: float) -> Real:
    """Return the amplitudes of the drive at other values of its parameters, which has to have the same times and frequencies."""
    try:
        changed = scenario.replace(dict(point)).drive
    except InputError as error:
        listed = ", ".join(point)
        raise NotInArraysError(f"the range of {listed} depends on other parameters: {error}") from None
    parts = parts_of(changed, end)
    mine, its = (_moments(each) for each in (base, parts))
    if len(mine) != len(its) or not all(map(np.array_equal, mine, its)):
        raise NotInArraysError(f"{', '.join(point)} changes more of the drive than its amplitude")
    return _amplitudes(parts)


def _moments(parts: Parts) -> list[Any]:
    """Return the times [s] and frequencies [Hz] of parts."""
    return [
        each
        for part in parts
        for each in (part.times if isinstance(part, Linear) else part.frequencies, part.start, part.stop)
    ]


def _amplitudes(parts: Parts) -> Real:
    """Return all amplitudes of parts in one row [V]."""
    rows = [
        each
        for part in parts
        for each in (
            (part.before, part.after)
            if isinstance(part, Linear)
            else (part.amplitudes.real, part.amplitudes.imag)
        )
    ]
    return np.concatenate(rows)


def _with_amplitudes(parts: Parts, row: Real) -> Parts:
    """Return parts with other amplitudes, from one row [V]."""
    found: list[Linear | Tones] = []
    for part in parts:
        count = len(part.times if isinstance(part, Linear) else part.frequencies)
        first, second, row = np.split(row, [count, 2 * count])
        if isinstance(part, Linear):
            found.append(replace(part, before=first, after=second))
        else:
            found.append(replace(part, amplitudes=first + 1j * second))
    return found
