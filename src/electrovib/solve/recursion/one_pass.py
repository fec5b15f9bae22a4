"""The recursion at unequal time stamps in one compiled pass over very many pieces."""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from electrovib.core.arrays import Indices, Real
    from electrovib.solve.recursion.record import Modes, StraightDrive

_WORTH: Final = 1_000_000
"""Modes times pieces from which loading the compiled code costs less time than it saves."""
_AT_ONCE: Final = 1024
"""Pieces whose states are in memory together."""
_DEGREES: Final = (4, 10)
_REACH: Final = (0.015, 0.9, 100.0)
"""Rate times longest step up to which these polynomials, and then a table of decays, are exact to rounding."""
_TABLE: Final = 1024
"""Number of durations in the table of decays."""
_OUTLIER: Final = 4.0
"""Ratio to the mean duration above which a piece has weights of its own."""
_SOON: Final = 0.1
"""Rate times longest step from which a state has decayed after some hundred pieces."""
_FORGOTTEN: Final = 45.0
"""Rate times time after which a state has decayed below rounding."""


class _Plan(NamedTuple):
    """Modes in the order in which they are advanced."""

    order: Indices
    counts: tuple[int, int, int]
    rates: Real
    terms: tuple[Real, Real]
    decays: Real
    longest: float

    @property
    def slow(self) -> int:
        """Number of modes of which the state is advanced; of the others it is the lag behind the drive."""
        return self.counts[0] + self.counts[1]


def is_worth_compiling(modes: Modes, drive: StraightDrive) -> bool:
    """Return whether the compiled pass is faster for so many modes and pieces."""
    many = modes.poles.size * drive.starts.size >= _WORTH
    return many and not np.iscomplexobj(modes.poles) and _kernel() is not None


def march_in_one_pass(
    modes: Modes,
    drive: StraightDrive,
    state: Real,
    output: Sequence[Real],
    passed: list[tuple[int, Real]] | None = None,
) -> Real:
    """Compute the response of relaxing modes to a drive with pieces of unequal duration, as `march_jittered` does.

    `state` (poles,), `output` (pieces + 1,); returns `final_state` (poles,).

    The states of an interval stay in the cache; the outputs are their product with the gains.
    """
    plan, pieces = _plan(modes, drive), drive.starts.size
    gains, level = _ordered(modes, plan)
    followed = _begun(plan, state, float(drive.starts[0]))
    table = np.empty((min(_AT_ONCE, pieces), len(plan.order)))
    for begin in range(0, pieces, _AT_ONCE):
        end = min(begin + _AT_ONCE, pieces)
        if passed is not None:
            passed.append((begin, _ended(plan, followed, float(drive.starts[begin]))))
        _follow(plan, drive, begin, end, followed, table[: end - begin])
        found = gains @ table[: end - begin].T
        for row, each, share in zip(output, found, level, strict=True):
            np.multiply(drive.starts[begin:end], share, out=row[begin:end])
            row[begin:end] += each
    for row, each in zip(output, gains @ followed + level * drive.ends[-1], strict=True):
        row[-1] = each
    return _ended(plan, followed, float(drive.ends[-1]))


def states_in_one_pass(modes: Modes, drive: StraightDrive, state: Real, places: Indices) -> Real:
    """Return the states at some points of a drive with pieces of unequal duration, as `jittered_states` does.

    `places` (n,); returns `states` (poles, n).

    Modes that decay within some hundred pieces are advanced only through the pieces shortly before a place.
    """
    plan, reached = _plan(modes, drive), 0
    followed, found = _begun(plan, state, float(drive.starts[0])), np.empty((len(plan.order), len(places)))
    parts = [(slice(0, _lasting(plan)), False), (slice(_lasting(plan), plan.slow), True)]
    parts += [(slice(plan.slow, len(plan.order)), True)]
    several = [
        (some, among, _remembered(some, drive, places) if forgets else None)
        for among, forgets in parts
        if len((some := _some(plan, among)).order)
    ]
    for column, place in enumerate(places.tolist()):
        for some, among, since in several:
            begin = reached if since is None else max(reached, since[column])
            if begin > reached:
                followed[among] = 0.0
            _follow(some, drive, begin, place, followed[among])
        found[:, column] = followed
        reached = place
    found[plan.slow :] += np.where(
        places < drive.starts.size, drive.starts[np.minimum(places, drive.starts.size - 1)], drive.ends[-1]
    )
    result = np.empty_like(found)
    result[plan.order] = found
    return result


def _plan(modes: Modes, drive: StraightDrive) -> _Plan:
    """Sort modes by their relaxation in the longest usual piece, and compute their polynomials."""
    longest = min(float(np.max(drive.steps)), _OUTLIER * float(np.mean(drive.steps)))
    fall = -modes.poles * longest
    kinds = np.searchsorted(_REACH, fall)
    order = np.argsort(fall, kind="stable")
    counts = tuple(np.bincount(kinds, minlength=4)[:3].tolist())
    rates = -modes.poles[order]
    first, second, third = np.split(rates, np.cumsum(counts))[:3]
    few, more = (
        _terms(each * longest, degree) for each, degree in zip((first, second), _DEGREES, strict=True)
    )
    times = longest / _TABLE * (np.arange(_TABLE) + 0.5)
    return _Plan(order, counts, rates, (few, more), np.exp(np.outer(times, -third)), longest)


def _lasting(plan: _Plan) -> int:
    """Return the number of modes whose states have not decayed after some hundred pieces."""
    return min(plan.slow, int(np.searchsorted(plan.rates * plan.longest, _SOON)))


def _some(plan: _Plan, among: slice) -> _Plan:
    """Return the plan for a range of the modes."""
    ends = np.concatenate([[0], np.cumsum(plan.counts)])
    inside = np.clip(ends, among.start, among.stop)
    begins = (inside - ends)[:-1]
    counts = np.diff(inside).tolist()
    few, more, decays = (
        np.ascontiguousarray(each[:, begin : begin + count])
        for each, begin, count in zip((*plan.terms, plan.decays), begins.tolist(), counts, strict=True)
    )
    return _Plan(plan.order[among], tuple(counts), plan.rates[among], (few, more), decays, plan.longest)


def _terms(falls: Real, degree: int) -> Real:
    """Return (1 - mean)/fall for a share of these falls as coefficients of powers of 2 share - 1, (degree + 1, modes)."""
    nodes = np.polynomial.chebyshev.chebpts1(degree + 1)
    fall = np.multiply.outer((1 + nodes) / 2, falls)
    later = np.zeros_like(fall)
    for order in range(19, 1, -1):  # 1/2! - fall/3! + ...
        later = (1 - fall * later) / order
    to_chebyshev, to_powers = _rule(degree)
    return np.ascontiguousarray(to_powers @ (to_chebyshev @ later))


@functools.cache
def _rule(degree: int) -> tuple[Real, Real]:
    """Return the matrices from nodal values to Chebyshev coefficients and from these to powers; one would lose digits."""
    count = degree + 1
    angles = np.arccos(np.polynomial.chebyshev.chebpts1(count))
    to_chebyshev: Real = 2 / count * np.cos(np.outer(np.arange(count), angles))
    to_chebyshev[0] /= 2
    rows = [np.polynomial.chebyshev.cheb2poly(row) for row in np.eye(count)]
    to_powers = np.stack([np.pad(row, (0, count - len(row))) for row in rows], axis=1)
    return np.asarray(to_chebyshev), np.asarray(to_powers, float)


def _ordered(modes: Modes, plan: _Plan) -> tuple[Real, Real]:
    """Return the gains in the order of the plan, and the direct share of the drive in each output."""
    gains = np.ascontiguousarray(modes.gains[:, plan.order])
    slow, quick = gains[:, : plan.slow].sum(axis=1), gains[:, plan.slow :].sum(axis=1)
    return gains, modes.direct + np.where(modes.lag, -slow, quick)


def _begun(plan: _Plan, state: Real, level: float) -> Real:
    """Return states and lags at the first point, in the order of the plan."""
    followed = np.array(state[plan.order])
    followed[plan.slow :] -= level
    return followed


def _ended(plan: _Plan, followed: Real, level: float) -> Real:
    """Return the states of all modes from states and lags at the last point."""
    state = np.empty_like(followed)
    state[plan.order] = followed
    state[plan.order[plan.slow :]] += level
    return state


def _remembered(some: _Plan, drive: StraightDrive, places: Indices) -> list[int]:
    """Return, for each place, the first piece that still affects the states of the modes there."""
    times = np.concatenate([[0.0], np.cumsum(drive.steps)])
    longest = _FORGOTTEN / float(np.min(some.rates))
    found: list[int] = np.maximum(np.searchsorted(times, times[places] - longest) - 1, 0).tolist()
    return found


def _follow(
    plan: _Plan, drive: StraightDrive, begin: int, end: int, followed: Real, table: Real | None = None
) -> None:
    """Advance states and lags through some pieces, and write those before each piece into the table."""
    kernel = _kernel()
    assert kernel is not None
    following = drive.starts[end] if end < drive.starts.size else drive.ends[-1]
    some = drive.starts[begin:end], drive.ends[begin:end], drive.steps[begin:end]
    table = np.empty((0, len(followed))) if table is None else table
    kernel(
        plan.rates,
        plan.counts,
        *plan.terms,
        plan.decays,
        plan.longest,
        *some,
        float(following),
        followed,
        table,
    )


@functools.cache
def _kernel() -> Any:
    """Return the compiled pass; None where numba is not installed."""
    try:
        from electrovib.solve.recursion.compiled import follow
    except ImportError:
        return None
    return follow
