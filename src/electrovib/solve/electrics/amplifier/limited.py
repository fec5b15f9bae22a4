"""Linear layers behind an amplifier with limits, from one change of its regime to the next.

Between two changes everything is in closed form. While no limit is met the response is that without limits plus a
decaying deviation; at a largest voltage or current the voltage of the plate is a sum of exponentials.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.core.budget import Meter
from electrovib.core.errors import ElectrovibError
from electrovib.solve.costs import LIMIT_WINDOW, SHORTER, limit_look
from electrovib.solve.electrics.amplifier.limit_looks import LimitLooks
from electrovib.solve.electrics.amplifier.limited_plate import HYSTERESIS, LimitedPlate
from electrovib.solve.electrics.amplifier.span import Span
from electrovib.solve.electrics.amplifier.unlimited import without_limits
from electrovib.solve.nonlinear.electrics import snapped

if TYPE_CHECKING:
    from collections.abc import Mapping

    from electrovib.core.arrays import Real
    from electrovib.physics.amplifier import Amplifier
    from electrovib.physics.drive.base import Drive
    from electrovib.solve.stack.transfer import Transfer

MOST_CHANGES = 1_000_000
MOST_AT_ONCE = 16
"""Changes of the regime at one time, one after the other, beyond which none will last; those that last need two."""
_FORESEEN = 300
"""Number of changes after which the duration of the rest is predicted."""
_CLOSER = 32
"""Additional checks between two, where a current may be larger than at either and beyond its limit."""


class LimitedMarch:
    """Event-driven integration of linear layers behind an amplifier with limits.

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
        self.transfers, self.drive = transfers, drive
        self.plate = LimitedPlate(transfers, amplifier, drive, end)
        self.gains = {name: self._spread(transfer) for name, transfer in transfers.items()}
        self.looks = LimitLooks(drive, end)
        self.beside = int(LIMIT_WINDOW / limit_look(len(self.plate.rates)))
        self.corners = frozenset(self.looks.corners.tolist())
        self.kinks: list[float] = []

    def _fresh_meter(self) -> Meter:
        each = limit_look(len(self.plate.rates))
        return Meter("the amplifier with limits", end=self.looks.end, each=each, remedy=SHORTER)

    def _spread(self, transfer: Transfer) -> Real:
        found = np.zeros(len(self.plate.rates))
        on = (transfer.gains != 0) & (transfer.rates > 0)
        np.add.at(found, np.searchsorted(self.plate.rates, transfer.rates[on]), transfer.gains[on])
        return found

    def run(self, time: Real) -> tuple[dict[str, Real], list[float]]:
        """Compute the wanted quantities from rest.

        `time` (n,) [s].
        """
        found = without_limits(self.transfers, self.drive, time, amplifier=self.plate.amplifier)
        self.meter = self._fresh_meter()
        wanted = snapped(time, self.looks.corners.tolist())
        rest = Span(start=0.0, mode=0, held=0, course=None, states=np.zeros(len(self.plate.rates)))
        first_span = self._begin(rest, 0.0)
        changes = [0.0] if first_span.mode else []
        self.kinks, at_once = [], 0
        span: Span | None = first_span
        while span is not None:
            following = self._next(span)
            stop = np.inf if following is None else following.start
            first, beyond = np.searchsorted(wanted, [span.start, stop], side="left")
            if beyond > first and not (span.follows and span.course is None):
                self._write(found, slice(first, beyond), wanted, span)
            if following is not None and following.mode != span.mode:
                changes.append(following.start)
                if len(changes) == _FORESEEN:
                    share = max(following.start / self.looks.end, 1e-9)
                    self._fresh_meter().expect(int(self.meter.steps / share))
            at_once = at_once + 1 if stop <= span.start else 0
            if len(changes) > MOST_CHANGES or at_once > MOST_AT_ONCE:
                most = f"{MOST_AT_ONCE} times at" if at_once else f"{MOST_CHANGES} times before"
                raise ElectrovibError(f"the amplifier changed more than {most} {span.start:.6g} s")
            if following is not None:
                self.kinks.append(following.start)
            span = following
        return found, changes

    def _next(self, span: Span) -> Span | None:
        """Return the regime that begins at the next change; None if there is no change up to the end."""
        seen = np.array([span.start])
        for window in self.looks.after(span.start):
            self.meter.count(
                float(window[-1]) if len(window) else span.start, steps=len(window) + self.beside
            )
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
        """Return the times of the checks, closer near a limit, and the margins there, below 0 where the regime changes."""
        values = self.plate.margins(span, looks, hysteresis=HYSTERESIS)
        if span.mode or not np.isfinite(self.plate.limits[1]):
            return looks, values
        more = [looks]
        for row in values[:2]:
            before, after = row[:-2] - row[1:-1], row[2:] - row[1:-1]
            low = (before > 0) & (after >= 0) & (row[1:-1] >= 0) & (row[1:-1] < np.maximum(before, after))
            places = np.flatnonzero(low) + 1
            more.append(np.linspace(looks[places - 1], looks[places + 1], _CLOSER + 1).ravel())
        closer = np.concatenate(more)
        if len(closer) == len(looks):
            return looks, values
        looks = np.unique(closer)
        return looks, self.plate.margins(span, looks, hysteresis=HYSTERESIS)

    def _root(self, span: Span, kind: int, low: float, high: float) -> float:
        """Return when a margin falls below 0 between two times."""

        def value(when: float) -> float:
            return self.plate.margin(span, when=when, kind=kind)

        from scipy.optimize import brentq

        if value(low) <= 0:
            return low
        if value(high) >= 0:
            return high
        return float(brentq(value, low, high, xtol=1e-300, rtol=1e-15))

    def _changed(self, span: Span, when: float, kind: int) -> Span:
        """Return the regime after a change between two corners."""
        plate = self.plate
        voltage, states = plate.state(span, when=when)
        if span.mode:
            return plate.left(
                plate.span(start=when, mode=0, held=plate.held(when), voltage=voltage, states=states)
            )
        if kind == 2:
            side = int(np.sign(plate.amplifier.gain * float(self.drive.voltage(when))))
            return plate.span(
                start=when, mode=0, held=0 if span.held else side, voltage=voltage, states=states
            )
        return plate.span(start=when, mode=1 - 2 * kind, held=0, voltage=voltage, states=states)

    def _begin(self, span: Span, when: float) -> Span:
        """Return the regime from a corner on; the same object if nothing changes."""
        plate, at = self.plate, np.array([when])
        if span.mode and plate.behind(span, at)[0] > 0:
            return span
        voltage, states = plate.state(span, when=when)
        held = plate.held(when)
        limited = bool(np.isfinite(plate.limits[1]))
        if limited and plate.corner is None and plate.network.capacitance > 0:
            lag = float(plate.aim(at)[0]) - voltage
            if abs(lag) > HYSTERESIS * plate.scale:
                return plate.span(start=when, mode=int(np.sign(lag)), held=0, voltage=voltage, states=states)
        following = span
        if span.mode or span.held != held:
            following = plate.span(start=when, mode=0, held=held, voltage=voltage, states=states)
        if limited:
            current = float(plate.current(following, at)[0])
            lowest, highest = plate.limits
            over = int(current > highest * (1 + HYSTERESIS)) - int(current < lowest * (1 + HYSTERESIS))
            if over:
                return plate.span(start=when, mode=over, held=0, voltage=voltage, states=states)
        return following

    def _write(self, found: dict[str, Real], place: slice, time: Real, span: Span) -> None:
        """Write all responses at the output times of a regime; where it follows the drive, add the deviations."""
        at, course = time[place], span.course
        assert course is not None
        since = at - span.start
        voltage, slope = course.voltage(since), course.slope(since)
        answered = course.answer(self.plate.rates, span.states, since)
        stray = self.plate.network.stray * slope
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
            self.plate.limits[span.mode > 0] if span.mode else found["current"][place] + stray
        )
