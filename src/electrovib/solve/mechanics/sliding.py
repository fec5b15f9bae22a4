"""Stick-slip motion of fingertip and bristles as one stiff system, with every reversal located."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from electrovib.core.errors import InputError
from electrovib.solve.nonlinear.integrate import System, integrate

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from electrovib.core.arrays import Real
    from electrovib.physics.friction import BristleFriction
    from electrovib.solve.nonlinear.integrate import Mode


OverTime: TypeAlias = "Callable[[float | Real], float | Real]"
"""A quantity at times [s], one or many; at a discontinuity the value after it."""
DEFLECTION, DISPLACEMENT, OVER_PLATE, WORK, DAMPER, HEAT = range(6)
"""States: deflection of the bristles and displacement of the skin against the bone [m], its speed over the plate [m/s],
work of the hand, heat of the damper and of the friction [J]."""
TOLERANCE = 1e-8
"""Local error of a step, relative; the energy balance then closes to some 1e-8 of the work."""
SMALLEST = 1e-9
"""Smallest strength of the friction over the largest, which avoids a division by zero without load or contact."""
DEAD_BAND = 1e-10
"""Relative excess of the bristle force over the strength below which the excess is rounding."""
KINDS = ("turns", "passes the strength")
"""Events of a slide: the skin reverses over the plate, the bristle force passes the strength of the friction."""
_LOOKS = 4096
"""Number of output times at which speed and strength are checked beforehand."""


def _always(time: float | Real) -> Any:
    return np.ones(np.shape(time), dtype=bool)


def rates_of_skin(state: Any, rate: Any, friction: Any, speed: Any, bristles: Any, body: Any) -> Any:
    """Return the rates of the six states; the compiled time stepping uses this function too.

    `rate` of the deflection [m/s], `friction` [N], `speed` of the bone [m/s], `bristles` their stiffness [N/m]; `body` is
    mass, stiffness and damping of the skin, of which a mass of 0 stands for a skin that moves with the bone.
    """
    mass, stiffness, damping = body
    held = bristles * state[0]
    if mass == 0:
        return rate, 0.0, 0.0, friction * speed, 0.0, friction * speed - held * rate
    over_plate = state[2]
    lag = speed - over_plate
    hand = stiffness * state[1] + damping * lag
    push = (hand - friction) / mass
    return rate, lag, push, hand * speed, damping * lag * lag, friction * over_plate - held * rate


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
    stored_before : float
        Energy stored at time 0 [J].
    """

    work: Real
    kinetic: Real
    elastic: Real
    bristle: Real
    damper: Real
    friction: Real
    stored_before: float

    @property
    def residual(self) -> float:
        """Largest error of the energy balance, over the largest work or the initial energy [1]; 0 without motion."""
        stored = self.kinetic + self.elastic + self.bristle
        missing = self.work - (stored - self.stored_before) - self.damper - self.friction
        size = float(max(np.max(np.abs(self.work)), self.stored_before))
        return float(np.max(np.abs(missing))) / size if size > 0 else 0.0


@dataclass(frozen=True, kw_only=True)
class SlidingSkin:
    """A sliding skin with mass on a spring and a damper, or one that moves with the bone: its states and their rates.

    Parameters
    ----------
    law : BristleFriction
        Friction of the contact.
    body : tuple of float
        Mass [kg], stiffness [N/m] and damping [N s/m]; all 0 if the skin moves with the bone.
    """

    law: Any
    body: tuple[float, float, float]

    @property
    def is_rigid(self) -> bool:
        """Whether the skin moves with the bone."""
        return self.body[0] == 0

    def rate(self, now: Real, *, speed: float, strength: float, direction: int, touches: bool) -> Real:
        """Return the rate of change of the states, at a speed of the bone [m/s] and a strength [N].

        `now` (6,); returns `rate` (6,).
        """
        rate, friction = 0.0, 0.0
        if touches:
            deflection, over_plate = now[DEFLECTION], self.over_plate(now, speed=speed)
            rate = self.law.deflection_rate(deflection, over_plate, strength, direction)
            friction = self.law.force(deflection, rate, over_plate)
        return np.array(rates_of_skin(now, rate, friction, speed, self.law.stiffness, self.body))

    def over_plate(self, now: Real, *, speed: Any) -> Any:
        """Return the speed of the skin over the plate at a speed of the bone [m/s]."""
        return speed if self.is_rigid else now[OVER_PLATE]

    def left(self, now: Real, *, strength: float, direction: int) -> float:
        """Return the share of the strength [N] that the bristles have not reached yet, from the states (6,) [1]."""
        return 1 - direction * self.law.stiffness * float(now[DEFLECTION]) / strength

    def scales(self, strength: float, speed: float) -> tuple[float, float]:
        """Return scales of strength [N] and speed [m/s] above 0 from their largest values.

        At rest the speed is that of a skin released from its stretch; without friction the strength is the force of its
        spring when it is stopped.
        """
        impedance = float(np.sqrt(self.body[0] * self.body[1]))
        largest = strength or speed * impedance or 1.0
        return largest, speed or (1.0 if self.is_rigid else largest / impedance)

    def scale(self, *, strength: float, speed: float) -> Real:
        """Return the scale of each state, shape (6,), for a strength [N] and a speed [m/s]."""
        deflection = strength / self.law.stiffness
        if self.is_rigid:
            return np.array([deflection, 1.0, 1.0, *[strength * deflection] * 3])
        stretch = strength / self.body[1]
        return np.array([deflection, stretch, speed, *[strength * stretch] * 3])

    def settled(self, *, speed: float, strength: float, touches: bool) -> Real:
        """Return the states of steady sliding, shape (6,), at a speed [m/s] and a strength [N]."""
        state: Any = np.zeros(6)
        state[OVER_PLATE] = speed
        if touches:
            state[DEFLECTION] = np.sign(speed) * self.law.strength_at(speed, strength) / self.law.stiffness
            force = self.law.force(state[DEFLECTION], 0.0, speed)
            state[DISPLACEMENT] = 0.0 if self.is_rigid else force / self.body[1]
        return np.asarray(state)

    def energies(self, now: Real) -> Energies:
        """Return the energies of the states over time [J]."""
        mass, stiffness, _ = self.body
        kinetic = mass * now[OVER_PLATE] ** 2 / 2
        elastic = stiffness * now[DISPLACEMENT] ** 2 / 2
        bristle = self.law.stiffness * now[DEFLECTION] ** 2 / 2
        return Energies(
            work=now[WORK],
            kinetic=kinetic,
            elastic=elastic,
            bristle=bristle,
            damper=now[DAMPER],
            friction=now[HEAT],
            stored_before=float(kinetic[0] + elastic[0] + bristle[0]),
        )


def skin_of(
    law: BristleFriction, *, mass: float | None, stiffness: float | None, damping: float | None
) -> SlidingSkin:
    """Return the skin of a finger, or a rigid one."""
    if mass is None and stiffness is None and damping is None:
        return SlidingSkin(law=law, body=(0.0, 0.0, 0.0))
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
    return SlidingSkin(law=law, body=(mass, stiffness, damping))


@dataclass(frozen=True, kw_only=True)
class Sliding(System):
    """Equations of a skin that slides over the plate under a given strength of the friction.

    Parameters
    ----------
    skin : SlidingSkin
        Equations of the skin.
    speed, strength : callable
        Speed of the bone over the plate [m/s] and strength of the friction [N], smooth between the corners.
    corners : tuple of float
        Times at which they are not smooth [s].
    largest_strength, largest_speed : float
        Scales of strength [N] and speed [m/s], above 0.

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

    @property
    def scale(self) -> Real:
        """Scale of each state."""
        return self.skin.scale(strength=self.largest_strength, speed=self.largest_speed)

    def breaks(self, end: float) -> Sequence[float]:
        """Return the corners of speed and strength before an end [s]."""
        return [corner for corner in self.corners if 0 < corner < end]

    def jump(self, state: Real, *, time: float) -> Real:
        """Return the state just after a time [s]; off the plate the deflection of the bristles is 0."""
        after = state.copy()
        if not self.touches(time):
            let_go(after, self.skin.law.stiffness)
        return after

    def rate(self, state: Real, mode: Mode, *, time: float) -> Real:
        """Return the rate of change of each state at a time [s]."""
        speed, strength = float(self.speed(time)), float(self.strength_of(time))
        touches = bool(self.touches(time))
        return self.skin.rate(state, speed=speed, strength=strength, direction=mode[0], touches=touches)

    def switches(self, state: Real, mode: Mode, *, time: float) -> Real:
        """Return speed [m/s] and remaining share of the strength [1] at a time [s], each times its sign in the mode."""
        direction, side = mode
        along = direction * self.skin.over_plate(state, speed=float(self.speed(time)))
        if self.skin.law.yields_smoothly:
            return np.array([along])
        left = self.skin.left(state, strength=float(self.strength_of(time)), direction=direction)
        return np.array([along, side * left + DEAD_BAND])

    def following(self, index: int, state: Real, mode: Mode, *, time: float) -> Mode:
        """Return the mode after a reversal, or after the bristle force has passed the strength, at a time [s]."""
        direction, side = mode
        if index == 1:
            return (direction, -side)
        turned = -direction
        left = self.skin.left(state, strength=float(self.strength_of(time)), direction=turned)
        return (turned, 1 if left >= 0 else -1)

    def strength_of(self, time: float | Real) -> Real:
        """Return the strength at times [s], above 0 also without load [N]."""
        return np.hypot(self.strength(time), SMALLEST * self.largest_strength)


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
        Times [s] and kinds of the events, as in `KINDS`.
    steps, evaluations : int
        Number of time steps, and of evaluations of the equations.
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
    """Compute the stick-slip motion of a skin with bristle friction, with its energy balance.

    `times` (n,) [s].

    m w' = k x + c x' - F(z, z', w), x' = u - w, with z' from the law; u and w are the speeds of the bone and of the skin
    over the plate. In the frame of the plate the power of the hand is (k x + c x') u; it changes m w^2/2, k x^2/2 and
    stiffness z^2/2, and is dissipated as c x'^2 and F w - stiffness z z'. Without load the strength is 1e-9 of the
    largest one (`SMALLEST`); a viscous damping of the law is independent of the load and acts as long as the finger
    touches.
    """
    looks = _looks(times, breaks)
    strengths = np.asarray(strength(looks), dtype=float) + np.zeros(len(looks))
    not_negative(looks, strengths)
    skin = skin_of(law, mass=mass, stiffness=stiffness, damping=damping)
    fastest = float(np.max(np.abs(speed(looks))))
    largest_strength, largest_speed = skin.scales(float(strengths.max()), fastest)
    system = Sliding(
        skin=skin,
        speed=speed,
        strength=strength,
        corners=tuple(breaks),
        largest_strength=largest_strength,
        largest_speed=largest_speed,
        touches=touches,
    )
    state, direction = np.zeros(6), 1
    if settled:
        at_start = float(speed(0.0))
        direction = -1 if at_start < 0 else 1
        first = float(system.strength_of(0.0))
        state = skin.settled(speed=at_start, strength=first, touches=bool(touches(0.0)))
    solved = integrate(system, state, (direction, 1), times, tolerance=tolerance, step=step)
    return slide_of(
        skin,
        solved.states,
        np.array([mode[0] for mode in solved.modes], dtype=float),
        speed=np.asarray(speed(times), dtype=float) + np.zeros(len(times)),
        strength=system.strength_of(times),
        touches=touches(times),
        events=[(when, KINDS[index]) for when, index in solved.events],
        counts=(solved.steps, solved.evaluations),
    )


def let_go(state: Real, stiffness: float) -> None:
    """Set the deflection of the bristles to 0 [m]; their energy becomes heat [J]."""
    state[5] += stiffness * state[0] ** 2 / 2
    state[0] = 0.0


def slide_of(
    skin: SlidingSkin,
    states: Real,
    directions: Real,
    *,
    speed: Real,
    strength: Real,
    touches: Any,
    events: Sequence[tuple[float, str]],
    counts: tuple[int, int],
) -> Slide:
    """Return motion, forces and energies from the states at n times.

    `states` (6, n), `directions`, `speed`, `strength`, `touches` (n,); `counts` of steps and of evaluations.
    """
    law, deflection, over_plate = skin.law, states[DEFLECTION], skin.over_plate(states, speed=speed)
    rate = law.deflection_rate(deflection, over_plate, strength, directions)
    energies = skin.energies(states)
    return Slide(
        skin_displacement=states[DISPLACEMENT],
        skin_speed=speed - over_plate,
        lateral_force=np.where(touches, law.force(deflection, rate, over_plate), 0.0),
        bristle_deflection=deflection,
        energies=energies,
        energy_residual=energies.residual,
        events=tuple(events),
        steps=counts[0],
        evaluations=counts[1],
    )


def _looks(times: Real, breaks: Sequence[float]) -> Real:
    """Return the times at which speed and strength are checked beforehand [s]."""
    every = max(1, len(times) // _LOOKS)
    inside = [when for when in breaks if 0 <= when <= times[-1]]
    return np.unique([0.0, *times[::every], float(times[-1]), *inside])


def not_negative(times: Real, strengths: Real) -> None:
    """Refuse a strength that is negative or not a number.

    `times`, `strengths` (n,) [s].
    """
    wrong = np.flatnonzero(~(strengths >= 0))
    if len(wrong):
        raise InputError(
            f"friction.steady: its strength is {strengths[wrong[0]]:.6g} N at {times[wrong[0]]:.6g} s; a sliding contact"
            " needs a strength of 0 or above, so check load, attraction and contact"
        )
