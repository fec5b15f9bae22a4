"""Amplifier, series elements, charge and polarisation of a stack as one stiff system, with a gap that is fixed or prescribed.

The drive is smooth only from one break to the next: `jump` is called at every break in order of time, and stores the
interval that begins there.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.core.constants import eps0
from electrovib.physics.amplifier import IDEAL, Amplifier
from electrovib.physics.drive.parts import Linear, Tones
from electrovib.solve.nonlinear.integrate import System

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.physics.drive.base import Drive
    from electrovib.physics.drive.parts import Smooth
    from electrovib.physics.motion import Distance
    from electrovib.solve.nonlinear.integrate import Mode
    from electrovib.solve.stack.keys import Key
    from electrovib.solve.stack.layer_states import Moment, StackStates


_SLACK = 16 * float(np.finfo(float).eps)
"""Relative difference of times up to which an output time counts as equal to a break."""
SLACK = 1e-9
"""Distance beyond its kink, over its scale, at which a field or a voltage changes the mode, so that noise does not."""
_SLOWEST = 1e-2
"""Least ratio of the scale of the voltage across a series resistance to that of the drive."""


@dataclass(frozen=True, kw_only=True)
class Stretch:
    """Voltage of a drive within an interval where it is smooth: a straight line, tones and formulas.

    Parameters
    ----------
    start, level, slope : float
        Beginning [s], and level [V] and slope [V/s] of the straight line from there.
    parts : tuple of Tones or Smooth
        Parts of the drive that are on.
    """

    start: float
    level: float
    slope: float
    parts: tuple[Tones | Smooth, ...] = ()

    def voltage(self, time: Any) -> tuple[Any, Any]:
        """Return the voltage [V] and its rate of change [V/s], also just before the break that ends the interval."""
        value: Any = self.level + self.slope * (time - self.start)
        rate: Any = self.slope
        for part in self.parts:
            if isinstance(part, Tones):
                wave = np.exp(2j * np.pi * np.multiply.outer(part.frequencies, time))
                value = value + (part.amplitudes @ wave).real
                rate = rate - (2 * np.pi * part.frequencies * part.amplitudes @ wave).imag
            else:
                at = np.asarray(time)
                value, rate = value + part.formula(at), rate + part.derivative(at)
        return value, rate


def snapped(times: Real, breaks: list[float]) -> Real:
    """Set output times that equal a break within rounding to the time of the break, as the drive itself does.

    `times` (n,) [s]; returns `times` (n,) [s].
    """
    if not breaks:
        return times
    marks = np.array(breaks)
    places = np.clip(np.searchsorted(marks, times), 1, max(len(marks) - 1, 1))
    found = times.copy()
    for near in (marks[places - 1], marks[np.minimum(places, len(marks) - 1)]):
        found = np.where(np.abs(times - near) <= _SLACK * times, near, found)
    return found


def stretch_after(drive: Drive, *, time: float, following: float) -> Stretch:
    """Return the drive between two neighbouring breaks."""
    level, slope = 0.0, 0.0
    kept: list[Tones | Smooth] = []
    middle = (time + following) / 2
    for part in drive.parts():
        if isinstance(part, Linear):
            piece = np.array(middle)
            rise = float(part.slope(piece))
            level, slope = level + float(part.value(piece)) - rise * (middle - time), slope + rise
        elif part.start <= middle < part.stop:
            kept.append(part)
    return Stretch(start=time, level=level, slope=slope, parts=tuple(kept))


class Electrics(System):
    """States of a stack behind an amplifier, for `integrate`.

    Parameters
    ----------
    space : StackStates
        Layers and series elements.
    drive : Drive
        A voltage, off before time 0.
    end : float
        Last time [s].
    amplifier : Amplifier, optional
        Amplifier between drive and plate; by default the drive is the plate's voltage.
    distance : Distance, optional
        Thickness of the moving layer of `space` over time.

    Notes
    -----
    States: those of `space`, and the plate's voltage where the amplifier cannot follow at once. Mode: the side of the
    largest voltage on which the target voltage is; whether the amplifier supplies its lowest (-1) or highest (1)
    current or its voltage (0); the sign of the field of each leak with a kink.
    """

    def __init__(
        self,
        space: StackStates,
        drive: Drive,
        *,
        end: float,
        amplifier: Amplifier = IDEAL,
        distance: Distance | None = None,
    ) -> None:
        self.space, self.drive, self.amplifier, self.distance = space, drive, amplifier, distance
        marks, heights = drive.corners(end)
        self._breaks, self._jumps = marks.tolist(), bool(np.any(heights))
        self._end = end
        self._stretch = Stretch(start=0.0, level=0.0, slope=0.0)
        self._gain, self._stray = amplifier.gain, amplifier.stray_capacitance
        self._limits, self._saturation = amplifier.current_limits, amplifier.saturation
        self._corner = None if amplifier.bandwidth is None else 2 * np.pi * amplifier.bandwidth
        self.limited = bool(np.isfinite(self._limits[1]))
        self.follows = self._corner is None and not self.limited
        self.size = space.size + (not self.follows)
        highest = abs(self._gain) * max(drive.largest(end), 1e-12)
        self.volts = highest if self._saturation is None else min(highest, self._saturation)
        self._noise = SLACK * self.volts / float(np.sum(space.thicknesses))

    @property
    def scale(self) -> Real:
        """Magnitude of each state."""
        space = self.space
        weights = space.repeats * space.thicknesses / space.permittivities
        elastance = float(np.sum(weights))
        largest = float(np.max(np.abs(space.charges), initial=0.0))
        charge = self.volts / elastance + largest
        sizes = np.full(self.size, charge)
        if space.resistance > 0:
            times = np.concatenate([np.linspace(0.0, self._end, 4001), self._breaks])
            speed = abs(self._gain) * float(np.max(np.abs(self.drive.slope(times))))
            share = speed * space.area * space.resistance / (elastance * self.volts)
            first = abs(self._gain * float(self.drive.voltage(np.zeros(1))[0]))
            if self._corner is None and (self._jumps or first > SLACK * self.volts):
                share = 1.0  # at a discontinuity all of the voltage is across the resistance
            most = float(np.max(np.abs(self._limits)))
            share = min(share, most * space.resistance / self.volts)
            sizes[space.size - 1] = (self.volts + largest * elastance) * float(np.clip(share, _SLOWEST, 1.0))
        if not self.follows:
            sizes[-1] = self.volts
        return sizes

    def begin(self) -> tuple[Real, Mode]:
        """Return the state before time 0 and the mode after it."""
        return self._begun(self._gap(0.0, np.zeros(0), None)[0])

    def _begun(self, gap: float | None) -> tuple[Real, Mode]:
        """Return the same for a gap at time 0 [m]."""
        state = np.concatenate([self.space.start(), np.zeros(self.size - self.space.size)])
        self._stretch = Stretch(start=0.0, level=0.0, slope=0.0)
        after = self.jump(state, time=0.0)
        aim = self._gain * self._stretch.voltage(0.0)[0]
        clipped = 0 if self._saturation is None else int(np.sign(aim)) * (abs(aim) > self._saturation)
        moment = self._supplied(0.0, after, (clipped, 0), gap, 0.0)[2]
        signs = tuple(-1 if moment.field[index] < 0 else 1 for index in self.space.polarities)
        self._stretch = Stretch(start=0.0, level=0.0, slope=0.0)
        return state, (clipped, 0, *signs)

    def breaks(self, end: float) -> list[float]:
        """Return the times of breaks of the drive and of the distance, up to an end [s]."""
        bends = () if self.distance is None else self.distance.breaks()
        return sorted(
            {*(time for time in self._breaks if time <= end), *(bend for bend in bends if 0 < bend < end)}
        )

    def jump(self, state: Real, *, time: float) -> Real:
        """Return the state just after a break [s], and store the drive's next smooth interval."""
        before = self._stretch.voltage(time)[0]
        if time == 0 or time in self._breaks:
            beyond = self._end if time < self._end else 1.001 * time
            following = next((b for b in self._breaks if b > time), beyond)
            self._stretch = stretch_after(self.drive, time=time, following=following)
        after = self._stretch.voltage(time)[0]
        old, new = (self._aimed(before), self._aimed(after)) if time > 0 else (0.0, self._aimed(after))
        place = self.space.size - 1
        if self.space.resistance == 0 or (old == new and time > 0):
            return state
        state = state.copy()
        if self.follows:
            state[place] += new - old
        elif self.limited and self._stray == 0 and (self._corner is None or time == 0):
            # the plate's voltage is discontinuous, up to the largest current through the resistance
            across = state[-1] - state[place]
            wanted = new if self._corner is None else state[-1]
            lowest, highest = (self.space.resistance * limit for limit in self._limits)
            state[place] = np.clip(wanted - across, lowest, highest)
            state[-1] = across + state[place]
        return state

    def rate(self, state: Real, mode: Mode, *, time: Any) -> Real:
        """Return the rate of change of each state [its unit/s], at one time or at n times."""
        return self._own_rate(state, mode, time, *self._gap(time, state, mode))

    def _own_rate(self, state: Real, mode: Mode, time: Any, gap: Any, closing: Any) -> Real:
        """Return the rates of the electrical states, for a gap [m] and its rate of change [m/s]."""
        _, slope, moment = self._supplied(time, state, mode, gap, closing)
        own = self.space.rate(state[: self.space.size], moment, slope=slope)
        return own if self.follows else np.concatenate([own, np.broadcast_to(slope, state.shape[1:])[None]])

    def switches(self, state: Real, mode: Mode, *, time: Any) -> Real:
        """Return values that stay above 0 as long as the mode holds, at one time or at n times."""
        own, gap = state[: self.size], self._gap(time, state, mode)
        return np.array([value for value, _ in self._watched(time, own, mode, *gap)])

    def following(self, index: int, state: Real, mode: Mode, *, time: float) -> Mode:
        """Return the mode after the switching function of this index has fallen through zero."""
        own, gap = state[: self.size], self._gap(time, state, mode)
        return self._watched(time, own, mode, *gap)[index][1]

    def _gap(self, time: Any, state: Real, mode: Mode | None) -> tuple[Any, Any]:
        """Return the gap [m] and its rate of change [m/s]."""
        del state, mode
        return (None, 0.0) if self.distance is None else (self.distance.gap(time), self.distance.rate(time))

    def attraction(self, state: Real, mode: Mode, *, time: Any, gap: Any = None) -> Any:
        """Compute the Maxwell stress in the gap, eps0 E^2/2 [Pa], at one time or at n times."""
        moment = self._supplied(time, state, mode, gap, 0.0)[2]
        return eps0 * moment.field[self.space.interface] ** 2 / 2

    def _aimed(self, voltage: float) -> float:
        return float(self.amplifier.aim(voltage))

    def _aim(self, time: float | Real, side: int) -> tuple[Any, Any]:
        """Return the target voltage [V] and its rate of change [V/s], on one side of the largest voltage."""
        if side and self._saturation is not None:
            return side * self._saturation, 0.0
        voltage, slope = self._stretch.voltage(time)
        return self._gain * voltage, self._gain * slope

    def _supplied(
        self, time: float | Real, state: Real, mode: Mode, gap: float | Real | None, closing: float | Real
    ) -> tuple[Any, Any, Moment]:
        """Return the voltage of the plate [V], its rate of change [V/s], and the fields of the stack under it."""
        own = state[: self.space.size]
        signs = dict(zip(self.space.polarities, mode[2:], strict=True)) if len(mode) > 2 else None
        voltage, slope = self._aim(time, mode[0])
        if not self.follows and (self._corner is not None or mode[1]):
            slope = 0.0 if self._corner is None else self._corner * (voltage - state[-1])
            voltage = state[-1]
        moment = self.space.moment(own, voltage=voltage, gap=gap, closing=closing, signs=signs)
        if mode[1]:
            slope = self._held(own, self._limits[mode[1] > 0], moment)
        return voltage, slope, moment

    def _held(self, own: Real, current: float | Real, moment: Moment) -> Real:
        """Return the rate of change of the plate's voltage [V/s] under a given current."""
        area, stray = self.space.area, self._stray
        if self.space.resistance == 0:
            fixed = current - area * moment.loss / moment.elastance
            return np.asarray(fixed / (stray + area / moment.elastance))
        if stray > 0:
            return np.asarray((current - area * self.space.density(own, moment, slope=0.0)) / stray)
        return np.asarray(moment.elastance * current / area - moment.loss)

    def _watched(
        self, time: float | Real, state: Real, mode: Mode, gap: float | Real | None, closing: float | Real
    ) -> list[tuple[float | Real, Mode]]:
        """Return the switching functions, above 0 as long as the mode holds, and the mode that follows each."""
        _, slope, moment = self._supplied(time, state, mode, gap, closing)
        found: list[tuple[float | Real, Mode]] = []
        clipped, held, *signs = mode
        if self._saturation is not None:
            free = self._aim(time, 0)[0]
            rest = (held, *signs)
            if clipped:
                found.append((clipped * free - self._saturation, (0, *rest)))
            else:
                found += [(self._saturation - side * free, (side, *rest)) for side in (-1, 1)]
        if self.limited:
            found += self._limit_watch(time, state, mode, slope, moment)
        for place, index in enumerate(self.space.polarities, start=2):
            turned = (*mode[:place], -mode[place], *mode[place + 1 :])
            found.append((mode[place] * moment.field[index] + self._noise, turned))
        return found

    def _limit_watch(
        self, time: float | Real, state: Real, mode: Mode, slope: float | Real, moment: Moment
    ) -> list[tuple[float | Real, Mode]]:
        clipped, held, *signs = mode
        behind = self._aim(time, clipped)[0] - state[-1]
        if held:
            wanted = behind if self._corner is None else (self._corner * behind - slope) / self._corner
            return [(held * wanted, (clipped, 0, *signs))]
        own = state[: self.space.size]
        current = self._stray * slope + self.space.area * self.space.density(own, moment, slope=slope)
        spare = [side * (self._limits[side > 0] - current) / self._limits[1] for side in (-1, 1)]
        if self._corner is None:
            slack = SLACK * self.volts
            # after a discontinuity of the target the current stays at its limit
            spare = [np.where(np.abs(behind) > slack, 1.0, each) for each in spare]
            spare += [slack - side * behind for side in (-1, 1)]
        modes = [(clipped, side, *signs) for side in (-1, 1)]
        return list(zip(spare, modes * (len(spare) // 2), strict=True))

    def signals(self, times: Real, states: Real) -> dict[Key, Real]:
        """Compute the signals at output times from the states alone, and a gap that moves.

        `times` (n,) [s], `states` (size, n).
        """
        gap, closing = self._gap(times, states, None)
        found = self._own_signals(times, states[: self.size], gap, closing)
        return found if gap is None else found | {"gap": gap}

    def _own_signals(
        self, times: Real, states: Real, gap: Real | None, closing: Real | float
    ) -> dict[Key, Real]:
        """Return the electrical signals for a gap [m] and its rate of change [m/s]."""
        own, drive = states[: self.space.size], self.drive.voltage(times)
        aim = self.amplifier.aim(drive)
        slope = self._gain * self.drive.slope(times) * (aim == self._gain * drive)
        voltage = aim
        if self._corner is not None:
            voltage = states[-1]
            slope = self._corner * (aim - voltage)
        elif self.limited:
            voltage = np.where(np.abs(states[-1] - aim) <= 10 * SLACK * self.volts, aim, states[-1])
        moment = self.space.moment(own, voltage=voltage, gap=gap, closing=closing)
        density = self.space.density(own, moment, slope=slope)
        if self.limited:
            current = self._stray * slope + self.space.area * density
            if self._corner is None:  # a plate that lags behind its target takes the largest current
                current = np.where(voltage < aim, np.inf, np.where(voltage > aim, -np.inf, current))
            held = np.clip(current, *self._limits)
            slope = np.where(held == current, slope, self._held(own, held, moment))
            density = self.space.density(own, moment, slope=slope)
        return {
            "plate_voltage": voltage,
            "current": self.space.area * density,
            "amplifier_current": self._stray * slope + self.space.area * density,
        } | self.space.named(own, moment, gap=gap)
