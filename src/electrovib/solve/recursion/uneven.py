"""The recursion at uneven time stamps, exact: as a scan over rows of pieces, and for long records in compiled code."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from electrovib.solve.compiling import is_compiled
from electrovib.solve.recursion.blocks import PRODUCT, numbers, states_before
from electrovib.solve.recursion.hold import SLOW, StraightDrive, hold_weights

if TYPE_CHECKING:
    from collections.abc import Iterator

    from electrovib.core.arrays import Indices, Numbers, Real
    from electrovib.solve.recursion.hold import Modes

_WORTH: Final = 1_000_000
"""Modes times pieces from which loading the compiled code costs less time than it saves."""
_OUTLIER: Final = 4.0
"""Ratio to the mean step above which a step is not a usual one."""
_GRADED: Final = 1e-4
"""Shortest step over the longest below which the steps extend over decades, as those of an adaptive solver."""


class _Plan(NamedTuple):
    """Modes in the order of their rates: states of the first `slow` are advanced, and lags of the others.

    `usual` is the longest step in which the first relax little [s].
    """

    order: Indices
    poles: Numbers
    slow: int
    usual: float
    compiled: Any


def march_uneven(modes: Modes, drive: StraightDrive, state: Numbers, output: Real) -> Numbers:
    """Compute the response of relaxing or oscillating modes to a drive with pieces of unequal duration.

    `state` (poles,), `output` (pieces + 1,); returns `final_state` (poles,).
    """
    plan = _plan(modes, drive)
    gains, lag = modes.gains[:, plan.order], np.arange(plan.poles.size) >= plan.slow
    level = modes.direct + (gains.real * (lag - modes.lag[:, np.newaxis].astype(float))).sum(axis=1)
    shares = numbers(np.conj(gains))  # the real part of a product
    for part, followed in _followed(plan, drive, state, len(gains)):
        np.multiply.outer(level, drive.starts[part], out=output[:, part])
        output[:, part] += shares @ numbers(followed[:-1]).T
    output[:, -1] = shares @ numbers(followed[-1]) + level * drive.ends[-1]
    final = np.empty_like(followed[-1])
    final[plan.order] = followed[-1] + lag * drive.ends[-1]
    return np.asarray(final)


def uneven_states(modes: Modes, drive: StraightDrive, state: Numbers, places: Indices) -> Numbers:
    """Return the states at some points of a drive with pieces of unequal duration.

    `places` (n,) in rising order; returns `states` (poles, n).
    """
    plan, levels = _plan(modes, drive), np.append(drive.starts, drive.ends[-1])
    found = np.empty((len(places), plan.poles.size), state.dtype)
    for part, followed in _followed(plan, drive, state, 0):
        some = slice(*np.searchsorted(places, [part.start, part.stop + 1]))
        found[some, plan.order] = followed[places[some] - part.start]
    found[:, plan.order[plan.slow :]] += levels[places, np.newaxis]
    return found.T


def _plan(modes: Modes, drive: StraightDrive) -> _Plan:
    """Order the modes by what they relax in the longest usual step.

    A drive with graded steps may be very large for a short time; the lag of a mode behind it would be rounded by the size of
    the drive, so that the states of all modes are advanced.
    """
    poles, lasting = modes.poles, drive.steps[drive.steps > 0]
    usual = min(float(np.max(drive.steps)), _OUTLIER * float(np.mean(drive.steps)))
    order, slow = np.argsort(-poles.real, kind="stable"), poles.size
    if np.iscomplexobj(poles) or float(np.min(lasting)) < _GRADED * float(np.max(lasting)):
        usual = 0.0
    else:
        slow = int(np.count_nonzero(-poles * usual <= SLOW))
    return _Plan(order, poles[order], slow, usual, _compiled(poles, drive))


def _compiled(poles: Numbers, drive: StraightDrive) -> Any:
    """Return the compiled recursion where it is faster. The choice depends on the record alone."""
    if poles.size * drive.starts.size < _WORTH or np.iscomplexobj(poles) or not is_compiled():
        return None
    from electrovib.solve.recursion.compiled import follow

    return follow


def _followed(
    plan: _Plan, drive: StraightDrive, state: Numbers, outputs: int
) -> Iterator[tuple[slice, Numbers]]:
    """Yield intervals of a drive with states and lags before each piece and after the last, (pieces + 1, modes)."""
    pieces, rates = drive.starts.size, -plan.poles
    followed = state[plan.order]
    followed[plan.slow :] -= drive.starts[0]
    # the product with the gains stays on one thread, and the states in the second-level cache
    length = max(1, PRODUCT // max(1, numbers(rates).size * max(8, outputs)))
    for begin in range(0, pieces, length):
        part = slice(begin, min(begin + length, pieces))
        some = StraightDrive(*(each[part] for each in drive))
        following = float(drive.starts[part.stop] if part.stop < pieces else drive.ends[-1])
        if plan.compiled:
            table = np.empty((len(some.starts) + 1, len(rates)))
            table[0] = followed
            plan.compiled(rates, plan.slow, plan.usual, tuple(some), following, table)
        else:
            table = _scanned(plan, some, following, followed)
        followed = table[-1]
        yield part, table


def _scanned(plan: _Plan, drive: StraightDrive, following: float, followed: Numbers) -> Numbers:
    """Return states and lags before each piece and after the last, (pieces + 1, modes)."""
    starts, ends, steps = (each[:, np.newaxis] for each in drive)
    z, slow = steps * plan.poles, slice(0, plan.slow)
    pushes = np.empty_like(z)
    _, first, last = hold_weights(z[:, slow])
    pushes[:, slow] = first * starts + last * ends
    fast = z[:, plan.slow :]
    mean = np.divide(np.expm1(fast), fast, out=np.ones_like(fast), where=fast != 0)
    jumps = np.append(drive.starts[1:], following) - drive.ends
    pushes[:, plan.slow :] = mean * (starts - ends) - jumps[:, np.newaxis]
    return states_before(pushes, z, followed)
