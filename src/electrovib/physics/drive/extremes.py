"""What a drive does between two times: its extremes, its largest rate of change, and how many times show it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.physics.drive.parts import CYCLE_SAMPLES, MOST_SAMPLES, Linear, Smooth, Tones

if TYPE_CHECKING:
    from collections.abc import Sequence

    from electrovib.core.arrays import Complex, Indices, Real
    from electrovib.physics.drive.base import Drive
    from electrovib.physics.drive.parts import Part


TOLERANCE = 1e-12
"""Tolerance of a searched extreme, relative to the sum of the amplitudes."""
_DIVISIONS = 4
_CURVED = 2.0
"""Largest curvature of a formula over that of a sine of its highest frequency and its largest value."""


def extremes(parts: Sequence[Part], start: float, end: float) -> tuple[float, float]:
    """Find the lowest and the highest sum of parts between two times [V].

    Of a step at the start the value after it counts, of one at the end both values do.
    """
    at_end = sum(float(part.value(np.array(end))) for part in parts)
    if end <= start:
        return at_end, at_end
    if len(parts) == 1 and isinstance(parts[0], Linear) and parts[0].period is None:
        return _of_straight(parts[0], start, end, at_end)
    repeating = [part for part in parts if isinstance(part, Linear) and part.period]
    if sum(end / (part.period or end) * len(part.times) for part in repeating) > MOST_SAMPLES:
        bound = sum(part.bound() for part in parts)
        return -bound, bound
    straight = [part.until(end) for part in parts if isinstance(part, Linear)]
    others = [part for part in parts if not isinstance(part, Linear)]
    gates = [gate for part in others for gate in (part.start, part.stop) if start < gate < end]
    found = []
    for first, last in pairwise([start, *sorted(set(gates)), end]):
        middle = (first + last) / 2
        on = [part for part in others if part.start <= middle < part.stop]
        found.append(_Stretch.between(straight, on, first, last).extremes())
    lows, highs = zip(*found, strict=True)
    return min(*lows, at_end), max(*highs, at_end)


def _of_straight(part: Linear, start: float, end: float, at_end: float) -> tuple[float, float]:
    """Return the extremes of straight pieces, which lie at breaks or at the ends [V]."""
    inside = slice(np.searchsorted(part.times, start, side="right"), np.searchsorted(part.times, end))
    ends = [float(part.value(np.array(start))), float(part.value_before(np.array(end))), at_end]
    sides = part.after[inside], part.before[inside]
    return (
        min(*ends, *(float(np.min(side, initial=at_end)) for side in sides)),
        max(*ends, *(float(np.max(side, initial=at_end)) for side in sides)),
    )


@dataclass(frozen=True)
class _Stretch:
    """Straight pieces from corner to corner, with tones and formulas that are on for all of them.

    `begins` and `ends` of each piece (n,) [s]; voltage just `after` the beginning and just `before` the end
    of each (n,) [V]; `frequencies` (m,) [Hz] and complex peak `amplitudes` (m,) [V] of the tones.
    """

    begins: Real
    ends: Real
    after: Real
    before: Real
    frequencies: Real
    amplitudes: Complex
    formulas: tuple[Smooth, ...]

    @classmethod
    def between(
        cls, straight: Sequence[Linear], others: Sequence[Tones | Smooth], first: float, last: float
    ) -> _Stretch:
        corners = np.concatenate([[first, last], *(part.times for part in straight)])
        corners = np.unique(corners[(corners >= first) & (corners <= last)])
        begins, ends = corners[:-1], corners[1:]
        after, before = np.zeros(len(begins)), np.zeros(len(begins))
        for part in straight:
            after, before = after + part.value(begins), before + part.value_before(ends)
        tones = [part for part in others if isinstance(part, Tones)]
        frequencies = np.concatenate([np.zeros(1), *(part.frequencies for part in tones)])
        amplitudes = np.concatenate([np.zeros(1, complex), *(part.amplitudes for part in tones)])
        frequencies, place = np.unique(frequencies, return_inverse=True)
        together = np.zeros(len(frequencies), complex)
        np.add.at(together, place, amplitudes)
        level, kept = together[0].real, together != 0
        kept[0] = False
        formulas = tuple(part for part in others if isinstance(part, Smooth))
        return cls(begins, ends, after + level, before + level, frequencies[kept], together[kept], formulas)

    def extremes(self) -> tuple[float, float]:
        """Return the lowest and highest value [V]."""
        if not len(self.frequencies) and not self.formulas:
            values = np.concatenate([self.after, self.before])
            return float(np.min(values)), float(np.max(values))
        if len(self.frequencies) == 1 and not self.formulas:
            return self._of_one_tone()
        searched = self._search()
        return self._bounds() if searched is None else searched

    def _oscillating(self, times: Real) -> Real:
        waves = Tones(self.frequencies, self.amplitudes).value(times)
        return np.asarray(waves + sum(part.whenever(times) for part in self.formulas), dtype=float)

    def _straight(self, pieces: Indices | slice, times: Real) -> Real:
        """Return the value of straight pieces at some times in them [V]; exact at both ends."""
        begins, ends = self.begins[pieces], self.ends[pieces]
        share = (times - begins) / (ends - begins)
        return np.asarray(self.after[pieces] * (1 - share) + self.before[pieces] * share)

    def _of_one_tone(self) -> tuple[float, float]:
        """Return the extremes of one tone on straight pieces, from the ends and the outermost crests of each piece [V]."""
        angular, amplitude = 2 * np.pi * self.frequencies[0], complex(self.amplitudes[0])
        size, phase = abs(amplitude), math.atan2(amplitude.imag, amplitude.real)
        slope = (self.before - self.after) / (self.ends - self.begins)
        with np.errstate(over="ignore"):  # a tone too small for a crest
            steep = np.clip(slope / (size * angular), -1.0, 1.0)
        values = [
            self.after + self._oscillating(self.begins),
            self.before + self._oscillating(self.ends),
        ]
        for turn in (
            np.arcsin(steep),
            np.pi - np.arcsin(steep),
        ):  # slope = size angular sin(angular t + phase)
            fewest = np.ceil((angular * self.begins + phase - turn) / (2 * np.pi))
            most = np.floor((angular * self.ends + phase - turn) / (2 * np.pi))
            for count in (fewest, most):
                at = (turn - phase + 2 * np.pi * count) / angular
                at = np.clip(at, self.begins, self.ends)
                crest = np.where(fewest <= most, size * np.cos(turn), self._oscillating(at))
                values.append(self._straight(slice(None), at) + crest)
        found = np.concatenate(values)
        return float(np.min(found)), float(np.max(found))

    def _bounds(self) -> tuple[float, float]:
        swing = float(np.sum(np.abs(self.amplitudes))) + sum(part.bound() for part in self.formulas)
        straight = np.concatenate([self.after, self.before])
        return float(np.min(straight)) - swing, float(np.max(straight)) + swing

    def _search(self) -> tuple[float, float] | None:
        """Bracket both extremes by dividing the intervals that may hold one, by the largest curvature; None if too long."""
        angular = 2 * np.pi * self.frequencies
        scale, curvature = float(np.sum(np.abs(self.amplitudes))), float(angular**2 @ np.abs(self.amplitudes))
        span = float(self.ends[-1] - self.begins[0])
        for part in self.formulas:
            if span * part.highest_frequency * CYCLE_SAMPLES > MOST_SAMPLES:
                return None
            size = part.bound()
            scale += size
            curvature += _CURVED * size * (2 * np.pi * part.highest_frequency) ** 2
        if curvature == 0:
            scale, curvature = 1.0, 0.0
        step = 2 * np.pi / CYCLE_SAMPLES * math.sqrt(scale / curvature) if curvature else span
        counts = np.ceil((self.ends - self.begins) / step).astype(int)
        if float(np.sum(counts)) * max(1, len(angular) + len(self.formulas)) > CYCLE_SAMPLES * MOST_SAMPLES:
            return None
        high = self._highest(counts, curvature, scale, sign=1.0)
        return -self._highest(counts, curvature, scale, sign=-1.0), high

    def _highest(self, counts: Indices, curvature: float, scale: float, *, sign: float) -> float:
        pieces = np.repeat(np.arange(len(counts)), counts)
        number = np.arange(len(pieces)) - np.repeat(np.cumsum(counts) - counts, counts)
        width = ((self.ends - self.begins) / counts)[pieces]
        first = self.begins[pieces] + number * width
        last = np.where(number + 1 == counts[pieces], self.ends[pieces], first + width)
        best = -math.inf
        while True:
            left = sign * (self._straight(pieces, first) + self._oscillating(first))
            right = sign * (self._straight(pieces, last) + self._oscillating(last))
            best = max(best, float(np.max(left)), float(np.max(right)))
            above = np.maximum(left, right) + curvature * (last - first) ** 2 / 8
            kept = above > best + TOLERANCE * scale
            if not np.any(kept) or np.count_nonzero(kept) > MOST_SAMPLES:
                return best if not np.any(kept) else float(np.max(above))
            pieces = np.repeat(pieces[kept], _DIVISIONS)
            width = np.repeat((last - first)[kept] / _DIVISIONS, _DIVISIONS)
            first = np.repeat(first[kept], _DIVISIONS) + width * np.tile(
                np.arange(_DIVISIONS), np.count_nonzero(kept)
            )
            last = first + width


_ROUNDED = 1e-9
"""Height of a step over the bound of the drive, below which it is rounding."""


def slew_of(drive: Drive, end: float, *, from_rest: bool = True) -> float:
    """Return the largest absolute rate of change of a drive up to `end` [s], in V/s, or in A/s of a current drive.

    It is infinite where the drive is discontinuous, also at time 0 if it starts `from_rest` at another value
    than 0. It is exact for straight pieces; of tones and formulas the bound 2 pi f times the amplitude is
    used.
    """
    parts = drive.parts()
    smallest = _ROUNDED * sum(part.bound() for part in parts)
    if from_rest and abs(float(drive.voltage(0.0))) > smallest:
        return math.inf
    if np.any(np.abs(drive.corners(end)[1]) > smallest):
        return math.inf
    total = 0.0
    for part in parts:
        if isinstance(part, Linear):
            inside = part.times[:-1] < end
            total += float(np.max(np.abs(part.slopes()[:-1][inside]), initial=0.0))
        else:
            total += 2 * math.pi * part.highest_frequency * part.bound()
    return total


FEWEST: Final = 8
"""Samples in a cycle of the drive below which a curve is misleading: the force has two cycles in that time."""
MISSED: Final = 1 / 3
"""Limit of the area between the drive and a line through its samples, over the area between the drive and its mean.
Above it the line is misleading: a pulse between two samples has 1, a square wave with 8 samples a period 1/4."""
ROUNDING: Final = 1e-9
"""Relative excess of a time step that counts as rounding."""


def enough(drive: Drive, start: float, end: float, *, fewest: int, most: int) -> int:
    """Return a number of even times from `start` to `end` [s], both included, that shows a drive.

    It is at least `fewest`, and above `most` where no number up to it shows the drive.
    """
    count = max(fewest, math.ceil(FEWEST * fastest_frequency(drive) * (end - start)) + 1)
    while count <= most and not shows(drive, np.linspace(start, end, count)):
        count = 2 * count - 1
    return count


def shows(drive: Drive, times: Real) -> bool:
    """Return whether a line through given times shows oscillations and straight pieces of a drive.

    That is whether the values at the times, shape (n,), increasing [s], joined by straight lines, follow the
    drive.
    """
    step = float(np.max(np.diff(times)))
    if step * fastest_frequency(drive) * FEWEST > 1 + ROUNDING:
        return False
    straight = [part for part in drive.parts() if isinstance(part, Linear) and not part.is_step]
    return all(_missed(part, times) <= MISSED for part in straight)


def _missed(part: Linear, times: Real) -> float:
    """Return the area between straight pieces and a line through these times [s], over that to their mean [1]."""
    if part.begins_with(times) and np.array_equal(part.before[1 : len(times)], part.after[1 : len(times)]):
        return 0.0
    corners = part.corners(float(times[-1]))[0]
    inside = corners[(corners > times[0]) & (corners < times[-1])]
    every = np.union1d(times, inside)
    after, before = part.value(every)[:-1], part.value_before(every[1:])
    line = np.interp(every, times, part.value(times))
    lengths = np.diff(every)
    mean = float(lengths @ (after + before)) / (2 * float(lengths.sum()))
    whole = float(lengths @ (np.abs(after - mean) + np.abs(before - mean)))
    between = float(lengths @ (np.abs(after - line[:-1]) + np.abs(before - line[1:])))
    return between / whole if whole > 0 else 0.0


def fastest_frequency(drive: Drive) -> float:
    """Return the highest frequency [Hz] of the parts of a drive.

    Of straight pieces it is one over the duration of all of them.
    """
    return max((_fastest_of(part) for part in drive.parts()), default=0.0)


def _fastest_of(part: Part) -> float:
    if not isinstance(part, Linear):
        return part.highest_frequency
    lasts = part.period or float(part.times[-1])
    return 1 / lasts if lasts else 0.0
