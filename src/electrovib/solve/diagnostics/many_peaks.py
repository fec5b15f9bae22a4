"""Largest values of many solutions at once, by the method of `PeakRecord` and `refined` in arrays over all cases."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from electrovib.solve.diagnostics.peaks import AT_A_CORNER, CLEAR, DIVISIONS, REFINEMENTS, ROUNDED, PeakRecord

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from electrovib.core.arrays import Indices, Real
    from electrovib.solve.stack.keys import Key


def many_peaks(
    times: Real, rows: dict[Key, Real], look: Callable[[Indices, Real], dict[Key, Real]]
) -> list[PeakRecord]:
    """Return the largest values of every quantity in every case, refined where their neighbours do not resolve them.

    `times` (cases, n) [s].
    """
    names = list(rows)
    values = np.array([rows[name] for name in names])
    for _ in range(REFINEMENTS):
        height, place, drop = _peaks(times, values)
        wanted = [
            _around(times, place[:, case], drop[:, case] > CLEAR * height[:, case], case)
            for case in range(len(times))
        ]
        counts = np.array([len(each) for each in wanted])
        if not np.any(counts):
            break
        cases = np.repeat(np.arange(len(times)), counts)
        found = look(cases, np.concatenate(wanted))
        more = np.array([found[name] for name in names])
        times, values = _joined(times, values, wanted, more)
    height, place, drop = _peaks(times, values)
    records = []
    for case, moments in enumerate(times):
        known = np.isfinite(moments)
        record = PeakRecord(
            moments[known], {name: row[case, known] for name, row in zip(names, values, strict=True)}
        )
        parabolas = zip(
            height[:, case].tolist(), place[:, case].tolist(), drop[:, case].tolist(), strict=True
        )
        records.append(record.knowing(dict(zip(names, parabolas, strict=True))))
    return records


def _around(times: Real, place: Indices, unclear: NDArray[np.bool_], case: int) -> Real:
    """Return new times around the largest values of a case that a parabola does not resolve [s]."""
    if not np.any(unclear):
        return np.zeros(0)
    moments = times[case]
    left, right = _neighbours(moments[None], place[None, unclear])
    found = np.linspace(moments[left[0]], moments[right[0]], DIVISIONS + 1)
    return np.setdiff1d(found, moments)


def _joined(times: Real, values: Real, wanted: list[Real], more: Real) -> tuple[Real, Real]:
    """Add times and values to every case; cases with fewer times are padded with infinite times and values of 0."""
    longest = max(len(each) for each in wanted)
    moments = np.full((len(times), longest), np.inf)
    rows = np.zeros((*values.shape[:2], longest))
    first = 0
    for case, each in enumerate(wanted):
        moments[case, : len(each)] = each
        rows[:, case, : len(each)] = more[:, first : first + len(each)]
        first += len(each)
    whole = np.concatenate([times, moments], axis=1)
    order = np.argsort(whole, axis=1, kind="stable")
    both = np.concatenate([values, rows], axis=2)
    return np.take_along_axis(whole, order, axis=1), np.take_along_axis(both, order[None], axis=2)


def _neighbours(times: Real, place: Indices) -> tuple[Indices, Indices]:
    """Return the indices of the times before and after some, apart from rounding; shapes (cases, n), (cases, k)."""
    last = np.max(np.where(np.isfinite(times), times, 0.0), axis=1)[:, None]
    here = np.take_along_axis(times, place, axis=1)
    left = np.sum(times[:, None] < (here - ROUNDED * last)[..., None], axis=2) - 1
    return left, np.sum(times[:, None] <= (here + ROUNDED * last)[..., None], axis=2)


def _peaks(times: Real, values: Real) -> tuple[Real, Indices, Real]:
    """Return largest absolute value, its index, and the drop of its neighbours; each of shape (quantities, cases)."""
    size = np.abs(values)
    finite = np.isfinite(size)
    place = np.argmax(np.where(finite, size, -1.0), axis=2)
    left, right = (each.T for each in _neighbours(times, place.T))
    known = np.sum(np.isfinite(times), axis=1)

    def at(found: Indices) -> Real:
        return np.take_along_axis(size, found[..., None], axis=2)[..., 0]

    def when(found: Indices) -> Real:
        return np.take_along_axis(times, found.T, axis=1).T

    inside = (left >= 0) & (right < known)
    left, right = np.where(inside, left, place), np.where(inside, right, place)
    value = at(place)
    before, after = when(place) - when(left), when(right) - when(place)
    first, last = value - at(left), value - at(right)
    inside &= np.minimum(before, after) >= AT_A_CORNER * np.maximum(before, after)
    inside &= np.minimum(first, last) >= 0
    before, after = np.where(inside, before, 1.0), np.where(inside, after, 1.0)
    bend = np.where(inside, first / before + last / after, 0.0)
    inside &= bend > 0
    tilt = (first * after / before - last * before / after) / (before + after)
    above = tilt**2 * (before + after) / (4 * np.where(inside, bend, 1.0))
    drop = np.where(inside, np.maximum(first, last), 0.0)
    return value + np.where(inside, np.minimum(above, drop / 2), 0.0), place, drop
