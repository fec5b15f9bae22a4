"""Roots of sums of simple poles, which are the relaxation rates of a stack of layers."""

from __future__ import annotations

import decimal
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from electrovib.core.arrays import Indices, Numbers, Real
from electrovib.solve.stack.few_poles import Roots, _between_two_poles, _of_one_pole, _of_two_poles, _roots_at
from electrovib.solve.stack.secular_input import _checked

_ROUNDING = float(np.finfo(float).eps)

_ILL_CONDITIONED = 50.0  # above it rounding alone costs the offset more than about 1e-14
_SLACK = 8 * _ROUNDING
_LONG = decimal.Context(prec=150, Emin=-9999, Emax=9999, traps=[decimal.InvalidOperation])
_TINY = decimal.Decimal("1e-25")


@dataclass(frozen=True, eq=False, kw_only=True)
class _Rows:
    """Equations of the roots, one row for each, mirrored where the root lies below its origin.

    With t > 0 the distance from the origin, the root is where
    ``weight/t + sum(rest/(t - position)) + level = 0``; the left side falls with t.
    """

    position: Numbers  # (rows, nodes), of the nodes relative to the origin, positive towards the root
    weight: Numbers  # (rows,), of the origin
    rest: Numbers  # (rows, nodes), the weights with 0 at the origin
    level: Numbers  # (rows,)
    neighbour: Numbers  # (rows,), position of the other end of the bracket, 0 where there is none

    def take(self, chosen: NDArray[Any]) -> _Rows:
        return _Rows(
            position=self.position[chosen],
            weight=self.weight[chosen],
            rest=self.rest[chosen],
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


def secular_roots(nodes: ArrayLike, weights: ArrayLike, *, constant: float) -> Roots:
    r"""Find the roots at which a sum of poles with positive weights equals a constant.

    They are the zeros of the impedance of layers in series.

    `nodes` (nodes,), `weights` (nodes,).

    .. math:: f(x) = -c + \sum_l \frac{w_l}{x - n_l}

    falls from :math:`+\infty` to :math:`-\infty` between neighbouring nodes. Each root is computed as its
    distance from the nearer end of its bracket, with steps that treat the pole there exactly, model all other
    poles by one at the far end, and fall back to geometric bisection. The numbers given are taken as exact:
    where cancellation prevents 53 bits from resolving the root, it is computed again with 150 digits. Offset,
    differences and slope are therefore accurate to better than 1e-13 relative, whatever the conditioning.
    """
    node, weight = _checked(nodes, weights, constant)
    if node.size == 1 and constant > 0:
        return _of_one_pole(node, weight, float(constant))
    if node.size == 2 and constant == 0:
        return _between_two_poles(node, weight)
    if node.size == 2 and (found := _of_two_poles(node, weight, float(constant))) is not None:
        return found
    origin, side, reach = _nearer_ends(node, weight, float(constant))
    rows = _rows(node, weight, float(constant), origin, side)
    distance = _solve(rows, reach, tolerance=1e-10, noise=2 * _ROUNDING)
    sums = _sums(rows, distance)
    doubtful = sums.size > _ILL_CONDITIONED * (rows.weight + distance * distance * sums.steepness)
    if doubtful.any():
        with decimal.localcontext(_LONG):
            rows = _long_rows(node, weight, float(constant), origin[doubtful], side[doubtful])
            long = _solve(rows, _long(reach[doubtful]), tolerance=_TINY, noise=_TINY**5)
            distance[doubtful] = long.astype(float)
    return _roots_at(node, weight, origin, np.where(side > 0, distance, -distance))


def _nearer_ends(node: Real, weight: Real, constant: float) -> tuple[Indices, Indices, Real]:
    """Return origin, side of the origin the root is on, and an upper bound of its distance."""
    left = np.arange(node.size - 1)
    upwards = np.ones_like(left)
    reach: Real = np.diff(node) / 2
    if left.size:
        rows = _rows(node, weight, constant, left, upwards)
        sums = _sums(rows, reach)
        product = sums.product
        doubtful = np.abs(product) <= 64 * _ROUNDING * sums.size
        if doubtful.any():  # the nearer end follows from the sign alone, so the sign must be right
            with decimal.localcontext(_LONG):
                rows = _long_rows(node, weight, constant, left[doubtful], upwards[doubtful])
                product[doubtful] = np.where(_sums(rows, _long(reach[doubtful])).product > 0, 1, -1)
        above = product > 0
        left, upwards = left + above, np.where(above, -1, 1)
    if constant > 0:
        left = np.append(left, node.size - 1)
        upwards = np.append(upwards, 1)
        reach = np.append(reach, weight.sum() / constant)
    return left, upwards, reach * (1 + _SLACK)


def _rows(node: Numbers, weight: Numbers, constant: Any, origin: Indices, side: Indices) -> _Rows:
    row = np.arange(origin.size)
    position = side[:, None] * (node - node[origin][:, None])
    rest = np.repeat(weight[None, :], origin.size, axis=0)
    rest[row, origin] = 0 * weight[origin]
    # the bracket of the root above the last node has no other end: the index is that of the origin, position 0
    neighbour = position[row, np.minimum(origin + side, node.size - 1)]
    return _Rows(
        position=position, weight=weight[origin], rest=rest, level=-side * constant, neighbour=neighbour
    )


def _sums(rows: _Rows, distance: Numbers) -> _Sums:
    apart = distance[:, None] - rows.position
    terms = rows.rest / apart
    others = terms.sum(axis=1)
    rest = others + rows.level
    size = rows.weight + distance * (np.abs(terms).sum(axis=1) + np.abs(rows.level))
    return _Sums(
        product=rows.weight + distance * rest,
        size=size,
        others=others,
        rest=rest,
        steepness=(terms / apart).sum(axis=1),
    )


def _step(rows: _Rows, distance: Numbers, sums: _Sums) -> tuple[Numbers, NDArray[np.bool_]]:
    """Return the step to the zero of weight/t + level + strength/(t - pole), and whether it exists.

    The pole is the other end of the bracket; level and strength are fitted to value and slope of the rest.
    Without another end, all poles are on one side: then the level is kept, and the pole is fitted.
    """
    flat = sums.steepness == 0
    fitted = np.where(flat, distance, sums.others / np.where(flat, 1 + 0 * distance, sums.steepness))
    apart = np.where(rows.neighbour == 0, fitted, distance - rows.neighbour)
    # in terms of the sums at the present distance, so that no terms cancel at the root
    linear = sums.steepness * distance - sums.rest - sums.product / apart
    square = linear * linear + 4 * sums.product * (sums.steepness - sums.rest / apart)
    usable = (linear > 0) & (square >= 0)
    divisor = np.where(usable, linear + np.sqrt(np.maximum(square, 0 * square)), 1 + 0 * linear)
    return 2 * sums.product / divisor, usable


def _solve(rows: _Rows, reach: Numbers, *, tolerance: Any, noise: Any) -> Numbers:
    """Return the distance of each root from its origin, at most ``reach``.

    Convergence is quadratic, so a last step below ``tolerance`` leaves an error of about its square.
    """
    found = reach.copy()
    active = np.arange(reach.size)
    distance, high = reach, reach
    sums = _sums(rows, distance)
    low = reach * (rows.weight / sums.size) / 2
    turn = 0
    while active.size:
        step, usable = _step(rows, distance, sums)
        low, high = np.where(sums.product > 0, distance, low), np.where(sums.product < 0, distance, high)
        small = np.abs(step) <= tolerance * distance
        done = (usable & small) | (np.abs(sums.product) <= noise * sums.size) | (high - low <= noise * low)
        target = distance + step
        near = usable & (8 * np.abs(step) <= distance)
        found[active] = np.where(near, target, distance)
        # bisection replaces a large step in every third turn, and later any step in every other, to shrink the bracket
        bisect = ~(usable & (target > low) & (target < high)) | (~near & (turn % 3 == 2))
        bisect |= (turn > 24) & (turn % 2 == 0)
        distance = np.where(bisect, np.sqrt(low) * np.sqrt(high), target)
        if done.any():
            keep = ~done
            rows, active = rows.take(keep), active[keep]
            distance, low, high = distance[keep], low[keep], high[keep]
        sums = _sums(rows, distance)
        turn += 1
    return found


def _long_rows(node: Real, weight: Real, constant: float, origin: Indices, side: Indices) -> _Rows:
    """Return the rows in exact decimals, so that the same steps use as many digits as the context has."""
    return _rows(_long(node), _long(weight), decimal.Decimal(constant), origin, side)


def _long(numbers: Real) -> Numbers:
    return np.array([decimal.Decimal(number) for number in numbers.tolist()], dtype=object)
