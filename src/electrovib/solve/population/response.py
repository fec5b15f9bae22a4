"""The drive that fingers share, straight pieces on a grid of all outputs and corners and sines, and the responses to it."""

from __future__ import annotations

import functools
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final, TypeVar

import numpy as np

from electrovib.core.errors import InputError
from electrovib.core.paths import quantity_at, value_at
from electrovib.physics.drive.parts import SLACK, Linear, Smooth, Tones, circling
from electrovib.solve.population.kernels import TimeSteps, first_order_hold_many, time_steps
from electrovib.solve.recursion import hold_weights
from electrovib.solve.stack.harmonics import drive_mean, settled_integral
from electrovib.solve.stack.section import total_of
from electrovib.solve.stack.transfer import NotInArraysError, Transfer, integral_weight, without_integrators

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from electrovib.core.arrays import Complex, Indices, Real
    from electrovib.physics.drive.base import Drive
    from electrovib.scenario import Scenario

K = TypeVar("K")
MOST_CORNERS: Final = 200_000
"""Corners of a drive up to the last output time beyond which fingers are computed one by one."""
MOST_PIECES: Final = 4096
"""Straight pieces of one period beyond which the periodic state is computed one by one."""
_SAME: Final = 1e-13
"""Difference over the largest number up to which two drives agree."""
_LOOKS: Final = ((0.53, 0.75, 0.11), (0.97, 0.51, 0.37), (0.81, 0.93, 0.73))
"""Factors of a value at which a drive is compared with a linear one, for paths in turn; of the largest value for a 0."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Moments:
    """The times and frequencies of a drive, without its amplitudes.

    Parameters
    ----------
    outputs : ndarray, shape (n,)
        Output times, increasing, >= 0 [s].
    time : ndarray, shape (m,)
        Time 0, outputs and corners of the straight pieces, not decreasing; a discontinuity has its time twice [s].
    places : ndarray of int, shape (n,)
        Index of each output in `time`.
    lengths : tuple of ndarray, shape (pieces,)
        Durations of the pieces of each part that has been repeating since long before time 0 [s].
    frequencies : ndarray, shape (tones,)
        Frequencies of the sines, which are on at all outputs [Hz]; 0 for a constant.
    settled, is_straight : bool
        Whether the drive has been on since long before time 0, and whether it has straight pieces.
    """

    outputs: Real
    time: Real
    places: Indices
    lengths: tuple[Real, ...]
    frequencies: Real
    settled: bool
    is_straight: bool

    @functools.cached_property
    def steps(self) -> TimeSteps:
        """Steps of the grid."""
        return time_steps(self.time)

    @functools.cached_property
    def waves(self) -> Real:
        """Cosines and minus sines of all tones at the outputs, shape (2 tones, n)."""
        found = [circling(frequency, self.outputs) for frequency in self.frequencies.tolist()]
        rows = [cosine for cosine, _ in found] + [-sine for _, sine in found]
        return np.array(rows).reshape(len(rows), len(self.outputs))

    def agrees_with(self, other: Moments) -> bool:
        """Return whether another drive has the same times and frequencies."""
        mine, its = ((each.time, each.places, each.frequencies, *each.lengths) for each in (self, other))
        return len(mine) == len(its) and all(map(np.array_equal, mine, its))


class Excitation:
    """A drive as sums of straight pieces and of sines: its moments, and all of its amplitudes [V] in one row.

    Attributes
    ----------
    slopes, integral : ndarray, shape (n,)
        Rate of change of the straight pieces after each output [V/s]; integral of a settled drive without a mean [V s].
    rises, voltage : ndarray, shape (m,)
        Rise from each time of the grid to the next, no difference of large values, and the straight pieces there [V].
    mean, level : float
        Mean of a settled drive, and the constant to which all modes have settled at time 0 [V].
    tones : ndarray of complex, shape (tones,)
        Amplitudes of the sines [V].
    """

    def __init__(self, moments: Moments, row: Real) -> None:
        self.moments, self.row = moments, row
        outputs, grid, tones = len(moments.outputs), len(moments.time), len(moments.frequencies)
        parts = np.split(row, np.cumsum([outputs, outputs, grid, grid, 1, 1, tones, tones]))
        self.slopes, self.integral, self.rises, self.voltage, mean, level, real, imag, self._ends = parts
        self.mean, self.level, self.tones = float(mean[0]), float(level[0]), real + 1j * imag

    def periods(self) -> list[tuple[Real, Real, Real]]:
        """Return duration, begin and end of the pieces of each repeated part."""
        rest, found = self._ends, []
        for lengths in self.moments.lengths:
            begins, ends, rest = np.split(rest, [len(lengths), 2 * len(lengths)])
            found.append((lengths, begins, ends))
        return found

    def values(self) -> Real:
        """Return the drive at its output times [V], shape (n,)."""
        waves = np.concatenate([self.tones.real, self.tones.imag]) @ self.moments.waves
        return np.asarray(self.voltage[self.moments.places] + self.level + waves)


@dataclass(frozen=True, eq=False, kw_only=True)
class SharedDrive:
    """A drive v = fixed + sum of value times share over the free parameters of the drive.

    Parameters
    ----------
    fixed : Excitation or None
        What does not depend on them; None if there is nothing.
    shares : mapping of str to Excitation
        What each is multiplied with, by its stored path.
    """

    fixed: Excitation | None
    shares: Mapping[str, Excitation]

    def terms(self, columns: Mapping[str, Any]) -> list[tuple[Any, Excitation]]:
        """Return factors and drives whose products add up to the drive of each finger."""
        found: list[tuple[Any, Excitation]] = [] if self.fixed is None else [(1.0, self.fixed)]
        return found + [(columns[path], share) for path, share in self.shares.items()]


def excitation(drive: Drive, time: Real, *, settled: bool) -> Excitation:
    """Return a drive as straight pieces and sines.

    `time` (n,) [s].
    """
    parts, kind = drive.parts(), type(drive).__name__
    straight = [part for part in parts if isinstance(part, Linear)]
    tones = [part for part in parts if isinstance(part, Tones)]
    if any(isinstance(part, Smooth) for part in parts):
        raise NotInArraysError(f"{kind} is neither made of straight pieces nor of sines")
    for part in tones:
        always = part.start == -np.inf if settled else part.start <= 0
        if not (always and part.stop > time[-1]):
            raise NotInArraysError(f"{kind} has sines that are switched within the output times")
    level = 0.0
    if settled:
        level = sum(float(part.after[0]) for part in straight if part.is_step)
        straight = [part for part in straight if not part.is_step]
    grid, voltage, places = _grid(straight, time, kind) if straight else _only_outputs(time)
    rises = _rises(straight, grid, voltage)
    slopes = sum((part.slope(time) for part in straight), start=np.zeros(len(time)))
    periods = [_period(part, kind) for part in straight] if settled else []
    amplitudes = np.concatenate([np.zeros(0), *(part.amplitudes for part in tones)])
    moments = Moments(
        outputs=time,
        time=grid,
        places=places,
        lengths=tuple(lengths for lengths, _, _ in periods),
        frequencies=np.concatenate([np.zeros(0), *(part.frequencies for part in tones)]),
        settled=settled,
        is_straight=bool(straight),
    )
    ends = [each for _, begins, ends in periods for each in (begins, ends)]
    mean = drive_mean(drive) if settled else 0.0
    integral = settled_integral(drive, time) if settled and not mean else np.zeros(len(time))
    row: list[Any] = [
        slopes,
        integral,
        rises,
        voltage,
        [mean, level],
        amplitudes.real,
        amplitudes.imag,
        *ends,
    ]
    return Excitation(moments, np.concatenate(row))


def _only_outputs(time: Real) -> tuple[Real, Real, Indices]:
    """Return time 0 and the outputs, at which there is no voltage of straight pieces."""
    return np.concatenate([[0.0], time]), np.zeros(len(time) + 1), np.arange(1, len(time) + 1)


def _period(part: Linear, kind: str) -> tuple[Real, Real, Real]:
    """Return duration, begin and end of the pieces of one period."""
    if part.period is None or len(part.times) > MOST_PIECES:
        raise NotInArraysError(f"{kind} has more than {MOST_PIECES} straight pieces in a period")
    return np.diff(part.times), part.after[:-1], part.before[1:]


def _grid(parts: Sequence[Linear], time: Real, kind: str) -> tuple[Real, Real, Indices]:
    """Return outputs and corners, the drive there, and the places of the outputs.

    An output within the rounding of a corner is at that corner, as for one finger.
    """
    end = float(time[-1])
    if sum(part.count_breaks(end) for part in parts) > MOST_CORNERS:
        raise NotInArraysError(f"{kind} has more than {MOST_CORNERS} corners up to the last output time")
    corners = np.unique(np.concatenate([[0.0], *[part.until(end).times for part in parts]]))
    corners = corners[corners < end * (1 + SLACK)]
    corners = corners[
        np.diff(corners, prepend=-1.0) > 2 * SLACK * np.abs(corners)
    ]  # one point for two that agree
    after = np.sum([part.value(corners) for part in parts], axis=0)
    before = after.copy()
    before[1:] = np.sum([part.value_before(corners[1:]) for part in parts], axis=0)
    nearest = np.clip(np.searchsorted(corners, time * (1 + SLACK), side="right") - 1, 0, None)
    met = np.abs(time - corners[nearest]) <= SLACK * np.abs(time)
    moments = np.where(met, corners[nearest], time)
    steps = np.flatnonzero(before != after)
    lone = np.setdiff1d(np.arange(len(corners)), nearest[met])
    grid = np.concatenate([corners[steps], corners[lone], moments])
    kinds = np.concatenate([np.zeros(len(steps)), np.ones(len(lone)), np.full(len(moments), 2.0)])
    values = [before[steps], after[lone], np.sum([part.value(moments) for part in parts], axis=0)]
    order = np.lexsort((kinds, grid))
    places = np.flatnonzero(kinds[order] == 2)
    return grid[order], np.concatenate(values)[order], places


def _rises(parts: Sequence[Linear], grid: Real, voltage: Real) -> Real:
    """Return the rise of straight pieces from each time of a grid to the next [V], shape (m,)."""
    steps = np.diff(grid)
    slopes = sum((part.slope(grid[:-1] + steps / 2) for part in parts), start=np.zeros(len(steps)))
    return np.append(np.where(steps > 0, slopes * steps, np.diff(voltage)), 0.0)


def shared_drive(scenario: Scenario, free: tuple[str, ...], time: Real, *, settled: bool) -> SharedDrive:
    """Find the fixed drives whose sum is the drive of every finger, `free` being the stored paths of its free parameters.

    `time` (n,) [s].
    """
    base = excitation(scenario.drive, time, settled=settled)
    if not free:
        return SharedDrive(fixed=base, shares={})
    begin = {path: _value(scenario, path) for path in free}
    slopes, rest = {}, base.row
    own = slice(2 * len(time) + len(base.moments.time), None)  # what precedes it follows from it
    for path in free:
        nudged = 0.5 * begin[path] or 0.5 * quantity_at(scenario, path).high
        other = _with(scenario, begin | {path: nudged}, base)  # a level may follow another
        slopes[path] = (other.row - base.row) / (nudged - begin[path])
        rest = rest - slopes[path] * begin[path]
    sizes = [float(np.max(np.abs(slope[own]))) * abs(begin[path]) for path, slope in slopes.items()]
    size = max([float(np.max(np.abs(base.row[own]), initial=0.0)), *sizes])
    for look in _LOOKS:
        point = {
            path: begin[path] * look[place % 2] or look[2] * quantity_at(scenario, path).high
            for place, path in enumerate(free)
        }
        expected = rest + sum(slopes[path] * point[path] for path in free)
        seen = _with(scenario, point, base).row[own]
        if np.any(np.abs(seen - expected[own]) > _SAME * max(size, float(np.max(np.abs(seen), initial=0.0)))):
            raise NotInArraysError(f"the drive is not linear in {', '.join(free)}")
    fixed = None if np.all(np.abs(rest[own]) <= _SAME * size) else Excitation(base.moments, rest)
    shares = {path: Excitation(base.moments, slope) for path, slope in slopes.items()}
    return SharedDrive(fixed=fixed, shares=shares)


def _with(scenario: Scenario, point: Mapping[str, float], base: Excitation) -> Excitation:
    """Return the drive at other values of its parameters, which has to have the moments of the first."""
    try:
        changed = scenario.replace(dict(point)).drive
    except InputError as error:
        listed = ", ".join(point)
        raise NotInArraysError(f"the range of {listed} depends on other parameters: {error}") from None
    found = excitation(changed, base.moments.outputs, settled=base.moments.settled)
    if not found.moments.agrees_with(base.moments):
        raise NotInArraysError(f"{', '.join(point)} changes more of the drive than its amplitude")
    return found


def _value(scenario: Scenario, path: str) -> float:
    value = value_at(scenario, path)
    if not isinstance(value, float):
        raise NotInArraysError(f"{path} has no value in the scenario")
    return value


def respond(transfers: Mapping[K, Transfer], terms: Sequence[tuple[Any, Excitation]]) -> dict[K, Real]:
    """Compute the response of linear quantities to a sum of drives with factors.

    `terms` are factors, 1 or a column (fingers, 1), and drives with common moments; returns rows (fingers, n), or
    (1, n) for what does not differ.
    """
    known: dict[Any, Real] = {}
    found = {}
    for key, transfer in transfers.items():
        total = total_of(
            _driven(transfer if np.ndim(factor) == 0 else transfer * factor, drive, known)
            for factor, drive in terms
        )
        found[key] = total + _left(transfer, terms[0][1]) if np.any(transfer.free) else total
    return found


def some_of(transfers: Mapping[K, Transfer], part: slice) -> dict[K, Transfer]:
    """Return the transfer functions of some fingers; what several have in common stays common."""
    known: dict[int, Any] = {}

    def some(number: Any) -> Any:
        if np.ndim(number) < 2:
            return number
        return known.setdefault(id(number), number[part])

    names = ("rates", "gains", "direct", "slope", "free", "static")
    return {
        key: replace(each, **{name: some(getattr(each, name)) for name in names})
        for key, each in transfers.items()
    }


def joined(parts: Iterable[Real]) -> Real:
    """Return rows of ranges of fingers below each other."""
    found = list(parts)
    return found[0] if len(found) == 1 else np.concatenate(found)


def _rows(*arrays: Real) -> list[Real]:
    """Return arrays (modes,) and (fingers, modes) as arrays of one shape (fingers, modes)."""
    shape = np.broadcast_shapes(*(np.atleast_2d(each).shape for each in arrays))
    return [np.broadcast_to(each, shape) for each in arrays]


def _driven(transfer: Transfer, drive: Excitation, known: dict[Any, Real]) -> Real:
    """Return the response to a drive, without that to charge, shape (fingers or 1, n)."""
    moments, lags = drive.moments, transfer.static is not None
    if moments.settled and np.any(weight := integral_weight(transfer)):
        if drive.mean:
            raise NotInArraysError("the integral of a drive with a mean has no period")
        relaxing = _driven(without_integrators(transfer), drive, known)
        return np.asarray(relaxing + weight * drive.integral)
    at_once = np.atleast_2d(transfer.direct if transfer.static is None else transfer.static)
    rates, gains = _rows(transfer.rates, transfer.gains, at_once * np.ones(transfer.rates.shape[-1]))[:2]
    active = np.any(gains != 0, axis=0)
    rates, gains = rates[:, active], gains[:, active]
    state = sum(
        (gains * each[:, active] for each in _settled(transfer, drive, known)), start=np.zeros(rates.shape)
    )
    if lags:  # gain (x - v) in the place of gain x
        state = state - gains * drive.voltage[0]
    steady = zip(moments.frequencies.tolist(), drive.tones.tolist(), strict=True)
    for frequency, tone in () if moments.settled else steady:
        state = state - gains * (rates * tone / (rates + 2j * np.pi * frequency)).real
    if not (moments.is_straight or np.any(state)):
        found = np.zeros((len(rates), len(moments.outputs)))
    else:
        direct = np.broadcast_to(at_once, (len(rates), 1))[:, 0]
        found = _stepped(drive, rates, gains if lags else gains * rates, direct, state, lags=lags)
        if np.any(transfer.slope):
            found = found + transfer.slope * drive.slopes
    if drive.level:
        found = found + np.atleast_1d(transfer.at(0.0)).real[:, None] * drive.level
    if len(moments.frequencies):
        found = found + in_tones(transfer, moments.frequencies, drive.tones, moments.waves)
    return found


def in_tones(transfer: Transfer, frequencies: Real, tones: Complex, waves: Real) -> Real:
    """Return the response to sines that have always been on, shape (fingers or 1, n).

    `frequencies` (tones,) or (tones, fingers) [Hz]; `tones` (tones,) or (fingers, tones) [V]; `waves` (2 tones, n) or
    (fingers, 2 tones, n), cosines and minus sines at the outputs.
    """
    gain = np.stack([np.atleast_1d(transfer.at(each)) for each in frequencies], axis=1)
    own = gain * tones
    shares = np.concatenate([own.real, own.imag], axis=1)
    return np.asarray(shares @ waves if waves.ndim == 2 else (shares[:, None] @ waves)[:, 0])


def _settled(transfer: Transfer, drive: Excitation, known: dict[Any, Real]) -> list[Real]:
    """Return the states of all modes at the beginning of each repeated part, computed once for modes in common."""
    found = []
    for place, period in enumerate(drive.periods()):
        key = id(transfer.rates), id(drive), place
        if key not in known:
            known[key] = settled_state(np.atleast_2d(transfer.rates), *period)
        found.append(known[key])
    return found


def _left(transfer: Transfer, drive: Excitation) -> Real:
    """Return the response to charge at time 0; in the periodic state only trapped charge remains."""
    rates, free = _rows(transfer.rates, transfer.free)
    left = np.where(rates == 0, free, 0.0) if drive.moments.settled else free
    nothing = Excitation(drive.moments, np.zeros(len(drive.row)))
    return _stepped(nothing, rates, np.zeros(rates.shape), np.zeros(len(rates)), left, lags=False)


def _stepped(
    drive: Excitation, rates: Real, residues: Real, direct: Real, state: Real, *, lags: bool
) -> Real:
    """Return the response of modes to the straight pieces of a drive at its outputs."""
    moments, rises = drive.moments, drive.rises if lags else None
    return first_order_hold_many(
        rates, residues, direct, state, drive.voltage, moments.steps, rises=rises, places=moments.places
    )


def settled_state(rates: Real, lengths: Real, begins: Real, ends: Real) -> Real:
    """Return rate times the state of modes at the beginning of a period, in the periodic state.

    `rates` (...) [1/s], `lengths`, `begins`, `ends` (pieces,).
    """
    positive = np.where(rates > 0, rates, 1.0)  # the drive does not excite trapped charge
    state = np.zeros(rates.shape)
    for length, begin, end in zip(lengths.tolist(), begins.tolist(), ends.tolist(), strict=True):
        decay, first, last = hold_weights(-positive * length)
        state = decay * state + first * begin + last * end
    return np.asarray(state / -np.expm1(-positive * float(np.sum(lengths))))
