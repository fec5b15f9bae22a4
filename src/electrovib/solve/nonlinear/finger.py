"""General solver for a finger over a plate: any leaks, a gap that changes, an amplifier with limits.

It is slow and general: one stiff system of charges, polarisations, plate voltage and gap, solved by an implicit method
with adaptive steps that locates every kink. The fast solvers are tested against it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from electrovib.core.constants import eps0
from electrovib.core.errors import InputError
from electrovib.physics.amplifier import IDEAL, Amplifier
from electrovib.physics.motion import Distance
from electrovib.solve.electrics.solution import NONLINEAR, Solution
from electrovib.solve.nonlinear.electrics import Electrics, snapped
from electrovib.solve.nonlinear.integrate import integrate
from electrovib.solve.stack.keys import FieldOf

if TYPE_CHECKING:
    from collections.abc import Callable

    from electrovib.core.arrays import Real
    from electrovib.physics.drive.base import Drive
    from electrovib.solve.nonlinear.integrate import Mode
    from electrovib.solve.stack.layer_states import StackStates

CLOSED = 1e-6
"""Ratio to the gap at time 0 below which a gap that follows the forces counts as closed."""


class Repelling(Protocol):
    """Repulsive pressure between finger and plate."""

    def pressure(self, gap: Any) -> Any:
        """Return the pressure [Pa] at a gap [m]; it decreases with the gap."""


@dataclass(frozen=True, kw_only=True)
class Yielding:
    """A gap that follows load, attraction and the repulsive pressure of the surfaces.

    Parameters
    ----------
    surface : Repelling
        Repulsive pressure as a function of the gap.
    load : callable
        Pressure of the load [Pa] at a time [s].
    start : float
        Gap at time 0, at rest [m].
    damping : float
        Damping per area [Pa s/m], above 0: the motion is overdamped.
    pulling : float
        Share of the area on which the field of the gap attracts.
    together : callable, optional
        Pressure of load and attraction together [Pa] at a time [s] and a pressure of attraction [Pa], on an area that
        grows with both; by default their sum.
    """

    surface: Repelling
    load: Callable[[float], float]
    start: float
    damping: float
    pulling: float = 1.0
    together: Callable[[float, float], float] | None = None


class FingerOnSurface(Electrics):
    """A stack whose gap follows load, attraction and the repulsion of the surfaces, and is the last state of the system."""

    def __init__(
        self, space: StackStates, drive: Drive, *, end: float, amplifier: Amplifier, motion: Yielding
    ) -> None:
        super().__init__(space, drive, end=end, amplifier=amplifier)
        self.motion = motion

    @property
    def scale(self) -> Real:
        """Magnitude of each state."""
        return np.append(super().scale, self.motion.start)

    def begin(self) -> tuple[Real, Mode]:
        """Return the state before time 0 and the mode after it."""
        state, mode = self._begun(self.motion.start)
        return np.append(state, self.motion.start), mode

    def jump(self, state: Real, *, time: float) -> Real:
        """Return the state just after a break [s]."""
        return np.append(super().jump(state[: self.size], time=time), state[self.size :])

    def rate(self, state: Real, mode: Mode, *, time: Any) -> Real:
        """Return the rate of change of each state [its unit/s]."""
        own, (gap, closing) = state[: self.size], self._gap(time, state, mode)
        return np.concatenate([self._own_rate(own, mode, time, gap, closing), [closing]])

    def switches(self, state: Real, mode: Mode, *, time: Any) -> Real:
        """Return values that stay above 0 as long as the mode holds, the last one as long as the gap is open."""
        open_ = state[self.size] / self.motion.start - CLOSED
        return np.concatenate(
            [super().switches(state, mode, time=time).reshape(-1, *np.shape(open_)), [open_]]
        )

    def following(self, index: int, state: Real, mode: Mode, *, time: float) -> Mode:
        """Return the mode after the switching function of this index has fallen through zero; a closed gap is refused."""
        if index == len(super().switches(state, mode, time=time)):
            raise InputError(self._closed(time, state, mode))
        return super().following(index, state, mode, time=time)

    def _closed(self, time: float, state: Real, mode: Mode) -> str:
        """Return the message that the gap has closed: when, under which voltage, and what the user may do."""
        topography = type(self.motion.surface).__name__
        held = float(self.motion.surface.pressure(0.0))
        return (
            f"contact.closing: the layer '{self.space.names[self.space.moving or 0]}' closes at {time:.6g} s, under a"
            f" drive of {float(self.drive.voltage(np.array(time))):.4g} V: load and attraction press with"
            f" {self._pressing(time, self._pull(time, state, mode)):.4g} Pa, and contact.surface = {topography} supports at"
            f" most {held:.4g} Pa (pull-in). A closed gap is not modelled: choose a lower drive voltage, a stiffer surface"
            " topography or a shorter time.duration; 'electrovib run --states' shows the gap at a voltage"
        )

    def _pull(self, time: Any, state: Real, mode: Mode) -> Any:
        """Return the pressure of the attraction over the contact [Pa]."""
        own, gap = state[: self.size], state[self.size]
        return self.motion.pulling * self.attraction(own, mode, time=time, gap=gap)

    def _push(self, time: Any, state: Real, mode: Mode) -> Any:
        """Return the pressure that opens the gap [Pa]: that of the surface, less load and attraction."""
        held = self.motion.surface.pressure(state[self.size])
        return held - self._pressing(time, self._pull(time, state, mode))

    def _pressing(self, time: Any, pull: Any) -> Any:
        """Return the pressure of load and attraction together [Pa]."""
        together = self.motion.together or (lambda when, pulled: self.motion.load(when) + pulled)
        return np.vectorize(together, otypes=[float])(time, pull)[()]

    def _gap(self, time: Any, state: Real, mode: Mode | None) -> tuple[Any, Any]:
        """Return the gap [m] and its rate of change [m/s]; without a mode from the states alone."""
        gap = state[self.size]
        if mode is not None:
            return gap, self._push(time, state, mode) / self.motion.damping
        moving = self.space.moving
        assert moving is not None
        found = self._own_signals(time, state[: self.size], gap, 0.0)
        # the field does not depend on the rate of change of the gap
        pulls = self.motion.pulling * eps0 * found[FieldOf(self.space.names[moving])] ** 2 / 2
        push = self.motion.surface.pressure(gap) - self._pressing(time, pulls)
        return gap, push / self.motion.damping


def follow_finger(
    space: StackStates,
    drive: Drive,
    times: Real,
    *,
    amplifier: Amplifier = IDEAL,
    motion: Distance | Yielding | None = None,
) -> Solution:
    """Compute the response of a finger over a plate from rest by the general solver.

    `times` (n,) [s].
    """
    given: dict[str, Any] = {"end": float(times[-1]), "amplifier": amplifier}
    system = (
        FingerOnSurface(space, drive, motion=motion, **given)
        if isinstance(motion, Yielding)
        else Electrics(space, drive, distance=motion, **given)
    )
    state, mode = system.begin()
    outputs = snapped(times, system.breaks(float(times[-1])))
    solved = integrate(system, state, mode, outputs, repeats=drive.period or math.inf)
    why = (
        "charges, polarisations and the moving gap as one stiff system from rest, Radau's method of order 5,"
        f" {solved.steps} steps, {len(solved.events)} events located"
    )
    events = tuple(moment for moment, _ in solved.events)
    return Solution(
        found=system.signals(times, solved.states),
        method=NONLINEAR,
        reason=why,
        events=events,
        steps=solved.steps,
    )
