"""Largest values of a solution, at the output times and between them."""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from electrovib.physics.safety import breakdown_share, paschen_voltage
from electrovib.solve.stack.expand import Surroundings
from electrovib.solve.stack.keys import DisplacementOf, FieldOf

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.scenario import Scenario
    from electrovib.solve.stack.keys import Key

REFINEMENTS = 3
"""Number of refinements; each divides the interval around a largest value by `DIVISIONS`/2."""
CLEAR = 1e-2
"""Relative drop of the neighbours of a largest value, below which a parabola through the three is accurate to 1e-5."""
DIVISIONS = 12
"""Intervals into which the time between the neighbours of a largest value is divided."""
_MANY = 100_000
"""Number of times above which only those around the largest values and next to further evaluation times are kept."""
_BESIDE = 2
"""Times on both sides of a largest value that are kept."""
_JUST = 1e-6
"""Distance from a largest value at which it is evaluated again, as a share of the time to its neighbour."""
_BEFORE = 1e-9
"""Distance from a corner of the drive at which the value before it is evaluated, as a share of the time since the one before."""
ROUNDED = 1e-13
"""Share of the last time below which two times are equal by rounding."""
SUDDEN = 1e-6
"""Share of the last time within which a drop beyond `CLEAR` is a discontinuity, whose both sides are among the times."""
AT_A_CORNER = 1e-4
"""Ratio of the times to both neighbours, below which the largest value is at a corner, not between two times."""


@dataclass(frozen=True)
class PeakRecord:
    """Quantities with limits, over time.

    Parameters
    ----------
    times : ndarray, shape (n,)
        Increasing [s].
    rows : dict of Key to ndarray, shape (n,)
        Field of each layer [V/m], ``interface`` [V/m], ``gap`` [m] and ``breakdown`` [1] where there is a gap,
        ``across`` (voltage of the stack) [V], and the quantities that `Limits` names.
    whole : PeakRecord or None
        Record at all times, where this one holds only those that determine the largest values.
    """

    times: Real
    rows: dict[Key, Real]
    whole: PeakRecord | None = None

    @classmethod
    def of(cls, scenario: Scenario, times: Real, found: dict[Key, Real]) -> PeakRecord:
        """Return the quantities with limits from the quantities that a solver found.

        `times` (n,) [s].
        """
        around, layers = Surroundings.of(scenario), scenario.stack.layers
        gap = scenario.stack.gap_name
        rows: dict[Key, Real] = {FieldOf(name): found[FieldOf(name)] for name in layers}
        thicknesses: dict[str, Real | float] = {name: layer.thickness for name, layer in layers.items()}
        if gap is not None:
            thicknesses[gap] = found.get("gap", np.full(len(times), layers[gap].thickness))
            rows["gap"] = np.asarray(thicknesses[gap])
        rows["interface"] = found.get("interface_field", np.full(len(times), np.nan))
        if gap is not None:
            rows["breakdown"] = breakdown_share(rows["interface"], rows["gap"])
        rows["across"] = found["stack_voltage"]
        rows["voltage"] = found.get("plate_voltage", found["drive_voltage"])
        rows["current"] = found.get("amplifier_current", found["current"])
        rows["body_current"] = found["current"]
        rows["charge"] = around.area * found[DisplacementOf(next(iter(layers)))]
        energy = np.zeros(len(times))
        for name in layers:
            energy += thicknesses[name] * found[FieldOf(name)] * found[DisplacementOf(name)] / 2
        amplifier = scenario.circuit.amplifier
        stray = 0.0 if amplifier is None else amplifier.stray_capacitance
        rows["stored_energy"] = (1 + around.second) * around.area * energy + stray * rows["voltage"] ** 2 / 2
        return cls(times, rows)

    def among(self, moments: Real) -> PeakRecord:
        """Omit, of very many times, those that are neither near a largest value nor next to given further times."""
        if len(self.times) <= _MANY:
            return self
        largest = np.array(list(self._places.values()))
        beside = np.searchsorted(self.times, moments)
        near = [largest + step for step in range(-_BESIDE, _BESIDE + 1)] + [beside - 1, beside]
        last = len(self.times) - 1
        kept = np.unique(np.clip(np.concatenate([*near, [0, last]]), 0, last))
        return PeakRecord(self.times[kept], {name: row[kept] for name, row in self.rows.items()}, self)

    def just_before(self) -> Real:
        """Return times just before and just after each largest value, which distinguish a corner from a crest [s]."""
        places = np.array(list(self._places.values()))
        inner = places[(places > 0) & (places < len(self.times) - 1)]
        before = self.times[inner] - _JUST * (self.times[inner] - self.times[inner - 1])
        after = self.times[inner] + _JUST * (self.times[inner + 1] - self.times[inner])
        return np.unique(np.concatenate([before, after]))

    def before_corners(self, corners: Real) -> Real:
        """Return times just before the corners of the drive that are next to the largest values."""
        after = np.searchsorted(corners, self.times[np.array(list(self._places.values()))])
        near = (
            corners[np.unique(np.concatenate([after - 1, after]).clip(0, len(corners) - 1))]
            if len(corners)
            else corners
        )
        inside = near[(near > self.times[0]) & (near <= self.times[-1])]
        previous = self.times[np.searchsorted(self.times, inside) - 1]
        return np.unique(inside - _BEFORE * (inside - previous))

    def joined(self, other: PeakRecord) -> PeakRecord:
        """Return the union of two records of one solution; at a time of both, the values of this one."""
        times = np.concatenate([self.times, other.times])
        times, places = np.unique(times, return_index=True)
        rows = {name: np.concatenate([row, other.rows[name]])[places] for name, row in self.rows.items()}
        return PeakRecord(times, rows, self.whole)

    @functools.cached_property
    def _places(self) -> dict[Key, int]:
        return {name: _largest(row) for name, row in self.rows.items()}

    @functools.cached_property
    def _peaks(self) -> dict[Key, tuple[float, int, float]]:
        return {name: self._peak(row, self._places[name]) for name, row in self.rows.items()}

    def knowing(self, peaks: dict[Key, tuple[float, int, float]]) -> PeakRecord:
        """Store largest values, indices and drops that were computed elsewhere, and return this record."""
        self.__dict__["_peaks"] = peaks  # where the cached property keeps them
        return self

    def peaks(self) -> dict[Key, float]:
        """Return the largest absolute value of each quantity; NaN where it is unknown."""
        return {name: value for name, (value, _, _) in self._peaks.items()}

    def unclear(self) -> Real:
        """Return times around the largest values whose neighbours are too far below them for a parabola [s]."""
        found = [np.zeros(0)]
        for value, place, drop in self._peaks.values():
            if drop > CLEAR * value:
                first, last = self.times[self._neighbours(place)].tolist()
                found.append(np.linspace(first, last, DIVISIONS + 1))
        return np.unique(np.concatenate(found))

    def _neighbours(self, place: int) -> list[int]:
        """Return the indices of the times before and after one, which differ from it by more than rounding."""
        apart = ROUNDED * self.times[-1]
        left = int(np.searchsorted(self.times, self.times[place] - apart, side="left")) - 1
        return [left, int(np.searchsorted(self.times, self.times[place] + apart, side="right"))]

    def _peak(self, row: Real, place: int) -> tuple[float, int, float]:
        """Return the largest absolute value, its index, and how far its neighbours lie below it (0 at an end or a corner)."""
        value = float(abs(row[place]))
        left, right = self._neighbours(place)
        if left < 0 or right >= len(row):
            return value, place, 0.0
        before, after = self.times[place] - self.times[left], self.times[right] - self.times[place]
        first, last = value - abs(row[left]), value - abs(row[right])
        if min(before, after) < AT_A_CORNER * max(before, after) or not min(first, last) >= 0:
            return value, place, 0.0
        bend = first / before + last / after
        if bend <= 0:
            return value, place, 0.0
        tilt = (first * after / before - last * before / after) / (before + after)
        above = tilt**2 * (before + after) / (4 * bend)
        drop = float(max(first, last))
        if drop > CLEAR * value and (before if first > last else after) <= SUDDEN * self.times[-1]:
            return value, place, drop  # a parabola through both sides of a discontinuity would lie above them
        near = (left, self._neighbours(left)[0]) if tilt < 0 else (right, self._neighbours(right)[1])
        return value + min(float(min(above, drop / 2)), self._most_above(row, place, *near)), place, drop

    def _most_above(self, row: Real, place: int, near: int, outer: int) -> float:
        """Return how far a concave course between a time and its neighbour can rise above the value at that time.

        It lies below the secant through that neighbour and the next one; so a corner, steep on one side only, has no crest.
        """
        if not 0 <= outer < len(row):
            return np.inf
        times, sizes = self.times[[place, near, outer]], np.abs(row[[place, near, outer]])
        slope = (sizes[1] - sizes[2]) / (times[1] - times[2])
        return max(0.0, float(sizes[1] + slope * (times[0] - times[1]) - sizes[0]))

    def nearest_to_breakdown(self) -> tuple[float, float]:
        """Return field [V/m] and gap [m] at the time that is nearest to breakdown by Paschen's law."""
        share, place, _ = self._peaks["breakdown"]
        gap = float(self.rows["gap"][place])
        if share == 0:
            return float(abs(self.rows["interface"][place])), gap
        return share * paschen_voltage(gap=gap) / gap, gap


def _largest(row: Real) -> int:
    """Return the index of the largest absolute finite value."""
    high, low = int(np.argmax(row)), int(np.argmin(row))
    if np.isfinite(row[high]) and np.isfinite(row[low]):  # there is no NaN, which both would return first
        first, second = sorted((high, low))
        return second if abs(row[second]) > abs(row[first]) else first
    size = np.abs(row)
    return int(np.argmax(np.where(np.isfinite(size), size, -1.0)))
