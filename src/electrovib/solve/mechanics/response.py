"""Response of linear mechanics and sensors to a force of any course in time, to a stated error: skin and readings of the rig."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from electrovib.core.diagnostics import Diagnostic
from electrovib.core.errors import InputError
from electrovib.core.units import format_quantity
from electrovib.solve.mechanics.filters import finite, march_through, of_stages
from electrovib.solve.meter import Meter

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from numpy.typing import ArrayLike, NDArray

    from electrovib.core.arrays import Indices, Real
    from electrovib.physics.finger import Finger
    from electrovib.physics.rig import Digitiser, Rig
    from electrovib.solve.mechanics.filters import Filter

    Response: TypeAlias = Callable[[Filter, Real], tuple[Real, float]]

FEWEST = 3000
"""Pieces of the first grid, whatever the times."""
PER_CHANGE = 4
"""Pieces of the first grid in the shortest time in which the force changes."""
GROWTH = 3
"""Power of a piece's index with which its end grows after a corner."""
SAME_TIME = 8 * float(np.finfo(float).eps)
"""Difference of times over the largest one, below which they count as equal."""
FAINT = 1e-9
"""Smallest scale of an output's error, over the largest possible output: smaller outputs are rounding."""
ROUNDING = 1e-13
"""Change by rounding alone, over the largest possible output."""
FORGOTTEN = 25.0
"""Time constants after which the response to a force counts as decayed: 1e-11 of it remains."""
MOST = 4_000_000
"""Pieces of the finest grid."""
PIECES = 100_000
"""Pieces of a first grid that are computed at once: more take memory, fewer take time for the preceding decay."""
EXTRAPOLATIONS = 2
"""Number of even powers of the length of a piece that extrapolation eliminates."""
TOGETHER = 64
"""Outputs in a group that is refined until all of them have converged."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Grid:
    """Knots between which a force is smooth, and the division of the stretches between them.

    Parameters
    ----------
    knots : ndarray, shape (n,)
        Output times and corners between them [s].
    wanted, corners : ndarray of int
        Indices of the knots that are output times, and of those that are corners.
    graded : ndarray of bool, shape (n - 1,)
        Whether a stretch begins with a corner, after which the force may decay quickly, so that its pieces grow.
    memory : float
        Time after which the response to a force has decayed [s].
    """

    knots: Real
    wanted: Indices
    corners: Indices
    graded: NDArray[np.bool_]
    memory: float = math.inf

    @classmethod
    def over(cls, stamps: Real, corners: Real, *, memory: float = math.inf) -> Grid:
        """Return the grid of output times and corners.

        `stamps` (n,) [s], `corners` (m,) [s].
        """
        inside = corners[(corners > stamps[0]) & (corners <= stamps[-1])]
        slack = SAME_TIME * max(abs(stamps[0]), abs(stamps[-1]))
        near = stamps[np.clip(np.searchsorted(stamps, inside - slack), 0, len(stamps) - 1)]
        inside = np.where(
            np.abs(near - inside) <= slack, near, inside
        )  # a corner at an output time, apart from rounding
        begins = (stamps - memory)[1:][np.diff(stamps) > 2 * memory]
        counts = ~_is_idle(inside, stamps, memory)
        inside = inside[counts]
        knots = np.union1d(np.union1d(stamps, inside), begins)
        graded = np.isin(knots[:-1], np.append(inside, corners[np.abs(corners - stamps[0]) <= slack]))
        return cls(
            knots=knots,
            wanted=np.searchsorted(knots, stamps),
            corners=np.unique(np.searchsorted(knots, inside)),
            graded=graded,
            memory=memory,
        )

    @property
    def is_point(self) -> bool:
        """Whether the grid is a single time."""
        return len(self.knots) == 1

    def counts(self, remaining: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Return which stretches affect some of the output times.

        `remaining` (wanted,); returns `affects` (knots - 1,).
        """
        if not np.any(remaining):
            return np.zeros(len(self.knots) - 1, bool)
        return ~_is_idle(self.knots[1:], self.knots[self.wanted[remaining]], self.memory)

    def density(self, *, shortest: float, most: int) -> float:
        """Return the density of pieces for FEWEST pieces in all and PER_CHANGE in the shortest change."""
        lengths = np.diff(self.knots)
        if 2 * len(lengths) > most:
            raise InputError(
                f"the force on finger and rig has {len(lengths)} corners and output times up to {self.knots[-1]:.6g} s, which"
                f" take twice as many pieces, more than {most}. Choose a shorter time.duration, fewer time.samples or a slower"
                " drive"
            )
        span = float(np.sum(lengths[self.counts(np.ones(len(self.wanted), bool))]))
        if span == 0.0:
            return 0.0
        return min(max(FEWEST, PER_CHANGE * span / shortest), most / 2 - len(lengths)) / span

    def divisions(self, *, density: float, halvings: int, counts: NDArray[np.bool_]) -> Indices:
        """Return the number of pieces of each stretch.

        `counts` (knots - 1,); returns `divisions` (knots - 1,).
        """
        # lengths of an even grid differ in their last digit only
        even = np.maximum(np.ceil(np.diff(self.knots) * density * (1 - 1e-9)), 1)
        first = np.where(self.graded, GROWTH * even, even)  # the last piece is as long as the others
        return np.asarray(np.where(counts, first * 2**halvings, 1), np.intp)

    def points(self, divisions: Indices) -> tuple[Real, Real]:
        """Return begin and duration of every piece.

        `divisions` (knots - 1,); returns `begins`, `lengths` (pieces,) [s].
        """
        whole, since = np.repeat(np.diff(self.knots), divisions), np.repeat(self.knots[:-1], divisions)
        count, power = np.repeat(divisions, divisions), np.repeat(np.where(self.graded, GROWTH, 1), divisions)
        place = np.arange(len(whole)) - np.repeat(np.cumsum(divisions) - divisions, divisions)
        first = (place / count) ** power
        return since + whole * first, whole * (((place + 1) / count) ** power - first)


def _is_idle(times: Real, wanted: Real, memory: float) -> NDArray[np.bool_]:
    """Return which times affect no output time."""
    after = np.append(wanted, math.inf)[np.searchsorted(wanted, times, side="left")]
    return np.asarray(after - times >= memory * (1 - 1e-9))


def increasing(times: ArrayLike) -> Real:
    """Return times as an array, refusing those that do not increase.

    `times` (n,) [s]; returns `stamps` (n,) [s].
    """
    stamps = np.asarray(times, dtype=float)
    if stamps.ndim != 1 or not stamps.size or not np.all(np.isfinite(stamps)) or np.any(np.diff(stamps) <= 0):
        raise InputError(
            "times: expected finite times that increase, at least one. Sort them, drop equal ones."
        )
    return stamps


def respond_mechanically(
    force_at: Callable[[Real], Real],
    filters: Mapping[str, Filter],
    times: ArrayLike,
    *,
    tolerance: float = 1e-6,
    most: int = MOST,
    corners: ArrayLike = (),
    shortest: float = math.inf,
) -> tuple[dict[str, Real], float]:
    """Compute the outputs of linear mechanics and sensors under one force, to a stated error.

    `times` (n,) [s], `corners` (m,) [s].

    The force is linear between the points of a grid, for which the modes are exact, however stiff. The remaining error
    is that of the curvature of the force in a piece, of second order in its length; extrapolation over grids of halved
    pieces (Romberg) eliminates two orders, which leaves the sixth. Times that no output depends on any more are not
    evaluated, and times that affect only converged outputs are not refined.
    """
    stamps, marks = increasing(times), np.asarray(corners, dtype=float).ravel()
    memory = FORGOTTEN / _slowest(filters)
    found = {name: np.empty(len(stamps)) for name in filters}
    sizes = {name: _Size() for name in filters}
    part_by_part = _in_parts(force_at, end=float(stamps[-1]))
    for group in _groups(stamps, marks, memory, shortest):
        begins = max(stamps[group.start] - memory, stamps[0])
        early = begins < stamps[group.start]
        grid = Grid.over(np.append(begins, stamps[group]) if early else stamps[group], marks, memory=memory)
        rows = _settled(part_by_part, filters, grid, shortest, most, tolerance, sizes)
        for name, row in rows.items():
            found[name][group] = row[int(early) :]
    return found, max((size.moved / (size.largest or 1.0) for size in sizes.values()), default=0.0)


def respond(
    force_at: Callable[[Real], Real], filter_: Filter, times: ArrayLike, **options: Any
) -> tuple[Real, float]:
    """Return the output of one filter under a force, and its error, as `respond_mechanically` does for several."""
    rows, error = respond_mechanically(force_at, {"output": filter_}, times, **options)
    return rows["output"], error


def _in_parts(force_at: Callable[[Real], Real], *, end: float) -> Callable[[Real], Real]:
    """Return a force that is computed for `PIECES` of the times in turn, within the budget of memory and time.

    `end` [s].
    """
    meter = Meter("the motion of finger and rig", end=end)

    def of(times: Real) -> Real:
        found = np.empty(len(times))
        for first in range(0, len(times), PIECES):
            part = slice(first, first + PIECES)
            found[part] = force_at(times[part])
            meter.count(float(times[part][-1]))
        return found

    return of


@dataclass
class _Size:
    """Largest value of an output so far, and its change by the last halving of its grid."""

    largest: float = 0.0
    moved: float = 0.0


def _groups(stamps: Real, corners: Real, memory: float, shortest: float) -> list[slice]:
    """Return the groups of outputs computed together: some `PIECES` of a first grid, if long compared with the memory [s]."""
    lengths = np.append(0.0, np.minimum(np.diff(stamps), memory))
    pieces = np.cumsum(lengths * PER_CHANGE / shortest) + np.searchsorted(np.sort(corners), stamps)
    together = max(PIECES, 4 * memory * PER_CHANGE / shortest)
    edges = np.flatnonzero(np.diff(np.floor(pieces / together), prepend=0.0))
    bounds = [0, *edges[edges > 0].tolist(), len(stamps)]
    return [slice(first, last) for first, last in itertools.pairwise(bounds)]


def _settled(
    force_at: Callable[[Real], Real],
    filters: Mapping[str, Filter],
    grid: Grid,
    shortest: float,
    most: int,
    tolerance: float,
    sizes: dict[str, _Size],
) -> dict[str, Real]:
    """Halve the pieces of a grid where outputs change, until they have converged or `most` pieces are used."""
    density, halvings = grid.density(shortest=shortest, most=most), 0
    remaining = np.ones(len(grid.wanted), bool)
    divisions = grid.divisions(density=density, halvings=halvings, counts=grid.counts(remaining))
    coarse, possible = _on_grid(force_at, filters, grid, divisions)
    found, moved = dict(coarse), {name: np.zeros(len(remaining)) for name in filters}
    tables = {name: [row] for name, row in coarse.items()}
    while True:
        halvings += 1
        divisions = grid.divisions(density=density, halvings=halvings, counts=grid.counts(remaining))
        fine, possible = _on_grid(force_at, filters, grid, divisions)
        moves = np.zeros(len(remaining), bool)
        for name, size in sizes.items():
            row = _extrapolated(tables[name], fine[name])
            changes = [np.abs(now - before) for now, before in zip(row, tables[name], strict=False)]
            change = np.maximum(np.min(changes, axis=0) - ROUNDING * possible[name], 0.0)
            moved[name] = np.where(remaining, change, moved[name])
            found[name] = np.where(remaining, row[-1], found[name])
            tables[name] = row
            size.largest = max(size.largest, float(np.max(np.abs(found[name]))), FAINT * possible[name])
            moves |= moved[name] > tolerance * size.largest
        remaining = _with_neighbours(moves)
        more = grid.divisions(density=density, halvings=halvings + 1, counts=grid.counts(remaining)).sum()
        if not np.any(remaining) or more > most or grid.is_point:
            for name, size in sizes.items():
                size.moved = max(size.moved, float(np.max(moved[name])))
            return found


def _slowest(filters: Mapping[str, Filter]) -> float:
    """Return the slowest rate of all filters [1/s]; 1e9 if none has a memory."""
    return min((float(np.min(-each.poles.real, initial=1e9)) for each in filters.values()), default=1e9)


def _with_neighbours(moved: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Mark whole groups of outputs, so that none counts as converged by coincidence."""
    groups = np.arange(len(moved)) // TOGETHER
    return np.isin(groups, groups[moved])


def _extrapolated(before: list[Real], fine: Real) -> list[Real]:
    """Return the next row of Romberg's table, for halved pieces and an error in even powers of their length."""
    row = [fine]
    for order, coarse in zip(range(1, EXTRAPOLATIONS + 1), before, strict=False):
        row.append(row[-1] + (row[-1] - coarse) / (4**order - 1))
    return row


def _on_grid(
    force_at: Callable[[Real], Real],
    filters: Mapping[str, Filter],
    grid: Grid,
    divisions: Indices,
) -> tuple[dict[str, Real], dict[str, float]]:
    """Return the outputs of all filters on one grid, and the largest possible output of each."""
    begins, lengths = grid.points(divisions)
    force = finite(force_at(np.append(begins, grid.knots[-1])))
    marks = np.cumsum(np.append(0, divisions))
    before = force[marks[1:]]
    if grid.corners.size:
        moments = grid.knots[grid.corners]
        last = lengths[marks[grid.corners] - 1]
        back = np.maximum(1e-6 * last, 64 * np.finfo(float).eps * np.abs(moments))
        before[grid.corners - 1] = finite(force_at(moments - back))
    ends = force[1:].copy()
    ends[marks[1:] - 1] = before
    found: dict[str, Real] = {}
    largest: dict[str, float] = {}
    for name, filter_ in filters.items():
        state = filter_.state(float(force[0]))
        if grid.is_point:
            output = march_through(filter_, force, force, steps=0.0, state=state)[:1]
        else:
            output = march_through(filter_, force[:-1], ends, steps=lengths, state=state)[marks]
            output[-1] += filter_.direct * (force[-1] - before[-1])
        possible = (abs(filter_.direct) + 2 * np.abs(filter_.gains).sum()) * np.abs(force).max()
        found[name], largest[name] = output[grid.wanted], float(possible)
    return found, largest


def finger_filters(finger: Finger) -> dict[str, Filter]:
    """Return the filters from the lateral force to the motion of the skin."""
    displacement = finger.compliance_at_rest() * of_stages((finger.resonance(),))
    return {"skin_displacement": displacement, "skin_speed": displacement.rate()}


@dataclass(frozen=True, eq=False)
class Measured:
    """Readings of a rig.

    Parameters
    ----------
    signals : dict of str to ndarray, shape (n,)
        ``normal_force_measured`` and ``lateral_force_measured`` at the output times [N].
    error : float
        Relative error, as from `respond_mechanically` [1].
    diagnostics : list of Diagnostic
        One for each channel of a digitiser: whether its range was exceeded.
    """

    signals: dict[str, Real]
    error: float
    diagnostics: list[Diagnostic]


def measured(
    rig: Rig,
    times: ArrayLike,
    normal: Response | None,
    lateral: Response,
    *,
    unknown: Callable[[Filter, Real], NDArray[np.bool_]] | None = None,
) -> Measured:
    """Compute the readings of a rig: forces through its sensors, digitised with its noise.

    `times` (n,) [s]; `normal` and `lateral` return the output of a sensor under that force at some times, and its error.
    """
    stamps = increasing(times)
    moments = stamps if rig.digitiser is None else _moments(rig.digitiser, stamps)
    found, worst, sensor = {}, 0.0, of_stages(rig.lateral_stages())
    if normal is not None:
        found["normal"], worst = normal(of_stages(rig.normal_stages()), moments)
    found["lateral"], error = lateral(sensor, moments)
    if unknown is not None:
        found["lateral"] = np.where(unknown(sensor, moments), np.nan, found["lateral"])
    worst = max(worst, error)
    signals, diagnostics = found, list[Diagnostic]()
    if rig.digitiser is not None:
        signals, diagnostics = _digitised(rig, rig.digitiser, found)
        place = np.floor((stamps - stamps[0]) * rig.digitiser.sampling_rate + 1e-6).astype(int)
        signals = {name: values[np.minimum(place, len(moments) - 1)] for name, values in signals.items()}
    return Measured({f"{name}_force_measured": row for name, row in signals.items()}, worst, diagnostics)


def _moments(digitiser: Digitiser, stamps: Real) -> Real:
    """Return the times of the readings; one at the last output time, apart from rounding, is included."""
    count = refuse_readings(digitiser, span=float(stamps[-1] - stamps[0]))
    moments: Real = np.minimum(stamps[0] + np.arange(count) / digitiser.sampling_rate, stamps[-1])
    return moments


def refuse_readings(digitiser: Digitiser, *, span: float) -> int:
    """Return the number of readings of a digitiser, refusing too many."""
    count = math.floor(span * digitiser.sampling_rate + 1e-6) + 1
    if 2 * count > MOST:
        raise InputError(
            f"digitiser.sampling_rate = {format_quantity(digitiser.sampling_rate, 'Hz')}: {count} readings are"
            f" more than half of {MOST}. Lower the rate, or choose a shorter time."
        )
    return count


def _digitised(
    rig: Rig, digitiser: Digitiser, forces: dict[str, Real]
) -> tuple[dict[str, Real], list[Diagnostic]]:
    """Return readings with noise, quantisation and clipping, and their diagnostics; each channel has its own noise."""
    streams = np.random.SeedSequence(digitiser.seed).spawn(2)
    ranges = (digitiser.normal_range, digitiser.lateral_range)
    readings, diagnostics = {}, []
    for (name, force), noise, full_scale, stream in zip(
        forces.items(), rig.noises(), ranges, streams, strict=True
    ):
        seen = force + noise * np.random.default_rng(stream).standard_normal(len(force))
        readings[name] = digitiser.reading(seen, full_scale=full_scale)
        nearest = digitiser.levels(seen, full_scale=full_scale) * (full_scale / 2.0 ** (digitiser.bits - 1))
        known, allowed = np.isfinite(seen), format_quantity(full_scale, "N")
        beyond = int(np.count_nonzero((readings[name] != nearest) & known))
        text = (
            f"{beyond} of {np.count_nonzero(known)} {name} readings lie beyond the range of {allowed} and are clipped"
            if beyond
            else f"no {name} reading lies beyond the range of {allowed}"
        )
        diagnostics.append(Diagnostic(f"{name} range", "warning" if beyond else "ok", text))
    return readings, diagnostics
