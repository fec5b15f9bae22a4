"""Skin that sticks and slips: fingertip and bristles marched together, with every reversal located."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.core.errors import InputError
from electrovib.solve.mechanics.stick_slip.skin import SlidingSkin
from electrovib.solve.mechanics.stick_slip.skin_of import OverTime, _always, lifted, skin_of
from electrovib.solve.nonlinear.integrate import integrate
from electrovib.solve.nonlinear.system import System

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from electrovib.core.arrays import Real
    from electrovib.physics.friction import BristleFriction
    from electrovib.solve.mechanics.stick_slip.skin import Energies
    from electrovib.solve.nonlinear.system import Mode


TOLERANCE = 1e-8
"""Local error of a step: the energy then closes to some 1e-8 of the work."""
SMALLEST = 1e-9
"""Strength of a lifted finger over the largest: its bristles let go at once, and nothing is divided by zero."""
DEAD_BAND = 1e-10
"""By how much the bristles must pass the strength before that counts: rounding alone does not."""
EVENTS = ("turns", "passes the strength")
"""What the switches of a slide tell."""
_LOOKS = 4096


@dataclass(frozen=True, kw_only=True)
class Sliding(System):
    """Equations of a skin that slides over the plate under a given strength of the friction.

    Parameters
    ----------
    skin : SlidingSkin
        What moves, with its slice of the state: all of it, here.
    speed, strength : callable
        Of the finger's bone over the plate [m/s] and of the friction [N], smooth between the corners.
    corners : tuple of float
        Times [s] at which they are not smooth.
    largest_strength, largest_speed : float
        What counts as small is measured against these [N], [m/s]; above 0.

    Notes
    -----
    The mode is (sign of the speed of the skin over the plate, sign of what is left to the strength).
    """

    skin: SlidingSkin
    speed: OverTime
    strength: OverTime
    corners: tuple[float, ...]
    largest_strength: float
    largest_speed: float
    touches: Callable[[float | Real], Any] = _always

    @property
    def scale(self) -> Real:
        """Size of each state."""
        return self.skin.scale(strength=self.largest_strength, speed=self.largest_speed)

    def breaks(self, end: float) -> Sequence[float]:
        """Corners of speed and strength [s]."""
        return [corner for corner in self.corners if 0 < corner < end]

    def jump(self, state: Real, *, time: float) -> Real:
        """State just after a time [s]: bristles that leave the plate let go."""
        return state if self.touches(time) else self.skin.let_go(state)

    def rate(self, state: Real, mode: Mode, *, time: float) -> Real:
        """Rate of change of each state at a time [s]."""
        skin = self.skin if self.touches(time) else lifted(self.skin)
        return skin.rate(
            state, speed=float(self.speed(time)), strength=float(self.strength_of(time)), direction=mode[0]
        )

    def switches(self, state: Real, mode: Mode, *, time: float) -> Real:
        """Speed [m/s] along the direction of the mode, and what is left to the strength [1] likewise, at a time [s]."""
        direction, side = mode
        along = direction * self.skin.speed_over_plate(state, speed=float(self.speed(time)))
        if self.skin.law.yields_smoothly:
            return np.array([along])
        left = self.skin.left(state, strength=float(self.strength_of(time)), direction=direction)
        return np.array([along, side * left + DEAD_BAND])

    def following(self, index: int, state: Real, mode: Mode, *, time: float) -> Mode:
        """Turn the direction, or the side of the strength, at a time [s]."""
        direction, side = mode
        if index == 1:
            return (direction, -side)
        turned = -direction
        left = self.skin.left(state, strength=float(self.strength_of(time)), direction=turned)
        return (turned, 1 if left >= 0 else -1)

    def strength_of(self, time: float | Real) -> Real:
        """Strength [N] at times [s], above 0 for a lifted finger too."""
        return np.hypot(self.strength(time), SMALLEST * self.largest_strength)


@dataclass(frozen=True, kw_only=True)
class Slide:
    """How a skin slid.

    Parameters
    ----------
    skin_displacement : ndarray, shape (n,)
        Of the skin against the finger's bone, against the motion [m].
    skin_speed : ndarray, shape (n,)
        Its rate of change [m/s].
    lateral_force : ndarray, shape (n,)
        Friction force [N].
    bristle_deflection : ndarray, shape (n,)
        Deflection of the contact [m].
    energies : Energies
        Where the work of the hand has gone.
    energy_residual : float
        Largest work that is nowhere, over the largest work done [1].
    events : tuple of (float, str)
        When [s] the skin turned its direction over the plate or the bristles passed the strength.
    steps, evaluations : int
        Of the integrator, and of the equations.
    """

    skin_displacement: Real
    skin_speed: Real
    lateral_force: Real
    bristle_deflection: Real
    energies: Energies
    energy_residual: float
    events: tuple[tuple[float, str], ...]
    steps: int
    evaluations: int


def sliding(
    law: BristleFriction,
    *,
    speed: OverTime,
    strength: OverTime,
    times: Real,
    mass: float | None = None,
    stiffness: float | None = None,
    damping: float | None = None,
    breaks: Sequence[float] = (),
    touches: Callable[[float | Real], Any] = _always,
    settled: bool = False,
    tolerance: float = TOLERANCE,
    step: float | None = None,
) -> Slide:
    """March a skin with bristles over the plate: it sticks, it slips, and the energy is counted.

    Parameters
    ----------
    law : BristleFriction
        Friction of the contact.
    speed : callable
        Speed of the finger's bone over the plate [m/s] at times [s].
    strength : callable
        What the law's steady friction gives under load and attraction [N] at times [s], 0 or above.
    times : ndarray, shape (n,)
        Increasing, from 0 on [s].
    mass, stiffness, damping : float, optional
        Of the skin against the bone [kg], [N/m], [N s/m]; all absent for a rigid finger.
    breaks : sequence of float
        Times at which speed or strength are not smooth [s].
    touches : callable
        Whether the finger touches at times [s]; off the plate nothing rubs.
    settled : bool
        Whether it has always slid with the speed and strength of time 0; else it begins at rest, undeflected.
    tolerance : float
        Local error of a step over the size of each state.
    step : float, optional
        Fixed steps [s], to measure the order of convergence.

    Returns
    -------
    Slide
        Motion, force, energies and events.

    Raises
    ------
    InputError
        If the finger is neither rigid nor complete, or the strength is negative or not a number.

    Notes
    -----
    m w' = k x + c x' - F(z, z', w), x' = u - w, z' of the law; u speed of the bone, w of the skin over the
    plate. In the plate's frame the hand does (k x + c x') u, which goes into m w^2/2, k x^2/2, stiffness z^2/2,
    c x'^2 and F w - stiffness z z'. A finger without load keeps 1e-9 of the largest strength (`SMALLEST`); a viscous
    damping of the law does not know the load and stays, as long as the finger touches.
    """
    looks = _looks(times, breaks)
    strengths = np.asarray(strength(looks), dtype=float) + np.zeros(len(looks))
    not_negative(looks, strengths)
    skin = skin_of(law, mass=mass, stiffness=stiffness, damping=damping)
    fastest = float(np.max(np.abs(speed(looks))))
    largest_strength = float(strengths.max()) or skin.natural_force(fastest) or 1.0
    largest_speed = fastest or skin.natural_speed(largest_strength)
    system = Sliding(
        skin=skin,
        speed=speed,
        strength=strength,
        corners=tuple(breaks),
        largest_strength=largest_strength,
        largest_speed=largest_speed,
        touches=touches,
    )
    at_start, strength_at_start = float(speed(0.0)), float(system.strength_of(0.0))
    at_first = skin if touches(0.0) else lifted(skin)
    state = at_first.settled(speed=at_start, strength=strength_at_start) if settled else np.zeros(skin.states)
    direction = -1 if settled and at_start < 0 else 1
    solved = integrate(system, state, (direction, 1), times, tolerance=tolerance, step=step)
    speeds = np.asarray(speed(times), dtype=float) + np.zeros(len(times))
    directions = np.array([mode[0] for mode in solved.modes], dtype=float)
    over_plate = np.asarray(skin.speed_over_plate(solved.states, speed=speeds))
    deflection = skin.deflection(solved.states)
    rate = law.deflection_rate(deflection, over_plate, system.strength_of(times), directions)
    energies = skin.energies(solved.states)
    return Slide(
        skin_displacement=skin.displacement(solved.states),
        skin_speed=speeds - over_plate,
        lateral_force=np.where(touches(times), law.force(deflection, rate, over_plate), 0.0),
        bristle_deflection=deflection,
        energies=energies,
        energy_residual=energies.residual,
        events=tuple((when, EVENTS[index]) for when, index in solved.events),
        steps=solved.steps,
        evaluations=solved.evaluations,
    )


def _looks(times: Real, breaks: Sequence[float]) -> Real:
    """Times at which speed and strength are looked at beforehand."""
    every = max(1, len(times) // _LOOKS)
    inside = [when for when in breaks if 0 <= when <= times[-1]]
    return np.unique([0.0, *times[::every], float(times[-1]), *inside])


def not_negative(times: Real, strengths: Real) -> None:
    """Refuse a strength that is negative or not a number.

    Parameters
    ----------
    times, strengths : ndarray, shape (n,)
        s, N.

    Raises
    ------
    InputError
        With the first such time.
    """
    wrong = np.flatnonzero(~(strengths >= 0))
    if len(wrong):
        raise InputError(
            f"friction.steady: its strength is {strengths[wrong[0]]:.6g} N at {times[wrong[0]]:.6g} s; a contact "
            "that slips needs 0 or above, so check load, attraction and contact"
        )
