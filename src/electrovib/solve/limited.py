"""The march of linear layers behind an amplifier with limits, from one change of its behaviour to the next."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.errors import ElectrovibError
from electrovib.solve.nonlinear.stretch import snapped
from electrovib.solve.slewing import Course, Modes, Network

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from electrovib.physics.amplifier import Amplifier
    from electrovib.solve.aim import Piece
    from electrovib.solve.transfer import Real, Transfer

MOST_CHANGES = 1_000_000
_HYSTERESIS = 1e-10
"""How far over its limit a current, or past its aim a voltage, changes what the amplifier does: noise shall not."""
_LOOKS = np.unique(np.concatenate([[0.0], np.geomspace(1e-9, 1.0, 40), np.linspace(0.0, 1.0, 33)]))
"""Where in a piece a limit is looked for: two changes between two of them are not seen."""


class LimitedMarch:
    """From change to change of an amplifier with limits, with the states of everything that is wanted.

    Parameters
    ----------
    transfers : mapping of str to Transfer
        Per volt of the plate; `current` [A per volt] among them.
    amplifier : Amplifier
        Pole, largest current and stray capacitance.
    """

    def __init__(self, transfers: Mapping[str, Transfer], amplifier: Amplifier) -> None:
        self.transfers, self.amplifier = transfers, amplifier
        self.network = Network.of(transfers["current"], amplifier.stray_capacitance)
        self.modes: Modes = self.network.modes()
        driven = [t.rates[(t.gains != 0) & (t.rates > 0)] for t in transfers.values()]
        self.rates = np.unique(np.concatenate(driven))
        self.branches = np.searchsorted(self.rates, self.network.rates)
        self.gains = {name: self._spread(transfer) for name, transfer in transfers.items()}
        self.corner = None if amplifier.bandwidth is None else 2 * np.pi * amplifier.bandwidth
        self.limits = amplifier.current_limits

    def _spread(self, transfer: Transfer) -> Real:
        found = np.zeros(len(self.rates))
        on = (transfer.gains != 0) & (transfer.rates > 0)
        np.add.at(found, np.searchsorted(self.rates, transfer.rates[on]), transfer.gains[on])
        return found

    def run(self, pieces: Sequence[Piece], time: Real) -> tuple[dict[str, Real], list[float]]:
        """Follow the amplifier from rest.

        Parameters
        ----------
        pieces : sequence of Piece
            What it aims at.
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
        wanted = snapped(time, [piece.start for piece in pieces])
        found = {
            name: np.empty(len(time)) for name in [*self.transfers, "plate_voltage", "amplifier_current"]
        }
        self.scale = max([1e-12, *(abs(piece.level) for piece in pieces)])
        now, voltage, states, mode = 0.0, 0.0, np.zeros(len(self.rates)), 0
        changes: list[float] = []
        for piece in pieces:
            mode_before, mode = mode, self._begin(mode, piece, voltage, states)
            if mode != mode_before:
                changes.append(piece.start)
            while now < piece.stop:
                course = self._course(mode, now, voltage, states, piece)
                last = piece.stop if np.isfinite(piece.stop) else now
                length, turned = self._turn(mode, course, now, states, piece, last - now)
                stop = now + length if turned is not None else piece.stop
                first, beyond = np.searchsorted(wanted, [now, stop], side="left")
                if beyond > first:
                    self._write(found, slice(first, beyond), wanted, now, course, states, mode)
                if not np.isfinite(stop):
                    break
                end = np.array([length])
                voltage, states = float(course.voltage(end)[0]), course.answer(self.rates, states, end)[:, 0]
                now = stop
                if turned is not None:
                    mode = turned
                    changes.append(now)
                if len(changes) > MOST_CHANGES:
                    raise ElectrovibError(
                        f"the amplifier changed more than {MOST_CHANGES} times before {now} s"
                    )
        return found, changes

    def _course(self, mode: int, now: float, voltage: float, states: Real, piece: Piece) -> Course:
        """Voltage of the plate from now on, if nothing changes."""
        if mode:
            current = self.limits[mode > 0]
            return self.network.slewed(current, voltage, states[self.branches], now, self.modes)
        level = piece.level + piece.slope * (now - piece.start)
        if self.corner is None:
            return Course(np.zeros(1), np.array([level]), np.array([piece.slope]))
        rates = np.array([0.0, self.corner])
        return Course(rates, np.array([level, voltage - level]), np.array([piece.slope, -piece.slope]))

    def _current(self, course: Course, now: float, states: Real, since: Real) -> Real:
        branches = course.answer(self.network.rates, states[self.branches], since)
        return self.network.current(course.voltage(since), course.slope(since), branches, now + since)

    def _behind(self, course: Course, mode: int, now: float, piece: Piece, since: Real) -> Real:
        """Above 0 as long as the amplifier cannot reach what it wants with its largest current."""
        aim = piece.level + piece.slope * (now + since - piece.start)
        lag = aim - course.voltage(since)
        if self.corner is not None:
            lag = lag - course.slope(since) / self.corner
        return np.asarray(mode * lag)

    def _begin(self, mode: int, piece: Piece, voltage: float, states: Real) -> int:
        """Find what holds at the beginning of a piece, where aim or slope have jumped."""
        start = np.zeros(1)
        if mode:
            course = self._course(mode, piece.start, voltage, states, piece)
            if self._behind(course, mode, piece.start, piece, start)[0] > 0:
                return mode
        if self.corner is None and self.network.capacitance > 0:
            lag = piece.level - voltage
            if abs(lag) > _HYSTERESIS * self.scale and np.isfinite(self.limits[1]):
                return int(np.sign(lag))
        course = self._course(0, piece.start, voltage, states, piece)
        current = float(self._current(course, piece.start, states, start)[0])
        return self._over(current)

    def _over(self, current: float) -> int:
        lowest, highest = self.limits
        return int(current > highest * (1 + _HYSTERESIS)) - int(current < lowest * (1 + _HYSTERESIS))

    def _turn(
        self, mode: int, course: Course, now: float, states: Real, piece: Piece, length: float
    ) -> tuple[float, int | None]:
        """Time until the amplifier changes, and to what; None if it does not within this length [s]."""
        if length <= 0 or not np.isfinite(self.limits[1]):
            return length, None
        if mode:
            values = self._behind(course, mode, now, piece, _LOOKS * length) + _HYSTERESIS * self.scale
            turned = 0
        else:
            currents = self._current(course, now, states, _LOOKS * length)
            sides = np.array([self._over(float(current)) for current in currents])
            values, turned = np.where(sides == 0, 1.0, -1.0), 0
            if np.any(sides):
                turned = int(sides[np.flatnonzero(sides)[0]])
        falls = np.flatnonzero(values[1:] < 0)
        if not len(falls):
            return length, None
        first = int(falls[0])

        def value(since: float) -> float:
            at = np.array([since])
            if mode:
                return float(self._behind(course, mode, now, piece, at)[0])
            limit = self.limits[turned > 0] * (1 + _HYSTERESIS / 2)
            return turned * (limit - float(self._current(course, now, states, at)[0]))

        low, high = _LOOKS[first] * length, _LOOKS[first + 1] * length
        return _root(value, low, high), turned

    def _write(
        self,
        found: dict[str, Real],
        place: slice,
        time: Real,
        now: float,
        course: Course,
        states: Real,
        mode: int,
    ) -> None:
        """Fill in all responses at the output times of a course."""
        at, since = time[place], time[place] - now
        voltage, slope = course.voltage(since), course.slope(since)
        answered = course.answer(self.rates, states, since)
        for name, transfer in self.transfers.items():
            free = transfer.free @ np.exp(-np.outer(transfer.rates, at))
            if transfer.static is None:
                forced = transfer.direct * voltage + self.gains[name] @ answered
            else:
                forced = transfer.static * voltage + self.gains[name] @ (answered - voltage)
            found[name][place] = forced + transfer.slope * slope + free
        found["plate_voltage"][place] = voltage
        stray = self.network.stray
        flows = found["current"][place] + stray * slope
        found["amplifier_current"][place] = self.limits[mode > 0] if mode else flows


def _root(value, low: float, high: float) -> float:  # type: ignore[no-untyped-def]  # noqa: ANN001
    """Find the zero of a falling value between two times."""
    from scipy.optimize import brentq

    if value(low) <= 0:
        return low
    if value(high) >= 0:
        return high
    return float(brentq(value, low, high, xtol=1e-300, rtol=1e-15))
