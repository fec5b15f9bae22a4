"""Linear response of a force law to evenly spaced samples of a drive, and its regularised inverse."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.errors import InputError
from electrovib.solve.electrics.attraction import attraction, total_pull
from electrovib.solve.stack.keys import AmplitudeOf

if TYPE_CHECKING:
    from electrovib.core.arrays import Indices, Real
    from electrovib.study.design.drive.played import Played

_SMOOTH: Final = 1e-7
"""Weight of the second differences of the voltage over that of the amplitude of the force; a choice."""
_BESIDE: Final = 1e-3
"""Distance from a kink at which the current on either side of it is evaluated, over the interval."""


@dataclass(frozen=True, kw_only=True)
class SampleResponse:
    """Linear response to the samples of a drive in the window of the target, its ramps of `lead` intervals included.

    - `spread`, shape (samples, unknowns): all samples from those in the window.
    - `knots`, `middles`, shapes (intervals + 1, unknowns) and (intervals, unknowns): amplitude of the force
      law at the samples of the window and between them, in its unit per volt.
    - `currents`, `body_currents`: of amplifier and finger on both sides of all samples [A/V].
    - `per_square`: force over the squared amplitude.
    """

    lead: int
    spread: Real
    knots: Real
    middles: Real
    currents: Real
    body_currents: Real
    per_square: float


def sample_response(played: Played, count: int, lead: int) -> SampleResponse:
    """Return the linear response to the samples in a window of `count` intervals, from the response to one hat."""
    total = count + 2 * lead
    hat = np.zeros(total + 1)
    hat[1] = 1.0
    beside = _BESIDE / played.rate
    times = np.unique(
        np.concatenate(
            [played.halves(total + 1), (times := played.times(total + 1))[1:] - beside, times[:-1] + beside]
        )
    )
    record = played.expanded(hat).at(times)
    amplitudes = {key: row for key, row in record.solution.found.items() if isinstance(key, AmplitudeOf)}
    if len(amplitudes) != 1:
        law = type(played.base.force).__name__
        raise InputError(
            f"{law} has {len(amplitudes)} amplitudes, and method 'dc' inverts one; use a law with the field in the gap, or"
            " method 'carrier'"
        )
    (key, row), found = next(iter(amplitudes.items())), record.solution.found
    per_square = float(attraction(played.base, total_pull(played.base, {key.name: np.array([1.0])}))[0])
    spread = _spread(count, lead)
    at = np.searchsorted(times, played.halves(total + 1) - 1e-9 / played.rate)
    knots = _shifted(row[at[::2]], total) @ spread
    middles = _shifted(row[at[1::2]], total)[:total] @ spread
    window = slice(lead, lead + count + 1)
    amplified = found.get("amplifier_current", found["current"])
    return SampleResponse(
        lead=lead,
        spread=spread,
        knots=knots[window],
        middles=middles[lead : lead + count],
        currents=_on_both_sides(amplified, at, total) @ spread,
        body_currents=_on_both_sides(found["current"], at, total) @ spread,
        per_square=per_square,
    )


def _on_both_sides(row: Real, at: Indices, total: int) -> Real:
    """Return the matrix from all samples to a current before and after each sample."""
    before = np.append(0.0, row[at[2::2] - 1])
    after = np.append(row[at[:-1:2] + 1], 0.0)
    return np.concatenate([_shifted(before, total), _shifted(after, total)[:-1]])


def _shifted(row: Real, total: int) -> Real:
    """Return the matrix whose column i is the response to a hat at sample i, from that at sample 1; column 0 is 0."""
    from scipy.linalg import toeplitz

    first = np.zeros(total + 1)
    first[0] = row[0]
    matrix = np.zeros((len(row), total + 1))
    matrix[:, 1:] = toeplitz(row, first)[:, :total]
    return matrix


def _spread(count: int, lead: int) -> Real:
    """Return the matrix from the samples of the window to all samples, with straight ramps from and to 0 V."""
    spread = np.zeros((count + 2 * lead + 1, count + 1))
    ramp = np.arange(lead + 1) / lead
    spread[lead : lead + count + 1] = np.eye(count + 1)
    spread[: lead + 1, 0] = ramp
    spread[lead + count :, -1] = ramp[::-1]
    return spread


def inverse_of(response: SampleResponse) -> Real:
    """Return the regularised inverse of a response, from amplitudes at the samples to their voltages.

    The amplitude between two samples is to be the mean of both, so that no oscillation between them is free.
    """
    from scipy.linalg import cho_factor, cho_solve

    size = response.knots.shape[1]
    matrix = np.concatenate([response.knots, response.middles])
    halves = (np.eye(size)[:-1] + np.eye(size)[1:]) / 2
    weight = (_SMOOTH * float(np.max(np.abs(matrix)))) ** 2
    second = np.diff(np.eye(size), n=2, axis=0) if size > 2 else np.zeros((1, size))
    factor = cho_factor(matrix.T @ matrix + weight * (second.T @ second))
    return np.asarray(cho_solve(factor, matrix.T @ np.concatenate([np.eye(size), halves])))
