"""Stick-slip motion of fingertip and bristles as one stiff system, with every reversal located.

A state has the rows `DEFLECTION` to `DAMPER`; a rigid finger has the first three only. The equations are functions of
numbers, so that the same ones run in Python for any law and any course in time, and compiled (`compiled.py`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from electrovib.core.errors import InputError
from electrovib.solve.nonlinear.integrate import Solved, System, integrate

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from electrovib.core.arrays import Real
    from electrovib.physics.friction import BristleFriction
    from electrovib.solve.nonlinear.integrate import Mode


OverTime: TypeAlias = "Callable[[float | Real], float | Real]"
"""A quantity at times [s], one or many; at a discontinuity the value after it."""
DEFLECTION, WORK, FRICTION, DISPLACEMENT, OVER_PLATE, DAMPER = range(6)
"""Deflection of the bristles [m], work of the hand, heat of the friction [J]; displacement of the skin against the bone [m],
its speed over the plate [m/s], heat of its damper [J]."""
TOLERANCE = 1e-8
"""Local error of a step, relative; the energy balance then closes to some 1e-8 of the work."""
SMALLEST = 1e-9
"""Smallest strength of the friction over the largest, which avoids a division by zero without load or contact."""
DEAD_BAND = 1e-10
"""Excess of the bristle force over the strength, over the largest strength, below which it is rounding."""
STILL = 1e-12
"""Speed against the direction of the mode, over the largest, above which it is a reversal rather than rounding."""
EVENTS = ("turns", "passes the strength")
"""Events of a slide: the skin reverses over the plate, the bristle force passes the strength of the friction."""
_LOOKS = 4096
"""Number of output times at which speed and strength are checked beforehand."""


def given_at(system: Any, time: float) -> tuple[float, float, Any]:
    """Return the speed of the bone [m/s], the strength of the friction [N] and the contact at a time [s]."""
    strength = float(system.strength_of(time))
    return float(system.speed(time)), strength, system.touches(time)


def deflection_rate(law: Any, deflection: Any, speed: Any, strength: Any, direction: Any) -> Any:
    """Return the rate of the deflection [m/s] of a bristle law."""
    return law.deflection_rate(deflection, speed, strength, direction)


def friction_force(law: Any, deflection: Any, rate: Any, speed: Any) -> Any:
    """Return the force [N] of a bristle law."""
    return law.force(deflection, rate, speed)


def skin_rates(system: Any, states: Real, mode: Any, times: Real) -> Real:
    """Return the rates of change of n states (states, n): m w' = k x + c x' - F(z, z', w), x' = u - w, z' from the law.

    In the frame of the plate the power of the hand is (k x + c x') u, and the heat of the friction F w - stiffness z z'.
    """
    found = np.zeros(states.shape)
    for column in range(len(times)):
        speed, strength, touches = given_at(system, times[column])
        deflection = states[DEFLECTION, column]
        over_plate = states[OVER_PLATE, column] if len(states) > OVER_PLATE else speed
        rate, friction = 0.0, 0.0
        if touches:
            rate = deflection_rate(system.law, deflection, over_plate, strength, mode[0])
            friction = friction_force(system.law, deflection, rate, over_plate)
        hand = friction
        if len(states) > OVER_PLATE:
            relative = speed - over_plate
            hand = system.stiffness * states[DISPLACEMENT, column] + system.damping * relative
            found[DISPLACEMENT, column] = relative
            found[OVER_PLATE, column] = (hand - friction) / system.mass
            found[DAMPER, column] = system.damping * relative * relative
        found[DEFLECTION, column] = rate
        found[WORK, column] = hand * speed
        found[FRICTION, column] = friction * over_plate - system.law.stiffness * deflection * rate
    return found


def skin_switches(system: Any, states: Real, mode: Any, times: Real) -> Real:
    """Return speed along the direction of the mode [m/s] and remaining share of the strength [1], (switches, n)."""
    direction, side = mode
    values = np.empty((1 if system.yields_smoothly else 2, len(times)))
    for column in range(len(times)):
        speed, strength, _touches = given_at(system, times[column])
        over_plate = states[OVER_PLATE, column] if len(states) > OVER_PLATE else speed
        values[0, column] = direction * over_plate + STILL * system.largest_speed
        if len(values) > 1:
            left = 1 - direction * system.law.stiffness * states[DEFLECTION, column] / strength
            values[1, column] = side * left + DEAD_BAND * system.largest_strength / strength
    return values


def skin_following(system: Any, index: int, state: Real, mode: Any, time: float) -> Any:
    """Return the mode after a reversal, or after the bristle force has passed the strength."""
    direction, side = mode
    if index == 1:
        return direction, -side
    _speed, strength, _touches = given_at(system, time)
    left = 1 + direction * system.law.stiffness * state[DEFLECTION] / strength
    return -direction, 1 if left >= 0 else -1


def skin_jump(system: Any, state: Real, time: float) -> Real:
    """Return the state just after a time [s]: off the plate the deflection is 0, and its energy has become heat."""
    after = state.copy()
    if not given_at(system, time)[2]:
        after[FRICTION] += system.law.stiffness * state[DEFLECTION] ** 2 / 2
        after[DEFLECTION] = 0.0
    return after


@dataclass(frozen=True, kw_only=True)
class Energies:
    """Energy balance of a sliding skin since time 0.

    Parameters
    ----------
    work : ndarray, shape (n,)
        Work done by the hand [J].
    kinetic, elastic, bristle : ndarray, shape (n,)
        Energy stored in the motion of the skin over the plate, in the fingertip and in the contact [J].
    damper, friction : ndarray, shape (n,)
        Heat dissipated in the fingertip and in the contact [J].
    """

    work: Real
    kinetic: Real
    elastic: Real
    bristle: Real
    damper: Real
    friction: Real

    @property
    def residual(self) -> float:
        """Largest error of the energy balance, over the largest work or the initial energy [1]; 0 without motion."""
        stored = self.kinetic + self.elastic + self.bristle
        missing = self.work - (stored - stored[0]) - self.damper - self.friction
        size = float(max(np.max(np.abs(self.work)), stored[0]))
        return float(np.max(np.abs(missing))) / size if size > 0 else 0.0


@dataclass(frozen=True, kw_only=True)
class SlidingSkin:
    """Skin with mass on a spring and a damper, or a rigid one, whose mass is 0.

    Parameters
    ----------
    law : BristleFriction
        Friction of the contact.
    mass, stiffness, damping : float
        Mass [kg], stiffness [N/m] and damping [N s/m].
    """

    law: BristleFriction
    mass: float = 0.0
    stiffness: float = 0.0
    damping: float = 0.0

    def scale(self, *, strength: float, speed: float) -> Real:
        """Return the scale of each state for a strength [N] and a speed [m/s]."""
        deflection = strength / self.law.stiffness
        if not self.mass:
            return np.array([deflection, *[strength * deflection] * 2])
        stretch = strength / self.stiffness
        return np.array([deflection, *[strength * stretch] * 2, stretch, speed, strength * stretch])

    def begin(self, *, settled: bool, speed: float, strength: float, touches: bool) -> Real:
        """Return the state of steady sliding, or of an undeflected contact at rest."""
        state = np.zeros(6 if self.mass else 3)
        if not settled:
            return state
        level: Any = self.law.strength_at(np.asarray(speed), np.asarray(strength))
        deflection: Any = np.sign(speed) * level / self.law.stiffness * touches
        state[DEFLECTION] = deflection
        if self.mass:
            rest: Any = 0.0
            force = float(self.law.force(deflection, rest, np.asarray(speed))) if touches else 0.0
            state[DISPLACEMENT], state[OVER_PLATE] = force / self.stiffness, speed
        return state

    @property
    def impedance(self) -> float:
        """Force of the spring when the skin is stopped, over its speed: sqrt(stiffness mass) [N s/m]."""
        return float(np.sqrt(self.stiffness * self.mass))

    def sizes(self, *, strength: float, speed: float) -> tuple[float, float]:
        """Return scales above 0 of strength [N] and speed [m/s] from the largest of a motion, each of which may be 0."""
        largest = strength or speed * self.impedance or 1.0
        return largest, speed or (largest / self.impedance if self.mass else 1.0)

    def slide(self, solved: Solved, *, speeds: Real, strengths: Real, touches: Any) -> Slide:
        """Return forces and energies at the output times from the states."""
        states, nothing = solved.states, np.zeros(len(speeds))
        deflection, directions = states[DEFLECTION], solved.modes[:, 0].astype(float)
        over_plate = states[OVER_PLATE] if self.mass else speeds
        displacement = states[DISPLACEMENT] if self.mass else nothing
        rate = self.law.deflection_rate(deflection, over_plate, strengths, directions)
        energies = Energies(
            work=states[WORK],
            kinetic=self.mass * over_plate**2 / 2,
            elastic=self.stiffness * displacement**2 / 2,
            bristle=self.law.stiffness * deflection**2 / 2,
            damper=states[DAMPER] if self.mass else nothing,
            friction=states[FRICTION],
        )
        return Slide(
            skin_displacement=displacement,
            skin_speed=speeds - over_plate,
            lateral_force=np.where(touches, self.law.force(deflection, rate, over_plate), 0.0),
            bristle_deflection=deflection,
            energies=energies,
            energy_residual=energies.residual,
            events=tuple((when, EVENTS[index]) for when, index in solved.events),
            steps=solved.steps,
        )


@dataclass(frozen=True, kw_only=True)
class Slide:
    """Motion, forces and energies of a sliding skin.

    Parameters
    ----------
    skin_displacement : ndarray, shape (n,)
        Displacement of the skin relative to the bone, positive against the motion [m].
    skin_speed : ndarray, shape (n,)
        Its rate of change [m/s].
    lateral_force : ndarray, shape (n,)
        Friction force [N].
    bristle_deflection : ndarray, shape (n,)
        Deflection of the contact [m].
    energies : Energies
        Energy balance.
    energy_residual : float
        Largest error of the energy balance, over the largest work [1].
    events : tuple of (float, str)
        Times [s] and kinds of the events, as in `EVENTS`.
    steps : int
        Number of time steps.
    """

    skin_displacement: Real
    skin_speed: Real
    lateral_force: Real
    bristle_deflection: Real
    energies: Energies
    energy_residual: float
    events: tuple[tuple[float, str], ...]
    steps: int


def skin_of(
    law: BristleFriction,
    *,
    mass: float | None = None,
    stiffness: float | None = None,
    damping: float | None = None,
) -> SlidingSkin:
    """Return the skin of a finger, or a rigid one."""
    if mass is None and stiffness is None and damping is None:
        return SlidingSkin(law=law)
    if mass is None or stiffness is None or damping is None:
        raise InputError("finger: needs mass, stiffness and damping, or none of them for a rigid finger")
    if not mass > 0:
        raise InputError(
            f"finger.mass = {mass:.6g} kg: it must be above 0, because the speed of the skin is a state; omit the finger for"
            " a rigid one"
        )
    if not (stiffness > 0 and damping >= 0):
        raise InputError(
            f"finger: stiffness = {stiffness:.6g} N/m must be above 0, and damping = {damping:.6g} N s/m must not be negative"
        )
    return SlidingSkin(law=law, mass=mass, stiffness=stiffness, damping=damping)


def _always(time: float | Real) -> Any:
    return np.ones(np.shape(time), dtype=bool)


@dataclass(frozen=True, kw_only=True)
class Sliding(System):
    """Equations of a skin that slides over the plate under a given strength of the friction.

    Parameters
    ----------
    skin : SlidingSkin
        Finger and law.
    speed, strength : callable
        Speed of the bone over the plate [m/s] and strength of the friction [N], smooth between the corners.
    corners : tuple of float
        Times at which they are not smooth [s].
    largest_strength, largest_speed : float
        Scales of strength [N] and speed [m/s], above 0.
    touches : callable
        Whether the finger touches the plate.

    Notes
    -----
    The mode is (sign of the speed of the skin over the plate, sign of the strength minus the bristle force).
    """

    skin: SlidingSkin
    speed: OverTime
    strength: OverTime
    corners: tuple[float, ...]
    largest_strength: float
    largest_speed: float
    touches: Callable[[float | Real], Any] = _always

    def __post_init__(self) -> None:
        """Take over the numbers of the equations."""
        for name in ("law", "mass", "stiffness", "damping"):
            object.__setattr__(self, name, getattr(self.skin, name))
        object.__setattr__(self, "yields_smoothly", self.skin.law.yields_smoothly)

    @property
    def scale(self) -> Real:
        """Scale of each state."""
        return self.skin.scale(strength=self.largest_strength, speed=self.largest_speed)

    def breaks(self, end: float) -> Sequence[float]:
        """Return the corners of speed and strength before an end [s]."""
        return [corner for corner in self.corners if 0 < corner < end]

    def jump(self, state: Real, *, time: float) -> Real:
        """Return the state just after a time [s]."""
        return skin_jump(self, state, time)

    def rate(self, state: Real, mode: Mode, *, time: float) -> Real:
        """Return the rate of change of each state."""
        return self.rates(state[:, None], mode, times=np.array([time]))[:, 0]

    def switches(self, state: Real, mode: Mode, *, time: float) -> Real:
        """Return the switching functions (switches,)."""
        return self.watched(state[:, None], mode, times=np.array([time]))[:, 0]

    def rates(self, states: Real, mode: Mode, *, times: Real) -> Real:
        """Return the rates of change of n states (states, n)."""
        return skin_rates(self, states, mode, times)

    def watched(self, states: Real, mode: Mode, *, times: Real) -> Real:
        """Return the switching functions (switches, n)."""
        return skin_switches(self, states, mode, times)

    def following(self, index: int, state: Real, mode: Mode, *, time: float) -> Mode:
        """Return the mode after an event at a time [s]."""
        found: Mode = skin_following(self, index, state, mode, time)
        return found

    def strength_of(self, time: float | Real) -> Real:
        """Return the strength at times [s], above 0 also without load [N]."""
        return np.hypot(self.strength(time), SMALLEST * self.largest_strength)


def sliding(
    law: BristleFriction,
    *,
    speed: OverTime,
    strength: OverTime,
    times: Real,
    breaks: Sequence[float] = (),
    touches: Callable[[float | Real], Any] = _always,
    settled: bool = False,
    tolerance: float = TOLERANCE,
    step: float | None = None,
    **finger: float,
) -> Slide:
    """Compute the stick-slip motion of a skin with any bristle friction at `times` (n,) [s], with its energy balance.

    Without load the strength is 1e-9 of the largest one (`SMALLEST`); a viscous damping of the law is independent of the
    load and acts as long as the finger touches.
    """
    looks = _looks(times, breaks)
    strengths = np.asarray(strength(looks), dtype=float) + np.zeros(len(looks))
    not_negative(looks, strengths)
    skin = skin_of(law, **finger)
    largest, fastest = skin.sizes(strength=float(strengths.max()), speed=float(np.max(np.abs(speed(looks)))))
    system = Sliding(
        skin=skin,
        speed=speed,
        strength=strength,
        corners=tuple(breaks),
        largest_strength=largest,
        largest_speed=fastest,
        touches=touches,
    )
    first = float(speed(0.0))
    state = skin.begin(
        settled=settled, speed=first, strength=float(system.strength_of(0.0)), touches=bool(touches(0.0))
    )
    direction = -1 if settled and first < 0 else 1
    solved = integrate(system, state, (direction, 1), times, tolerance=tolerance, step=step)
    speeds = np.asarray(speed(times), dtype=float) + np.zeros(len(times))
    return skin.slide(solved, speeds=speeds, strengths=system.strength_of(times), touches=touches(times))


def _looks(times: Real, breaks: Sequence[float]) -> Real:
    """Return the times at which speed and strength are checked beforehand [s]."""
    every = max(1, len(times) // _LOOKS)
    inside = [when for when in breaks if 0 <= when <= times[-1]]
    return np.unique([0.0, *times[::every], float(times[-1]), *inside])


def not_negative(times: Real, strengths: Real) -> None:
    """Refuse strengths [N] at times [s] that are negative or not a number."""
    wrong = np.flatnonzero(~(strengths >= 0))
    if len(wrong):
        raise InputError(
            f"friction.steady: its strength is {strengths[wrong[0]]:.6g} N at {times[wrong[0]]:.6g} s; a sliding contact"
            " needs a strength of 0 or above, so check load, attraction and contact"
        )
