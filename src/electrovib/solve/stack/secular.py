"""Roots of sums of simple poles, which are the relaxation rates of a stack of layers."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from electrovib.core.arrays import Indices, Real
from electrovib.core.errors import InputError
from electrovib.solve.stack.secular_step import offsets_in_arrays

_CANCELLED = 8.0  # largest cancellation in the closed form of two poles: three of 53 bits
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
    if node.ndim != 1 or node.size == 0 or weight.shape != node.shape:
        message = f"nodes and weights: shapes {node.shape} and {weight.shape}, expected the same (count,)"
        raise ValueError(message)
    _refuse_beyond_reach(node[:, None], weight[:, None], np.array([float(constant)]))
    if node.size == 1 and constant > 0:
        return _of_one_pole(node, weight, float(constant))
    if node.size == 2 and constant == 0:
        return _between_two_poles(node, weight)
    if node.size == 2 and (found := _of_two_poles(node, weight, float(constant))) is not None:
        return found
    offset, origin = offsets_in_arrays(node[:, None], weight[:, None], np.array([float(constant)]))
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
    offsets, origins = secular_offsets(ordered.T, heavy.T, level[:, 0])
    some = slice(count if has_last else count - 1)
    return _roots_at(apart, weight, np.take_along_axis(order, origins[some].T, 1), offsets[some].T)


def secular_offsets(nodes: Real, weights: Real, constants: Real) -> tuple[Real, Indices]:
    """Find the roots of many problems with equal numbers of increasing nodes.

    `nodes`, `weights` (nodes, problems), `constants` (problems,); returns `offsets`, `origins` (nodes, problems): the
    distance of each root from the nearer end of its bracket, infinite for the last root where the constant is 0, and the
    index of that end.
    """
    if (
        nodes.ndim != 2
        or not len(nodes)
        or weights.shape != nodes.shape
        or constants.shape != nodes.shape[1:]
    ):
        raise InputError(
            f"nodes, weights and constants have the shapes {nodes.shape}, {weights.shape} and {constants.shape}: expected "
            "(nodes, problems) twice, and (problems,)."
        )
    _refuse_beyond_reach(nodes, weights, constants)
    return offsets_in_arrays(nodes, weights, constants)


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


def _between_two_poles(node: Real, weight: Real) -> Roots:
    """Return the root between two poles for a constant of 0, in closed form."""
    nearer = int(weight[0] > weight[1])
    distance = (node[1] - node[0]) * (weight[nearer] / (weight[0] + weight[1]))
    return _roots_at(node, weight, np.array([nearer]), np.array([-distance if nearer else distance]))


def _of_one_pole(node: Real, weight: Real, constant: float) -> Roots:
    """Return the root above a single pole, in closed form."""
    return _roots_at(node, weight, np.zeros(1, np.intp), weight / constant)


def _of_two_poles(node: Real, weight: Real, constant: float) -> Roots | None:
    """Return the roots between and above two poles, in closed form; None where terms cancel too much.

    With x the distance from the upper pole, c x^2 + (c gap - w0 - w1) x - w1 gap = 0: one root below it, one above.
    """
    (below, above), gap = weight.tolist(), float(node[1] - node[0])
    reach = constant * gap
    middle, product = reach - below - above, above * gap
    root = math.sqrt(middle * middle + 4 * constant * product)
    if not (reach + below + above <= _CANCELLED * root and product > 0):
        return None
    larger = (abs(middle) + root) / (2 * constant)
    smaller = product / constant / larger
    down, up = (larger, smaller) if middle > 0 else (smaller, larger)
    if 2 * down <= gap:
        origin, offset = [1, 1], [-down, up]
    else:  # the lower root is nearer to the lower pole
        other = reach + below + above
        between = math.hypot(reach + above - below, 2 * math.sqrt(below * above))
        origin, offset = [0, 1], [2 * below * gap / (other + between), up]
    return _roots_at(node, weight, np.array(origin), np.array(offset))


def _differences(node: Real, origin: Indices, offset: Real) -> Real:
    begins = np.take_along_axis(node, origin, -1)
    result: Real = (begins[..., :, None] - node[..., None, :]) + offset[..., :, None]
    return result
