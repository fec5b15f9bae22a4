"""The steps of `secular` for many problems, in loops compiled by numba: problems side by side, one root after the other."""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from electrovib.solve.stack.compilation import inner, outer
from electrovib.solve.stack.secular_step import step_with

TOGETHER: Final = 64
"""Problems that are advanced until the last of them has converged."""
_TURNS: Final = 60  # steps after which a problem is lost
_ROUNDING: Final = 2.220446049250313e-16
_CONDITION: Final = 200.0  # of an offset, above which rounding costs it more than some 1e-13


@inner
def _where(condition: Any, one: Any, other: Any) -> Any:
    """Return one of two numbers."""
    return one if condition else other


_step = inner(step_with(_where))  # the formulas that `secular` uses for arrays


# Numbers of the problems that are advanced together lie in one flat array, one row of `TOGETHER` after the other; indices
# are unsigned, or the compiler would not use vectors.
_ROWS: Final = tuple(np.uint64(row * TOGETHER) for row in range(14))
_DISTANCE, _BASE, _SIDE, _ORIGIN, _OTHERS, _SIZES, _SLOPE = _ROWS[:7]
_OWN, _LEVEL, _END, _FOUND, _LOW, _HIGH, _DONE = _ROWS[7:]


@inner
def _write_sums(node: Any, weight: Any, first: Any, count: Any, work: Any) -> Any:
    """Write the sum over the poles other than the origin, that of their absolute values, and minus the derivative."""
    for lane in range(np.uint64(0), np.uint64(count)):
        work[_OTHERS + lane] = work[_SIZES + lane] = work[_SLOPE + lane] = 0.0
    for place in range(len(node)):
        nodes, weights, index = node[place], weight[place], float(place)
        for lane in range(np.uint64(0), np.uint64(count)):
            problem = np.uint64(first) + lane
            apart = work[_DISTANCE + lane] - work[_SIDE + lane] * (nodes[problem] - work[_BASE + lane])
            over = 1.0 / apart
            term = 0.0 if work[_ORIGIN + lane] == index else weights[problem] * over
            work[_OTHERS + lane] += term
            work[_SIZES + lane] += abs(term)
            work[_SLOPE + lane] += term * over


@outer
def write_roots(node: Any, weight: Any, constant: Any, offsets: Any, origins: Any, lost: Any) -> Any:
    """Write offsets and origins of the roots of problems, and which of them need more digits.

    All but `constant` and `lost`, (problems,), are (nodes, problems).
    """
    work = np.zeros(len(_ROWS) * TOGETHER)
    for first in range(0, len(constant), TOGETHER):
        count = min(TOGETHER, len(constant) - first)
        for root in range(len(node)):
            _bracket(node, weight, constant, first, count, root, work, lost)
            _solve(node, weight, first, count, work)
            for lane in range(np.uint64(0), np.uint64(count)):
                problem, t = np.uint64(first) + lane, work[_FOUND + lane]
                origins[root, problem] = int(work[_ORIGIN + lane])
                if root + 1 < len(node) or constant[problem] > 0.0:
                    offsets[root, problem] = work[_SIDE + lane] * t
                    size = work[_OWN + lane] + t * (work[_SIZES + lane] + abs(work[_LEVEL + lane]))
                    ill = size > _CONDITION * (work[_OWN + lane] + t * t * work[_SLOPE + lane])
                    lost[problem] |= ill or work[_DONE + lane] == 0.0


@inner
def _bracket(
    node: Any, weight: Any, constant: Any, first: Any, count: Any, root: Any, work: Any, lost: Any
) -> Any:
    """Write the origin of a root, the side of it on which the root is, and a bound of its distance."""
    last = root + 1 == len(node)
    for lane in range(np.uint64(0), np.uint64(count)):
        problem = np.uint64(first) + lane
        work[_SIDE + lane], work[_ORIGIN + lane], work[_BASE + lane] = 1.0, root, node[root, problem]
        work[_END + lane] = 0.0 if last else node[root + 1, problem] - node[root, problem]
        work[_DISTANCE + lane] = work[_END + lane] / 2
    _write_sums(node, weight, first, count, work)
    for lane in range(np.uint64(0), np.uint64(count)):
        problem = np.uint64(first) + lane
        own, level, reach = weight[root, problem], constant[problem], work[_DISTANCE + lane]
        if last:
            # without a constant there is no last root: it is computed for 1 and not used
            level = level if level > 0.0 else 1.0
            reach = 0.0
            for place in range(len(node)):
                reach += weight[place, problem]
            reach /= level
        else:
            product = own + reach * (work[_OTHERS + lane] - level)
            size = own + reach * (work[_SIZES + lane] + level)
            lost[problem] |= abs(product) <= 64 * _ROUNDING * size  # the sign of the sum is doubtful
            if product > 0.0:
                own, work[_SIDE + lane], work[_ORIGIN + lane] = weight[root + 1, problem], -1.0, root + 1
                work[_BASE + lane] = node[root + 1, problem]
        work[_OWN + lane], work[_LEVEL + lane] = own, -work[_SIDE + lane] * level
        work[_HIGH + lane] = work[_DISTANCE + lane] = reach * (1 + 8 * _ROUNDING)


@inner
def _solve(node: Any, weight: Any, first: Any, count: Any, work: Any) -> Any:
    """Write the distances of one root of some problems from its origins, and the sums there."""
    for lane in range(np.uint64(0), np.uint64(count)):
        work[_DONE + lane] = 0.0
    turn, active = 0, count
    while active and turn < _TURNS:
        _write_sums(node, weight, first, count, work)
        if turn == 0:
            for lane in range(np.uint64(0), np.uint64(count)):
                size = work[_SIZES + lane] + abs(work[_LEVEL + lane])
                share = work[_OWN + lane] / (work[_OWN + lane] + work[_DISTANCE + lane] * size)
                work[_LOW + lane] = work[_DISTANCE + lane] * share / 2
        active = 0
        for lane in range(np.uint64(0), np.uint64(count)):
            size = work[_SIZES + lane] + abs(work[_LEVEL + lane])
            best, reached, distance, low, high = _step(
                work[_DISTANCE + lane],
                work[_LOW + lane],
                work[_HIGH + lane],
                work[_OWN + lane],
                work[_LEVEL + lane],
                work[_END + lane],
                work[_OTHERS + lane],
                work[_SLOPE + lane],
                work[_OWN + lane] + work[_DISTANCE + lane] * size,
                turn,
                1e-8,
                2 * _ROUNDING,
            )
            work[_DISTANCE + lane], work[_LOW + lane], work[_HIGH + lane] = distance, low, high
            work[_FOUND + lane] = work[_FOUND + lane] if work[_DONE + lane] == 1.0 else best
            work[_DONE + lane] = 1.0 if reached else work[_DONE + lane]
            active += work[_DONE + lane] == 0.0
        turn += 1
    for lane in range(np.uint64(0), np.uint64(count)):
        work[_DISTANCE + lane] = work[_FOUND + lane]
    _write_sums(node, weight, first, count, work)
