"""Response of many fingers to one piecewise linear drive."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from electrovib.core.errors import InputError
from electrovib.solve.population.kernels.choice import compiled
from electrovib.solve.population.kernels.time_steps import (
    BLOCK,
    COMPENSATED,
    SMALLEST,
    TimeSteps,
    decay_correction,
    step_weights,
    time_steps,
)

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import ArrayLike, DTypeLike, NDArray

    from electrovib.core.arrays import Real

_TIMES: Final = 64  # times whose responses are in memory together
_KNOWN: Final = 64  # durations of steps whose weights are in memory together


class Fingers(NamedTuple):
    """Sums of relaxing modes of many fingers, and the drive that all of them share.

    Parameters
    ----------
    rates, residues, state : ndarray, shape (fingers, modes)
        As for `first_order_hold_many`.
    direct : ndarray, shape (fingers,)
        As for `first_order_hold_many`.
    voltage : ndarray, shape (n,)
        Drive at the times.
    steps : TimeSteps
        Steps between the times.
    """

    rates: Real
    residues: Real
    direct: Real
    state: Real
    voltage: Real
    steps: TimeSteps

    def some(self, part: slice) -> Fingers:
        """Return the fingers of a range."""
        return self._replace(
            rates=self.rates[part],
            residues=self.residues[part],
            direct=self.direct[part],
            state=self.state[part],
        )


def first_order_hold_many(
    rates: ArrayLike,
    residues: ArrayLike,
    direct: ArrayLike,
    state: ArrayLike,
    voltage: ArrayLike,
    time: ArrayLike | TimeSteps,
    *,
    factor: ArrayLike | None = None,
    dtype: DTypeLike = np.float64,
    out: NDArray[Any] | None = None,
    threads: int | None = None,
) -> NDArray[Any]:
    """Compute the responses of many fingers to one piecewise linear drive, exact at every time.

    `rates` (fingers, modes), `residues` (fingers, modes), `direct` (fingers,), `state` (fingers, modes),
    `voltage` (n,) [V], `time` (n,) [s], `factor` (fingers,), `out` (fingers, n); returns `response` (fingers,
    n).

    Each mode is advanced by its exact weights for a straight drive. With the weights ``a`` of the state and ``A``,
    ``C`` of the drive at both ends of a step, ``w = (s - C v)/(a C + A)`` needs one multiplication and addition for each
    step of equal duration, ``w' = a w + v``. Every step of another duration begins with new weights. The result of a
    finger does not depend on the other fingers, to the last bit.
    """
    fingers = gather(rates, residues, direct, state, voltage, time)
    squared = None if factor is None else factors(factor, fingers)
    shape = len(fingers.direct), fingers.voltage.size
    result = np.empty(shape, dtype) if out is None else out
    if result.shape != shape or result.dtype != np.dtype(dtype) or not result.flags.c_contiguous:
        raise InputError(
            f"out has shape {result.shape} and type {result.dtype}: expected {shape} and {np.dtype(dtype)}."
        )
    if (kernel := compiled()) is not None:
        kernel.step(fingers, squared, result, threads)
        return result
    for begin in range(0, len(result), BLOCK):
        part = slice(begin, begin + BLOCK)
        for place, rows in blocks_of_times(fingers.some(part), None if squared is None else squared[part]):
            result[part, place : place + len(rows)] = rows.T
    return result


def gather(
    rates: ArrayLike,
    residues: ArrayLike,
    direct: ArrayLike,
    state: ArrayLike,
    voltage: ArrayLike,
    time: ArrayLike | TimeSteps,
) -> Fingers:
    """Convert the arguments of `first_order_hold_many` into contiguous arrays, and refuse arguments that disagree."""
    rate, residue, level, begin, drive = (
        np.ascontiguousarray(each, np.float64) for each in (rates, residues, direct, state, voltage)
    )
    steps = time if isinstance(time, TimeSteps) else time_steps(time)
    if (
        rate.ndim != 2
        or residue.shape != rate.shape
        or begin.shape != rate.shape
        or level.shape != rate.shape[:1]
    ):
        raise InputError(
            f"rates, residues and state have the shapes {rate.shape}, {residue.shape} and {begin.shape}, direct "
            f"{level.shape}: expected (fingers, modes) three times, and (fingers,)."
        )
    if drive.shape != (steps.kind.size + 1,):
        raise InputError(
            f"voltage has shape {drive.shape}: expected one value for each of {steps.kind.size + 1} times."
        )
    if not (np.isfinite(rate).all() and (rate >= 0.0).all()):
        raise InputError("rates has a value that is negative or not finite: expected minus the poles [1/s].")
    return Fingers(rate, residue, level, begin, drive, steps)


def factors(factor: ArrayLike, fingers: Fingers) -> Real:
    """Return the factor of each finger.

    `factor` (fingers,); returns `factor` (fingers,).
    """
    return np.ascontiguousarray(np.broadcast_to(np.asarray(factor, np.float64), fingers.direct.shape))


class _Weights(NamedTuple):
    """Weights for steps of one duration, (modes, fingers), and the direct share with that of the states, (fingers,)."""

    decay: Real
    scale: Real
    later: Real
    direct: Real
    correction: Real


def _weights(fingers: Fingers, duration: float) -> _Weights:
    rates, residues = fingers.rates.T, fingers.residues.T
    decay, earlier, later = step_weights(np.ascontiguousarray(rates), duration)
    scale = residues * (decay * later + earlier)
    scale = np.where(np.abs(scale) < SMALLEST, SMALLEST, scale)
    later = residues * later
    return _Weights(
        decay, scale, later, fingers.direct + _summed(later), decay_correction(rates, duration, decay)
    )


def _summed(rows: Real) -> Real:
    """Return the sum over modes, row after row, so that a column does not depend on the number of columns."""
    total = np.zeros(rows.shape[1])
    for row in rows:
        total += row
    return total


def blocks_of_times(fingers: Fingers, factor: Real | None) -> Iterator[tuple[int, Real]]:
    """Yield the responses of some fingers for some times after the other.

    `factor` (fingers,); returns `rows` (times, fingers).
    """
    rows, filled = np.empty((_TIMES, len(fingers.direct))), 0
    for place, values in enumerate(_responses(fingers)):
        rows[filled] = values if factor is None else factor * values * values
        filled += 1
        if filled == _TIMES or place + 1 == fingers.voltage.size:
            yield place + 1 - filled, rows[:filled]
            filled = 0


def _responses(fingers: Fingers) -> Iterator[Real]:
    """Yield the responses of some fingers at each time."""
    steps, voltage = fingers.steps, fingers.voltage.tolist()
    state = np.ascontiguousarray(fingers.state.T)
    known: dict[int, _Weights] = {}
    scaled, product = np.empty_like(state), np.empty_like(state)
    since, previous = [0] * steps.duration.size, -1
    weights = _weights(fingers, 0.0)
    for place, level in enumerate(voltage[:-1]):
        kind = int(steps.kind[place])
        if kind != previous:
            if previous >= 0:
                state = scaled * weights.scale + weights.later * level
            weights = known[kind] if kind in known else _weights(fingers, float(steps.duration[kind]))
            if len(known) < _KNOWN:
                known[kind] = weights
            scaled[:] = (state - weights.later * level) / weights.scale
            previous = kind
        np.multiply(scaled, weights.scale, out=product)
        yield _summed(product) + weights.direct * level
        scaled *= weights.decay
        scaled += level
        since[kind] += 1
        if since[kind] % COMPENSATED == 0:
            scaled *= weights.correction
    yield weights.direct * voltage[-1] + _summed(scaled * weights.scale if previous >= 0 else state)
