"""A skin with bristles under the attraction of a scenario: the force between its corners as smooth as a solver needs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.core.errors import InputError
from electrovib.physics.finger import MassSpringDamper
from electrovib.solve.nonlinear.sliding import Slide, sliding
from electrovib.solve.scenario import PeriodicState

if TYPE_CHECKING:
    from collections.abc import Callable

    from electrovib.physics.friction import BristleFriction
    from electrovib.solve.scenario import Scenario
    from electrovib.solve.transfer import Real

KNOTS = 4000
"""Times, besides the output times, between which the attraction is taken as a cubic."""
_BEFORE = 1e-9
"""How long before a corner the force before it is looked up, as a share of the whole time."""


class Smooth:
    """A force as cubics between its corners, where it may jump.

    Parameters
    ----------
    force_at : callable
        Force [N] at increasing times [s], at a jump the value after it.
    times : ndarray, shape (n,)
        Where it has to be right [s].
    corners : ndarray
        Where it may bend or jump [s].
    """

    def __init__(self, force_at: Callable[[Real], Real], times: Real, corners: Real) -> None:
        from scipy.interpolate import CubicSpline

        end = float(times[-1])
        inside = corners[(corners > 0) & (corners < end)]
        self.ends = np.unique(np.concatenate([[0.0], inside, [end]]))
        even = np.linspace(0.0, end, KNOTS + 1)
        knots = np.unique(np.concatenate([even, times, self.ends]))
        before = self.ends[1:] - _BEFORE * end
        force = force_at(np.sort(np.concatenate([knots, before])))
        asked = np.sort(np.concatenate([knots, before]))
        self.pieces = []
        for start, stop, just in zip(self.ends[:-1], self.ends[1:], before, strict=True):
            chosen = (asked >= start) & (asked < just)
            values = np.append(force[chosen], force[np.searchsorted(asked, just)])
            stamps = np.append(asked[chosen], stop)
            spaced = np.append(np.diff(stamps) > _BEFORE * end, True)
            spaced[0] = True
            stamps, values = stamps[spaced], values[spaced]
            self.pieces.append(
                CubicSpline(stamps, values, bc_type="natural" if len(stamps) < 4 else "not-a-knot")
            )

    def __call__(self, time: Any) -> Any:
        """Force [N] at times [s]."""
        place = np.clip(np.searchsorted(self.ends, time, side="right") - 1, 0, len(self.pieces) - 1)
        if np.ndim(time) == 0:
            return float(self.pieces[int(place)](time))
        found = np.empty(np.shape(time))
        for index in np.unique(place).tolist():
            found[place == index] = self.pieces[index](np.asarray(time)[place == index])
        return found


def slide(
    scenario: Scenario, law: BristleFriction, times: Real, force_at: Callable[[Real], Real], corners: Real
) -> tuple[Slide, dict[str, Any]]:
    """March the skin of a scenario over the plate.

    Parameters
    ----------
    scenario : Scenario
        Motion, finger and load.
    law : BristleFriction
        Its friction.
    times : ndarray, shape (n,)
        Increasing, >= 0 [s].
    force_at : callable
        Steady friction [N] at times [s].
    corners : ndarray
        Where it may bend or jump [s].

    Returns
    -------
    slide : Slide
        At these times.
    how : dict
        Solver, residual of the energy and number of events, for the Trace.

    Raises
    ------
    InputError
        If there is no speed, or the finger is none that the solver knows.

    Notes
    -----
    A finger that moves at time 0 has always slid steadily; one that begins at rest is not deflected.
    """
    motion, finger = scenario.motion, scenario.finger
    name = type(law).__name__
    if motion.speed is None:
        raise InputError(f"friction = {name} needs motion.speed, for instance motion.speed = '30 mm/s'")
    if isinstance(scenario.time.initial_state, PeriodicState):
        raise InputError(
            f"time.initial_state = PeriodicState: friction = {name} sticks and slips in its own time. Start AtRest and look"
            " at a late period"
        )
    if finger is not None and not isinstance(finger, MassSpringDamper):
        raise InputError(
            f"finger = {type(finger).__name__}: friction = {name} needs MassSpringDamper, or no finger"
        )
    skin = {} if finger is None else _skin(finger.at_speed(motion.speed))
    bends = {time for time, _ in motion.programme.corners() if time > 0} | set(corners[corners > 0].tolist())
    asked = times if times[0] == 0 else np.append(0.0, times)
    found = sliding(
        law,
        speed=motion.speeds,
        strength=Smooth(force_at, asked, corners),
        times=asked,
        breaks=sorted(bends),
        settled=float(motion.speeds(0.0)) > 0,
        **skin,
    )
    why = (
        f"{name} sticks and slips: skin and bristles as one stiff system, Radau's method of order 5, {found.steps} steps,"
        f" {len(found.events)} events located"
    )
    return found, {
        "friction_solver": why,
        "energy_residual": found.energy_residual,
        "friction_events": len(found.events),
    }


def _skin(finger: MassSpringDamper) -> dict[str, float]:
    return {"mass": finger.mass, "stiffness": finger.stiffness, "damping": finger.damping}
