"""The recursion at unequal time stamps, exact and without a loop over samples."""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from electrovib.solve.recursion.blocks import PRODUCT
from electrovib.solve.recursion.hold import hold_weights, weights_of
from electrovib.solve.recursion.one_pass import is_worth_compiling, march_in_one_pass, states_in_one_pass
from electrovib.solve.recursion.record import StraightDrive
from electrovib.solve.recursion.scan import fold_length, states_before

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from electrovib.core.arrays import Indices, Numbers, Real
    from electrovib.solve.recursion.record import Modes

_HELD = 1 << 19  # modes times pieces in memory together: fewer need more calls, more need more memory
_SLOW = ((0.0, 0.03), (0.03, 1.0))  # ranges of rate times longest step, the lower end excluded
_DEGREE = (6, 13)  # degree of the polynomials in the step that are exact to rounding there
_GRADED = 1e-4  # shortest piece over the longest
_FEW = 16  # pieces per place from which the compiled pass stops at every place


class _Family(NamedTuple):
    """Modes that are advanced by the same method.

    Parameters
    ----------
    chosen : ndarray of int
        Indices among all modes.
    degree : int
        Degree of the polynomials in the step for their weights; 0 for exponentials of each step.
    lag : bool
        Whether the lag ``x - v`` is advanced.
    """

    chosen: Indices
    degree: int
    lag: bool


def march_jittered(
    modes: Modes,
    drive: StraightDrive,
    state: Numbers,
    keep: int,
    output: Sequence[Real],
    passed: list[tuple[int, Real]] | None = None,
) -> Numbers:
    """Compute the response of relaxing modes to a drive with pieces of unequal duration.

    `state` (poles,), `output` (pieces // keep + 1,); returns `final_state` (poles,).

    All outputs are sums over the same states. The weights of a mode that relaxes little in the longest step of an
    interval are polynomials in the step, summed as one matrix product; of a mode that relaxes within a step the lag
    ``x - v`` is advanced, which needs its exponential alone.
    """
    if keep == 1 and not _is_graded(drive) and is_worth_compiling(modes, drive):
        return march_in_one_pass(modes, drive, np.asarray(state, float), output, passed)
    pieces = drive.starts.size
    state = state.copy()
    for begin, drove, following in _chunks(modes, drive):
        found = _outputs(modes, drove, following, state)[:, -begin % keep :: keep]
        place = -(-begin // keep)
        for row, each in zip(output, found, strict=True):
            row[place : place + found.shape[1]] = each
    if pieces % keep == 0:
        last = np.where(modes.lag, (modes.gains @ (state - drive.ends[-1])).real, (modes.gains @ state).real)
        for row, each in zip(output, last + modes.direct * drive.ends[-1], strict=True):
            row[-1] = each
    return state


def jittered_states(modes: Modes, drive: StraightDrive, state: Numbers, places: Indices) -> Numbers:
    """Return the states at some points of a drive with pieces of unequal duration.

    `places` (n,); returns `states` (poles, n).
    """
    few = _FEW * len(places) <= drive.starts.size
    if few and not _is_graded(drive) and is_worth_compiling(modes, drive):
        return states_in_one_pass(modes, drive, np.asarray(state, float), places)
    found, state = np.empty((modes.poles.size, len(places)), state.dtype), state.copy()
    for begin, drove, following in _chunks(modes, drive):
        first, last = np.searchsorted(places, [begin, begin + drove.starts.size])
        inside = places[first:last] - begin
        for family, table in _followed(modes, drove, following, state):
            row, column = np.divmod(inside, len(table))
            level = drove.starts[inside] if family.lag else 0.0
            found[family.chosen, first:last] = table[column, row].T + level
    found[:, np.searchsorted(places, drive.starts.size) :] = state[:, np.newaxis]
    return found


def _chunks(modes: Modes, drive: StraightDrive) -> Iterator[tuple[int, StraightDrive, float]]:
    """Yield intervals of a drive, each with the index of its first piece and the drive after its end."""
    pieces, length = drive.starts.size, max(64, _HELD // max(1, modes.poles.size))
    for begin in range(0, pieces, length):
        end = min(begin + length, pieces)
        following = drive.starts[end] if end < pieces else drive.ends[-1]
        yield begin, StraightDrive(*(each[begin:end] for each in drive)), float(following)


def _outputs(modes: Modes, drive: StraightDrive, following: float, state: Numbers) -> Real:
    """Return the outputs before every piece of one interval, (outputs, pieces), and update the state to its end."""
    columns, rows = fold_length(drive.starts.size)
    total, level = np.zeros((columns * rows, modes.direct.size)), modes.direct.copy()
    for family, table in _followed(modes, drive, following, state):
        gains = modes.gains[:, family.chosen]
        modal = table.reshape(columns * rows, -1) @ gains.T
        total += modal.real
        level += (float(family.lag) - modes.lag) * gains.real.sum(axis=1)
    total += _fold(drive.starts, columns, rows).reshape(-1, 1) * level
    ordered = total.reshape(columns, rows, -1).transpose(2, 1, 0)
    return ordered.reshape(len(level), rows * columns)[:, : drive.starts.size]


def _followed(
    modes: Modes, drive: StraightDrive, following: float, state: Numbers
) -> Iterator[tuple[_Family, Numbers]]:
    """Yield, family by family, the states or lags before every piece, (columns, rows, modes)."""
    columns, rows = fold_length(drive.starts.size)
    folded = [_fold(each, columns, rows) for each in drive]
    spans = folded[2].sum(axis=0)
    for family in _families(modes, float(np.max(drive.steps)), graded=_is_graded(drive)):
        poles = modes.poles[family.chosen]
        decays, pushes = _weights(poles, family, folded)
        begins = state[family.chosen]
        if family.lag:
            _drop(pushes, drive, following, columns, rows)
            begins = begins - drive.starts[0]
        table = pushes.reshape(columns, rows, len(poles))
        after = states_before(
            table, decays.reshape(table.shape), np.exp(spans[:, np.newaxis] * poles), begins
        )
        state[family.chosen] = after + following if family.lag else after
        yield family, table


def _is_graded(drive: StraightDrive) -> bool:
    """Return whether the steps extend over decades, as those of an adaptive solver.

    Such a drive may be very large for a short time, and the lag of a mode behind it is then rounded by the size of the
    drive.
    """
    lasting = drive.steps[drive.steps > 0]
    return bool(len(lasting)) and float(np.min(lasting)) < _GRADED * float(np.max(lasting))


def _families(modes: Modes, longest: float, *, graded: bool) -> list[_Family]:
    """Sort modes by how far they relax in the longest step."""
    if np.iscomplexobj(modes.poles):
        return [_Family(np.arange(modes.poles.size), 0, lag=False)]
    fall = -modes.poles * longest
    slow = [
        _Family(np.flatnonzero((fall > low) & (fall <= high)), degree, lag=False)
        for (low, high), degree in zip(_SLOW, _DEGREE, strict=True)
    ]
    found = [*slow, _Family(np.flatnonzero(fall > _SLOW[-1][1]), 0, lag=not graded)]
    return [family for family in found if len(family.chosen)]


def _weights(poles: Numbers, family: _Family, folded: list[Real]) -> tuple[Numbers, Numbers]:
    """Return the decay of the state in each piece, and the increment by the piece, (pieces, modes) each."""
    starts, ends, steps = (each.reshape(-1, 1) for each in folded)
    if family.degree:
        return _by_polynomials(poles, family.degree, starts, ends, steps)
    z = steps * poles
    if not family.lag:
        decays, first, last = weights_of(z)
        return decays, first * starts + last * ends
    share = np.ones_like(z)
    np.divide(np.expm1(z), z, out=share, where=z != 0)
    share *= starts - ends
    return np.exp(z, out=z), share


def _by_polynomials(
    poles: Numbers, degree: int, starts: Real, ends: Real, steps: Real
) -> tuple[Numbers, Numbers]:
    """Return decays and increments of slow modes from Chebyshev polynomials in the step, from 0 to the longest.

    The polynomials represent the increment over step times pole, which keeps its digits however short the step is.
    """
    longest = float(np.max(steps))
    nodes, to_coefficients = _rule(degree)
    z = np.multiply.outer(longest * (1 + nodes) / 2, poles)
    decay, first, last = hold_weights(z)
    decaying = to_coefficients @ decay
    pushing = np.concatenate([to_coefficients @ (first / z), to_coefficients @ (last / z)])
    powers = np.polynomial.chebyshev.chebvander(2 / longest * steps[:, 0] - 1, degree)
    decays, pushes = np.empty((len(steps), len(poles))), np.empty((len(steps), len(poles)))
    height = max(1, PRODUCT // pushing.size)
    for begin in range(0, len(steps), height):
        tile = slice(begin, begin + height)
        np.matmul(powers[tile], decaying, out=decays[tile])
        np.matmul(
            np.hstack([powers[tile] * starts[tile], powers[tile] * ends[tile]]), pushing, out=pushes[tile]
        )
        pushes[tile] *= steps[tile] * poles
    return decays, pushes


@functools.cache
def _rule(degree: int) -> tuple[Real, Real]:
    """Return nodes between -1 and 1, and the matrix from values there to Chebyshev coefficients."""
    nodes = np.polynomial.chebyshev.chebpts1(degree + 1)
    return nodes, np.asarray(np.linalg.inv(np.polynomial.chebyshev.chebvander(nodes, degree)))


def _drop(pushes: Numbers, drive: StraightDrive, following: float, columns: int, rows: int) -> None:
    """Subtract the discontinuities of the drive after each piece from the lags, if there are any."""
    jumps = np.append(drive.starts[1:], following) - drive.ends
    if np.any(jumps):
        pushes -= _fold(jumps, columns, rows).reshape(-1, 1)


def _fold(samples: Real, columns: int, rows: int) -> Real:
    """Return samples row by row in an array (columns, rows), padded with pieces of no duration."""
    padded = np.zeros(rows * columns)
    padded[: samples.size] = samples
    return np.ascontiguousarray(padded.reshape(rows, columns).T)
