"""Steps towards the roots of sums of poles, of one problem or many, in arrays of numbers or of exact decimals."""

from __future__ import annotations

import decimal
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.core.arrays import Indices, Numbers, Real

if TYPE_CHECKING:
    from numpy.typing import NDArray

_ROUNDING = float(np.finfo(float).eps)
_ILL_CONDITIONED = 50.0  # above it rounding alone costs the offset more than about 1e-14
_SLACK = 8 * _ROUNDING
_LONG = decimal.Context(prec=150, Emin=-9999, Emax=9999, traps=[decimal.InvalidOperation])
_TINY = decimal.Decimal("1e-25")


@dataclass(frozen=True, eq=False, kw_only=True)
class _Equations:
    """Equations of the roots of one or many problems, one column for each, mirrored where the root lies below its origin.

    With t > 0 the distance from the origin, the root is where
    ``weight/t + sum(rest/(t - position)) + level = 0``; the left side falls with t.
    """

    position: Numbers  # (nodes, roots), of the nodes relative to the origin, positive towards the root
    weight: Numbers  # (roots,), of the origin
    rest: Numbers  # (nodes, roots), the weights with 0 at the origin
    level: Numbers  # (roots,)
    neighbour: Numbers  # (roots,), position of the other end of the bracket, 0 where there is none

    def take(self, chosen: NDArray[Any]) -> _Equations:
        return _Equations(
            position=self.position[:, chosen],
            weight=self.weight[chosen],
            rest=self.rest[:, chosen],
            level=self.level[chosen],
            neighbour=self.neighbour[chosen],
        )


@dataclass(frozen=True, eq=False, kw_only=True)
class _Sums:
    """The mirrored function times t, and the sums needed for a step towards its zero."""

    product: Numbers  # t times the function: finite at the origin, positive below the root
    size: Numbers  # the same with the absolute values of all terms: the scale of its rounding
    others: Numbers  # poles other than the origin
    rest: Numbers  # the same plus the level
    steepness: Numbers  # minus the derivative of the rest


def offsets_in_arrays(node: Real, weight: Real, constant: Real) -> tuple[Real, Indices]:
    """Find the roots of many problems, as `secular_offsets` does; where rounding costs too much, with 150 digits."""
    root, problem, origin, side, reach = _nearer_ends(node, weight, constant)
    equations = _equations(node, weight, constant, problem, origin, side)
    distance = _solve(equations, reach, tolerance=1e-10, noise=2 * _ROUNDING)
    sums = _sums(equations, distance)
    doubtful = sums.size > _ILL_CONDITIONED * (equations.weight + distance * distance * sums.steepness)
    if doubtful.any():
        chosen = problem[doubtful], origin[doubtful], side[doubtful]
        with decimal.localcontext(_LONG):
            equations = _long_equations(node, weight, constant, *chosen)
            long = _solve(equations, _long(reach[doubtful]), tolerance=_TINY, noise=_TINY**5)
            distance[doubtful] = long.astype(float)
    offsets, origins = np.full(node.shape, np.inf), np.full(node.shape, len(node) - 1, np.intp)
    offsets[root, problem], origins[root, problem] = np.where(side > 0, distance, -distance), origin
    return offsets, origins


def _nearer_ends(node: Real, weight: Real, constant: Real) -> tuple[Indices, Indices, Indices, Indices, Real]:
    """Return for each root its index, its problem, its origin, the side of the origin it is on, and a bound of its distance."""
    count, problems = node.shape
    left, problem = np.divmod(np.arange((count - 1) * problems), problems)
    upwards, origin = np.ones_like(left), left
    reach: Real = np.diff(node, axis=0).reshape(-1) / 2
    if left.size:
        sums = _sums(_equations(node, weight, constant, problem, left, upwards), reach)
        product = sums.product
        doubtful = np.abs(product) <= 64 * _ROUNDING * sums.size
        if doubtful.any():  # the nearer end follows from the sign alone, so the sign must be right
            chosen = problem[doubtful], left[doubtful], upwards[doubtful]
            with decimal.localcontext(_LONG):
                equations = _long_equations(node, weight, constant, *chosen)
                product[doubtful] = np.where(_sums(equations, _long(reach[doubtful])).product > 0, 1, -1)
        above = product > 0
        origin, upwards = left + above, np.where(above, -1, 1)
    last = np.flatnonzero(constant > 0)
    top = np.full(last.size, count - 1)
    reach = np.concatenate([reach, weight[:, last].sum(axis=0) / constant[last]]) * (1 + _SLACK)
    return (
        np.concatenate([left, top]),
        np.concatenate([problem, last]),
        np.concatenate([origin, top]),
        np.concatenate([upwards, np.ones_like(last)]),
        reach,
    )


def _equations(
    node: Numbers, weight: Numbers, constant: Numbers, problem: Indices, origin: Indices, side: Indices
) -> _Equations:
    column = np.arange(origin.size)
    position = side * (node[:, problem] - node[origin, problem])
    rest = weight[:, problem]
    own = rest[origin, column]
    rest[origin, column] = 0 * own
    # the bracket of the root above the last node has no other end: the index is that of the origin, position 0
    neighbour = position[np.minimum(origin + side, len(node) - 1), column]
    return _Equations(
        position=position, weight=own, rest=rest, level=-side * constant[problem], neighbour=neighbour
    )


def _sums(equations: _Equations, distance: Numbers) -> _Sums:
    apart = distance - equations.position
    terms = equations.rest / apart
    others = terms.sum(axis=0)
    rest = others + equations.level
    size = equations.weight + distance * (np.abs(terms).sum(axis=0) + np.abs(equations.level))
    return _Sums(
        product=equations.weight + distance * rest,
        size=size,
        others=others,
        rest=rest,
        steepness=(terms / apart).sum(axis=0),
    )


def _solve(equations: _Equations, reach: Numbers, *, tolerance: Any, noise: Any) -> Numbers:
    """Return the distance of each root from its origin, at most ``reach``.

    Convergence is quadratic, so a last step below ``tolerance`` leaves an error of about its square.
    """
    found = reach.copy()
    active = np.arange(reach.size)
    distance, high = reach, reach
    sums = _sums(equations, distance)
    low = reach * (equations.weight / sums.size) / 2
    turn = 0
    while active.size:
        found[active], done, distance, low, high = _step(
            distance,
            low,
            high,
            equations.weight,
            equations.level,
            equations.neighbour,
            sums.others,
            sums.steepness,
            sums.size,
            turn,
            tolerance,
            noise,
        )
        if done.any():
            keep = ~done
            equations, active = equations.take(keep), active[keep]
            distance, low, high = distance[keep], low[keep], high[keep]
        sums = _sums(equations, distance)
        turn += 1
    return found


def _step(
    distance: Numbers,
    low: Numbers,
    high: Numbers,
    weight: Numbers,
    level: Numbers,
    neighbour: Numbers,
    others: Numbers,
    steepness: Numbers,
    size: Numbers,
    turn: int,
    tolerance: Any,
    noise: Any,
) -> Any:
    """Return the best distance, whether it is the root, and distance and bracket of the next step.

    The step goes to the zero of weight/t + level + strength/(t - pole). The pole is the other end of the bracket;
    level and strength are fitted to value and slope of the poles other than the origin. Without another end, all poles
    are on one side: then the level is kept, and the pole is fitted.
    """
    rest = others + level
    product = weight + distance * rest
    flat = steepness == 0
    fitted = np.where(flat, distance, others / np.where(flat, 1 + 0 * distance, steepness))
    apart = np.where(neighbour == 0, fitted, distance - neighbour)
    # in terms of the sums at the present distance, so that no terms cancel at the root
    linear = steepness * distance - rest - product / apart
    square = linear * linear + 4 * product * (steepness - rest / apart)
    usable = (linear > 0) & (square >= 0)
    divisor = np.where(usable, linear + np.sqrt(np.where(square > 0, square, 0 * square)), 1 + 0 * linear)
    change = 2 * product / divisor
    low, high = np.where(product > 0, distance, low), np.where(product < 0, distance, high)
    done = usable & (abs(change) <= tolerance * distance)
    done = done | (abs(product) <= noise * size) | (high - low <= noise * low)
    target = distance + change
    near = usable & (8 * abs(change) <= distance)
    # bisection replaces a large step in every third turn, and later any step in every other, to shrink the bracket
    inside = usable & (target > low) & (target < high) & (near | (turn % 3 != 2))
    inside = inside & ((turn <= 24) | (turn % 2 != 0))
    following = np.where(inside, target, np.sqrt(low) * np.sqrt(high))
    return np.where(near, target, distance), done, following, low, high


def _long_equations(
    node: Real, weight: Real, constant: Real, problem: Indices, origin: Indices, side: Indices
) -> _Equations:
    """Return the equations in exact decimals, so that the same steps use as many digits as the context has."""
    nodes, weights, constants = (_long(each[..., problem]) for each in (node, weight, constant))
    return _equations(nodes, weights, constants, np.arange(len(problem)), origin, side)


def _long(numbers: Real) -> Numbers:
    flat = [decimal.Decimal(number) for number in numbers.reshape(-1).tolist()]
    return np.array(flat, dtype=object).reshape(numbers.shape)
