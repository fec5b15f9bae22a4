"""The recursion at uneven time stamps, exact: as a scan over rows of pieces, and for long records in compiled code."""

from __future__ import annotations

from bisect import bisect_left
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np
from numpy.polynomial.chebyshev import chebpts1, chebvander

from electrovib.solve.recursion.blocks import PRODUCT, numbers, states_before
from electrovib.solve.recursion.compiling import is_compiled
from electrovib.solve.recursion.hold import SLOW, StraightDrive, hold_weights

if TYPE_CHECKING:
    from collections.abc import Iterator

    from electrovib.core.arrays import Indices, Numbers, Real
    from electrovib.solve.recursion.hold import Modes

_WORTH: Final = 1_000_000
"""Modes times pieces from which loading the compiled code costs less time than it saves."""
_OUTLIER: Final = 4.0
"""Ratio to the mean step above which a step is not a usual one."""
FORGOTTEN: Final = 45.0
"""Rate times time after which a mode has decayed below rounding."""
_WINDOW: Final = 256
"""Pieces before a point at which all states are asked for, in which the fastest of them are followed."""
_SPAN: Final = 256
"""Pieces in an interval at whose end the states of many slow modes follow from those of a few."""
_LEAST: Final = 64
"""Least mean number of pieces in these intervals for which that saves work."""
_REACH: Final = 0.5
"""Largest rate of the slow modes times the longest interval."""
_RATES: Final = 10
"""Number of rates from which they follow: the error is 2 (_REACH / 4)^10 / 10!, below rounding."""
_FEWEST: Final = 4
"""Least number of outputs for which the states are held together."""
_GRADED: Final = 1e-4
"""Shortest step over the longest below which the steps extend over decades, as those of an adaptive solver."""


class _Plan(NamedTuple):
    """Modes in the order of their rates: states of the first `slow` are advanced, and lags of the others.

    `usual` is the longest step in which the first relax little [s], and `shortest` the shortest step.
    """

    order: Indices
    poles: Numbers
    slow: int
    usual: float
    shortest: float
    compiled: Any


class UnevenMarch:
    """The response of relaxing or oscillating modes to a drive with pieces of unequal duration, one part after the other."""

    def __init__(self, modes: Modes, drive: StraightDrive, state: Numbers) -> None:
        self.drive, self.plan = drive, _plan(modes.poles, drive)
        gains, self.lag = modes.gains[:, self.plan.order], np.arange(self.plan.poles.size) >= self.plan.slow
        lagging = self.lag - modes.lag[:, np.newaxis].astype(float)
        self.level = modes.direct + (gains.real * lagging).sum(axis=1)
        self.shares = numbers(np.conj(gains))  # the real part of a product
        self.followed = state[self.plan.order] - self.lag * drive.starts[0]

    def through(self, part: slice, output: Real) -> Numbers:
        """Write the outputs at the beginnings of some pieces, those after the ones before, and return the states at their end.

        `output` (outputs, n), or (outputs, n + 1) with the last point.
        """
        drive, shares = self.drive, self.shares
        for some, followed in _followed(self.plan, drive, self.followed, len(output), part):
            own = slice(some.start - part.start, some.stop - part.start)
            np.matmul(shares, numbers(followed[:-1]).T, out=output[:, own])
            self.followed = followed[-1].copy()
        output[:, : part.stop - part.start] += np.multiply.outer(self.level, drive.starts[part])
        at_end = float(drive.ends[part.stop - 1])
        is_last = part.stop == drive.starts.size
        if output.shape[1] > part.stop - part.start:
            output[:, -1] = shares @ numbers(self.followed) + self.level * at_end
        states = np.empty_like(self.followed)
        states[self.plan.order] = self.followed + self.lag * (at_end if is_last else drive.starts[part.stop])
        return np.asarray(states)


def uneven_states(
    poles: Numbers, drive: StraightDrive, state: Numbers, places: Indices, record: int = 0
) -> Numbers:
    """Return the states at some points of a drive with pieces of unequal duration, part of a record of so many pieces.

    `places` (n,) in rising order; returns `states` (poles, n).

    From rest a state at the end of an interval is the rate times the integral of exp(-rate t) v, t being the time until that
    end. For all modes that relax little within an interval this integral is a polynomial of the rate to rounding: many of them
    follow from a few rates.
    """
    marks = np.unique(np.append(np.arange(0, places[-1], _SPAN), places))
    spans = np.add.reduceat(drive.steps[: marks[-1]], marks[:-1])
    longest = _REACH / float(np.max(spans, initial=0.0) or 1.0)
    slow = -poles.real <= longest
    worth = np.count_nonzero(slow) > 2 * _RATES and len(marks) * _LEAST < places[-1]
    if not worth or np.iscomplexobj(poles):
        return _states(poles, drive, state, places, record)
    rates, nodes = -poles[slow], chebpts1(_RATES)
    few = longest * (1 + nodes) / 2
    begin = np.append(np.zeros(_RATES), state[~slow])
    reached = _states(np.append(-few, poles[~slow]), drive, begin, marks, record)
    grown = reached[:_RATES, 1:] - np.exp(-np.outer(few, spans)) * reached[:_RATES, :-1]
    between = np.linalg.solve(_powers(nodes).T, _powers(2 * rates / longest - 1).T)
    pushes = np.einsum("km,kr->mr", grown / few[:, np.newaxis], between * rates)
    found, at = np.empty((len(poles), len(places))), np.searchsorted(marks, places)
    found[~slow] = reached[_RATES:, at]
    found[slow] = states_before(pushes, -np.outer(spans, rates), state[slow])[at].T
    return found


def _powers(at: Real) -> Real:
    """Return the Chebyshev polynomials at some numbers (n,), (n, _RATES)."""
    return np.asarray(chebvander(at, _RATES - 1), np.float64)


def _states(poles: Numbers, drive: StraightDrive, state: Numbers, places: Indices, record: int) -> Numbers:
    """Return the states at some points (n,) in rising order, each mode by itself, (poles, n)."""
    plan, inside = _plan(poles, drive, record), np.minimum(places, drive.starts.size - 1)
    found = np.empty((len(places), plan.poles.size), state.dtype)
    begin = state[plan.order]
    begin[plan.slow :] -= drive.starts[0]
    each = places.tolist()
    for part, followed in _followed(plan, drive, begin, 0, slice(0, drive.starts.size), places):
        some = slice(bisect_left(each, part.start), bisect_left(each, part.stop + 1))
        if some.stop > some.start:
            found[some, plan.order] = followed[places[some] - part.start]
    levels = np.where(places < drive.starts.size, drive.starts[inside], drive.ends[-1])
    found[:, plan.order[plan.slow :]] += levels[:, np.newaxis]
    return found.T


def _plan(poles: Numbers, drive: StraightDrive, record: int = 0) -> _Plan:
    """Order the modes by what they relax in the longest usual step.

    A drive with graded steps may be very large for a short time; the lag of a mode behind it would be rounded by the size of
    the drive, so that the states of all modes are advanced.
    """
    shortest = float(np.min(drive.steps))
    lasting = shortest or float(np.min(drive.steps[drive.steps > 0]))
    longest = float(np.max(drive.steps))
    usual = min(longest, _OUTLIER * float(np.mean(drive.steps)))
    order, slow = np.argsort(-poles.real, kind="stable"), poles.size
    if np.iscomplexobj(poles) or lasting < _GRADED * longest:
        usual = 0.0
    else:
        slow = int(np.count_nonzero(-poles * usual <= SLOW))
    return _Plan(order, poles[order], slow, usual, shortest, _compiled(poles, max(drive.starts.size, record)))


def _compiled(poles: Numbers, pieces: int) -> Any:
    """Return the compiled recursion where it is faster. The choice depends on the record alone."""
    if poles.size * pieces < _WORTH or np.iscomplexobj(poles) or not is_compiled():
        return None
    from electrovib.solve.recursion.compiled import follow

    return follow


def _followed(
    plan: _Plan,
    drive: StraightDrive,
    followed: Numbers,
    outputs: int,
    within: slice,
    places: Indices | None = None,
) -> Iterator[tuple[slice, Numbers]]:
    """Yield intervals of a part of a drive with states and lags before each piece and after the last, (pieces + 1, modes).

    Where only the states at some `places` are asked for, lags that decay before the next of them are not followed. The table
    of states is that of the next interval afterwards.
    """
    rates, modes = -plan.poles, len(plan.poles)
    # the product with the gains stays on one thread, and the states in the second-level cache
    length = max(1, PRODUCT // max(1, numbers(rates).size * max(_FEWEST, outputs)))
    begins = np.arange(within.start, within.stop, length)
    if places is not None:
        apart = np.diff(places) > _WINDOW
        windows = places[np.append(True, apart)] - _WINDOW, places[np.append(apart, True)] + 1
        begins = np.unique(np.concatenate([begins, *windows]).clip(within.start, within.stop - 1))
    ends, counts = np.append(begins[1:], within.stop), np.full(len(begins), modes)
    if places is not None:
        after = places[np.minimum(np.searchsorted(places, begins), len(places) - 1)] - ends
        with np.errstate(divide="ignore"):
            fastest = FORGOTTEN / (plan.shortest * np.maximum(after, 0))
        counts = np.maximum(plan.slow, np.searchsorted(rates.real, fastest, side="right"))
    followed, held = followed.copy(), np.empty((length + 1) * modes, followed.dtype)
    for begin, end, count in zip(begins.tolist(), ends.tolist(), counts.tolist(), strict=True):
        if plan.compiled:
            table = held[: (end - begin + 1) * count].reshape(end - begin + 1, count)
            table[0] = followed[:count]
            plan.compiled(rates[:count], plan.slow, plan.usual, tuple(drive), begin, table)
        else:
            some = StraightDrive(*(each[begin:end] for each in drive))
            following = float(drive.starts[end] if end < drive.starts.size else drive.ends[-1])
            table = _scanned(plan, some, following, followed[:count])
        followed[:count] = table[-1]  # what is left of the others has decayed before it is wanted
        yield slice(begin, end), table


def _scanned(plan: _Plan, drive: StraightDrive, following: float, followed: Numbers) -> Numbers:
    """Return states and lags before each piece and after the last, (pieces + 1, modes)."""
    starts, ends, steps = (each[:, np.newaxis] for each in drive)
    z, slow = steps * plan.poles[: followed.size], slice(0, plan.slow)
    pushes, decays = np.empty_like(z), np.empty_like(z)
    decays[:, slow], first, last = hold_weights(z[:, slow])
    pushes[:, slow] = first * starts + last * ends
    fast = z[:, plan.slow :]
    fallen = np.expm1(fast)
    decays[:, plan.slow :] = 1 + fallen
    mean = np.divide(fallen, fast, out=np.ones_like(fast), where=fast != 0)
    jumps = np.append(drive.starts[1:], following) - drive.ends
    pushes[:, plan.slow :] = mean * (starts - ends) - jumps[:, np.newaxis]
    return states_before(pushes, z, followed, decays)
