"""Exponentials of vectors, and the weights of relaxing modes for one step."""

from __future__ import annotations

from math import factorial
from typing import Any, Final

from electrovib.solve.population.kernels.time_steps import COMPENSATED, SMALLEST
from electrovib.solve.recursion.vectors.jit import inlined, inner
from electrovib.solve.recursion.vectors.lanes import fma, load, shift_exponent, splat, store, where
from electrovib.solve.recursion.vectors.width import WIDTH

_SHIFT: Final = 6755399441055744.0  # 1.5 * 2^52: a sum with it is rounded to a whole number in its last bits
_PER_OCTAVE: Final = 1.4426950408889634  # 1/log(2)
_HIGH: Final = 0.6931471803691238  # log(2), whose last 21 bits are 0, and the rest of it
_LOW: Final = 1.9082149292705877e-10
_FEWEST: Final = -708.0  # below it exp is 0 here: subnormal numbers are not formed
_TERMS: Final = tuple(1.0 / factorial(order) for order in range(13, 1, -1))
_SERIES: Final = tuple(1.0 / factorial(order) for order in range(19, 1, -1))


@inlined
def exponential(number: Any) -> Any:
    """Return exp of numbers up to 700, to about 1e-16 relative; 0 below -708.

    exp(x) = 2^n exp(r) with n = round(x/log 2), and the series of exp(r) for abs(r) <= log(2)/2 up to order 13.
    """
    low = splat(_FEWEST)
    x = where(number < low, low, number)
    turned = fma(x, splat(_PER_OCTAVE), splat(_SHIFT))
    whole = turned - splat(_SHIFT)
    rest = fma(whole, splat(-_LOW), fma(whole, splat(-_HIGH), x))
    total = splat(_TERMS[0])
    for term in _TERMS[1:]:
        total = fma(total, rest, splat(term))
    total = fma(fma(total, rest * rest, rest), splat(1.0), splat(1.0))
    return where(number < low, splat(0.0), shift_exponent(total, turned))


@inner
def write_weights(work: Any, at: Any, modes: Any, duration: Any, to: Any) -> Any:
    """Write the weights of modes for one duration: decay, scale, 1/scale, later, correction; and the direct share.

    Rates, residues and direct share are at `at`, and the weights are written to `to`. The formulas are those of
    `step_weights` and `decay_correction`.
    """
    size = modes * WIDTH
    one, step, level = splat(1.0), splat(duration), load(work, at + 2 * size)
    for mode in range(0, size, WIDTH):
        u, residue = load(work, at + mode) * step, load(work, at + size + mode)
        small = where(u < one, u, one)
        series = splat(_SERIES[0])
        for term in _SERIES[1:]:
            series = fma(series, small, splat(term))
        risen = fma(small, series, one)
        near = one / fma(small, risen, one)
        far, large = exponential(-u), where(u < one, one, u)
        decay = where(u < one, near, far)
        mean = where(u < one, risen * near, (one - far) / large)
        earlier = where(u < one, near * series, (mean - far) / large)
        later = mean - earlier
        scale = residue * step * fma(decay, later, earlier)
        least, most = splat(-SMALLEST), splat(SMALLEST)
        scale = where(scale < most, where(scale > least, most, scale), scale)
        later = residue * step * later
        level = level + later
        store(work, to + mode, decay)
        store(work, to + size + mode, scale)
        store(work, to + 2 * size + mode, one / scale)
        store(work, to + 3 * size + mode, later)
        store(work, to + 4 * size + mode, _correction(u, mean, decay))
    store(work, to + 5 * size, level)


@inlined
def _correction(u: Any, mean: Any, decay: Any) -> Any:
    """Return the exact decay over many steps over that of as many rounded factors; 1 for fast modes.

    1 - decay is exact, and u mean = 1 - exp(-u) to rounding of itself: their difference is the error of the decay.
    """
    one = splat(1.0)
    error = fma(-u, mean, one - decay)
    return where(u < splat(0.1), fma(error / decay, splat(float(COMPENSATED)), one), one)
