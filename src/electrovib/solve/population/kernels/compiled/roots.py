"""Secular equations of fingers, one finger for each number of a vector; all of a tile until the last has converged."""

from __future__ import annotations

from typing import Any, Final

from electrovib.solve.recursion.vectors.jit import inlined, inner, outer
from electrovib.solve.recursion.vectors.lanes import (
    both,
    either,
    fma,
    inverse,
    load,
    other_than,
    root,
    size,
    some,
    splat,
    store,
    where,
)
from electrovib.solve.recursion.vectors.width import WIDTH

_ROUNDING: Final = 2.220446049250313e-16
_REACHED: Final = 1e-8  # last step over the distance; the error is of the order of its square
_TURNS: Final = 60  # steps after which a finger is left to `secular_roots`
_MIDDLE: Final = 64 * _ROUNDING  # share of its terms below which the sign of a sum is doubtful
CONDITION: Final = 200.0
"""Condition of an offset above which rounding costs it more than some 1e-13."""


@outer
def roots_of(
    nodes: Any,
    weights: Any,
    constants: Any,
    begin: Any,
    end: Any,
    work: Any,
    offsets: Any,
    origins: Any,
    lost: Any,
) -> Any:
    """Write offsets and origins of the roots of some fingers, and which of them need more digits.

    `work` holds nodes, weights, (nodes, fingers), and for one vector each: constant, offset, side, and lost.
    """
    count = nodes.shape[1]
    more = 2 * count * WIDTH
    for first in range(begin, end, WIDTH):
        positive = _gather(nodes, weights, constants, first, end, work)
        for node in range(count):
            if node + 1 < count:
                _between(work, count, node)
            elif positive:
                # without a constant there is no last root: it is computed for 1 and not used
                for lane in range(WIDTH):
                    work[more + lane] = work[more + lane] if work[more + lane] > 0 else 1.0
                _above(work, count)
            else:
                continue
            for lane in range(min(WIDTH, end - first)):
                if node + 1 < count or constants[first + lane] > 0:
                    offsets[first + lane, node] = work[more + WIDTH + lane]
                    origins[first + lane, node] = node + (work[more + 2 * WIDTH + lane] < 0)
                    lost[first + lane] = lost[first + lane] or work[more + 3 * WIDTH + lane] > 0


@inner
def _gather(nodes: Any, weights: Any, constants: Any, first: Any, end: Any, work: Any) -> Any:
    """Write a tile of fingers, the last finger repeated, and return whether one has a constant above 0."""
    count, positive = nodes.shape[1], False
    for lane in range(WIDTH):
        finger = min(first + lane, end - 1)
        for node in range(count):
            work[node * WIDTH + lane] = nodes[finger, node]
            work[(count + node) * WIDTH + lane] = weights[finger, node]
        work[2 * count * WIDTH + lane] = constants[finger]
        positive = positive or constants[finger] > 0
    return positive


@inlined
def _sums(work: Any, count: Any, low: Any, high: Any, origin: Any, at: Any) -> Any:
    """Return sums at a distance from the origin over the nodes below and from two indices on, and minus the slope."""
    below, above, slope = splat(0.0), splat(0.0), splat(0.0)
    weights = count * WIDTH
    for node in range(0, low * WIDTH, WIDTH):
        over = inverse(at - (load(work, node) - origin))
        term = load(work, weights + node) * over
        below, slope = below + term, fma(term, over, slope)
    for node in range(high * WIDTH, weights, WIDTH):
        over = inverse(at - (load(work, node) - origin))
        term = load(work, weights + node) * over
        above, slope = above + term, fma(term, over, slope)
    return below, above, slope


@inner
def _between(work: Any, count: Any, node: Any) -> Any:
    """Find the root between a node and the next one.

    The nearer end is the origin of a mirrored equation in the distance t > 0, as in `secular_roots`. The first distance
    solves the equation of both ends with all other poles as in the middle between them.
    """
    here, zero, one = node * WIDTH, splat(0.0), splat(1.0)
    left, right = load(work, here), load(work, here + WIDTH)
    of_left, of_right = load(work, (count + node) * WIDTH), load(work, (count + node + 1) * WIDTH)
    constant, gap = load(work, 2 * count * WIDTH), right - left
    half = gap * splat(0.5)
    below, above, _ = _sums(work, count, node, node + 2, left, half)
    others = below + above - constant
    ends = (of_left - of_right) / half
    total = others + ends
    scale = below - above + constant + (of_left + of_right) / half
    doubtful = size(total) <= splat(_MIDDLE) * scale
    is_right = total > zero
    side = where(is_right, -one, one)
    origin, own = where(is_right, right, left), where(is_right, of_right, of_left)
    other = where(is_right, of_left, of_right)
    level = side * others
    linear = fma(level, gap, -(own + other))
    apart = root(fma(splat(4.0) * level, own * gap, linear * linear))
    rising = linear > zero
    start = where(rising, linear + apart, splat(2.0) * own * gap) / where(
        rising, level + level, apart - linear
    )
    high = half * splat(1.0 + 8 * _ROUNDING)
    low = splat(0.5) * high * own / (half * scale)
    start = where(start < high, where(start > low, start, low), high)
    _solve(work, count, node, node + 2, origin, side, own, other, gap, start, low, high, doubtful)


@inner
def _above(work: Any, count: Any) -> Any:
    """Find the root above the last node.

    The first distance solves the equation of the last node and one pole for all others.
    """
    last, zero, one = (count - 1) * WIDTH, splat(0.0), splat(1.0)
    origin, own, constant = load(work, last), load(work, count * WIDTH + last), load(work, 2 * count * WIDTH)
    together, near = zero, zero
    for node in range(0, last, WIDTH):
        weight = load(work, count * WIDTH + node)
        together, near = together + weight, near + weight / (origin - load(work, node))
    apart = where(near > zero, together, zero) / where(near > zero, near, one)
    linear = own + together - constant * apart
    wide = root(fma(splat(4.0) * constant, own * apart, linear * linear))
    rising = linear > zero
    start = where(rising, linear + wide, splat(2.0) * own * apart)
    start = start / where(rising, constant + constant, wide - linear)
    low, high = own / constant, (own + together) / constant
    start = where(start < high, where(start > low, start, low), high)
    low, high = low * splat(0.5), high * splat(1.0 + 8 * _ROUNDING)
    _solve(work, count, count - 1, count, origin, one, own, zero, zero, start, low, high, zero > one)


@inner
def _solve(
    work: Any,
    count: Any,
    node: Any,
    after: Any,
    origin: Any,
    side: Any,
    own: Any,
    other: Any,
    gap: Any,
    distance: Any,
    low: Any,
    high: Any,
    lost: Any,
) -> Any:
    """Write the offset of a root from its origin, by the steps of `secular_roots`.

    `other` is the weight of the other end of the bracket at the distance `gap`; both are 0 above the last node.
    """
    zero, one, more = splat(0.0), splat(1.0), 2 * count * WIDTH
    level = -side * load(work, more)
    found, active, turn, has_end = distance, one > zero, 0, gap > zero
    while some(active) and turn < _TURNS:
        below, above, slope = _sums(work, count, node, after, origin, side * distance)
        to_end = where(has_end, distance - gap, one)
        end = other / to_end
        others, slope = fma(side, below + above, end), fma(end / to_end, one, slope)
        rest = others + level
        product = fma(distance, rest, own)
        scale = fma(distance, below - above + size(end) + size(level), own)
        flat = slope <= zero
        fitted = where(flat, distance, others / where(flat, one, slope))
        apart = where(has_end, to_end, fitted)
        linear = fma(slope, distance, -rest) - product / apart
        square = fma(linear, linear, splat(4.0) * product * (slope - rest / apart))
        usable = both(linear > zero, square >= zero)
        divisor = where(usable, linear + root(where(square > zero, square, zero)), one)
        step = splat(2.0) * product / divisor
        low, high = where(product > zero, distance, low), where(product < zero, distance, high)
        reached = both(usable, size(step) <= splat(_REACHED) * distance)
        done = either(reached, size(product) <= splat(2 * _ROUNDING) * scale)
        done = either(done, high - low <= splat(2 * _ROUNDING) * low)
        target = distance + step
        near = both(usable, splat(8.0) * size(step) <= distance)
        found = where(active, where(near, target, distance), found)
        ill = scale > splat(CONDITION) * fma(distance * distance, slope, own)
        lost = either(lost, both(active, both(done, ill)))
        inside = both(usable, both(target > low, target < high))
        if turn > 24 and turn % 2 == 0:
            inside = zero > one
        elif turn % 3 == 2:
            inside = both(inside, near)
        distance = where(inside, target, root(low) * root(high))
        active = both(active, other_than(done))
        turn += 1
    lost = either(lost, active)
    store(work, more + WIDTH, side * found)
    store(work, more + 2 * WIDTH, side)
    store(work, more + 3 * WIDTH, where(lost, one, zero))
