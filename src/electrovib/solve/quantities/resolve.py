"""Signals of a solution as polynomials on pieces of time, so that its quantities do not depend on evaluation times.

Mean, square and extremes of the polynomials are exact. Arrays may have an axis of cases before that of the pieces.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.physics.drive.parts import Tones
from electrovib.scenario.grids import FORMULA_SAMPLES
from electrovib.solve.electrics.fading import chebyshev_rule
from electrovib.solve.expanded import Expanded

if TYPE_CHECKING:
    from collections.abc import Iterable

    from numpy.typing import NDArray

    from electrovib.core.arrays import Real
    from electrovib.scenario import Scenario
    from electrovib.solve.expanded import Record

MOST_NODES: Final = 16
"""Chebyshev nodes in a piece, unless there are very many pieces."""
_BEST_PIECES: Final = 4
_NEWTON_STEPS: Final = 4
_LAST: Final = 3
"""Coefficients at the end of a series that measure its resolution: even and odd ones among them."""
TOLERANCE: Final = 1e-10
"""Last coefficients of a piece over the signal's largest value, below which the piece counts as resolved."""
PIECES_PER_CYCLE: Final = 5
"""Pieces in a cycle of the fastest sine of the drive; the force has two cycles in that time."""
GRADING: Final = 2.0
"""Ratio of neighbouring pieces after a corner, down to the fastest rate of the stack."""
FEW_CORNERS: Final = 200
"""Number of corners of a drive up to which each is followed by graded pieces."""
MOST_VALUES: Final = 1 << 19
"""Largest number of evaluation times."""
MOST_ROUNDS: Final = 40
"""Largest number of rounds of halving."""
MARCHED_ROUNDS: Final = 4
"""The same for a time-stepping solver, which solves the scenario again in every round."""
_STALLED: Final = 1e-6
"""Tail below which a piece whose halves are no better resolved is limited by rounding or by the time stepping."""


@dataclass(frozen=True)
class Mesh:
    """Pieces of time with Chebyshev nodes inside, so that a discontinuity at an end belongs to neither side.

    Parameters
    ----------
    edges : ndarray, shape (..., pieces + 1)
        Ends of the pieces [s], increasing.
    nodes : int
        Number of nodes in each piece.
    """

    edges: Real
    nodes: int = MOST_NODES

    @property
    def lengths(self) -> Real:
        """Duration of each piece [s]."""
        return np.diff(self.edges)

    def times(self) -> Real:
        """Return all edges and nodes [s], increasing: a piece's first edge, its nodes, and last the end."""
        inside = (1 + chebyshev_rule(self.nodes - 1)[0]) / 2
        rows = self.edges[..., :-1, None] + self.lengths[..., None] * np.append(0.0, inside)
        return np.concatenate([rows.reshape(*rows.shape[:-2], -1), self.edges[..., -1:]], axis=-1)

    def mean(self, values: Real) -> Real:
        """Return the mean over time of what is constant in each piece (..., pieces)."""
        span = self.edges[..., -1] - self.edges[..., 0]
        return np.asarray(np.sum(self.lengths * values, axis=-1) / span)

    def series(self, values: Real) -> Real:
        """Return the Chebyshev coefficients of a signal in each piece.

        `values` (..., n); returns `coefficients` (..., pieces, nodes).
        """
        inside = values[..., :-1].reshape(*values.shape[:-1], -1, self.nodes + 1)[..., 1:]
        coefficients: Real = inside @ chebyshev_rule(self.nodes - 1)[1].T
        return coefficients

    def halved(self, chosen: NDArray[np.bool_]) -> Mesh:
        """Halve the pieces that are chosen, one mark for each."""
        middles = (self.edges[:-1] + self.edges[1:])[chosen] / 2
        return Mesh(np.union1d(self.edges, middles), self.nodes)


def tails(series: Real) -> Real:
    """Return the size of the last coefficients, an estimate of the truncation error of the polynomials.

    `series` (..., pieces, nodes); returns `sizes` (..., pieces).
    """
    sizes = np.abs(series)
    few = series.shape[-1] <= 2 * _LAST  # for so few nodes the last but one is not small yet
    return np.asarray(sizes[..., -1] if few else np.max(sizes[..., -_LAST:], axis=-1))


def relative_tails(series: Real) -> Real:
    """Return the tails over the largest value of the signal, shape (..., pieces); a piece with NaN counts as resolved."""
    known = np.where(np.isfinite(series).all(axis=-1, keepdims=True), series, 0.0)
    scale = np.max(np.abs(known).sum(axis=-1), axis=-1, keepdims=True)
    return np.asarray(tails(known) / np.where(scale > 0, scale, 1.0))


def missed(mesh: Mesh, series: Real) -> Real:
    """Return the estimated error of a signal's mean over its largest value (...) [1], from the last coefficients."""
    largest = np.max(np.abs(series).sum(axis=-1), axis=-1)
    return np.asarray(mesh.mean(tails(series)) / np.where(largest == 0, 1.0, largest))


def mean(mesh: Mesh, series: Real) -> Real:
    """Return the mean over the pieces (...)."""
    return mesh.mean(series @ _integrals(series.shape[-1]) / 2)


def mean_square(mesh: Mesh, series: Real) -> Real:
    """Return the mean of the square over the pieces (...)."""
    return mesh.mean(np.sum((series @ _products(series.shape[-1])) * series, axis=-1) / 2)


def taken_from(taken: str, mesh: Mesh, series: Real) -> Real:
    """Return a quantity (...) from the polynomials of a signal."""
    if taken == "mean":
        return mean(mesh, series)
    if taken == "rms":
        return np.asarray(np.sqrt(np.maximum(mean_square(mesh, series), 0.0)))
    if taken == "final":
        return last_value(series)
    return of_extremes(taken, *extremes(series))


def last_value(series: Real) -> Real:
    """Return the value (...) at the end of the last piece, before a discontinuity at that time."""
    return np.asarray(np.sum(series[..., -1, :], axis=-1))


def of_extremes(taken: str, low: Any, high: Any) -> Real:
    """Return a quantity that follows from the smallest and the largest value."""
    found = {"peak": np.maximum(abs(low), abs(high)), "maximum": high, "minimum": low, "swing": high - low}
    return np.asarray(found[taken])


def extremes(series: Real) -> tuple[Real, Real]:
    """Return the smallest and the largest value (...) over the pieces, with both sides of every discontinuity."""
    known = np.asarray(np.isfinite(series).all(axis=(-2, -1)))
    rows = np.where(known[..., None, None], series, 0.0)
    return np.where(known, -_largest(-rows), np.nan), np.where(known, _largest(rows), np.nan)


def _largest(series: Real) -> Real:
    """Return the largest value (...), from close points and the zero of the derivative in the best pieces."""
    degree = series.shape[-1]
    angles, values = _close_points(degree)
    seen = series @ values.T
    tops = np.max(seen, axis=-1)
    best = np.argsort(tops, axis=-1)[..., -_BEST_PIECES:, None]
    rows = np.take_along_axis(series, best, axis=-2)
    angle = angles[np.argmax(np.take_along_axis(seen, best, axis=-2), axis=-1)]
    orders = np.arange(degree)
    for _ in range(_NEWTON_STEPS):  # on sum c cos(k angle), whose derivatives are sums of the same kind
        turned = angle[..., None] * orders
        slope = np.sum(rows * orders * np.sin(turned), axis=-1)
        bend = np.sum(rows * orders**2 * np.cos(turned), axis=-1)
        step = np.divide(slope, bend, out=np.zeros_like(slope), where=bend > 0)
        angle = np.clip(angle - np.clip(step, -angles[1], angles[1]), 0.0, np.pi)
    refined = np.sum(rows * _polynomials(angle, degree), axis=-1)
    return np.asarray(np.maximum(np.max(tops, axis=-1), np.max(refined, axis=-1)))


@functools.cache
def _close_points(degree: int) -> tuple[Real, Real]:
    """Return closely spaced angles from 0 to pi, and all polynomials there."""
    angles = np.pi * np.arange(4 * degree + 1) / (4 * degree)
    return angles, _polynomials(angles, degree)


def _polynomials(angles: Real, degree: int) -> Real:
    """Return the Chebyshev polynomials of cos(angle), shape (..., degree)."""
    return np.asarray(np.cos(angles[..., None] * np.arange(degree)))


@functools.cache
def _integrals(nodes: int) -> Real:
    """Return the integral of every Chebyshev polynomial from -1 to 1."""
    orders = np.arange(nodes)
    even = np.where(orders % 2 == 0, orders, 0)
    return np.asarray(np.where(orders % 2 == 0, 2 / (1.0 - even**2), 0.0))


@functools.cache
def _products(nodes: int) -> Real:
    """Return the integral of every product of two Chebyshev polynomials from -1 to 1."""
    whole, orders = _integrals(2 * nodes), np.arange(nodes)
    sums, differences = orders[:, None] + orders, np.abs(orders[:, None] - orders)
    return np.asarray((whole[sums] + whole[differences]) / 2)


@dataclass(frozen=True)
class Resolved:
    """Signals as polynomials over the time window of the quantities.

    Parameters
    ----------
    mesh : Mesh
        Pieces of time.
    record : Record
        Solution at the times of the mesh.
    series : dict of str to ndarray, shape (pieces, nodes)
        Chebyshev coefficients by requested key, in the unit of the signal.
    """

    mesh: Mesh
    record: Record
    series: dict[tuple[str, str], Real]

    def error(self, key: tuple[str, str]) -> float:
        """Return the error of a signal's mean over its largest value [1]; NaN where the signal is NaN."""
        return float(missed(self.mesh, self.series[key]))


def window(scenario: Scenario) -> tuple[float, str]:
    """Return the time window of the quantities."""
    period = scenario.drive.period
    if scenario.time.settled and period is not None:
        return period, "one period of the periodic state"
    end = scenario.time.duration or scenario.drive.duration
    return end, "the whole time from rest" if period else "the whole time"


def times_of_window(scenario: Scenario) -> Real:
    """Return times whose span and step determine the band over which materials are reduced [s]."""
    return np.linspace(0.0, window(scenario)[0], FORMULA_SAMPLES)


def solved(scenario: Scenario, *, before: Expanded | None = None, mechanics: bool = True) -> Expanded:
    """Prepare a scenario for quantities, with the band of its materials from the time window, not from output times."""
    return Expanded(scenario, times_of_window(scenario), before=before, mechanics=mechanics)


def resolve(expanded: Expanded, wanted: Iterable[tuple[str, str]], *, alone: bool = False) -> Resolved:
    """Evaluate a scenario at times that resolve the requested signals."""
    keys = list(dict.fromkeys(wanted))
    signals = {signal for signal, _ in keys} if alone else None
    mesh = first_mesh(expanded)
    before: dict[float, float] = {}
    for round_ in range(MOST_ROUNDS + 1):
        record = expanded.at(mesh.times(), wanted=signals)
        if not round_ and record.solution.kinks:
            mesh = first_mesh(expanded, record.solution.kinks)
            record = expanded.at(mesh.times(), wanted=signals)
        series = {key: mesh.series(values_of(record, expanded, key)) for key in keys}
        most = MOST_ROUNDS if not record.solution.method.is_marched else MARCHED_ROUNDS
        tail = np.max([0.0 * mesh.lengths, *map(relative_tails, series.values())], axis=0)
        stalled = (tail < _STALLED) & (tail > 0.5 * _parents(mesh, before))
        marched = max(record.how.get(name, 0.0) for name in ("step_error", "mechanics_error"))
        open_ = (tail > max(TOLERANCE, marched)) & ~stalled
        room = MOST_VALUES - len(mesh.edges) * (mesh.nodes + 1)
        if not np.any(open_) or round_ == most or np.count_nonzero(open_) * (mesh.nodes + 1) > room:
            break
        before = dict(zip(mesh.edges[:-1].tolist(), tail.tolist(), strict=True))
        mesh = mesh.halved(open_)
    return Resolved(mesh, record, series)


def values_of(record: Record, expanded: Expanded, key: tuple[str, str]) -> Real:
    """Return one signal of a record, of one layer where each layer has it."""
    name, layer = key
    dims, values = record.signals[name]
    row: Any = values[list(expanded.section.names).index(layer)] if "layer" in dims else values
    return np.asarray(row)


def _parents(mesh: Mesh, before: dict[float, float]) -> Real:
    """Return the tail of the piece from which each one was halved; infinite in the first round."""
    if not before:
        return np.full(len(mesh.lengths), np.inf)
    starts = np.array(sorted(before))
    places = np.searchsorted(starts, mesh.edges[:-1], side="right") - 1
    return np.array([before[start] for start in starts[places].tolist()])


def first_mesh(expanded: Expanded, kinks: tuple[float, ...] = ()) -> Mesh:
    """Return the initial pieces: between corners and kinks [s], fractions of a cycle, graded after each of them."""
    scenario = expanded.scenario
    end = window(scenario)[0]
    corners = _corners(scenario, end, kinks)
    fastest = scenario.drive.highest_frequency
    if (moved := scenario.motion.moved_gap) is not None:
        fastest = max(fastest, moved.fastest)
    count = min(int(np.ceil(end * fastest * PIECES_PER_CYCLE)), MOST_VALUES // (2 * MOST_NODES))
    even = np.linspace(0.0, end, max(2, count + 1))
    # sines in their periodic state are smooth at all times
    bends = not (scenario.time.settled and all(isinstance(part, Tones) for part in scenario.drive.parts()))
    if not bends and len(corners) == 2 and len(even) * (MOST_NODES + 1) <= MOST_VALUES // 2:
        return Mesh(even)
    edges = [corners, even]
    if len(corners) <= FEW_CORNERS and bends:
        rate = float(np.max(expanded.section.modes.rates, initial=1 / end))
        edges += [
            start + _graded(length, rate)
            for start, length in zip(corners[:-1].tolist(), np.diff(corners).tolist(), strict=True)
        ]
    apart = _apart(np.concatenate(edges), end)
    nodes = MOST_NODES
    while nodes > 4 and len(apart) * (nodes + 1) > MOST_VALUES // 2:
        nodes //= 2
    return Mesh(np.append(apart[:-1], end), nodes)


def _apart(times: Real, end: float) -> Real:
    """Sort times, and omit those that differ from the one before by rounding only [s]."""
    merged = np.unique(times)
    return np.asarray(merged[np.diff(merged, prepend=-np.inf) > 64 * np.finfo(float).eps * end])


def _graded(length: float, rate: float) -> Real:
    """Return times after a corner that grow from the shortest time constant to the next corner [s]."""
    count = 1 + int(np.ceil(np.log(max(length * rate, 1.0)) / np.log(GRADING)))
    return np.asarray(length * GRADING ** -np.arange(1.0, count + 1))


def _corners(scenario: Scenario, end: float, kinks: tuple[float, ...]) -> Real:
    """Return the times from 0 to the end at which drive, load, speed, distance or amplifier is not smooth [s]."""
    found = [0.0, end, *kinks, *(time for time, _ in scenario.load.time_profile.corners())]
    found += [time for time, _ in scenario.motion.time_profile.corners()]
    found += scenario.motion.distance.breaks() if scenario.motion.distance else ()
    times = np.unique(np.concatenate([found, scenario.drive.corners(end)[0]]))
    return np.asarray(times[(times >= 0) & (times <= end)])
