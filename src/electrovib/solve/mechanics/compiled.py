"""Stick-slip motion in compiled code, for bristle laws whose numbers the law declares (`BristleFriction.bristles`).

The equations are those of `sliding`, the method is that of `solve/nonlinear/`: their functions are compiled as they are,
with speed, strength and law from arrays instead of callables.
"""

from __future__ import annotations

import inspect
import zlib
from types import FunctionType
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from electrovib.core.budget import Meter
from electrovib.physics.friction import bristle
from electrovib.physics.friction.bristle import strength_at_speed, yielding_rate
from electrovib.solve.costs import BRISTLE_STEP, SHORTER
from electrovib.solve.mechanics import sliding
from electrovib.solve.mechanics.sliding import (
    SMALLEST,
    TOLERANCE,
    Slide,
    not_negative,
    skin_following,
    skin_jump,
    skin_of,
    skin_rates,
    skin_switches,
)
from electrovib.solve.nonlinear import integrate, radau
from electrovib.solve.nonlinear.integrate import advance
from electrovib.solve.nonlinear.radau import FROM_POWERS, GOES_ON, INTEGRALS, STAGES, WEIGHTS

if TYPE_CHECKING:
    from collections.abc import Callable

    from electrovib.core.arrays import Real
    from electrovib.physics.friction import BristleFriction
    from electrovib.physics.motion import Motion
    from electrovib.solve.mechanics.between import Between

AT_ONCE = 100_000
"""Steps in one call, some tenths of a second: between calls the run can be interrupted and reports its progress."""


class TabulatedSkin(NamedTuple):
    """A sliding skin whose speed, contact and strength over time are given between knots.

    Parameters
    ----------
    law : Bristles
        Parameters of the law; `nearest` is a force [N].
    mass, stiffness, damping : float
        Finger; all 0 for a rigid one.
    yields_smoothly : bool
        As declared by the law.
    largest_strength, largest_speed : float
        Scales [N], [m/s].
    knots, values, slopes : ndarray, shape (n,)
        Cubics of the strength: times [s], values [N], rates of change [N/s].
    speeds : ndarray, shape (n,)
        Speed of the bone, linear between the knots [m/s].
    touches : ndarray of bool, shape (n - 1,)
        Contact between the knots.
    at_once : int
        Number of steps in one call.
    """

    law: bristle.Bristles
    mass: float
    stiffness: float
    damping: float
    yields_smoothly: bool
    largest_strength: float
    largest_speed: float
    knots: Real
    values: Real
    slopes: Real
    speeds: Real
    touches: Any
    at_once: int


def slide_compiled(
    law: BristleFriction,
    *,
    motion: Motion,
    strength: Between,
    times: Real,
    tolerance: float = TOLERANCE,
    **finger: float,
) -> Slide:
    """Compute the stick-slip motion of a skin at `times` (n,) [s] as `sliding` does, in compiled steps."""
    pieces, stops = strength.pieces, np.unique(strength.pieces.knots)
    not_negative(pieces.knots, pieces.values)
    skin, speeds, bone = skin_of(law, **finger), motion.speeds(pieces.knots), motion.speeds(times)
    fastest = float(max(np.max(np.abs(speeds)), np.max(np.abs(bone))))
    largest, fastest = skin.sizes(strength=float(np.max(pieces.values)), speed=fastest)
    touches = np.asarray(motion.touches((pieces.knots[1:] + pieces.knots[:-1]) / 2), dtype=bool)
    assert law.bristles is not None
    numbers = law.bristles._replace(nearest=law.bristles.nearest * largest)
    body = (skin.mass, skin.stiffness, skin.damping)
    sizes = (bool(law.yields_smoothly), largest, fastest)
    course = TabulatedSkin(numbers, *body, *sizes, *pieces, speeds, touches, AT_ONCE)
    first, floor = float(speeds[0]), SMALLEST * largest
    state = skin.begin(
        settled=first > 0,
        speed=first,
        strength=float(np.hypot(strength(0.0), floor)),
        touches=bool(touches[0]),
    )
    scale = skin.scale(strength=largest, speed=fastest)
    task = radau.Task(stops, np.isin(stops, strength.ends), times, scale, tolerance, 0.0)
    meter = Meter("a friction with bristles", end=float(times[-1]), each=BRISTLE_STEP, remedy=SHORTER)
    solved = integrate.solved(march, course, _recorded(radau.progress_from(state)), (1, 1), task, meter)
    strengths = np.hypot(strength(times), floor)
    return skin.slide(solved, speeds=bone, strengths=strengths, touches=motion.touches(times))


def _recorded(progress: radau.Progress) -> radau.Progress:
    """Return the state of an integration with its numbers in the form that compiled functions change in place."""
    numbers = vars(progress.at)
    kinds = [(name, type(value)) for name, value in numbers.items()]
    return progress._replace(at=np.rec.array([tuple(numbers.values())], dtype=kinds)[0])


def product(first: Any, second: Any) -> Any:
    """Return the product of two matrices, without BLAS."""
    found = np.zeros((first.shape[0], second.shape[1]))
    for row in range(first.shape[0]):
        for column in range(second.shape[1]):
            for other in range(first.shape[1]):
                found[row, column] += first[row, other] * second[other, column]
    return found


def put(target: Any, source: Any) -> None:
    """Write one array into another, without a test of the shapes."""
    for place, value in np.ndenumerate(source):
        target[place] = value


def added(state: Any, increments: Any) -> Any:
    """Return one state plus n increments, shape (states, n)."""
    found = np.empty(increments.shape)
    for place, value in np.ndenumerate(increments):
        found[place] = state[place[0]] + value
    return found


def states_on(piece: Any, shares: Any) -> Any:
    """Return the states (states, n) at shares of a step, on the polynomial through its stages."""
    found = np.empty((len(piece.before), len(shares)))
    for row, column in np.ndindex(found.shape):
        found[row, column] = piece.before[row]
        for stage in range(STAGES):
            for order in range(STAGES):
                power = FROM_POWERS[stage, order] * shares[column] ** (order + 1)
                found[row, column] += piece.stages[row, stage] * power
    return found


def correction(size: Any, found: Any, stages: Any, inverse: Any) -> Any:
    """Return Newton's correction of the stages (states, 3)."""
    missing = product(found, INTEGRALS)
    for place, value in np.ndenumerate(stages):
        missing[place] = size * missing[place] - value
    return product(inverse, missing.reshape((-1, 1))).reshape(stages.shape)


def differences(found: Any, steps: Any) -> Any:
    """Return the derivatives (states, states) from differences of the rates."""
    slopes = np.empty((len(steps), len(steps)))
    for row in range(len(steps)):
        for column in range(len(steps)):
            slopes[row, column] = (found[row, column] - found[row, len(steps)]) / steps[column]
    return slopes


def inverse_of_stages(jacobian: Any, size: Any) -> Any:
    """Return the inverse of Newton's matrix of all stages (3 states, 3 states)."""
    matrix = np.eye(STAGES * len(jacobian))
    for row in range(len(matrix)):
        for column in range(len(matrix)):
            weight = WEIGHTS[row % STAGES, column % STAGES]
            matrix[row, column] -= size * jacobian[row // STAGES, column // STAGES] * weight
    return inverse_of(matrix)


def inverse_of(matrix: Any) -> Any:
    """Return the inverse after Gauss and Jordan; not finite where there is none."""
    size = len(matrix)
    both = np.zeros((size, 2 * size))
    put(both[:, :size], matrix)
    for column in range(size):
        both[column, size + column] = 1.0
    for column in range(size):
        best = column
        for row in range(column + 1, size):
            if abs(both[row, column]) > abs(both[best, column]):
                best = row
        for other in range(2 * size):
            above = both[best, other]
            both[best, other], both[column, other] = both[column, other], above
        pivot = both[column, column]
        for other in range(2 * size):
            both[column, other] /= pivot
        for row in range(size):
            factor = both[row, column]
            if row != column:
                for other in range(2 * size):
                    both[row, other] -= factor * both[column, other]
    return both[:, size:].copy()


def root_mean_square(values: Any, weights: Any) -> Any:
    """Return the root mean square of n columns over the weights (states,)."""
    total = 0.0
    for place, value in np.ndenumerate(values):
        total += (value / weights[place[0]]) ** 2
    return np.sqrt(total / values.size)


def given_at(course: Any, time: Any) -> Any:
    """Return speed [m/s], strength [N] and contact between two knots."""
    knots, values, slopes, speeds = course.knots, course.values, course.slopes, course.speeds
    place = min(max(np.searchsorted(knots, time, side="right") - 1, 0), len(knots) - 2)
    length = knots[place + 1] - knots[place]
    share = (time - knots[place]) / length
    rise = values[place + 1] - values[place]
    early, late = slopes[place] * length - rise, rise - slopes[place + 1] * length
    strength = values[place] + share * (rise + (1 - share) * (early * (1 - share) + late * share))
    speed = speeds[place] + share * (speeds[place + 1] - speeds[place])
    return speed, np.hypot(strength, SMALLEST * course.largest_strength), course.touches[place]


def deflection_rate(law: Any, deflection: Any, speed: Any, strength: Any, direction: Any) -> Any:
    """Return the rate of the deflection [m/s] from the parameters of the law."""
    level = strength_at_speed(speed, strength, law.excess, law.stribeck_speed)
    return yielding_rate(
        deflection, speed, level, direction, law.stiffness, law.exponent, law.nearest / strength
    )


def friction_force(law: Any, deflection: Any, rate: Any, speed: Any) -> Any:
    """Return the force [N] from the parameters of the law."""
    return law.stiffness * deflection + law.bristle_damping * rate + law.viscous_damping * speed


def _some_steps(system: Any, mode: Any, progress: Any, task: Any, out: Any) -> Any:
    """As `integrate.advance`, some steps in one call."""
    until = progress.at.tries + system.at_once
    while progress.at.status == GOES_ON and progress.at.tries < until:
        mode = advance(system, mode, progress, task, out)
    return mode


_OWN = (
    *(
        product,
        put,
        added,
        states_on,
        correction,
        differences,
        inverse_of_stages,
        inverse_of,
        root_mean_square,
    ),
    *(given_at, deflection_rate, friction_force),
)
"""What stands in compiled code for the functions of these names: loops, which compile in a quarter of the time; the law."""
_ROLES = {"rates": skin_rates, "watched": skin_switches, "following": skin_following, "jump": skin_jump}
"""What stands for the answers of a system."""
_ONCE = (
    *("advance", "next_piece", "_stages", "_growth", "_error"),
    *("restart", "_put_out", "_crossed", "first_fall", "land"),
)
"""Functions that are called at one place, and compiled there rather than by themselves and there again."""


def _compiled() -> Callable[..., Any]:
    """Compile the time stepping; its name makes numba's cache, which sees only this file, depend on all sources."""
    from numba import njit

    modules = (bristle, sliding, radau, integrate)
    # a division by 0 is infinite, as in arrays; wrappers for Python only where Python calls
    options: dict[str, Any] = {"error_model": "numpy", "no_cfunc_wrapper": True}
    known = {module.__name__: dict(vars(module)) for module in modules} | {__name__: dict(globals())}
    functions: dict[str, Any] = {
        name: each
        for module in modules
        for name, each in inspect.getmembers(module, inspect.isfunction)
        if each.__module__ in known
    }
    functions |= {each.__name__: each for each in _OWN} | _ROLES
    compiled: dict[str, Any] = {}
    for name, each in functions.items():
        inner: dict[str, Any] = {"no_cpython_wrapper": True, "inline": "always" if name in _ONCE else "never"}
        compiled[name] = njit(FunctionType(each.__code__, known[each.__module__], name), **options, **inner)
    for names in known.values():
        names.update(compiled)
    whole = FunctionType(_some_steps.__code__, known[__name__], "march")
    whole.__qualname__ = f"march_{zlib.crc32(''.join(map(inspect.getsource, modules)).encode())}"
    try:
        return njit(whole, cache=True, **options)  # type: ignore[no-any-return]
    except RuntimeError:  # numba finds no folder to write to
        return njit(whole, **options)  # type: ignore[no-any-return]


march = _compiled()
