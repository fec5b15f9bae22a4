"""Roots of a sum of poles, stored as distances from them, and the closed forms for one and two poles."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from electrovib.core.arrays import Indices, Real

_CANCELLED = 8.0  # largest cancellation in the closed form of two poles: three of 53 bits


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


def roots_at(node: Real, weight: Real, origin: Indices, offset: Real) -> Roots:
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
    return roots_at(node, weight, np.array([nearer]), np.array([-distance if nearer else distance]))


def _of_one_pole(node: Real, weight: Real, constant: float) -> Roots:
    """Return the root above a single pole, in closed form."""
    return roots_at(node, weight, np.zeros(1, np.intp), weight / constant)


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
    return roots_at(node, weight, np.array(origin), np.array(offset))


def _differences(node: Real, origin: Indices, offset: Real) -> Real:
    begins = np.take_along_axis(node, origin, -1)
    result: Real = (begins[..., :, None] - node[..., None, :]) + offset[..., :, None]
    return result
