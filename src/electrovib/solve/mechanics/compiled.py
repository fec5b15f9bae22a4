"""Stick-slip motion in compiled code, for bristle laws whose numbers the law declares (`BristleFriction.bristles`).

The equations are those of `sliding`, the method is that of `solve/nonlinear/`: their functions are compiled as they are,
with speed, strength and law from arrays instead of callables.
"""

from __future__ import annotations

import inspect
import zlib
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from electrovib.core.budget import Meter
from electrovib.physics.friction import bristle
from electrovib.physics.friction.bristle import strength_at_speed, yielding_rate
from electrovib.solve.costs import BRISTLE_STEP, SHORTER
from electrovib.solve.mechanics import sliding
from electrovib.solve.mechanics.sliding import SMALLEST, TOLERANCE, Slide, not_negative, skin_of
from electrovib.solve.nonlinear import integrate, radau

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


def _product(first: Any, second: Any) -> Any:
    found = np.zeros((first.shape[0], second.shape[1]))
    for row in range(first.shape[0]):
        for column in range(second.shape[1]):
            for other in range(first.shape[1]):
                found[row, column] += first[row, other] * second[other, column]
    return found


def _put(target: Any, source: Any) -> None:
    for place, value in np.ndenumerate(source):
        target[place] = value


def _inverse(matrix: Any) -> Any:
    """Return the inverse after Gauss and Jordan; not finite where there is none."""
    size = len(matrix)
    left, found = matrix.copy(), np.eye(size)
    for column in range(size):
        best = column
        for row in range(column + 1, size):
            if abs(left[row, column]) > abs(left[best, column]):
                best = row
        for one in (left, found):
            for other in range(size):
                kept = one[best, other]
                one[best, other], one[column, other] = one[column, other], kept
        pivot = left[column, column]
        for other in range(size):
            left[column, other] /= pivot
            found[column, other] /= pivot
        for row in range(size):
            factor = left[row, column]
            if row != column:
                for other in range(size):
                    left[row, other] -= factor * left[column, other]
                    found[row, other] -= factor * found[column, other]
    return found


def _given_at(course: Any, time: Any) -> Any:
    knots, values, slopes, speeds = course.knots, course.values, course.slopes, course.speeds
    place = min(max(np.searchsorted(knots, time, side="right") - 1, 0), len(knots) - 2)
    length = knots[place + 1] - knots[place]
    share = (time - knots[place]) / length
    rise = values[place + 1] - values[place]
    early, late = slopes[place] * length - rise, rise - slopes[place + 1] * length
    strength = values[place] + share * (rise + (1 - share) * (early * (1 - share) + late * share))
    speed = speeds[place] + share * (speeds[place + 1] - speeds[place])
    return speed, np.hypot(strength, SMALLEST * course.largest_strength), course.touches[place]


def _deflection_rate(law: Any, deflection: Any, speed: Any, strength: Any, direction: Any) -> Any:
    level = strength_at_speed(speed, strength, law.excess, law.stribeck_speed)
    return yielding_rate(
        deflection, speed, level, direction, law.stiffness, law.exponent, law.nearest / strength
    )


def _friction_force(law: Any, deflection: Any, rate: Any, speed: Any) -> Any:
    return law.stiffness * deflection + law.bristle_damping * rate + law.viscous_damping * speed


_OWN: dict[Callable[..., Any], Callable[..., Any]] = {
    radau.product: _product,
    radau.put: _put,
    radau._inverse: _inverse,
    radau.rates: sliding.skin_rates,
    integrate.watched: sliding.skin_switches,
    integrate.following: sliding.skin_following,
    integrate.jump: sliding.skin_jump,
    sliding.given_at: _given_at,
    sliding.deflection_rate: _deflection_rate,
    sliding.friction_force: _friction_force,
}
"""What a system or a law answers in Python, and the function that stands for it in compiled code."""


def _compile_for(stamp: int) -> Callable[..., Any]:
    """Compile the time stepping; the stamp makes numba's cache, which sees only this file, depend on all functions called."""
    from numba import njit
    import os
    from types import FunctionType

    # a division by 0 is infinite, as in arrays; wrappers for Python only where Python calls
    options: dict[str, Any] = {"error_model": "numpy", "no_cfunc_wrapper": True}
    inner: Any = options | {"no_cpython_wrapper": True}
    ONCE=os.environ.get('ONCE','').split(',')
    names: dict[str, Any] = {}
    for module in (bristle, sliding, radau, integrate):
        names |= {k: v for k, v in vars(module).items() if not k.startswith("__")}
    names["__builtins__"] = __builtins__
    whole = {f for module in (radau, integrate) for _, f in inspect.getmembers(module, inspect.isfunction) if f.__module__ == module.__name__}
    whole |= {strength_at_speed, yielding_rate, *_OWN.values()}
    for f in sorted(whole - {*_OWN}, key=lambda f: f.__name__):
        own = FunctionType(f.__code__, names, f.__name__, f.__defaults__)
        o = inner | ({"inline": "always"} if f.__name__ in ONCE else {})
        names[f.__name__] = njit(own, **o)
    for g, own in _OWN.items():
        names[g.__name__] = names[own.__name__]
    integrate_advance = names["advance"]
    advance, goes_on = integrate_advance, radau.GOES_ON

    def march(system: Any, mode: Any, progress: Any, task: Any, out: Any) -> Any:
        until = progress.at.tries + system.at_once + 0 * stamp
        while progress.at.status == goes_on and progress.at.tries < until:
            mode = advance(system, mode, progress, task, out)
        return mode

    try:
        return njit(march, cache=True, **options)  # type: ignore[no-any-return]
    except RuntimeError:  # numba finds no folder to write to
        return njit(march, **options)  # type: ignore[no-any-return]


march = _compile_for(
    zlib.crc32("".join(map(inspect.getsource, (bristle, radau, integrate, sliding))).encode())
)
"""As `integrate.advance`, some steps in one call."""
