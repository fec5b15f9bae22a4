"""The drive that all fingers share: straight pieces on a grid of all outputs and corners, and sines."""

from __future__ import annotations

import functools
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.physics.drive.parts import Smooth, Tones, circling
from electrovib.physics.drive.pieces import SLACK, Linear
from electrovib.solve.population.kernels import TimeSteps, time_steps
from electrovib.solve.population.together.refusal import NotTogetherError

if TYPE_CHECKING:
    from electrovib.core.arrays import Indices, Real
    from electrovib.physics.drive.base import Drive

MOST_CORNERS: Final = 200_000
"""Corners of a drive up to the last output time beyond which fingers are computed one by one."""
MOST_PIECES: Final = 4096
"""Straight pieces of one period beyond which the periodic state is computed one by one."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Period:
    """Straight pieces of one period of a drive in its periodic state.

    Parameters
    ----------
    lengths : ndarray, shape (pieces,)
        Duration of each piece [s].
    begins, ends : ndarray, shape (pieces,)
        Drive just after the beginning and just before the end of each piece [V].
    """

    lengths: Real
    begins: Real
    ends: Real


@dataclass(frozen=True, eq=False, kw_only=True)
class Tone:
    """One sine that is on at all output times: cosine and sine amplitude.

    Parameters
    ----------
    frequency : float
        Frequency [Hz], 0 for a constant.
    cosine, sine : float
        Amplitudes of cosine and sine [V].
    """

    frequency: float
    cosine: float
    sine: float


@dataclass(frozen=True, eq=False, kw_only=True)
class Excitation:
    """A drive as sums of straight pieces and of sines.

    Parameters
    ----------
    outputs : ndarray, shape (n,)
        Output times, increasing, >= 0 [s].
    time : ndarray, shape (m,)
        Time 0, outputs and corners of the straight pieces, not decreasing; a discontinuity has its time twice [s].
    voltage : ndarray, shape (m,)
        Straight pieces at these times [V].
    places : ndarray of int, shape (n,)
        Index of each output in `time`.
    periods : tuple of Period
        Pieces that have been repeating since long before time 0.
    level : float
        Constant voltage to which all modes have settled at time 0 [V].
    tones : tuple of Tone
        Sines.
    settled : bool
        Whether the drive has been on since long before time 0.
    is_straight : bool
        Whether there are straight pieces.
    """

    outputs: Real
    time: Real
    voltage: Real
    places: Indices
    periods: tuple[Period, ...]
    level: float
    tones: tuple[Tone, ...]
    settled: bool
    is_straight: bool

    @functools.cached_property
    def steps(self) -> TimeSteps:
        """Steps of the grid."""
        return time_steps(self.time)

    @functools.cached_property
    def runs(self) -> tuple[tuple[slice, slice], ...]:
        """Ranges of outputs, and of the points of the grid that they are; one where all points are outputs."""
        begins = np.flatnonzero(np.diff(self.places, prepend=-2) != 1)
        ends = [*begins[1:].tolist(), len(self.places)]
        first = self.places[begins].tolist()
        return tuple(
            (slice(begin, end), slice(at, at + end - begin))
            for begin, end, at in zip(begins.tolist(), ends, first, strict=True)
        )

    @functools.cached_property
    def waves(self) -> tuple[Real, Real]:
        """Cosine and sine of each tone at the outputs, shape (tones, n)."""
        shape = len(self.tones), len(self.outputs)
        found = [circling(tone.frequency, self.outputs) for tone in self.tones]
        return (
            np.array([cosine for cosine, _ in found]).reshape(shape),
            np.array([sine for _, sine in found]).reshape(shape),
        )

    def values(self) -> Real:
        """Return the drive at its output times [V], shape (n,)."""
        total = self.voltage[self.places] + self.level
        for tone, cosine, sine in zip(self.tones, *self.waves, strict=True):
            total = total + tone.cosine * cosine + tone.sine * sine
        return np.asarray(total)

    def numbers(self) -> Real:
        """Return everything that is linear in the amplitude of the drive, as one row."""
        tones = [each for tone in self.tones for each in (tone.cosine, tone.sine)]
        ends = [each for period in self.periods for each in (period.begins, period.ends)]
        return np.concatenate([self.voltage, *ends, [self.level], tones])

    def with_numbers(self, numbers: Real) -> Excitation:
        """Return the same drive with other amplitudes, a row [V] as from `numbers`."""
        at = len(self.voltage)
        voltage, periods = numbers[:at], []
        for period in self.periods:
            count = len(period.lengths)
            ends = numbers[at : at + count], numbers[at + count : at + 2 * count]
            periods.append(replace(period, begins=ends[0], ends=ends[1]))
            at += 2 * count
        level, rest = float(numbers[at]), numbers[at + 1 :].reshape(-1, 2)
        tones = tuple(
            replace(tone, cosine=float(cosine), sine=float(sine))
            for tone, (cosine, sine) in zip(self.tones, rest, strict=True)
        )
        return replace(self, voltage=voltage, periods=tuple(periods), level=level, tones=tones)

    def has_shape_of(self, other: Excitation) -> bool:
        """Return whether another drive differs in its amplitudes alone."""
        return (
            np.array_equal(self.time, other.time)
            and np.array_equal(self.places, other.places)
            and len(self.periods) == len(other.periods)
            and all(
                np.array_equal(mine.lengths, its.lengths)
                for mine, its in zip(self.periods, other.periods, strict=True)
            )
            and [tone.frequency for tone in self.tones] == [tone.frequency for tone in other.tones]
        )


def excitation(drive: Drive, time: Real, *, settled: bool) -> Excitation:
    """Return a drive as straight pieces and sines.

    `time` (n,) [s].
    """
    parts = drive.parts()
    kind = type(drive).__name__
    straight = [part for part in parts if isinstance(part, Linear)]
    tones = [
        _tones(part, kind, float(time[-1]), settled=settled) for part in parts if isinstance(part, Tones)
    ]
    if any(isinstance(part, Smooth) for part in parts):
        raise NotTogetherError(f"{kind} is neither made of straight pieces nor of sines")
    level = 0.0
    if settled:
        level = sum(float(part.after[0]) for part in straight if part.is_step)
        straight = [part for part in straight if not part.is_step]
    grid, voltage, places = _grid(straight, time, kind) if straight else _only_outputs(time)
    return Excitation(
        outputs=time,
        time=grid,
        voltage=voltage,
        places=places,
        periods=tuple(_period(part, kind) for part in straight) if settled else (),
        level=level,
        tones=tuple(tone for some in tones for tone in some),
        settled=settled,
        is_straight=bool(straight),
    )


def _only_outputs(time: Real) -> tuple[Real, Real, Indices]:
    """Return time 0 and the outputs, at which there is no voltage of straight pieces."""
    return np.concatenate([[0.0], time]), np.zeros(len(time) + 1), np.arange(1, len(time) + 1)


def _tones(part: Tones, kind: str, end: float, *, settled: bool) -> list[Tone]:
    always = part.start == -np.inf if settled else part.start <= 0
    if not (always and part.stop > end):
        raise NotTogetherError(f"{kind} has sines that are switched within the output times")
    return [
        Tone(frequency=float(frequency), cosine=float(amplitude.real), sine=float(-amplitude.imag))
        for frequency, amplitude in zip(part.frequencies, part.amplitudes, strict=True)
    ]


def _period(part: Linear, kind: str) -> Period:
    if part.period is None or len(part.times) > MOST_PIECES:
        raise NotTogetherError(f"{kind} has more than {MOST_PIECES} straight pieces in a period")
    return Period(lengths=np.diff(part.times), begins=part.after[:-1], ends=part.before[1:])


def _grid(parts: list[Linear], time: Real, kind: str) -> tuple[Real, Real, Indices]:
    """Return outputs and corners, the drive there, and the places of the outputs.

    An output within the rounding of a corner is at that corner, as for one finger.
    """
    end = float(time[-1])
    if sum(part.count_breaks(end) for part in parts) > MOST_CORNERS:
        raise NotTogetherError(f"{kind} has more than {MOST_CORNERS} corners up to the last output time")
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
