"""Roots of sums of simple poles, which are the relaxation rates of a stack of layers."""

from __future__ import annotations

import decimal
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from electrovib.core.arrays import Indices, Numbers, Real
from electrovib.core.errors import InputError

_LARGEST_NODE = 1e20
_SMALLEST_GAP = 1e-30
_LARGEST_WEIGHT = 1e50  # of the constant too; the smallest is its inverse


@dataclass(frozen=True, eq=False, kw_only=True)
class Roots:
    r"""Roots at which a sum of poles equals a constant, each stored as a distance from the nearer pole.

    Parameters
    ----------
    nodes : ndarray, shape (..., nodes)
        Poles of the sum.
    values : ndarray, shape (..., roots)
        Roots, increasing; a root closer to its node than rounding allows equals that node.
    origin : ndarray of int, shape (..., roots)
        Index of the nearer end of the bracket of each root.
    offset : ndarray, shape (..., roots)
        Root minus ``nodes[origin]``, signed, never 0.
    slope : ndarray, shape (..., roots)
        :math:`-f'` at each root, > 0; its inverse is the residue of :math:`-1/f`.

    Notes
    -----
    All arrays are read-only.
    """

    nodes: Real
    values: Real
    origin: Indices
    offset: Real
    slope: Real

    def differences(self) -> Real:
        """Return the distance of each root from each node, without cancellation.

        Returns `differences` (..., roots, nodes).
        """
        return _differences(self.nodes, self.origin, self.offset)


def secular_roots(nodes: ArrayLike, weights: ArrayLike, *, constant: Any) -> Roots:
    r"""Find the roots at which a sum of poles with positive weights equals a constant.

    They are the zeros of the impedance of layers in series.

    `nodes`, `weights` (nodes,); or `nodes` (cases, nodes) in any order, and weights and constant of as many cases or one.

    .. math:: f(x) = -c + \sum_l \frac{w_l}{x - n_l}

    falls from :math:`+\infty` to :math:`-\infty` between neighbouring nodes. Each root is computed as its
    distance from the nearer end of its bracket, with steps that treat the pole there exactly, model all other
    poles by one at the far end, and fall back to geometric bisection. The numbers given are taken as exact:
    where cancellation prevents 53 bits from resolving the root, it is computed again with 150 digits. Offset,
    differences and slope are therefore accurate to better than 1e-13 relative, whatever the conditioning.
    """
    if np.ndim(nodes) == 2:
        return _of_cases(np.asarray(nodes, float), np.asarray(weights, float), constant)
    node, weight = np.array(nodes, dtype=float), np.array(weights, dtype=float)
    _refuse_beyond_reach(node[:, None], weight[:, None], np.array([float(constant)]))
    if node.size == 1 and constant > 0:
        return _roots_at(node, weight, np.zeros(1, np.intp), weight / constant)
    offset, origin = _offsets(node[:, None], weight[:, None], np.array([float(constant)]))
    count = node.size - (constant == 0)
    return _roots_at(node, weight, origin[:count, 0], offset[:count, 0])


def _of_cases(nodes: Real, weights: Real, constant: Any) -> Roots:
    """Return the roots of many cases; a node that equals another in a case is moved by its rounding."""
    cases, count = np.broadcast_shapes(nodes.shape, weights.shape, np.shape(constant))
    node, weight = np.broadcast_to(nodes, (cases, count)), np.broadcast_to(weights, (cases, count))
    level = np.broadcast_to(np.asarray(constant, float), (cases, 1))
    order = np.argsort(node, axis=1, kind="stable")
    ordered, heavy = np.take_along_axis(node, order, 1), np.take_along_axis(weight, order, 1)
    for place in range(1, count):
        ordered[:, place] = np.maximum(ordered[:, place], np.nextafter(ordered[:, place - 1], np.inf))
    apart = np.empty_like(ordered)
    np.put_along_axis(apart, order, ordered, 1)
    has_last = np.ndim(constant) > 0 or constant > 0
    if count == 1 and has_last:
        return _roots_at(apart, weight, np.zeros((cases, 1), np.intp), weight / level)
    _refuse_beyond_reach(ordered.T, heavy.T, level[:, 0])
    offsets, origins = _offsets(ordered.T, heavy.T, level[:, 0])
    some = slice(count if has_last else count - 1)
    return _roots_at(apart, weight, np.take_along_axis(order, origins[some].T, 1), offsets[some].T)


class BeyondReachError(InputError, ValueError):
    """Error for rates of a stack that cannot be resolved in double precision."""

    def __init__(self, why: str) -> None:
        super().__init__(
            "stack: the rates or impedances of layers and circuit lie too far apart to be computed. Choose longer relaxation"
            " times or smaller conductivities of the layers, or a less extreme resistance or thickness (in the secular"
            f" equation, {why})"
        )


def _refuse_beyond_reach(nodes: Real, weights: Real, constants: Real) -> None:
    """Refuse the first of many problems whose numbers are beyond reach; `nodes`, `weights` (nodes, problems)."""
    within = np.asarray(np.all(np.isfinite(nodes), axis=0) & (nodes[0] >= 0) & (nodes[-1] <= _LARGEST_NODE))
    apart = np.asarray(np.all(np.diff(nodes, axis=0) >= _SMALLEST_GAP, axis=0))
    heavy = np.asarray(((weights >= 1 / _LARGEST_WEIGHT) & (weights <= _LARGEST_WEIGHT)).all(axis=0))
    level = (constants == 0) | ((constants >= 1 / _LARGEST_WEIGHT) & (constants <= _LARGEST_WEIGHT))
    if (within & apart & heavy & level).all():
        return
    first = int(np.argmin(within & apart & heavy & level))
    node, weight, constant = nodes[:, first], weights[:, first], float(constants[first])
    if not within[first]:
        why = f"nodes: expected numbers from 0 to {_LARGEST_NODE:g}, got up to {node.max():.3g}"
    elif not apart[first]:
        where = int(np.argmin(np.diff(node)))
        why = (
            f"nodes[{where}] = {node[where]!r} and nodes[{where + 1}] = {node[where + 1]!r}: expected "
            f"strictly increasing nodes {_SMALLEST_GAP:g} apart; merge equal nodes by adding their weights"
        )
    elif not heavy[first]:
        worst = weight[np.argmax(np.abs(np.log(np.abs(weight) + 1e-300)))]
        why = f"weights: expected {1 / _LARGEST_WEIGHT:g} to {_LARGEST_WEIGHT:g}, got {worst:.3g}"
    else:
        why = f"constant = {constant!r}: expected 0, or {1 / _LARGEST_WEIGHT:g} to {_LARGEST_WEIGHT:g}"
    raise BeyondReachError(why)


def _roots_at(node: Real, weight: Real, origin: Indices, offset: Real) -> Roots:
    """Return roots whose distance from the nearer node is known."""
    difference = _differences(node, origin, offset)
    slope: Real = (weight[..., None, :] / difference / difference).sum(axis=-1)
    values: Real = np.take_along_axis(node, origin, -1) + offset
    for array in (node, values, origin, offset, slope):
        array.flags.writeable = False
    return Roots(nodes=node, values=values, origin=origin, offset=offset, slope=slope)


def _differences(node: Real, origin: Indices, offset: Real) -> Real:
    begins = np.take_along_axis(node, origin, -1)
    result: Real = (begins[..., :, None] - node[..., None, :]) + offset[..., :, None]
    return result


_ROUNDING = float(np.finfo(float).eps)
_ILL_CONDITIONED = 50.0  # above it rounding alone costs the offset more than about 1e-14
_SLACK = 8 * _ROUNDING
_LONG = decimal.Context(prec=150, Emin=-9999, Emax=9999, traps=[decimal.InvalidOperation])
_TINY = decimal.Decimal("1e-25")


class _Equations(NamedTuple):
    """Equations of the roots of one or many problems, one column for each, mirrored where the root lies below its origin.

    With t > 0 the distance from the origin, the root is where
    ``weight/t + sum(rest/(t - position)) + level = 0``; the left side falls with t.
    """

    position: Numbers  # (nodes, roots), of the nodes relative to the origin, positive towards the root
    weight: Numbers  # (roots,), of the origin
    rest: Numbers  # (nodes, roots), the weights with 0 at the origin
    level: Numbers  # (roots,)
    neighbour: Numbers  # (roots,), position of the other end of the bracket, 0 where there is none


class _Sums(NamedTuple):
    """The mirrored function times t, and the sums needed for a step towards its zero."""

    product: Numbers  # t times the function: finite at the origin, positive below the root
    size: Numbers  # the same with the absolute values of all terms: the scale of its rounding
    others: Numbers  # poles other than the origin
    rest: Numbers  # the same plus the level
    steepness: Numbers  # minus the derivative of the rest


def _offsets(node: Real, weight: Real, constant: Real) -> tuple[Real, Indices]:
    """Find the roots of many problems with equal numbers of increasing nodes; where rounding costs too much, with 150 digits.

    `node`, `weight` (nodes, problems), `constant` (problems,); returns `offsets`, `origins` (nodes, problems): the
    distance of each root from the nearer end of its bracket, infinite for the last root where the constant is 0, and the
    index of that end.
    """
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
        step = _step(equations, sums, distance, (low, high), turn, tolerance, noise)
        found[active], done, distance, low, high = step
        if done.any():
            keep = ~done
            equations, active = _Equations(*(each[..., keep] for each in equations)), active[keep]
            distance, low, high = distance[keep], low[keep], high[keep]
        sums = _sums(equations, distance)
        turn += 1
    return found


def _step(
    equations: _Equations,
    sums: _Sums,
    distance: Numbers,
    bracket: tuple[Numbers, Numbers],
    turn: int,
    tolerance: Any,
    noise: Any,
) -> Any:
    """Return the best distance, whether it is the root, and distance and bracket of the next step.

    The step goes to the zero of weight/t + level + strength/(t - pole). The pole is the other end of the bracket;
    level and strength are fitted to value and slope of the poles other than the origin. Without another end, all poles
    are on one side: then the level is kept, and the pole is fitted.
    """
    product, size, others, rest, steepness = sums
    (low, high), neighbour = bracket, equations.neighbour
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
