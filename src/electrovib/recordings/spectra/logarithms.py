"""What is fitted of a spectrum: logarithms of its parts, their weights, and derivatives after the parameters of a material."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.constants import eps0
from electrovib.core.errors import InputError
from electrovib.core.numbers import with_numbers
from electrovib.recordings.fit.least_squares import FreeParameter

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from numpy.typing import ArrayLike

    from electrovib.core.arrays import Complex, Real
    from electrovib.physics.material import Material

LOSSES: Final = ("measured", "none", "unknown")
"""What is known of the loss of a spectrum: it is among the data, it is 0, or the data say nothing of it."""
_HELD: Final = frozenset({"reference_frequency"})
_LEAST_LOGARITHM: Final = 1e-18
_STEP: Final = 1e-7


def logarithms(permittivity: Complex, frequency: Real, loss: str) -> Real:
    """Compute the logarithms of permittivity and, if the loss was measured, of conductivity [S/m], one after the other."""
    if loss != "measured":
        with np.errstate(all="ignore"):
            return np.log(permittivity.real)
    conductivity = -permittivity.imag * 2 * math.pi * frequency * eps0
    with np.errstate(all="ignore"):
        return np.concatenate([np.log(permittivity.real), np.log(conductivity)])


def parts_of(loss: str) -> int:
    """Return how many parts of the permittivity are fitted."""
    return 2 if loss == "measured" else 1


def weights_of(noise: ArrayLike | None, count: int) -> Real | None:
    """Compute one over the relative standard deviation of permittivity and conductivity, shape (2, count)."""
    if noise is None:
        return None
    try:
        given = np.broadcast_to(np.asarray(noise, dtype=float), (2, count))
    except ValueError:
        raise InputError(f"noise: expected one number, {count} numbers or two rows of {count}") from None
    if not (np.isfinite(given).all() and (given > 0).all()):
        raise InputError("noise: expected relative standard deviations above 0")
    return 1 / given


def slopes_of(
    start: Material, values: Mapping[str, float], loss: str, rows: Callable[[Material], Real]
) -> Real:
    """Compute the derivatives, shape (n, parameters), of the numbers `rows` of a material after its parameters."""
    free = free_parameters(start, loss)
    base, columns = rows(with_numbers(start, values)), []
    for path, value in values.items():
        step = _STEP * max(abs(value), 1e-3 if not free[path].logarithmic else 0.0)
        moved = value + step if value + step <= free[path].upper else value - step
        columns.append((rows(with_numbers(start, dict(values) | {path: moved})) - base) / (moved - value))
    return np.column_stack(columns)


def free_parameters(start: Material, loss: str) -> dict[str, FreeParameter]:
    """Every number of a material that the data hold, within its range, by its logarithm where it may change by decades."""
    held = _HELD if loss == "measured" else _HELD | {"conductivity"}
    free = {}
    for path, value, quantity in start.parameters():
        if value is None or path in held or quantity is None:
            continue
        decades = quantity.high / max(quantity.low, _LEAST_LOGARITHM) > 1e3
        lower = max(quantity.low, _LEAST_LOGARITHM) if decades else quantity.low
        begin = min(max(float(value), lower), quantity.high)
        free[path] = FreeParameter(start=begin, lower=lower, upper=quantity.high, logarithmic=decades)
    return free
