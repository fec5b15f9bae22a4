"""The march of linear layers behind an amplifier with limits, from one change of its behaviour to the next.

Between two changes everything is in closed form. While no limit is met the stack does what it would do without
limits, plus what fades of a difference; at a largest voltage or current the plate is a sum of exponentials.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.errors import ElectrovibError
from electrovib.solve.limit_looks import LimitLooks
from electrovib.solve.nonlinear.stretch import snapped
from electrovib.solve.slewing import Course, Modes, Network
from electrovib.solve.transfer import Transfer
from electrovib.solve.unlimited import Unlimited, behind, corner_apart, without_limits

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from electrovib.physics.amplifier import Amplifier
    from electrovib.physics.drive.base import Drive
    from electrovib.solve.transfer import Real

MOST_CHANGES = 1_000_000
_HYSTERESIS = 1e-10
"""How far over its limit a current, or past its aim a voltage, changes what the amplifier does: noise shall not."""
_NOISE = 1e-12
"""How far past the largest voltage an aim is held there, or let go again."""
_CLOSER = 32
"""Looks between two where a current may be larger than at either and beyond its limit."""


@dataclass(frozen=True, eq=False)
class Span:
    """What an amplifier does from one change to the next.

    Parameters
    ----------
    start : float
        s.
    mode : int
        1 or -1 at its largest current of that sign, 0 at its voltage.
    held : int
        1 or -1 while its aim is held at its largest voltage of that sign, else 0.
    course : Course or None
        The plate; where it follows the drive, its distance from what it would do without limits, or None for none.
    states : ndarray, shape (modes,)
        At the beginning [V], of the same.
    """

    start: float
    mode: int
    held: int
    course: Course | None
    states: Real

    @property
    def follows(self) -> bool:
        """Tell whether the plate follows the drive."""
        return self.mode == 0 and self.held == 0


class LimitedMarch:
    """From change to change of an amplifier with limits, with the states of everything that is wanted.

    Parameters
    ----------
    transfers : mapping of str to Transfer
        Per volt of the plate; `current` [A per volt] among them.
    amplifier : Amplifier
        Gain, pole, limits and stray capacitance.
    drive : Drive
        A voltage, off before time 0.
    end : float
        Last time [s].
    """

    def __init__(
        self, transfers: Mapping[str, Transfer], amplifier: Amplifier, drive: Drive, end: float
    ) -> None:
        self.transfers, self.drive, self.end = transfers, drive, end
        self.network = Network.of(transfers["current"], amplifier.stray_capacitance)
        self.modes: Modes = self.network.modes()
        driven = [t.rates[(t.gains != 0) & (t.rates > 0)] for t in transfers.values()]
        self.rates = np.unique(np.concatenate(driven))
        self.branches = np.searchsorted(self.rates, self.network.rates)
        self.gains = {name: self._spread(transfer) for name, transfer in transfers.items()}
        self.corner = corner_apart(amplifier, self.rates)
        if self.corner is not None:
            amplifier = amplifier.model_copy(update={"bandwidth": self.corner / (2 * np.pi)})
        self.amplifier, self.limits = amplifier, amplifier.current_limits
        self.largest = np.inf if amplifier.saturation is None else amplifier.saturation
        none = np.zeros(0)
        stray = Transfer(none, none, 0.0, amplifier.stray_capacitance, static=0.0)
        self.unlimited = Unlimited(
            drive,
            gain=amplifier.gain,
            corner=self.corner,
            rates=self.rates,
            current=behind(transfers["current"] + stray, amplifier),
            end=end,
        )
        bound = abs(amplifier.gain) * sum(part.bound() for part in drive.parts())
        self.scale = max(1e-12, min(bound, self.largest))
        self.looks = LimitLooks(drive, end)
        self.corners = frozenset(self.looks.corners.tolist())
        marks, heights = drive.corners(end)
        self.jumps = marks[heights != 0]

    def _spread(self, transfer: Transfer) -> Real:
        found = np.zeros(len(self.rates))
        on = (transfer.gains != 0) & (transfer.rates > 0)
        np.add.at(found, np.searchsorted(self.rates, transfer.rates[on]), transfer.gains[on])
        return found

    def run(self, time: Real) -> tuple[dict[str, Real], list[float]]:
        """Follow the amplifier from rest.

        Parameters
        ----------
        time : ndarray, shape (n,)
            Output times, increasing, from 0 on [s].

        Returns
        -------
        found : dict of str to ndarray
            The wanted quantities, `plate_voltage` and `amplifier_current`.
        changes : list of float
            When the amplifier changed between its voltage and one of its largest currents [s].

        Raises
        ------
        ElectrovibError
            If it changes without end.
        """
        found = without_limits(self.transfers, self.drive, time, amplifier=self.amplifier)
        wanted = snapped(time, self.looks.corners.tolist())
        rest = Span(0.0, 0, 0, None, np.zeros(len(self.rates)))
        first_span = self._begin(rest, 0.0)
        changes = [0.0] if first_span.mode else []
        span: Span | None = first_span
        while span is not None:
            following = self._next(span)
            stop = np.inf if following is None else following.start
            first, beyond = np.searchsorted(wanted, [span.start, stop], side="left")
            if beyond > first and not (span.follows and span.course is None):
                self._write(found, slice(first, beyond), wanted, span)
            if following is not None and following.mode != span.mode:
                changes.append(following.start)
            if len(changes) > MOST_CHANGES:
                raise ElectrovibError(
                    f"the amplifier changed more than {MOST_CHANGES} times before {span.start} s"
                )
            span = following
        return found, changes

    def _next(self, span: Span) -> Span | None:
        """Find the next change, and what holds from there; None if there is none up to the end."""
        seen = np.array([span.start])
        for window in self.looks.after(span.start):
            looks, values = self._watched(span, np.concatenate([seen, window]))
            for place in np.flatnonzero(np.min(values[:, 1:], axis=0) < 0) + 1:
                when = float(looks[place])
                if when in self.corners:
                    following = self._begin(span, when)
                    if following is not span:
                        return following
                    continue
                kinds = np.flatnonzero(values[:, place] < 0).tolist()
                low = float(looks[place - 1])
                return self._changed(span, *min((self._root(span, kind, low, when), kind) for kind in kinds))
            seen = looks[-2:]
        return None

    def _watched(self, span: Span, looks: Real) -> tuple[Real, Real]:
        """Give looks, and what changes the amplifier where it falls below 0: see `_margins`; closer near a limit."""
        values = self._margins(span, looks, _HYSTERESIS)
        if span.mode or not np.isfinite(self.limits[1]):
            return looks, values
        more = [looks]
        for row in values[:2]:
            before, after = row[:-2] - row[1:-1], row[2:] - row[1:-1]
            low = (before > 0) & (after >= 0) & (row[1:-1] >= 0) & (row[1:-1] < np.maximum(before, after))
            for place in np.flatnonzero(low) + 1:
                more.append(np.linspace(looks[place - 1], looks[place + 1], _CLOSER + 1))
        if len(more) == 1:
            return looks, values
        looks = np.unique(np.concatenate(more))
        return looks, self._margins(span, looks, _HYSTERESIS)

    def _margins(self, span: Span, time: Real, hysteresis: float) -> Real:
        """How far an amplifier is from a change: to its voltage; or to a largest current of either sign, to another aim.

        Shape (1, times) at a largest current, else (3, times). At a corner the last is below 0 as well if the plate
        would have to jump against its capacitance.
        """
        if span.mode:
            return self._behind(span, time)[None] + hysteresis * self.scale
        values = np.ones((3, len(time)))
        lowest, highest = self.limits
        if np.isfinite(highest):
            current = self._current(span, time)
            values[0] = highest * (1 + hysteresis) - current
            values[1] = current - lowest * (1 + hysteresis)
            values[2] = np.where(self._jumps_at(time), -1.0, values[2])
        if np.isfinite(self.largest):
            noise = _NOISE if hysteresis else 0.0
            wanted = self.amplifier.gain * self.drive.voltage(time)
            if span.held:
                free = span.held * wanted - self.largest * (1 - noise)
            else:
                free = self.largest * (1 + noise) - np.abs(wanted)
            values[2] = np.minimum(values[2], free)
        return values

    def _jumps_at(self, time: Real) -> NDArray[np.bool_]:
        """Tell the times at which the plate would have to jump against a capacitance."""
        if self.corner is not None or self.network.capacitance == 0 or not len(self.jumps):
            return np.zeros(len(time), bool)
        return np.isin(time, self.jumps)

    def _root(self, span: Span, kind: int, low: float, high: float) -> float:
        """Find when a margin falls below 0 between two times."""

        def value(when: float) -> float:
            return float(self._margins(span, np.array([when]), 0.0)[kind, 0])

        from scipy.optimize import brentq

        if value(low) <= 0:
            return low
        if value(high) >= 0:
            return high
        return float(brentq(value, low, high, xtol=1e-300, rtol=1e-15))

    def _changed(self, span: Span, when: float, kind: int) -> Span:
        """Give what follows a change between two corners."""
        voltage, states = self._state(span, when)
        if span.mode:
            return self._span(when, 0, self._held(when), voltage, states)
        if kind == 2:
            side = int(np.sign(self.amplifier.gain * float(self.drive.voltage(when))))
            return self._span(when, 0, 0 if span.held else side, voltage, states)
        return self._span(when, 1 - 2 * kind, 0, voltage, states)

    def _begin(self, span: Span, when: float) -> Span:
        """Give what holds from a corner on; the same if nothing changes."""
        at = np.array([when])
        if span.mode and self._behind(span, at)[0] > 0:
            return span
        voltage, states = self._state(span, when)
        held = self._held(when)
        limited = bool(np.isfinite(self.limits[1]))
        if limited and self.corner is None and self.network.capacitance > 0:
            lag = float(self._aim(at)[0]) - voltage
            if abs(lag) > _HYSTERESIS * self.scale:
                return self._span(when, int(np.sign(lag)), 0, voltage, states)
        following = span
        if span.mode or span.held != held:
            following = self._span(when, 0, held, voltage, states)
        if limited:
            current = float(self._current(following, at)[0])
            lowest, highest = self.limits
            over = int(current > highest * (1 + _HYSTERESIS)) - int(current < lowest * (1 + _HYSTERESIS))
            if over:
                return self._span(when, over, 0, voltage, states)
        return following

    def _held(self, when: float) -> int:
        """Tell whether the aim is held at the largest voltage of a sign from a time on."""
        wanted = self.amplifier.gain * float(self.drive.voltage(when))
        side, distance = int(np.sign(wanted)), abs(wanted) - self.largest
        if abs(distance) > _NOISE * self.scale:
            return side if distance > 0 else 0
        rises = side * self.amplifier.gain * float(self.drive.slope(when)) > 0
        return side if rises else 0

    def _state(self, span: Span, when: float) -> tuple[float, Real]:
        """Voltage of the plate just before a time, and the modes [V]."""
        since = np.array([when - span.start])
        voltage, states = 0.0, np.zeros(len(self.rates))
        if span.follows:
            voltage, states = self.unlimited.state(when)
        if span.course is None:
            return voltage, states
        voltage += float(span.course.voltage(since)[0])
        return voltage, states + span.course.answer(self.rates, span.states, since)[:, 0]

    def _span(self, start: float, mode: int, held: int, voltage: float, states: Real) -> Span:
        """Begin with a voltage of the plate and modes [V]."""
        if mode:
            current = self.limits[mode > 0]
            course = self.network.slewed(current, voltage, states[self.branches], start, self.modes)
            return Span(start, mode, held, course, states)
        level, rates = held * self.largest if held else 0.0, np.zeros(1)
        if not held:
            level, expected = self.unlimited.state(start)
            states = states - expected
        if self.corner is None:
            level = level if held else 0.0
            return Span(start, mode, held, Course(rates, np.array([level]), rates), states)
        if held:
            levels = np.array([level, voltage - level])
            return Span(start, mode, held, Course(np.array([0.0, self.corner]), levels, np.zeros(2)), states)
        return Span(
            start, mode, held, Course(np.array([self.corner]), np.array([voltage - level]), rates), states
        )

    def _current(self, span: Span, time: Real) -> Real:
        """Current of the amplifier at its voltage [A]."""
        found = self.unlimited.current(time) if span.follows else self.network.fading(time)
        if span.course is None:
            return found
        return found + self.network.current(span.course, span.states[self.branches], time - span.start)

    def _aim(self, time: Real) -> Real:
        return np.asarray(self.amplifier.aim(self.drive.voltage(time)))

    def _behind(self, span: Span, time: Real) -> Real:
        """Above 0 as long as the amplifier cannot reach what it wants with its largest current."""
        assert span.course is not None
        lag = self._aim(time) - span.course.voltage(time - span.start)
        if self.corner is not None:
            lag = lag - span.course.slope(time - span.start) / self.corner
        return np.asarray(span.mode * lag)

    def _write(self, found: dict[str, Real], place: slice, time: Real, span: Span) -> None:
        """Fill in all responses at the output times of a span; where it follows the drive, add what is different."""
        at, course = time[place], span.course
        assert course is not None
        since = at - span.start
        voltage, slope = course.voltage(since), course.slope(since)
        answered = course.answer(self.rates, span.states, since)
        stray = self.network.stray * slope
        for name, transfer in self.transfers.items():
            if transfer.static is None:
                forced = transfer.direct * voltage + self.gains[name] @ answered
            else:
                forced = transfer.static * voltage + self.gains[name] @ (answered - voltage)
            forced = forced + transfer.slope * slope
            if span.follows:
                found[name][place] += forced
            else:
                found[name][place] = forced + transfer.free @ np.exp(-np.outer(transfer.rates, at))
            if name == "current":
                flows = forced + stray
        if span.follows:
            found["plate_voltage"][place] += voltage
            found["amplifier_current"][place] += flows
            return
        found["plate_voltage"][place] = voltage
        found["amplifier_current"][place] = (
            self.limits[span.mode > 0] if span.mode else found["current"][place] + stray
        )
