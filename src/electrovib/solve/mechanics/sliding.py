"""Stick-slip motion of fingertip and bristles as one stiff system, with every reversal located."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from electrovib.core.errors import InputError
from electrovib.solve.mechanics.skin import KINDS, Slide, SlidingSkin, let_go, skin_of, slide_of
from electrovib.solve.nonlinear.integrate import MOST_EVENTS, System, integrate

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from electrovib.core.arrays import Real
    from electrovib.physics.friction import BristleFriction
    from electrovib.physics.motion import Motion
    from electrovib.solve.mechanics.between import Between
    from electrovib.solve.nonlinear.integrate import Mode


OverTime: TypeAlias = "Callable[[float | Real], float | Real]"
"""A quantity at times [s], one or many; at a discontinuity the value after it."""
TOLERANCE = 1e-8
"""Local error of a step, relative; the energy balance then closes to some 1e-8 of the work."""
SMALLEST = 1e-9
"""Smallest strength of the friction over the largest, which avoids a division by zero without load or contact."""
DEAD_BAND = 1e-10
"""Relative excess of the bristle force over the strength below which the excess is rounding."""
STILL = 1e-12
"""Speed against the direction of the mode, over the largest, above which it is a reversal rather than rounding."""
_SAMPLES = 4096
"""Number of output times at which speed and strength are checked beforehand."""


def _always(time: float | Real) -> Any:
    return np.ones(np.shape(time), dtype=bool)


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

    def rate(self, state: Real, mode: Mode, *, time: Any) -> Real:
        """Return the rate of change of each state at times [s]."""
        speed, strength = self.speed(time), self.strength_of(time)
        return self.skin.rate(
            state, speed=speed, strength=strength, direction=mode[0], touches=self.touches(time)
        )

    def switches(self, state: Real, mode: Mode, *, time: Any) -> Real:
        """Return speed [m/s] and remaining share of the strength [1] at times [s], each times its sign in the mode."""
        direction, side = mode
        along = direction * self.skin.over_plate(state, speed=self.speed(time))
        if self.skin.law.yields_smoothly:
            return np.array([along])
        left = self.skin.left(state, strength=self.strength_of(time), direction=direction)
        return np.array([along, side * left + DEAD_BAND])

    def following(self, index: int, state: Real, mode: Mode, *, time: float) -> Mode:
        """Return the mode after a reversal, or after the bristle force has passed the strength, at a time [s]."""
        direction, side = mode
        if index == 1:
            return (direction, -side)
        turned = -direction
        left = self.skin.left(state, strength=self.strength_of(time), direction=turned)
        return (turned, 1 if left >= 0 else -1)

    def strength_of(self, time: float | Real) -> Real:
        """Return the strength at times [s], above 0 also without load [N]."""
        return np.hypot(self.strength(time), SMALLEST * self.largest_strength)


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
    sampled = _sampled(times, breaks)
    strengths = np.asarray(strength(sampled), dtype=float) + np.zeros(len(sampled))
    not_negative(sampled, strengths)
    skin = skin_of(law, mass=mass, stiffness=stiffness, damping=damping)
    fastest = float(np.max(np.abs(speed(sampled))))
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
        steps=solved.steps,
    )


def slide_quickly(
    law: BristleFriction,
    *,
    motion: Motion,
    strength: Between,
    times: Real,
    mass: float | None = None,
    stiffness: float | None = None,
    damping: float | None = None,
    tolerance: float = TOLERANCE,
) -> Slide:
    """Compute the stick-slip motion of a skin with bristle friction, as `sliding` does, in compiled steps.

    `times` (n,) [s].
    """
    from electrovib.solve.mechanics import quick_sliding

    pieces, stops, bone = strength.pieces, strength.ends, motion.speeds(times)
    not_negative(pieces.knots, pieces.values)
    skin = skin_of(law, mass=mass, stiffness=stiffness, damping=damping)
    speeds = motion.speeds(stops)
    fastest = float(np.max(np.abs(bone), initial=float(np.max(np.abs(speeds)))))
    largest, largest_speed = skin.scales(float(np.max(pieces.values)), fastest)
    floor = SMALLEST * largest
    first = np.searchsorted(pieces.knots, stops[:-1], side="right") - 1
    last = np.maximum(np.searchsorted(pieces.knots, stops[1:], side="left"), first + 1)
    touches = np.asarray(motion.touches((stops[1:] + stops[:-1]) / 2), dtype=float)
    assert law.bristles is not None
    given = quick_sliding.Given(
        *(stops, speeds, touches, first, last, *pieces, floor),
        law=law.bristles._replace(nearest=law.bristles.nearest * largest),
        body=skin.body,
        kinds=np.array([0] * (not skin.is_rigid) + [1] * (not law.yields_smoothly), np.int64),
        implicit=1 if skin.is_rigid else 3,
        scale=skin.scale(strength=largest, speed=largest_speed),
        tolerance=tolerance,
        turned=STILL * largest_speed,
        passed=DEAD_BAND * largest,
        most_events=MOST_EVENTS,
        steps_per_call=quick_sliding.STEPS_PER_CALL,
    )
    at_first = float(np.hypot(strength(0.0), floor))
    state = skin.settled(speed=float(speeds[0]), strength=at_first, touches=bool(touches[0]))
    states, directions, events, (steps, _) = quick_sliding.follow(times, state, given)
    return slide_of(
        skin,
        states,
        directions,
        speed=bone,
        strength=np.hypot(strength(times), floor),
        touches=motion.touches(times),
        events=events,
        steps=steps,
    )


def _sampled(times: Real, breaks: Sequence[float]) -> Real:
    """Return the times at which speed and strength are checked beforehand [s]."""
    every = max(1, len(times) // _SAMPLES)
    inside = [when for when in breaks if 0 <= when <= times[-1]]
    return np.unique([0.0, *times[::every], float(times[-1]), *inside])


def not_negative(times: Real, strengths: Real) -> None:
    """Refuse a strength that is not a number, or negative by more than what counts as no load: rounding of an attraction.

    `times` (n,) [s], `strengths` (n,) [N].
    """
    largest = np.max(strengths, where=np.isfinite(strengths), initial=0.0)
    wrong = np.flatnonzero(~(strengths >= -SMALLEST * largest))
    if len(wrong):
        raise InputError(
            f"friction.steady: its strength is {strengths[wrong[0]]:.6g} N at {times[wrong[0]]:.6g} s; a sliding contact"
            " needs a strength of 0 or above, so check load, attraction and contact"
        )
