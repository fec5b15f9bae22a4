"""Stick-slip motion for bristle laws of a known formula: the equations of `sliding` in compiled steps."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.core.errors import ElectrovibError
from electrovib.solve.mechanics.stick_slip.kinds import CompliantSlidingSkin
from electrovib.solve.mechanics.stick_slip.skin_of import lifted, skin_of
from electrovib.solve.mechanics.stick_slip.sliding import (
    DEAD_BAND,
    EVENTS,
    SMALLEST,
    TOLERANCE,
    Slide,
    not_negative,
)
from electrovib.solve.meter import Meter
from electrovib.solve.nonlinear.integrate import MOST_EVENTS
from electrovib.solve.nonlinear.radau import COEFFICIENTS, NODES, WEIGHTS

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.physics.friction import BristleFriction
    from electrovib.physics.motion import Motion
    from electrovib.solve.mechanics.between import Between
    from electrovib.solve.mechanics.stick_slip.skin import SlidingSkin

AT_ONCE = 100_000
"""Steps in one call, some tenths of a second: between calls the run can be interrupted and reports its progress."""
STILL = 1e-12
"""Speed against the direction of the mode, over the largest, above which it is a reversal rather than rounding."""


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
    from electrovib.solve.mechanics.stick_slip import compiled_records, compiled_step
    from electrovib.solve.mechanics.stick_slip.compiled_march import ASKED, STEPS

    pieces = strength.pieces
    not_negative(pieces.knots, pieces.values)
    skin = skin_of(law, mass=mass, stiffness=stiffness, damping=damping)
    speeds = motion.speeds(strength.ends)
    fastest = float(np.max(np.abs(motion.speeds(times)), initial=float(np.max(np.abs(speeds)))))
    largest = float(np.max(pieces.values)) or skin.natural_force(fastest) or 1.0
    largest_speed = fastest or skin.natural_speed(largest)
    floor = SMALLEST * largest
    course = _course(strength, motion, floor)
    first = float(np.hypot(strength(0.0), floor))
    state = _settled(skin if course.touches[0] else lifted(skin), speed=float(speeds[0]), strength=first)
    is_elastic = isinstance(skin, CompliantSlidingSkin)
    body = (skin.mass, skin.stiffness, skin.damping) if isinstance(skin, CompliantSlidingSkin) else (0.0,) * 3
    scale = skin.scale(strength=largest, speed=largest_speed)
    scale = scale[[2, 0, 1]] if is_elastic else np.array([scale[0], 1.0, 1.0])
    sizes = compiled_records.Sizes(
        tolerance, scale, STILL * largest_speed, DEAD_BAND * largest, MOST_EVENTS, AT_ONCE
    )
    assert law.bristles is not None
    numbers = law.bristles._replace(nearest=law.bristles.nearest * largest)
    switches = np.array([0] * is_elastic + [1] * (not law.yields_smoothly), np.int64)
    states, directions, moments, kinds, memory = _marched(
        times, state, (course, numbers, body, switches, sizes)
    )
    own = states[[1, 2, 0, 3, 4, 5]] if is_elastic else states[[0, 3, 5]]
    bone = motion.speeds(times)
    over_plate = states[compiled_step.OVER_PLATE] if is_elastic else bone
    deflection = states[compiled_step.DEFLECTION]
    rate = law.deflection_rate(deflection, over_plate, np.hypot(strength(times), floor), directions)
    energies = skin.energies(own)
    return Slide(
        skin_displacement=skin.displacement(own),
        skin_speed=bone - over_plate,
        lateral_force=np.where(motion.touches(times), law.force(deflection, rate, over_plate), 0.0),
        bristle_deflection=deflection,
        energies=energies,
        energy_residual=energies.residual,
        events=tuple((when, EVENTS[index]) for when, index in zip(moments, kinds, strict=True)),
        steps=int(memory[STEPS]),
        evaluations=int(memory[ASKED]),
    )


def _settled(skin: SlidingSkin, *, speed: float, strength: float) -> Any:
    """Return the state of steady sliding in the rows of the compiled steps; undeflected at rest."""
    from electrovib.solve.mechanics.stick_slip import compiled_step

    state: Any = np.zeros(6)
    if speed > 0:
        found = skin.settled(speed=speed, strength=strength)
        state[compiled_step.DEFLECTION] = float(skin.deflection(found))
        state[compiled_step.DISPLACEMENT] = float(np.ravel(skin.displacement(found))[0])
        state[compiled_step.OVER_PLATE] = speed
    return state


def _course(strength: Between, motion: Motion, floor: float) -> Any:
    """Return strength, speed and contact from corner to corner, in the form of the compiled steps."""
    from electrovib.solve.mechanics.stick_slip import compiled_records

    stops, pieces = strength.ends, strength.pieces
    last = np.searchsorted(pieces.knots, stops[1:], side="left")
    first = np.searchsorted(pieces.knots, stops[:-1], side="right") - 1
    touches = np.asarray(motion.touches((stops[1:] + stops[:-1]) / 2), dtype=float)
    return compiled_records.GivenOverTime(
        stops, motion.speeds(stops), touches, first, np.maximum(last, first + 1), *pieces, floor
    )


def _marched(
    times: Real, state: Real, given: tuple[Any, ...]
) -> tuple[Real, Real, list[float], list[int], Real]:
    """Return states and directions at the output times, times [s] and kinds of events, and the counts."""
    from electrovib.solve.mechanics.stick_slip import compiled_march as march
    from electrovib.solve.mechanics.stick_slip import compiled_records

    states, directions = np.empty((len(state), len(times))), np.empty(len(times))
    memory = np.zeros(march.STATUS + 1)
    moments, kinds = (
        np.empty(MOST_EVENTS + 2),
        np.empty(MOST_EVENTS + 2, np.int64),
    )  # two may come with a stretch
    memory[march.WANTED] = 1e-3 * float(given[0].stops[1])
    memory[march.DIRECTION] = memory[march.SIDE] = 1.0
    method = compiled_records.RadauNumbers(NODES, WEIGHTS, COEFFICIENTS)
    memory[march.STATUS] = march.GOES_ON
    meter = Meter("a friction with bristles", end=float(times[-1]))
    while memory[march.STATUS] == march.GOES_ON:
        march.march(times, state, *given, method, memory, (moments, kinds), (states, directions))
        meter.count(float(memory[march.NOW]))
    if memory[march.STATUS] == march.UNSOLVED:
        raise ElectrovibError(f"the equations could not be solved beyond {memory[march.NOW]:.6g} s")
    if memory[march.STATUS] == march.CHATTERS:
        raise ElectrovibError(
            f"more than {MOST_EVENTS} events before {memory[march.NOW]:.6g} s: the contact chatters"
        )
    filled = int(memory[march.FILLED])
    states[:, filled:], directions[filled:] = state[:, None], memory[march.DIRECTION]
    count = int(memory[march.EVENTS])
    return states, directions, moments[:count].tolist(), kinds[:count].tolist(), memory
