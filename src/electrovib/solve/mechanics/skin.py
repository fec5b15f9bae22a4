"""A skin with bristles that slides over the plate: its equations, with mass and spring or rigid, energy balance and slide."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.core.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from electrovib.core.arrays import Real
    from electrovib.physics.friction import BristleFriction

DEFLECTION, DISPLACEMENT, OVER_PLATE, WORK, DAMPER, HEAT = range(6)
"""States: deflection of the bristles and displacement of the skin against the bone [m], its speed over the plate [m/s],
work of the hand, heat of the damper and of the friction [J]."""
KINDS = ("turns", "passes the strength")
"""Events of a slide: the skin reverses over the plate, the bristle force passes the strength of the friction."""


def rates_of_skin(state: Any, rate: Any, friction: Any, speed: Any, bristles: Any, body: Any) -> Any:
    """Return the rates of the six states; the compiled time stepping uses this function too.

    `rate` of the deflection [m/s], `friction` [N], `speed` of the bone [m/s], `bristles` their stiffness [N/m]; `body` is
    mass, stiffness and damping of the skin, of which a mass of 0 stands for a skin that moves with the bone.
    """
    mass, stiffness, damping = body
    held = bristles * state[DEFLECTION]
    if mass == 0:
        work, still = friction * speed, 0.0 * rate
        return rate, still, still, work, still, work - held * rate
    over_plate = state[OVER_PLATE]
    lag = speed - over_plate
    hand = stiffness * state[DISPLACEMENT] + damping * lag
    push = (hand - friction) / mass
    return rate, lag, push, hand * speed, damping * lag * lag, friction * over_plate - held * rate


def let_go(state: Real, stiffness: float) -> None:
    """Set the deflection of the bristles to 0 [m]; their energy becomes heat [J]."""
    state[HEAT] += stiffness * state[DEFLECTION] ** 2 / 2
    state[DEFLECTION] = 0.0


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

    def rate(self, now: Real, *, speed: Any, strength: Any, direction: int, touches: Any) -> Real:
        """Return the rate of change of the states, at a speed of the bone [m/s] and a strength [N].

        `now` (6,) or (6, n); returns `rate` of the same shape.
        """
        deflection, over_plate = now[DEFLECTION], self.over_plate(now, speed=speed)
        rate = np.where(touches, self.law.deflection_rate(deflection, over_plate, strength, direction), 0.0)
        friction = np.where(touches, self.law.force(deflection, rate, over_plate), 0.0)
        return np.array(rates_of_skin(now, rate, friction, speed, self.law.stiffness, self.body))

    def over_plate(self, now: Real, *, speed: Any) -> Any:
        """Return the speed of the skin over the plate at a speed of the bone [m/s]."""
        return speed if self.is_rigid else now[OVER_PLATE]

    def left(self, now: Real, *, strength: Any, direction: int) -> Any:
        """Return the share of the strength [N] that the bristles have not reached yet [1]."""
        return 1 - direction * self.law.stiffness * now[DEFLECTION] / strength

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

    def energy_residual(self, now: Real) -> float:
        """Return the largest error of the energy balance since time 0, over the largest work or the initial energy [1].

        The work of the hand is stored in the motion of the skin, in the fingertip and in the bristles, or becomes heat.
        """
        mass, stiffness, _ = self.body
        stored = mass * now[OVER_PLATE] ** 2 + stiffness * now[DISPLACEMENT] ** 2
        stored = (stored + self.law.stiffness * now[DEFLECTION] ** 2) / 2
        missing = now[WORK] - (stored - stored[0]) - now[DAMPER] - now[HEAT]
        size = float(max(np.max(np.abs(now[WORK])), stored[0]))
        return float(np.max(np.abs(missing))) / size if size > 0 else 0.0


def skin_of(
    law: BristleFriction, *, mass: float | None, stiffness: float | None, damping: float | None
) -> SlidingSkin:
    """Return the skin of a finger, or a rigid one."""
    if mass is None or stiffness is None or damping is None:
        return SlidingSkin(law=law, body=(0.0, 0.0, 0.0))
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
class Slide:
    """Motion and forces of a sliding skin.

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
    states : ndarray, shape (6, n)
        States over time, work and heat among them.
    energy_residual : float
        Largest error of the energy balance, over the largest work [1].
    events : tuple of (float, str)
        Times [s] and kinds of the events, as in `KINDS`.
    steps : int
        Number of time steps.
    """

    skin_displacement: Real
    skin_speed: Real
    lateral_force: Real
    bristle_deflection: Real
    states: Real
    energy_residual: float
    events: tuple[tuple[float, str], ...]
    steps: int


def slide_of(
    skin: SlidingSkin,
    states: Real,
    directions: Real,
    *,
    speed: Real,
    strength: Real,
    touches: Any,
    events: Sequence[tuple[float, str]],
    steps: int,
) -> Slide:
    """Return motion and forces from the states at n times.

    `states` (6, n), `directions`, `speed`, `strength`, `touches` (n,).
    """
    law, deflection, over_plate = skin.law, states[DEFLECTION], skin.over_plate(states, speed=speed)
    rate = law.deflection_rate(deflection, over_plate, strength, directions)
    return Slide(
        skin_displacement=states[DISPLACEMENT],
        skin_speed=speed - over_plate,
        lateral_force=np.where(touches, law.force(deflection, rate, over_plate), 0.0),
        bristle_deflection=deflection,
        states=states,
        energy_residual=skin.energy_residual(states),
        events=tuple(events),
        steps=steps,
    )
