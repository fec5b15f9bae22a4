"""General solver for a finger over a plate: any leaks, a gap that changes, an amplifier with limits.

It is slow and general: one stiff system of charges, polarisations, plate voltage and gap, solved by an implicit method
with adaptive steps that locates every kink. The fast solvers are tested against it.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from electrovib.core.constants import eps0
from electrovib.core.errors import InputError
from electrovib.physics.motion import Distance
from electrovib.solve.electrics.solution import NONLINEAR, Solution
from electrovib.solve.nonlinear.electrics import Electrics
from electrovib.solve.nonlinear.integrate import TOLERANCE, integrate
from electrovib.solve.nonlinear.stretch import snapped
from electrovib.solve.nonlinear.system import Solved, System
from electrovib.solve.nonlinear.yielding import Yielding
from electrovib.solve.stack.keys import FieldOf

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.physics.amplifier import Amplifier
    from electrovib.physics.drive.base import Drive
    from electrovib.solve.nonlinear.system import Mode
    from electrovib.solve.stack.keys import Key
    from electrovib.solve.stack.layer_states import StackStates


CLOSED = 1e-6
"""Ratio to the gap at time 0 below which a gap that follows the forces counts as closed."""


Gap: TypeAlias = Distance | Yielding | None
"""Motion of the layer `gap`: prescribed whatever the forces, following the forces, or none."""


class FingerOverPlate(System):
    """A stack whose gap is constant, prescribed, or follows the forces; a `System` for `integrate`.

    Parameters
    ----------
    electrics : Electrics
        Electrical part of the system, whose states come first.
    motion : Distance, Yielding or None
        Motion of the moving layer of `electrics.space`.
    """

    def __init__(self, electrics: Electrics, motion: Gap = None) -> None:
        self.electrics, self.motion = electrics, motion

    @property
    def mechanical(self) -> int:
        """Number of states of the gap."""
        return (1 + (self.motion.mass > 0)) if isinstance(self.motion, Yielding) else 0

    @property
    def scale(self) -> Real:
        """Magnitude of each state."""
        sizes = self.electrics.scale
        if isinstance(self.motion, Yielding):
            start = self.motion.start
            slowed = self.motion.damping or np.sqrt(self.motion.mass * self.motion.load(0.0) / start)
            speed = self.motion.load(0.0) / (slowed or 1.0)
            sizes = np.append(sizes, [start, speed or start][: self.mechanical])
        return sizes

    def begin(self) -> tuple[Real, Mode]:
        """Return the state before time 0 and the mode after it."""
        gap = self.motion.start if isinstance(self.motion, Yielding) else self._gap(0.0, np.zeros(0))[0]
        state, mode = self.electrics.begin(gap)
        return (np.append(state, [gap, 0.0][: self.mechanical]) if gap is not None else state), mode

    def breaks(self, end: float) -> list[float]:
        """Return the breaks of the drive and of the motion, up to an end [s]."""
        bends = self.motion.breaks() if isinstance(self.motion, Distance) else ()
        return sorted({*self.electrics.breaks(end), *(bend for bend in bends if 0 < bend < end)})

    def jump(self, state: Real, *, time: float) -> Real:
        """Return the state just after a break [s]."""
        count = self.electrics.size
        own = self.electrics.jump(state[:count], time=time)
        return np.concatenate([own, state[count:]])

    def rates(self, states: Real, mode: Mode, *, times: Real) -> Real:
        """Return the rate of change of each state [its unit/s] at n times, all at once unless the gap is a state."""
        if isinstance(self.motion, Yielding):
            return super().rates(states, mode, times=times)
        return self.rate(states, mode, time=times)

    def watched(self, states: Real, mode: Mode, *, times: Real) -> Real:
        """Return the switching functions at n times, all at once unless the gap is a state."""
        if isinstance(self.motion, Yielding):
            return super().watched(states, mode, times=times)
        return self.switches(states, mode, time=times)

    def rate(self, state: Real, mode: Mode, *, time: Any) -> Real:
        """Return the rate of change of each state [its unit/s]."""
        own, (gap, closing) = state[: self.electrics.size], self._gap(time, state, mode)
        found = self.electrics.rate(own, mode, time=time, gap=gap, closing=closing)
        if not isinstance(self.motion, Yielding):
            return found
        if self.motion.mass > 0:
            push = self._push(time, state, mode) - self.motion.damping * closing
            return np.append(found, [closing, push / self.motion.mass])
        return np.append(found, closing)

    def switches(self, state: Real, mode: Mode, *, time: Any) -> Real:
        """Return values that stay above 0 as long as the mode holds."""
        own, (gap, closing) = state[: self.electrics.size], self._gap(time, state, mode)
        found = self.electrics.switches(own, mode, time=time, gap=gap, closing=closing)
        if isinstance(self.motion, Yielding):
            found = np.append(found, float(gap or 0.0) / self.motion.start - CLOSED)
        return found

    def following(self, index: int, state: Real, mode: Mode, *, time: float) -> Mode:
        """Return the mode after the switching function of this index has fallen through zero."""
        own, (gap, closing) = state[: self.electrics.size], self._gap(time, state, mode)
        if index == len(self.electrics.switches(own, mode, time=time, gap=gap, closing=closing)):
            raise InputError(self._closed(time, state, mode))
        return self.electrics.following(index, own, mode, time=time, gap=gap, closing=closing)

    def _closed(self, time: float, state: Real, mode: Mode) -> str:
        """Return the message that the gap has closed: when, under which voltage, and what the user may do."""
        assert isinstance(self.motion, Yielding)
        electrics, topography = self.electrics, type(self.motion.surface).__name__
        count = electrics.size
        pull = self.motion.pulling * electrics.attraction(
            state[:count], mode, time=time, gap=float(state[count])
        )
        held = float(self.motion.surface.pressure(0.0))
        return (
            f"contact.closing: the layer '{electrics.space.names[electrics.space.moving or 0]}' closes at {time:.6g} s, under a"
            f" drive of {float(electrics.drive.voltage(np.array(time))):.4g} V: load and attraction press with"
            f" {self._pressing(time, pull):.4g} Pa, and contact.surface = {topography} supports at most {held:.4g} Pa (pull-in)."
            " A closed gap is not modelled: choose a lower drive voltage, a stiffer surface topography or a shorter"
            " time.duration; 'electrovib equilibrium' shows the gap at a voltage"
        )

    def _push(self, time: float, state: Real, mode: Mode) -> float:
        """Return the pressure that opens the gap [Pa]: that of the surface, less load and attraction."""
        assert isinstance(self.motion, Yielding)
        count = self.electrics.size
        gap = float(state[count])
        pull = self.motion.pulling * self.electrics.attraction(state[:count], mode, time=time, gap=gap)
        return float(self.motion.surface.pressure(gap)) - self._pressing(time, pull)

    def _gap(self, time: Any, state: Real, mode: Mode | None = None) -> tuple[Any, Any]:
        """Return the gap [m] and its rate of change [m/s]."""
        if self.motion is None:
            return None, 0.0
        if isinstance(self.motion, Distance):
            return self.motion.gap(time), self.motion.rate(time)
        gap = float(state[self.electrics.size])
        if self.motion.mass > 0:
            return gap, float(state[self.electrics.size + 1])
        return gap, 0.0 if mode is None else self._push(time, state, mode) / self.motion.damping

    def signals(self, times: Real, solved: Solved) -> dict[Key, Real]:
        """Compute the signals at the output times, as `Electrics.signals`, and the gap.

        `times` (n,) [s].
        """
        if self.motion is None:
            return self.electrics.signals(times, solved.states, gap=None, closing=0.0)
        own = solved.states[: self.electrics.size]
        gap, closing = self._gaps(times, solved.states)
        return self.electrics.signals(times, own, gap=gap, closing=closing) | {"gap": gap}

    def _gaps(self, times: Real, states: Real) -> tuple[Real, Real]:
        """Return the gap [m] and its rate of change [m/s] at the output times, from the states alone."""
        if not isinstance(self.motion, Yielding):
            assert self.motion is not None
            return self.motion.gap(times), self.motion.rate(times)
        count, moving = self.electrics.size, self.electrics.space.moving
        assert moving is not None
        gap = states[count]
        if self.motion.mass > 0:
            return gap, states[count + 1]
        found = self.electrics.signals(times, states[:count], gap=gap, closing=0.0)
        field = found[
            FieldOf(self.electrics.space.names[moving])
        ]  # does not depend on the gap's rate of change
        pulls = self.motion.pulling * eps0 * field**2 / 2
        pressing = [self._pressing(*each) for each in zip(times.tolist(), pulls.tolist(), strict=True)]
        return gap, (self.motion.surface.pressure(gap) - np.array(pressing)) / self.motion.damping

    def _pressing(self, time: float, pull: float) -> float:
        """Return the pressure of load and attraction together [Pa]."""
        assert isinstance(self.motion, Yielding)
        together = self.motion.together
        return self.motion.load(time) + pull if together is None else together(time, pull)


def follow_finger(
    space: StackStates,
    drive: Drive,
    times: Real,
    *,
    amplifier: Amplifier | None = None,
    motion: Gap = None,
    tolerance: float = TOLERANCE,
) -> Solution:
    """Compute the response of a finger over a plate from rest by the general solver.

    `times` (n,) [s].
    """
    if drive.quantity == "current":
        raise InputError(
            f"drive = {type(drive).__name__}: the general solver takes a voltage drive; a current drive is solved with a"
            " fixed gap and at most one leak"
        )
    if (motion is not None) != (space.moving is not None):
        raise InputError("motion.distance: it needs the layer 'gap', and moves nothing else")
    system = FingerOverPlate(Electrics(space, drive, end=float(times[-1]), amplifier=amplifier), motion)
    state, mode = system.begin()
    outputs = snapped(times, system.breaks(float(times[-1])))
    solved = integrate(system, state, mode, outputs, tolerance=tolerance, repeats=drive.period or math.inf)
    why = (
        "charges, polarisations and the moving gap as one stiff system from rest, Radau's method of order 5,"
        f" {solved.steps} steps, {len(solved.events)} events located"
    )
    events = tuple(moment for moment, _ in solved.events)
    return Solution(
        found=system.signals(times, solved), method=NONLINEAR, reason=why, events=events, steps=solved.steps
    )
