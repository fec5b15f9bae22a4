"""Linear layers behind an amplifier: a filter before the stack without limits, a sequence of regimes with them.

Without limits the response is in closed form at all times, and it remains the response up to the first time beyond a
limit. The instant at which a limit is met is located. From there the amplifier supplies its largest voltage or its largest
current, and the voltage of the plate is a sum of exponentials, until the amplifier can follow its input again. The plate
then follows the response without limits plus a decaying deviation from it.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.errors import ElectrovibError
from electrovib.solve.electrics.slewing import Course, Network, Unlimited
from electrovib.solve.electrics.solution import LIMITED, Solution
from electrovib.solve.electrics.transient import (
    amplified,
    transient,
)
from electrovib.solve.meter import Meter
from electrovib.solve.nonlinear.electrics import snapped
from electrovib.solve.nonlinear.integrate import fall_of

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from electrovib.core.arrays import Real
    from electrovib.physics.amplifier import Amplifier
    from electrovib.physics.drive.base import Drive
    from electrovib.solve.stack.keys import Key
    from electrovib.solve.stack.transfer import Transfer

MOST_CHANGES: Final = 1_000_000
MOST_REPEATED: Final = 16
"""Changes of the regime at one time, one after the other, beyond which none will last; those that last need two."""
HYSTERESIS: Final = 1e-10
"""Relative excess of a current over its limit, or of a voltage over its target, that changes the regime: not noise."""
_NOISE: Final = 1e-12
"""Relative excess over the largest voltage from which a target is held there, or released again."""
_ROUNDED: Final = 256
"""Roundings of a current that do not count as a change; those of the phase of an oscillation are added."""
_SLACK: Final = 1e-6
"""Share of a limit up to which an excess of a current that has just left the limit counts as rounding."""
_CLOSER: Final = 32
"""Additional checks between two, where a current may be larger than at either and beyond its limit."""
PER_CYCLE: Final = 64
"""Checks in each cycle of the drive's fastest oscillation: a maximum is at most 0.12 % above the nearest check."""
_SHARES: Final = np.unique(
    np.concatenate([[0.0, 1 - 1e-9], np.geomspace(1e-9, 1.0, 40)[:-1], np.linspace(0.0, 1.0, 33)[:-1]])
)
"""Checks between one corner and the next, as shares of the time between them."""
_FIRST, _MOST = 128, 1 << 16
"""Number of checks in the first and in the longest window after a change."""


def amplified_response(
    transfers: Mapping[Key, Transfer],
    drive: Drive,
    time: Real,
    *,
    amplifier: Amplifier,
) -> Solution:
    """Compute the response behind an amplifier with limits of quantities that are linear in the plate's voltage.

    `time` (n,) [s].
    """
    march = LimitedMarch(transfers, amplifier, drive, float(time[-1]))
    found, changes = march.run(time)
    why = (
        "linear layers behind an amplifier with limits: real modes at its voltage and at its largest current, from"
        f" rest; {len(changes)} changes between them located, in closed form from one to the next"
    )
    return Solution(found=found, method=LIMITED, reason=why, events=tuple(changes), kinks=tuple(march.kinks))


@dataclass(frozen=True, eq=False, kw_only=True)
class Span:
    """One regime of an amplifier with limits, from one change to the next.

    Parameters
    ----------
    start : float
        Beginning [s].
    mode : int
        1 or -1 at its largest current of that sign, 0 at its voltage.
    held : int
        1 or -1 while its target voltage is held at its largest voltage of that sign, else 0.
    course : Course
        Voltage of the plate; where the plate follows the drive, its deviation from the response without limits.
    states : ndarray, shape (modes,)
        States of the modes at the beginning [V]; deviations where `course` is one.
    slack : float
        By how much more a current may exceed its limit [A]: rounding at the time when it left a limit and stays near it.
    """

    start: float
    mode: int
    held: int
    course: Course
    states: Real
    slack: float = 0.0

    @property
    def follows(self) -> bool:
        """Return whether the plate follows the drive."""
        return self.mode == 0 and self.held == 0


class LimitedPlate:
    """Voltage of the plate within one regime of its amplifier, and the margins to the next change.

    Parameters
    ----------
    transfers : mapping of str to Transfer
        Wanted quantities per volt of the plate; `current` [A per volt] among them.
    amplifier : Amplifier
        Gain, pole, limits and stray capacitance.
    drive : Drive
        A voltage, off before time 0.
    end : float
        Last time [s].
    """

    def __init__(
        self, transfers: Mapping[Any, Transfer], amplifier: Amplifier, drive: Drive, end: float
    ) -> None:
        self.drive, current = drive, transfers["current"]
        self.network = Network.of(current, stray=amplifier.stray_capacitance)
        driven = [t.rates[(t.gains != 0) & (t.rates > 0)] for t in transfers.values()]
        self.rates = np.unique(np.concatenate(driven))
        self.branches = np.searchsorted(self.rates, self.network.rates)
        self.unlimited = Unlimited(drive, amplifier, self.rates, current)
        self.amplifier, self.corner = self.unlimited.amplifier, self.unlimited.corner
        self.limits = amplifier.current_limits
        self.limits_current = bool(np.isfinite(self.limits[1]))
        self.largest = amplifier.largest_voltage
        bound = abs(amplifier.gain) * sum(part.bound() for part in drive.parts())
        self.scale = max(1e-12, min(bound, self.largest))
        admittance = self.network.direct + self.network.capacitance * (self.corner or 0.0)
        cycles = 2 * np.pi * drive.highest_frequency * end
        self.rounding = float(np.finfo(float).eps) * (_ROUNDED + 2 * cycles) * self.scale * admittance
        self.stiff = self.limits_current and self.corner is None and self.network.capacitance > 0
        marks, heights = drive.corners(end)
        self.jumps = marks[heights != 0] if self.stiff else np.zeros(0)

    def margins(self, span: Span, time: Real, *, hysteresis: float = 0.0) -> Real:
        """Compute the margins to the changes that are possible, below 0 where the regime changes.

        `time` (n,) [s]; returns the lag behind the target [V], shape (1, n), at a largest current, else those of both
        currents [A] and of the target voltage [V], shape (3, n). With a hysteresis noise is no change, and the times
        at which the plate would have to jump against a capacitance are.
        """
        if span.mode:
            return self.behind(span, time)[None] + hysteresis * self.scale
        found = np.ones((3, len(time)))
        if self.limits_current:
            (lowest, highest), current = self.limits, self.current(span, time)
            slack = span.slack + (self.rounding if hysteresis else 0.0)
            found[0] = highest * (1 + hysteresis) - current + slack
            found[1] = current - lowest * (1 + hysteresis) + slack
        if np.isfinite(self.largest):
            noise, wanted = _NOISE if hysteresis else 0.0, self.amplifier.gain * self.drive.voltage(time)
            below = self.largest * (1 + noise) - np.abs(wanted)
            found[2] = span.held * wanted - self.largest * (1 - noise) if span.held else below
        if hysteresis and len(self.jumps):
            found[2, np.isin(time, self.jumps)] = -1.0
        return found

    def held(self, when: float) -> int:
        """Return whether the target is held at a largest voltage: its sign, or 0."""
        wanted = self.amplifier.gain * float(self.drive.voltage(when))
        return int(np.sign(wanted)) if abs(wanted) - self.largest > _NOISE * self.scale else 0

    def state(self, span: Span, *, when: float) -> tuple[float, Real]:
        """Return the voltage of the plate [V] and the states of the modes (modes,) [V] at a time."""
        since = np.array([when - span.start])
        voltage, states = self.unlimited.state(when) if span.follows else (0.0, np.zeros(len(self.rates)))
        voltage += float(span.course.voltage(since)[0])
        return voltage, states + span.course.answer(self.rates, span.states, since)[:, 0]

    def span(self, *, start: float, mode: int, held: int, voltage: float, states: Real) -> Span:
        """Return the regime that begins in a given state, `states` (modes,) [V]."""
        if mode:
            current, inner = self.limits[mode > 0], states[self.branches]
            course = self.network.slewed(current=current, voltage=voltage, states=inner, time=start)
            return Span(start=start, mode=mode, held=held, course=course, states=states)
        level = held * self.largest if held else 0.0
        rates, levels = (np.zeros(1), np.array([level])) if held else (np.zeros(0), np.zeros(0))
        if not held:  # the response without limits, and the deviation from it
            level, expected = self.unlimited.state(start)
            states = states - expected
        if self.corner is not None:
            rates, levels = np.append(rates, self.corner), np.append(levels, voltage - level)
        course = Course(rates, levels, np.zeros(len(levels)))
        return Span(start=start, mode=mode, held=held, course=course, states=states)

    def current(self, span: Span, time: Real) -> Real:
        """Compute the current of an amplifier at its target voltage [A], at times (n,) [s]."""
        found = self.unlimited.current(time) if span.follows else self.network.fading(time)
        return found + self.network.current(span.course, span.states[self.branches], time - span.start)

    def left(self, span: Span) -> Span:
        """Allow a current that has just left its limit to stay near it."""
        if span.mode or not self.limits_current:
            return span
        beyond = -float(np.min(self.margins(span, np.array([span.start]))[:2]))
        return replace(span, slack=2 * beyond) if 0 < beyond < _SLACK * self.limits[1] else span

    def aim(self, time: Real) -> Real:
        """Compute the target voltage of the amplifier [V] at times (n,) [s]."""
        return np.asarray(self.amplifier.aim(self.drive.voltage(time)))

    def behind(self, span: Span, time: Real) -> Real:
        """Compute by how much an amplifier at a largest current lags behind its target voltage [V]."""
        lag = self.aim(time) - span.course.voltage(time - span.start)
        if self.corner is not None:
            lag = lag - span.course.slope(time - span.start) / self.corner
        return np.asarray(span.mode * lag)


class CheckTimes:
    """Times from a given time on at which an amplifier is checked against its limits, in growing windows.

    Parameters
    ----------
    drive : Drive
        Off before time 0.
    end : float
        Last time [s].
    """

    def __init__(self, drive: Drive, end: float) -> None:
        corners = drive.corners(end)[0]
        self.end, self.frequency = end, drive.highest_frequency
        self.corners = np.unique(np.concatenate([[0.0], corners[corners <= end], [end]]))

    def after(self, start: float) -> Iterator[Real]:
        """Yield windows of times at which the amplifier is checked; closer to the beginning at first."""
        corners, count, last = self.corners, _FIRST, start
        while last < self.end:
            place = int(np.searchsorted(corners, last, side="right"))
            far = self.end
            if self.frequency:
                far = max(last + count / PER_CYCLE / self.frequency, np.nextafter(last, np.inf))
            stop = min(float(corners[min(place + count // len(_SHARES), len(corners) - 1)]), far, self.end)
            marks = corners[place - 1 : int(np.searchsorted(corners, stop, side="left")) + 1]
            near = marks[:-1, None] + _SHARES * np.diff(marks)[:, None]
            even = np.linspace(last, stop, 1 + int(np.ceil((stop - last) * self.frequency * PER_CYCLE)))
            if last == start:
                soon = start + _SHARES * (corners[place] - start)
            window = np.concatenate([near.ravel(), even, soon, [stop]])
            yield np.unique(window[(window > last) & (window <= stop)])
            count, last = min(2 * count, _MOST), stop


class LimitedMarch:
    """Event-driven integration of linear layers behind an amplifier with limits; parameters as of `LimitedPlate`."""

    def __init__(
        self, transfers: Mapping[Any, Transfer], amplifier: Amplifier, drive: Drive, end: float
    ) -> None:
        self.transfers, self.drive = transfers, drive
        self.plate = LimitedPlate(transfers, amplifier, drive, end)
        self.gains = {name: self._spread(transfer) for name, transfer in transfers.items()}
        self.checks = CheckTimes(drive, end)
        self.corners = frozenset(self.checks.corners.tolist())
        self.kinks: list[float] = []

    def _spread(self, transfer: Transfer) -> Real:
        """Return the gains of a quantity at all rates of the plate."""
        found = np.zeros(len(self.plate.rates))
        on = (transfer.gains != 0) & (transfer.rates > 0)
        np.add.at(found, np.searchsorted(self.plate.rates, transfer.rates[on]), transfer.gains[on])
        return found

    def run(self, time: Real) -> tuple[dict[str, Real], list[float]]:
        """Compute the wanted quantities from rest at times (n,) [s], and the times of the changes [s]."""
        unlimited = transient(amplified(self.transfers, self.plate.amplifier), self.drive, time)
        found = {
            name: np.array(row) for name, row in unlimited.items()
        }  # equal quantities share a row, which is added to
        self.kinks, repeats = [], self.drive.period or np.inf
        self.meter = Meter("the amplifier with limits", end=self.checks.end, repeats=repeats)
        wanted = snapped(time, self.checks.corners.tolist())
        none = np.zeros(0)
        nothing, states = Course(none, none, none), np.zeros(len(self.plate.rates))
        rest = Span(start=0.0, mode=0, held=0, course=nothing, states=states)
        span = self._begin(rest, 0.0)
        changes, repeated = [0.0] if span.mode else [], 0
        while True:
            following = self._next(span)
            stop = np.inf if following is None else following.start
            first, beyond = np.searchsorted(wanted, [span.start, stop], side="left")
            if beyond > first and span is not rest:
                self._write(found, slice(first, beyond), wanted, span)
            if following is None:
                return found, changes
            self.kinks.append(stop)
            if following.mode != span.mode:
                changes.append(stop)
            repeated = repeated + 1 if stop <= span.start else 0
            if len(changes) > MOST_CHANGES or repeated > MOST_REPEATED:
                most = f"{MOST_REPEATED} times at" if repeated else f"{MOST_CHANGES} times before"
                raise ElectrovibError(f"the amplifier changed more than {most} {span.start:.6g} s")
            span = following

    def _next(self, span: Span) -> Span | None:
        """Return the regime that begins at the next change; None if there is no change up to the end."""
        seen = np.array([span.start])
        for window in self.checks.after(span.start):
            last = float(window[-1]) if len(window) else span.start
            self.meter.count(last)
            checked, values = self._watched(span, np.concatenate([seen, window]))
            for place in np.flatnonzero(np.min(values[:, 1:], axis=0) < 0) + 1:
                when = float(checked[place])
                if when in self.corners:
                    following = self._begin(span, when)
                    if following is not span:
                        return following
                    continue
                kinds = np.flatnonzero(values[:, place] < 0).tolist()
                low = float(checked[place - 1])
                return self._changed(span, *min((self._root(span, kind, low, when), kind) for kind in kinds))
            seen = checked[-2:]
        return None

    def _watched(self, span: Span, checked: Real) -> tuple[Real, Real]:
        """Return the times of the checks, closer near a limit, and the margins there, below 0 where the regime changes."""
        values = self.plate.margins(span, checked, hysteresis=HYSTERESIS)
        if span.mode or not self.plate.limits_current:
            return checked, values
        more = [checked]
        for row in values[:2]:
            before, after = row[:-2] - row[1:-1], row[2:] - row[1:-1]
            low = (before > 0) & (after >= 0) & (row[1:-1] >= 0) & (row[1:-1] < np.maximum(before, after))
            places = np.flatnonzero(low) + 1
            more.append(np.linspace(checked[places - 1], checked[places + 1], _CLOSER + 1).ravel())
        closer = np.concatenate(more)
        if len(closer) == len(checked):
            return checked, values
        checked = np.unique(closer)
        return checked, self.plate.margins(span, checked, hysteresis=HYSTERESIS)

    def _root(self, span: Span, kind: int, low: float, high: float) -> float:
        """Return when a margin falls below 0 between two times."""
        return fall_of(lambda when: float(self.plate.margins(span, np.array([when]))[kind, 0]), low, high)

    def _changed(self, span: Span, when: float, kind: int) -> Span:
        """Return the regime after a change between two corners."""
        plate = self.plate
        voltage, states = plate.state(span, when=when)
        begin = functools.partial(plate.span, start=when, voltage=voltage, states=states)
        if span.mode:
            return plate.left(begin(mode=0, held=plate.held(when)))
        if kind < 2:
            return begin(mode=1 - 2 * kind, held=0)
        side = int(np.sign(plate.amplifier.gain * float(self.drive.voltage(when))))
        return begin(mode=0, held=0 if span.held else side)

    def _begin(self, span: Span, when: float) -> Span:
        """Return the regime from a corner on; the same object if nothing changes."""
        plate, at = self.plate, np.array([when])
        if span.mode and plate.behind(span, at)[0] > 0:
            return span
        voltage, states = plate.state(span, when=when)
        begin = functools.partial(plate.span, start=when, voltage=voltage, states=states)
        if plate.stiff:
            lag = float(plate.aim(at)[0]) - voltage
            if abs(lag) > HYSTERESIS * plate.scale:
                return begin(mode=int(np.sign(lag)), held=0)
        following, held = span, plate.held(when)
        if span.mode or span.held != held:
            following = begin(mode=0, held=held)
        if plate.limits_current:
            current, (lowest, highest) = float(plate.current(following, at)[0]), plate.limits
            over = int(current > highest * (1 + HYSTERESIS)) - int(current < lowest * (1 + HYSTERESIS))
            if over:
                return begin(mode=over, held=0)
        return following

    def _write(self, found: dict[str, Real], place: slice, time: Real, span: Span) -> None:
        """Write all responses at the output times of a regime; where it follows the drive, add the deviations."""
        plate, since = self.plate, time[place] - span.start
        voltage, slope = span.course.voltage(since), span.course.slope(since)
        answered = span.course.answer(plate.rates, span.states, since)
        rows = {"plate_voltage": voltage}
        for name, transfer in self.transfers.items():
            if transfer.static is None:
                row = transfer.direct * voltage + self.gains[name] @ answered
            else:
                row = transfer.static * voltage + self.gains[name] @ (answered - voltage)
            rows[name] = row + transfer.slope * slope
            if not span.follows:
                rows[name] = rows[name] + transfer.free @ np.exp(-np.outer(transfer.rates, time[place]))
        rows["amplifier_current"] = rows["current"] + plate.network.stray * slope
        if span.mode:
            rows["amplifier_current"] = np.full(len(since), plate.limits[span.mode > 0])
        for name, row in rows.items():
            found[name][place] = found[name][place] + row if span.follows else row
