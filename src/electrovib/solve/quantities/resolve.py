"""Signals of a solution as polynomials, so that its quantities are independent of the evaluation times."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.physics.drive.parts import Tones
from electrovib.scenario.grids import FORMULA_SAMPLES
from electrovib.solve.expanded import Expanded
from electrovib.solve.quantities.pieces import MOST_NODES, Mesh, tails

if TYPE_CHECKING:
    from collections.abc import Iterable

    from electrovib.core.arrays import Real
    from electrovib.scenario import Scenario
    from electrovib.solve.expanded import Record

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
        return missed(self.mesh, self.series[key])


def missed(mesh: Mesh, series: Real) -> float:
    """Return the estimated error of a signal's mean, from the last coefficients of its pieces.

    `series` (pieces, nodes).
    """
    largest = float(np.max(np.abs(series).sum(axis=1)))
    off = float(mesh.lengths @ tails(series)) / mesh.span
    return off / largest if largest else off


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
            mesh = _with_kinks(mesh, np.array(record.solution.kinks), _fastest_rate(expanded))
            record = expanded.at(mesh.times(), wanted=signals)
        series = {key: mesh.series(values_of(record, expanded, key)) for key in keys}
        most = MOST_ROUNDS if not record.solution.method.is_marched else MARCHED_ROUNDS
        tail = _relative_tails(series)
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


def _relative_tails(series: dict[tuple[str, str], Real]) -> Real:
    """Return the largest tail of each piece among the signals, over their largest values; NaN counts as resolved."""
    found: Any = 0.0
    for each in series.values():
        finite = np.all(np.isfinite(each), axis=1)
        sizes = np.abs(each[finite]).sum(axis=1)
        scale = float(np.max(sizes, initial=0.0)) or 1.0
        found = np.maximum(found, np.where(finite, tails(np.where(finite[:, None], each, 0.0)) / scale, 0.0))
    return np.asarray(found)


def _parents(mesh: Mesh, before: dict[float, float]) -> Real:
    """Return the tail of the piece from which each one was halved; infinite in the first round."""
    if not before:
        return np.full(len(mesh.lengths), np.inf)
    starts = np.array(sorted(before))
    places = np.searchsorted(starts, mesh.edges[:-1], side="right") - 1
    return np.array([before[start] for start in starts[places].tolist()])


def first_mesh(expanded: Expanded, member: Scenario | None = None) -> Mesh:
    """Return the initial pieces: between corners, fractions of a cycle, graded after each corner."""
    scenario = member or expanded.scenario
    end = window(scenario)[0]
    corners = _corners(scenario, end)
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
        rate = max(_fastest_rate(expanded), 1 / end)
        edges += [
            start + _graded(length, rate)
            for start, length in zip(corners[:-1].tolist(), np.diff(corners).tolist(), strict=True)
        ]
    apart = _apart(np.concatenate(edges), end)
    nodes = MOST_NODES
    while nodes > 4 and len(apart) * (nodes + 1) > MOST_VALUES // 2:
        nodes //= 2
    return Mesh(np.append(apart[:-1], end), nodes)


def _fastest_rate(expanded: Expanded) -> float:
    """Return the fastest rate of the stack [1/s]; 0 without modes."""
    return float(np.max(expanded.section.modes.rates, initial=0.0))


def _apart(times: Real, end: float) -> Real:
    """Sort times, and omit those that differ from the one before by rounding only [s]."""
    merged = np.unique(times)
    return np.asarray(merged[np.diff(merged, prepend=-np.inf) > 64 * np.finfo(float).eps * end])


def _with_kinks(mesh: Mesh, kinks: Real, rate: float) -> Mesh:
    """Add times at which a limited amplifier changes between its regimes, each followed by graded pieces if they are few."""
    first, end = float(mesh.edges[0]), float(mesh.edges[-1])
    inside = kinks[(kinks > first) & (kinks < end)]
    edges = np.union1d(mesh.edges, inside)
    if rate and len(inside) <= FEW_CORNERS:
        lengths = edges[np.searchsorted(edges, inside, side="right")] - inside
        graded = [
            start + _graded(length, rate)
            for start, length in zip(inside.tolist(), lengths.tolist(), strict=True)
        ]
        edges = np.concatenate([edges, *graded])
    apart = _apart(edges, end)
    if len(apart) * (mesh.nodes + 1) > MOST_VALUES:
        return mesh
    return Mesh(np.append(apart[:-1], end), mesh.nodes)


def _graded(length: float, rate: float) -> Real:
    """Return times after a corner that grow from the shortest time constant to the next corner [s]."""
    count = 1 + int(np.ceil(np.log(max(length * rate, 1.0)) / np.log(GRADING)))
    return np.asarray(length * GRADING ** -np.arange(1.0, count + 1))


def _corners(scenario: Scenario, end: float) -> Real:
    """Return the times from 0 to the end at which drive, load, speed or distance is not smooth [s]."""
    found = [0.0, end, *(time for time, _ in scenario.load.time_profile.corners())]
    found += [time for time, _ in scenario.motion.time_profile.corners()]
    found += scenario.motion.distance.breaks() if scenario.motion.distance else ()
    times = np.unique(np.concatenate([found, scenario.drive.corners(end)[0]]))
    return np.asarray(times[(times >= 0) & (times <= end)])
