"""Roots of sums of simple poles for many fingers: the relaxation rates of their stacks."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from electrovib.core.errors import InputError
from electrovib.solve.population.kernels.choice import compiled
from electrovib.solve.stack.secular import _Rows, _solve, _sums, secular_roots

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from electrovib.core.arrays import Indices, Real

_AT_ONCE: Final = 64  # fingers in memory together
_MIDDLE: Final = 64 * float(
    np.finfo(float).eps
)  # share of its terms below which the sign of a sum is doubtful
_CONDITION: Final = 200.0  # of the offset, above which rounding costs it more than some 1e-13
_ROUNDING: Final = float(np.finfo(float).eps)


class ManyRoots(NamedTuple):
    """Roots of many sums of poles, each stored as its distance from the nearer pole.

    Parameters
    ----------
    offsets : ndarray, shape (fingers, nodes)
        Root minus the node of its origin, signed, never 0; infinite for the last root where the constant is 0.
    origins : ndarray of int, shape (fingers, nodes)
        Index of the nearer end of the bracket of each root.
    """

    offsets: Real
    origins: Indices


def secular_roots_many(
    nodes: ArrayLike, weights: ArrayLike, constant: ArrayLike, *, threads: int | None = None
) -> ManyRoots:
    """Find the roots at which sums of poles with positive weights equal a constant, for many fingers.

    `nodes` (fingers, nodes), `weights` (fingers, nodes), `constant` (fingers,).

    The equation and its steps are those of `secular_roots`. A finger whose roots are lost by cancellation is solved by
    `secular_roots`, with as many digits as it needs.
    """
    node, weight, level = _checked(nodes, weights, constant)
    offsets = np.full(node.shape, np.inf)
    origins = np.full(node.shape, node.shape[1] - 1, np.intp)
    if (kernel := compiled()) is not None:
        remaining = kernel.secular(node, weight, level, offsets, origins, threads)
    else:
        remaining = _in_numpy(node, weight, level, offsets, origins)
    for finger in remaining.tolist():
        count = node.shape[1] - (level[finger] == 0)
        if count:
            found = secular_roots(node[finger], weight[finger], constant=float(level[finger]))
            offsets[finger, :count], origins[finger, :count] = found.offset, found.origin
    return ManyRoots(offsets, origins)


def _checked(nodes: ArrayLike, weights: ArrayLike, constant: ArrayLike) -> tuple[Real, Real, Real]:
    """Return contiguous arrays; refuse what `secular_roots` refuses, with its message."""
    node, weight, level = (np.ascontiguousarray(each, np.float64) for each in (nodes, weights, constant))
    if node.ndim != 2 or node.shape[1] == 0 or weight.shape != node.shape or level.shape != node.shape[:1]:
        raise InputError(
            f"nodes, weights and constant have the shapes {node.shape}, {weight.shape} and {level.shape}: expected "
            "(fingers, nodes) twice, and (fingers,)."
        )
    wrong = ~(_reachable(node, weight) & ((level == 0) | ((level >= 1e-50) & (level <= 1e50))))
    if wrong.any():
        finger = int(np.argmax(wrong))
        secular_roots(node[finger], weight[finger], constant=float(level[finger]))
    return node, weight, level


def _reachable(node: Real, weight: Real) -> NDArray[np.bool_]:
    """Return whether nodes and weights of each finger are in the range of `secular_roots`."""
    inside = (node[:, 0] >= 0) & (node[:, -1] <= 1e20) & (np.diff(node, axis=1) >= 1e-30).all(axis=1)
    return np.asarray(inside & ((weight >= 1e-50) & (weight <= 1e50)).all(axis=1))


def _in_numpy(node: Real, weight: Real, level: Real, offsets: Real, origins: Indices) -> Indices:
    """Write offsets and origins of all fingers, and return the fingers that need more digits."""
    doubtful = []
    for begin in range(0, len(node), _AT_ONCE):
        part = slice(begin, begin + _AT_ONCE)
        lost = _of_some(node[part], weight[part], level[part], offsets[part], origins[part])
        doubtful.append(begin + np.flatnonzero(lost))
    return np.concatenate([np.zeros(0, np.intp), *doubtful])


def _of_some(node: Real, weight: Real, level: Real, offsets: Real, origins: Indices) -> NDArray[np.bool_]:
    """Write offsets and origins of some fingers, and return which of them need more digits."""
    fingers, count = node.shape
    finger, left = np.divmod(np.arange(fingers * (count - 1)), max(1, count - 1))
    half = (node[finger, left + 1] - node[finger, left]) / 2
    middle = _sums(_rows_of(node, weight, level, finger, left, np.ones_like(left)), half)
    lost = np.zeros(fingers, bool)
    lost[finger[np.abs(middle.product) <= _MIDDLE * middle.size]] = True
    above = middle.product > 0
    last = np.flatnonzero(level > 0)
    finger = np.concatenate([finger, last])
    root = np.concatenate([left, np.full(last.size, count - 1)])
    origin = np.concatenate([left + above, np.full(last.size, count - 1)])
    side = np.concatenate([np.where(above, -1, 1), np.ones_like(last)])
    reach = np.concatenate([half, weight[last].sum(axis=1) / level[last]]) * (1 + 8 * _ROUNDING)
    kept = ~lost[finger]
    finger, root, origin, side, reach = finger[kept], root[kept], origin[kept], side[kept], reach[kept]
    rows = _rows_of(node, weight, level, finger, origin, side)
    distance = _solve(rows, reach, tolerance=1e-10, noise=2 * _ROUNDING)
    sums = _sums(rows, distance)
    lost[finger[sums.size > _CONDITION * (rows.weight + distance * distance * sums.steepness)]] = True
    offsets[finger, root], origins[finger, root] = side * distance, origin
    return lost


def _rows_of(node: Real, weight: Real, level: Real, finger: Indices, origin: Indices, side: Indices) -> _Rows:
    """Return the equations of roots with given origins, as for one finger in `secular_roots`."""
    row = np.arange(finger.size)
    position = side[:, None] * (node[finger] - node[finger, origin][:, None])
    rest = weight[finger]
    own = rest[row, origin].copy()
    rest[row, origin] = 0.0
    neighbour = position[row, np.minimum(origin + side, node.shape[1] - 1)]
    return _Rows(position=position, weight=own, rest=rest, level=-side * level[finger], neighbour=neighbour)
