"""Linear layers behind an amplifier: exact behind a gain and a pole, and from limit to limit where it has limits.

Without limits an amplifier is a filter before the stack. With them it either gives its voltage or its largest
current; the plate's voltage is known in closed form until the next change, and so is all that follows from it.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.errors import ElectrovibError, InputError
from electrovib.physics.drive.parts import Linear
from electrovib.solve.nonlinear.stretch import highest_frequency, snapped
from electrovib.solve.slewing import Course, Modes, Network
from electrovib.solve.transfer import Transfer
from electrovib.solve.transient import transient

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from electrovib.physics.amplifier import Amplifier
    from electrovib.physics.drive.base import Drive
    from electrovib.solve.transfer import Real

PIECES = 512
"""Straight pieces for one period of the fastest oscillation of a drive that is not straight; then twice as many."""
MOST_CHANGES = 1_000_000
_HYSTERESIS = 1e-10
"""How far over its limit, relative, a current counts as limited."""
_SAME_RATE = 1e-8
"""A corner nearer than this to a rate of the stack, relative, is moved away by it."""
_LOOKS = np.unique(np.concatenate([[0.0], np.geomspace(1e-9, 1.0, 40), np.linspace(0.0, 1.0, 33)]))
"""Where in a piece a limit is looked for: two changes between two of them are not seen."""


@dataclass(frozen=True)
class Amplified:
    """What a stack does behind an amplifier.

    Parameters
    ----------
    found : dict of str to ndarray
        Responses at the output times, `drive_voltage`, `plate_voltage` and `amplifier_current` among them.
    changes : tuple of float
        When [s] the amplifier changed between its voltage and one of its largest currents.
    error : float
        Error of the plate's voltage over its largest, by halving the straight pieces; 0 where they are exact.
    """

    found: dict[str, Real]
    changes: tuple[float, ...]
    error: float

    def reason(self) -> str:
        """Say why this solver ran and how well."""
        how = "straight pieces and exponentials exactly"
        if self.error:
            how = f"the drive as straight pieces, by halving them the error of the plate's voltage is {self.error:.1e}"
            how += " of its largest"
        return (
            "linear layers behind an amplifier with limits: real modes at its voltage and at its largest current, from"
            f" rest, {len(self.changes)} changes between them located; {how}"
        )


def behind(transfer: Transfer, amplifier: Amplifier) -> Transfer:
    """Put gain and pole of an amplifier before a linear quantity of the plate's voltage.

    Parameters
    ----------
    transfer : Transfer
        Per volt of the plate.
    amplifier : Amplifier
        Its limits are left out.

    Returns
    -------
    Transfer
        Per volt of the drive; what initial charge leaves behind is as before.
    """
    gain = amplifier.gain
    if amplifier.bandwidth is None:
        static = None if transfer.static is None else transfer.static * gain
        forced = (transfer.gains * gain, transfer.direct * gain, transfer.slope * gain)
        return Transfer(transfer.rates, *forced, transfer.free, static)
    corner = 2 * np.pi * amplifier.bandwidth
    if np.any(np.abs(transfer.rates - corner) < _SAME_RATE * corner):
        corner *= 1 + 2 * _SAME_RATE
    apart = corner - transfer.rates
    direct = transfer.at_rest() - float(np.sum(transfer.gains))
    own = direct - transfer.slope * corner - float(np.sum(transfer.gains * transfer.rates / apart))
    return Transfer(
        np.append(transfer.rates, corner),
        gain * np.append(transfer.gains * corner / apart, own),
        gain * transfer.slope * corner,
        0.0,
        np.append(transfer.free, 0.0),
        None if transfer.static is None else gain * transfer.static,
    )


def amplified_response(
    transfers: Mapping[str, Transfer],
    drive: Drive,
    time: Real,
    *,
    amplifier: Amplifier,
    settled: bool = False,
) -> Amplified:
    """Response of linear quantities of the plate's voltage behind an amplifier.

    Parameters
    ----------
    transfers : mapping of str to Transfer
        Per volt of the plate; `current` [A per volt] among them.
    drive : Drive
        A voltage, off before time 0 when starting from rest.
    time : ndarray, shape (n,)
        Increasing, >= 0 [s].
    amplifier : Amplifier
        Gain, pole, limits and stray capacitance.
    settled : bool
        Start from the periodic state: for an amplifier without limits.

    Returns
    -------
    Amplified
        At a jump of the drive the value after it.

    Raises
    ------
    InputError
        If the periodic state is asked for behind limits, or the drive prescribes the current.
    """
    if drive.quantity == "current":
        raise InputError(
            f"circuit.amplifier: {type(drive).__name__} prescribes the current itself; leave the amplifier away"
        )
    if not amplifier.is_limited:
        return _unlimited(transfers, drive, time, amplifier, settled=settled)
    if settled:
        raise InputError(
            "time.initial_state = PeriodicState: behind an amplifier with limits the periodic state is not known"
            " beforehand. Start AtRest and look at a late period, or leave its limits away"
        )
    parts = [part for part in drive.parts() if not isinstance(part, Linear)]
    fastest = max([highest_frequency(part) for part in parts], default=0.0)
    march = _March(transfers, amplifier)
    found, changes = march.run(_pieces(drive, float(time[-1]), amplifier, fastest * PIECES), time)
    error = 0.0
    if fastest:
        coarse = found["plate_voltage"]
        found, changes = march.run(_pieces(drive, float(time[-1]), amplifier, 2 * fastest * PIECES), time)
        moved = float(np.max(np.abs(found["plate_voltage"] - coarse)))
        error = moved / 3 / (float(np.max(np.abs(found["plate_voltage"]))) or 1.0)
    found["drive_voltage"] = drive.voltage(time)
    return Amplified(found, tuple(changes), error)


def _unlimited(
    transfers: Mapping[str, Transfer], drive: Drive, time: Real, amplifier: Amplifier, *, settled: bool
) -> Amplified:
    none = np.zeros(0)
    wanted = dict(transfers) | {
        "plate_voltage": Transfer(none, none, 1.0),
        "stray current": Transfer(none, none, 0.0, amplifier.stray_capacitance, static=0.0),
    }
    found = transient(
        {name: behind(transfer, amplifier) for name, transfer in wanted.items()}, drive, time, settled=settled
    )
    found["amplifier_current"] = found.pop("stray current") + found["current"]
    found["drive_voltage"] = drive.voltage(time)
    return Amplified(found, (), 0.0)


@dataclass(frozen=True)
class _Piece:
    """A straight piece of what the amplifier aims at [s, V, V/s]."""

    start: float
    stop: float
    level: float
    slope: float


def _pieces(drive: Drive, end: float, amplifier: Amplifier, frequency: float) -> list[_Piece]:
    """Straight pieces of the aim; what is not straight in the drive is cut `frequency` times a second."""
    times = [np.array([0.0, end])]
    for part in drive.parts():
        if isinstance(part, Linear):
            times.append(part.until(end).times)
        else:
            times.append(np.array([part.start, part.stop]))
            times.append(np.linspace(0.0, end, 1 + int(np.ceil(end * frequency))))
    marks = np.unique(np.concatenate(times))
    marks = marks[(marks >= 0) & (marks <= end)]
    marks = marks[np.append(True, np.diff(marks) > 1e-14 * end)]
    found: list[_Piece] = []
    for start, stop in zip(marks[:-1].tolist(), marks[1:].tolist(), strict=True):
        near = (stop - start) * 1e-6
        inside = amplifier.gain * drive.voltage(np.array([start + near, stop - near]))
        slope = float(inside[1] - inside[0]) / (stop - start - 2 * near)
        found += _clipped(start, stop, float(inside[0]) - slope * near, slope, amplifier.saturation)
    found.append(_Piece(end, np.inf, float(amplifier.aim(drive.voltage(np.array(end)))), 0.0))
    return found


def _clipped(start: float, stop: float, level: float, slope: float, limit: float | None) -> list[_Piece]:
    if limit is None:
        return [_Piece(start, stop, level, slope)]
    crossings = [start + (side * limit - level) / slope for side in (-1, 1)] if slope else []
    cuts = [start, *sorted(each for each in crossings if start < each < stop), stop]
    found = []
    for first, last in itertools.pairwise(cuts):
        middle = level + slope * ((first + last) / 2 - start)
        free = abs(middle) <= limit
        begin = level + slope * (first - start) if free else np.sign(middle) * limit
        found.append(_Piece(first, last, float(begin), slope if free else 0.0))
    return found


class _March:
    """From change to change of the amplifier, with the states of everything that is wanted."""

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

    def run(self, pieces: Sequence[_Piece], time: Real) -> tuple[dict[str, Real], list[float]]:
        """Responses at output times [s], and when the amplifier changed."""
        wanted = snapped(time, [piece.start for piece in pieces])
        found = {
            name: np.empty(len(time)) for name in [*self.transfers, "plate_voltage", "amplifier_current"]
        }
        self.scale = max(*(abs(p.level) for p in pieces), 1e-12)
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

    def _course(self, mode: int, now: float, voltage: float, states: Real, piece: _Piece) -> Course:
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

    def _behind(self, course: Course, mode: int, now: float, piece: _Piece, since: Real) -> Real:
        """Above 0 as long as the amplifier cannot reach what it wants with its largest current."""
        aim = piece.level + piece.slope * (now + since - piece.start)
        lag = aim - course.voltage(since)
        if self.corner is not None:
            lag = lag - course.slope(since) / self.corner
        return np.asarray(mode * lag)

    def _begin(self, mode: int, piece: _Piece, voltage: float, states: Real) -> int:
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
        self, mode: int, course: Course, now: float, states: Real, piece: _Piece, length: float
    ) -> tuple[float, int | None]:
        """Time until the amplifier changes, and to what; None if it does not within this length [s]."""
        if length <= 0 or not np.isfinite(self.limits[1]):
            return length, None
        if mode:
            values = self._behind(course, mode, now, piece, _LOOKS * length)
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
