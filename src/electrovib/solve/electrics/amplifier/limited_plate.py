"""Plate and stack behind an amplifier with limits, in closed form within one regime."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.solve.electrics.amplifier.course import Course
from electrovib.solve.electrics.amplifier.slewing import Network, SlewingModes
from electrovib.solve.electrics.amplifier.span import Span
from electrovib.solve.electrics.amplifier.unlimited import Unlimited, behind, corner_apart
from electrovib.solve.stack.transfer import Transfer

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from electrovib.core.arrays import Real
    from electrovib.physics.amplifier import Amplifier
    from electrovib.physics.drive.base import Drive

HYSTERESIS = 1e-10
"""Relative excess of a current over its limit, or of a voltage over its target, that changes the regime: not noise."""
_ROUNDED = 256
"""Roundings of a current that do not count as a change; those of the phase of an oscillation are added."""
_SLACK = 1e-6
"""Share of a limit up to which an excess of a current that has just left the limit counts as rounding."""
_NOISE = 1e-12
"""Relative excess over the largest voltage from which a target is held there, or released again."""


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
        self.drive = drive
        self.network = Network.of(transfers["current"], stray=amplifier.stray_capacitance)
        self.modes: SlewingModes = self.network.modes()
        driven = [t.rates[(t.gains != 0) & (t.rates > 0)] for t in transfers.values()]
        self.rates = np.unique(np.concatenate(driven))
        self.branches = np.searchsorted(self.rates, self.network.rates)
        self.corner = corner_apart(amplifier, self.rates)
        if self.corner is not None:
            amplifier = amplifier.model_copy(update={"bandwidth": self.corner / (2 * np.pi)})
        self.amplifier, self.limits = amplifier, amplifier.current_limits
        self.largest = np.inf if amplifier.saturation is None else amplifier.saturation
        none = np.zeros(0)
        stray = Transfer(rates=none, gains=none, direct=0.0, slope=amplifier.stray_capacitance, static=0.0)
        self.unlimited = Unlimited(
            drive,
            gain=amplifier.gain,
            corner=self.corner,
            rates=self.rates,
            current=behind(transfers["current"] + stray, amplifier),
        )
        bound = abs(amplifier.gain) * sum(part.bound() for part in drive.parts())
        self.scale = max(1e-12, min(bound, self.largest))
        admittance = self.network.direct + self.network.capacitance * (self.corner or 0.0)
        cycles = 2 * np.pi * drive.highest_frequency * end
        self.rounding = float(np.finfo(float).eps) * (_ROUNDED + 2 * cycles) * self.scale * admittance
        marks, heights = drive.corners(end)
        self.jumps = marks[heights != 0]

    def margins(self, span: Span, time: Real, *, hysteresis: float) -> Real:
        """Compute the margins of an amplifier to the changes that are possible.

        `time` (n,) [s]; returns `margins` (1, n) [V].
        """
        if span.mode:
            return self.behind(span, time)[None] + hysteresis * self.scale
        current = self._of_current(span, time, hysteresis)
        jumps = np.where(self._jumps_at(time), -1.0, 1.0)
        return np.concatenate([current, np.minimum(self._of_aim(span, time, hysteresis), jumps)[None]])

    def margin(self, span: Span, *, when: float, kind: int) -> float:
        """Compute the margin of an amplifier to one change."""
        at = np.array([when])
        if span.mode:
            return float(self.behind(span, at)[0])
        if kind == 2:
            return float(self._of_aim(span, at, 0.0)[0])
        return float(self._of_current(span, at, 0.0)[kind, 0])

    def _of_current(self, span: Span, time: Real, hysteresis: float) -> Real:
        lowest, highest = self.limits
        if not np.isfinite(highest):
            return np.ones((2, len(time)))
        current, slack = self.current(span, time), span.slack + (self.rounding if hysteresis else 0.0)
        over, under = highest * (1 + hysteresis) - current, current - lowest * (1 + hysteresis)
        return np.array([over, under]) + slack

    def _of_aim(self, span: Span, time: Real, hysteresis: float) -> Real:
        if not np.isfinite(self.largest):
            return np.ones(len(time))
        noise, wanted = _NOISE if hysteresis else 0.0, self.amplifier.gain * self.drive.voltage(time)
        if span.held:
            return np.asarray(span.held * wanted - self.largest * (1 - noise))
        return np.asarray(self.largest * (1 + noise) - np.abs(wanted))

    def _jumps_at(self, time: Real) -> NDArray[np.bool_]:
        """Return at which times the plate's voltage would have to be discontinuous against a capacitance."""
        bound = self.corner is None and self.network.capacitance > 0 and np.isfinite(self.limits[1])
        if not bound or not len(self.jumps):
            return np.zeros(len(time), bool)
        return np.isin(time, self.jumps)

    def held(self, when: float) -> int:
        """Return whether the target is held at a largest voltage."""
        wanted = self.amplifier.gain * float(self.drive.voltage(when))
        return int(np.sign(wanted)) if abs(wanted) - self.largest > _NOISE * self.scale else 0

    def state(self, span: Span, *, when: float) -> tuple[float, Real]:
        """Return the voltage of the plate and the states of the modes at a time.

        Returns `modes` (modes,) [V].
        """
        since = np.array([when - span.start])
        voltage, states = 0.0, np.zeros(len(self.rates))
        if span.follows:
            voltage, states = self.unlimited.state(when)
        if span.course is None:
            return voltage, states
        voltage += float(span.course.voltage(since)[0])
        return voltage, states + span.course.answer(self.rates, span.states, since)[:, 0]

    def span(self, *, start: float, mode: int, held: int, voltage: float, states: Real) -> Span:
        """Return the regime that begins in a given state.

        `states` (modes,) [V].
        """
        if mode:
            current = self.limits[mode > 0]
            course = self.network.slewed(
                current=current, voltage=voltage, states=states[self.branches], time=start, modes=self.modes
            )
            return Span(start=start, mode=mode, held=held, course=course, states=states)
        level = held * self.largest
        if not held:  # the response without limits, and the deviation from it
            level, expected = self.unlimited.state(start)
            states = states - expected
        rates, levels = np.zeros(int(bool(held))), np.full(int(bool(held)), level)
        if self.corner is not None:
            rates, levels = np.append(rates, self.corner), np.append(levels, voltage - level)
        return Span(
            start=start,
            mode=mode,
            held=held,
            course=Course(rates, levels, np.zeros(len(levels))),
            states=states,
        )

    def current(self, span: Span, time: Real) -> Real:
        """Compute the current of an amplifier at its target voltage.

        `time` (n,) [s]; returns `current` (n,) [A].
        """
        found = self.unlimited.current(time) if span.follows else self.network.fading(time)
        if span.course is None:
            return found
        return found + self.network.current(span.course, span.states[self.branches], time - span.start)

    def left(self, span: Span) -> Span:
        """Allow a current that has just left its limit to stay near it."""
        if span.mode or not np.isfinite(self.limits[1]):
            return span
        beyond = -float(np.min(self._of_current(span, np.array([span.start]), 0.0)))
        return replace(span, slack=2 * beyond) if 0 < beyond < _SLACK * self.limits[1] else span

    def aim(self, time: Real) -> Real:
        """Compute the target voltage of the amplifier.

        `time` (n,) [s]; returns `target` (n,) [V].
        """
        return np.asarray(self.amplifier.aim(self.drive.voltage(time)))

    def behind(self, span: Span, time: Real) -> Real:
        """Compute by how much an amplifier at a largest current lags behind its target voltage.

        `time` (n,) [s]; returns `lag` (n,) [V].
        """
        assert span.course is not None
        lag = self.aim(time) - span.course.voltage(time - span.start)
        if self.corner is not None:
            lag = lag - span.course.slope(time - span.start) / self.corner
        return np.asarray(span.mode * lag)
