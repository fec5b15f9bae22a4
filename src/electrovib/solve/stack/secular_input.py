"""Validation of the nodes, weights and constant of a secular equation."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from electrovib.core.arrays import Real
from electrovib.core.errors import InputError

_LARGEST_NODE = 1e20


_SMALLEST_GAP = 1e-30


_LARGEST_WEIGHT = 1e50  # of the constant too; the smallest is its inverse


class BeyondReachError(InputError, ValueError):
    """Error for rates of a stack that cannot be resolved in double precision."""

    def __init__(self, why: str) -> None:
        super().__init__(
            "stack: the rates or impedances of layers and circuit lie too far apart to be computed. Choose longer relaxation"
            " times or smaller conductivities of the layers, or a less extreme resistance or thickness (in the secular"
            f" equation, {why})"
        )


def _checked(nodes: ArrayLike, weights: ArrayLike, constant: float) -> tuple[Real, Real]:
    node, weight = np.array(nodes, dtype=float), np.array(weights, dtype=float)
    if node.ndim != 1 or node.size == 0 or weight.shape != node.shape:
        message = f"nodes and weights: shapes {node.shape} and {weight.shape}, expected the same (count,)"
        raise ValueError(message)
    if not (np.isfinite(node).all() and node[0] >= 0 and node[-1] <= _LARGEST_NODE):
        raise BeyondReachError(
            f"nodes: expected numbers from 0 to {_LARGEST_NODE:g}, got up to {node.max():.3g}"
        )
    gap = np.diff(node)
    if not (gap >= _SMALLEST_GAP).all():
        where = int(np.argmin(gap))
        raise BeyondReachError(
            f"nodes[{where}] = {node[where]!r} and nodes[{where + 1}] = {node[where + 1]!r}: expected "
            f"strictly increasing nodes {_SMALLEST_GAP:g} apart; merge equal nodes by adding their weights"
        )
    if not ((weight >= 1 / _LARGEST_WEIGHT) & (weight <= _LARGEST_WEIGHT)).all():
        worst = weight[np.argmax(np.abs(np.log(np.abs(weight) + 1e-300)))]
        raise BeyondReachError(
            f"weights: expected {1 / _LARGEST_WEIGHT:g} to {_LARGEST_WEIGHT:g}, got {worst:.3g}"
        )
    if not (constant == 0 or 1 / _LARGEST_WEIGHT <= constant <= _LARGEST_WEIGHT):
        raise BeyondReachError(
            f"constant = {constant!r}: expected 0, or {1 / _LARGEST_WEIGHT:g} to {_LARGEST_WEIGHT:g}"
        )
    return node, weight


def refuse_beyond_reach(nodes: Real, weights: Real, constants: Real) -> None:
    """Refuse the first of many problems that `_checked` refuses; `nodes`, `weights` (nodes, problems)."""
    inside = (nodes[0] >= 0) & (nodes[-1] <= _LARGEST_NODE)
    inside &= (np.diff(nodes, axis=0) >= _SMALLEST_GAP).all(axis=0)
    inside &= ((weights >= 1 / _LARGEST_WEIGHT) & (weights <= _LARGEST_WEIGHT)).all(axis=0)
    inside &= (constants == 0) | ((constants >= 1 / _LARGEST_WEIGHT) & (constants <= _LARGEST_WEIGHT))
    if not inside.all():
        first = int(np.argmin(inside))
        _checked(nodes[:, first], weights[:, first], float(constants[first]))
