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
from electrovib.solve.nonlinear.integrate import Solved, System, integrate
from electrovib.solve.stack.keys import FieldOf

if TYPE_CHECKING:
    from collections.abc import Callable

    from electrovib.core.arrays import Real
    from electrovib.physics.drive.base import Drive
    from electrovib.solve.nonlinear.integrate import Mode
    from electrovib.solve.stack.keys import Key
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


class FingerOverPlate(System):
    """A stack whose gap is constant or prescribed; a `System` for `integrate`.

    Parameters
    ----------
    electrics : Electrics
        Electrical part of the system, whose states come first.
    distance : Distance, optional
        Thickness of the moving layer of `electrics.space` over time.
    """

    def __init__(self, electrics: Electrics, distance: Distance | None = None) -> None:
        self.electrics, self.distance = electrics, distance

    @property
    def scale(self) -> Real:
        """Magnitude of each state."""
        return self.electrics.scale

    def begin(self) -> tuple[Real, Mode]:
        """Return the state before time 0 and the mode after it."""
        return self.electrics.begin(self._gap(0.0, np.zeros(0), None)[0])

    def breaks(self, end: float) -> list[float]:
        """Return the breaks of the drive and of the distance, up to an end [s]."""
        bends = () if self.distance is None else self.distance.breaks()
        return sorted({*self.electrics.breaks(end), *(bend for bend in bends if 0 < bend < end)})

    def jump(self, state: Real, *, time: float) -> Real:
        """Return the state just after a break [s]."""
        count = self.electrics.size
        own = self.electrics.jump(state[:count], time=time)
        return np.concatenate([own, state[count:]])

    def rate(self, state: Real, mode: Mode, *, time: Any) -> Real:
        """Return the rate of change of each state [its unit/s]."""
        own, (gap, closing) = state[: self.electrics.size], self._gap(time, state, mode)
        return self.electrics.rate(own, mode, time=time, gap=gap, closing=closing)

    def switches(self, state: Real, mode: Mode, *, time: Any) -> Real:
        """Return values that stay above 0 as long as the mode holds."""
        own, (gap, closing) = state[: self.electrics.size], self._gap(time, state, mode)
        return self.electrics.switches(own, mode, time=time, gap=gap, closing=closing)

    def following(self, index: int, state: Real, mode: Mode, *, time: float) -> Mode:
        """Return the mode after the switching function of this index has fallen through zero."""
        own, (gap, closing) = state[: self.electrics.size], self._gap(time, state, mode)
        return self.electrics.following(index, own, mode, time=time, gap=gap, closing=closing)

    def _gap(self, time: Any, state: Real, mode: Mode | None) -> tuple[Any, Any]:
        """Return the gap [m] and its rate of change [m/s]."""
        del state, mode
        return (None, 0.0) if self.distance is None else (self.distance.gap(time), self.distance.rate(time))

    def signals(self, times: Real, solved: Solved) -> dict[Key, Real]:
        """Compute the signals at the output times, as `Electrics.signals`, and a gap that moves.

        `times` (n,) [s].
        """
        own, (gap, closing) = solved.states[: self.electrics.size], self._gaps(times, solved.states)
        found = self.electrics.signals(times, own, gap=gap, closing=closing)
        return found if gap is None else found | {"gap": gap}

    def _gaps(self, times: Real, states: Real) -> tuple[Any, Any]:
        """Return the gap [m] and its rate of change [m/s] at the output times, from the states alone."""
        return self._gap(times, states, None)


class FingerOnSurface(FingerOverPlate):
    """A stack whose gap follows load, attraction and the repulsion of the surfaces, and is a state of the system.

    Parameters
    ----------
    electrics : Electrics
        Electrical part of the system, whose states come first.
    motion : Yielding
        Motion of the moving layer of `electrics.space`.
    """

    def __init__(self, electrics: Electrics, motion: Yielding) -> None:
        super().__init__(electrics)
        self.motion = motion

    @property
    def scale(self) -> Real:
        """Magnitude of each state."""
        return np.append(self.electrics.scale, self.motion.start)

    def begin(self) -> tuple[Real, Mode]:
        """Return the state before time 0 and the mode after it."""
        state, mode = self.electrics.begin(self.motion.start)
        return np.append(state, self.motion.start), mode

    def rate(self, state: Real, mode: Mode, *, time: Any) -> Real:
        """Return the rate of change of each state [its unit/s]."""
        own, (gap, closing) = state[: self.electrics.size], self._gap(time, state, mode)
        found = self.electrics.rate(own, mode, time=time, gap=gap, closing=closing)
        return np.concatenate([found, [closing]])

    def switches(self, state: Real, mode: Mode, *, time: Any) -> Real:
        """Return values that stay above 0 as long as the mode holds, the last one as long as the gap is open."""
        open_ = state[self.electrics.size] / self.motion.start - CLOSED
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
        electrics, topography = self.electrics, type(self.motion.surface).__name__
        held = float(self.motion.surface.pressure(0.0))
        return (
            f"contact.closing: the layer '{electrics.space.names[electrics.space.moving or 0]}' closes at {time:.6g} s, under a"
            f" drive of {float(electrics.drive.voltage(np.array(time))):.4g} V: load and attraction press with"
            f" {self._pressing(time, self._pull(time, state, mode)):.4g} Pa, and contact.surface = {topography} supports at"
            f" most {held:.4g} Pa (pull-in). A closed gap is not modelled: choose a lower drive voltage, a stiffer surface"
            " topography or a shorter time.duration; 'electrovib run --states' shows the gap at a voltage"
        )

    def _pull(self, time: Any, state: Real, mode: Mode) -> Any:
        """Return the pressure of the attraction over the contact [Pa]."""
        count = self.electrics.size
        gap = state[count]
        return self.motion.pulling * self.electrics.attraction(state[:count], mode, time=time, gap=gap)

    def _push(self, time: Any, state: Real, mode: Mode) -> Any:
        """Return the pressure that opens the gap [Pa]: that of the surface, less load and attraction."""
        held = self.motion.surface.pressure(state[self.electrics.size])
        return held - self._pressing(time, self._pull(time, state, mode))

    def _pressing(self, time: Any, pull: Any) -> Any:
        """Return the pressure of load and attraction together [Pa]."""
        together = self.motion.together or (lambda when, pulled: self.motion.load(when) + pulled)
        return np.vectorize(together, otypes=[float])(time, pull)[()]

    def _gap(self, time: Any, state: Real, mode: Mode | None) -> tuple[Any, Any]:
        """Return the gap [m] and its rate of change [m/s]."""
        gap = state[self.electrics.size]
        return gap, 0.0 if mode is None else self._push(time, state, mode) / self.motion.damping

    def _gaps(self, times: Real, states: Real) -> tuple[Any, Any]:
        """Return the gap [m] and its rate of change [m/s] at the output times, from the states alone."""
        count, moving = self.electrics.size, self.electrics.space.moving
        assert moving is not None
        gap = states[count]
        found = self.electrics.signals(times, states[:count], gap=gap, closing=0.0)
        # the field does not depend on the rate of change of the gap
        field = found[FieldOf(self.electrics.space.names[moving])]
        pulls = self.motion.pulling * eps0 * field**2 / 2
        push = self.motion.surface.pressure(gap) - self._pressing(times, pulls)
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
    electrics = Electrics(space, drive, end=float(times[-1]), amplifier=amplifier)
    system = (
        FingerOnSurface(electrics, motion)
        if isinstance(motion, Yielding)
        else FingerOverPlate(electrics, motion)
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
        found=system.signals(times, solved), method=NONLINEAR, reason=why, events=events, steps=solved.steps
    )
