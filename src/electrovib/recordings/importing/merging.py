"""Two records on one clock, by the edges that both hold."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.diagnostics import Diagnostic, read_diagnostics
from electrovib.core.errors import InputError, nearest
from electrovib.core.signals import make_trace
from electrovib.core.units import format_quantity
from electrovib.recordings.importing.notices import told
from electrovib.recordings.importing.reduction import find_edges, resampled, seconds, span_words
from electrovib.recordings.interval import student

if TYPE_CHECKING:
    import xarray

    from electrovib.core.arrays import Real
    from electrovib.recordings.importing.reduction import SignalEdges


_LONGEST: Final = 4000
_OF_THE_SECOND: Final = dict.fromkeys(("file", "file_sha256", "reader", "options"), _LONGEST) | {
    "columns_of_file": None
}
"""Attributes of the second Trace that are kept, and at most how many letters of them."""


def merge_traces(
    reference: xarray.Dataset, other: xarray.Dataset, *, edges: str = "", shift: str | float | None = None
) -> xarray.Dataset:
    """Put the signals of a record onto the clock and the samples of another one.

    Parameters
    ----------
    reference : xarray.Dataset
        Trace whose time axis is kept.
    other : xarray.Dataset
        Trace whose signals are added. A signal that both hold is kept as the reference has it.
    edges : str
        Signal that both hold, or ``"A=B"`` for signal A of the reference and B of the other one: recordings of the same event,
        whose edges determine the shift and, from two edges on, the ratio of the clocks.
    shift : str or float, optional
        Time that is added to the time stamps of `other` [s]. Without `edges` it is used as it is; with `edges` it selects the
        alignment, where periodic edges leave several open.

    Returns
    -------
    xarray.Dataset
        Trace over the time of the reference where both records have samples. The history states the shift and the ratio with
        their 95 % intervals, ``validity`` the diagnostics of both.

    Raises
    ------
    InputError
        If neither edges nor a shift are given, the edges do not determine the alignment, or the records do not overlap.

    Notes
    -----
    Edges of a drive and of the force that it causes are not the same event: their alignment removes the delay between them.
    """
    first, second = _over_time("reference", reference), _over_time("other", other)
    if not edges and shift is None:
        raise InputError("edges: state a signal whose edges both records hold, or a shift, such as '12 ms'")
    stated = None if shift is None else seconds("shift", shift)
    as_stated = ClockRelation(shift=stated or 0.0, ratio=1.0)
    return _merged(first, second, _by_edges(first, second, edges, stated) if edges else as_stated)


def _over_time(option: str, trace: xarray.Dataset) -> xarray.Dataset:
    """Return the signals over time of a Trace, or refuse one without a time axis."""
    names = [name for name, values in trace.data_vars.items() if values.dims == ("time",)]
    if "time" not in trace.coords or trace.sizes["time"] < 2 or not names:
        raise InputError(f"{option}: expected a Trace with two or more samples over time")
    return trace[names].astype(float)


def _by_edges(
    first: xarray.Dataset, second: xarray.Dataset, edges: str, stated: float | None
) -> ClockRelation:
    """Return the relation of the clocks from the edges of a signal of each record."""
    one, sign, two = (part.strip() for part in edges.partition("="))
    found, steps = [], []
    for name, record, what in ((one, first, "reference"), (two if sign else one, second, "other record")):
        if name not in record.data_vars:
            raise InputError(
                f"edges = {edges}: the {what} has no signal '{name}'.{nearest(name, map(str, record))}"
            )
        values, time = record[name].values, record["time"].values.astype(float)
        good = np.isfinite(values)
        if np.count_nonzero(good) < 2 or np.ptp(values[good]) == 0:
            raise InputError(f"edges = {edges}: '{name}' of the {what} has no edge")
        found.append(find_edges(time, values))
        steps.append(float(np.median(np.diff(time))))
    return match_edges(found[0], found[1], steps=(steps[0], steps[1]), near=stated)


def _merged(first: xarray.Dataset, second: xarray.Dataset, relation: ClockRelation) -> xarray.Dataset:
    """Interpolate the second record onto the first, and combine the statements of both."""
    own = first["time"].values.astype(float)
    time = relation.shift + relation.ratio * second["time"].values
    inside = (own >= time[0]) & (own <= time[-1])
    if np.count_nonzero(inside) < 2:
        raise InputError(
            f"shift: the records do not overlap; the reference has {span_words(own)}, the other one after alignment"
            f" {span_words(time)}"
        )
    grid = own[inside]
    added = [str(name) for name in second if name not in first]
    left = [str(name) for name in second if name in first]
    if not added:
        raise InputError(f"other: it adds no signal; both have {', '.join(left)}")
    signals = {str(name): values.values[inside] for name, values in first.items()}
    signals |= {name: _onto(time, second[name].values, grid) for name in added}
    words = [
        *_history(first),
        *(f"second file: {line}" for line in _history(second)),
        relation.sentence(),
        f"{', '.join(added)}: interpolated onto the {grid.size} samples of the first file that both records cover",
        *([f"{', '.join(left)} of the second file omitted, because the first file has it too"] * bool(left)),
    ]
    before, after = (read_diagnostics(each.attrs.get("validity", "[]")) for each in (first, second))
    after = [replace(each, name=f"{each.name} (second file)") for each in after]
    attributes = {str(name): value for name, value in first.attrs.items() if name != "format"}
    attributes |= {
        f"second_{name}": str(second.attrs[name])[:most]
        for name, most in _OF_THE_SECOND.items()
        if name in second.attrs
    }
    merged = make_trace(
        {name: (("time",), values) for name, values in signals.items()},
        {"time": grid},
        attributes | told(words, (*before, *after, relation.diagnostic())),
    )
    for name in signals:  # such as the error of a calibration
        merged[name].attrs = (second if name in added else first)[name].attrs | merged[name].attrs
    return merged


def _onto(time: Real, values: Real, grid: Real) -> Real:
    """Interpolate to a grid; means over its steps where it is coarser than the samples."""
    even = np.diff(grid)
    if np.ptp(even) <= 1e-6 * even.mean():
        return resampled(time, values, grid)
    return np.asarray(np.interp(grid, time, values))


def _history(trace: xarray.Dataset) -> list[str]:
    return [line for line in str(trace.attrs.get("history", "")).split("\n") if line]


_MOST: Final = 2000
"""Largest number of edges of a record."""
_LARGEST_DRIFT: Final = 0.01
"""Largest difference of the ratio of two clocks from 1."""
_CLEARLY: Final = 3.0
"""Ratio of the misfit of the second best alignment to that of the best one from which on the edges determine it."""
_SHARE: Final = 0.5
"""Share of the edges of the shorter record that an alignment has to match."""


@dataclass(frozen=True, kw_only=True)
class ClockRelation:
    """Time on the clock of a reference, over time on another clock: shift + ratio time.

    `edges` determine it; 0 if the shift was stated. The half widths are those of the 95 % intervals of the
    shift at the mean time of the edges, and of the ratio; None if unknown.
    """

    shift: float
    ratio: float
    edges: int = 0
    shift_half_width: float | None = None
    ratio_half_width: float | None = None

    def sentence(self) -> str:
        """Return the relation as a sentence of the history."""
        moved = f"second file: {format_quantity(self.shift, 's', digits=7)} added to its time stamps"
        if not self.edges:
            return f"{moved}, as stated; the clocks were assumed to run alike"
        within = f"(95 % interval +-{format_quantity(self.shift_half_width or 0.0, 's', digits=2)})"
        if self.ratio_half_width is None:
            return f"{moved} {within}, from one common edge; the clocks were assumed to run alike"
        return (
            f"{moved} {within} after multiplication by the clock ratio 1 {1e6 * (self.ratio - 1):+.4g} ppm"
            f" (95 % interval +-{1e6 * self.ratio_half_width:.2g} ppm), from {self.edges} common edges"
        )

    def diagnostic(self) -> Diagnostic:
        """Return whether the ratio of the clocks is known."""
        if self.ratio_half_width is None:
            why = "one common edge" if self.edges else "a stated shift"
            return Diagnostic(
                "clock ratio",
                "unknown",
                f"{why} does not determine the ratio of the clocks, so a drift cannot be noticed",
            )
        return Diagnostic(
            "clock ratio", "ok",
            f"{self.edges} common edges determine the ratio of the clocks within {1e6 * self.ratio_half_width:.2g} ppm",
        )  # fmt: skip


def match_edges(
    reference: SignalEdges, other: SignalEdges, *, steps: tuple[float, float], near: float | None = None
) -> ClockRelation:
    """Match the edges of two records in their order and fit shift and ratio of the clocks.

    Rising edges match rising ones, falling ones falling ones. An alignment is accepted if every residual is
    below a quarter of the shortest interval between edges, if the ratio of the clocks differs from 1 by at
    most 1 %, and if no other alignment fits within three times its misfit; else the approximate shift `near`
    has to select it. The 95 % intervals are from the residuals (Student's t) or from the sampling intervals
    `steps`, whichever standard deviation is larger.
    """
    sizes = reference.times.size, other.times.size
    for count, what in zip(sizes, ("reference", "other record"), strict=True):
        if not 0 < count <= _MOST:
            raise InputError(f"edges: the {what} has {count} edges; expected 1 to {_MOST}")
    timing = math.hypot(*steps) / math.sqrt(12)
    if 1 in sizes:
        return _single(reference, other, timing, near)
    lags = range(1 - sizes[1], sizes[0])
    fits = [fit for lag in lags if (fit := _fitted(reference, other, lag, timing)) is not None]
    if not fits:
        raise InputError(
            "edges: those of the two records do not match in order and spacing; state a shift, such as '12 ms'"
        )
    if near is not None:
        middle = other.times.mean()
        return min((fit for _, fit in fits), key=lambda fit: abs(fit.shift + (fit.ratio - 1) * middle - near))
    (misfit, chosen), *others = sorted(fits, key=lambda fit: fit[0])
    if others and others[0][0] <= _CLEARLY * max(misfit, timing):
        shifts = (format_quantity(fit.shift, "s", digits=5) for fit in (chosen, others[0][1]))
        raise InputError(
            f"edges: shifts of {' and '.join(shifts)} fit alike, because the edges are periodic; state a shift near the right"
            " one, such as shift = '12 ms'"
        )
    return chosen


def _single(reference: SignalEdges, other: SignalEdges, timing: float, near: float | None) -> ClockRelation:
    """Return the shift from one edge; of several edges `near` selects it."""
    alike = np.equal.outer(reference.signs, other.signs)
    shifts = np.sort(np.subtract.outer(reference.times, other.times)[alike])
    if not shifts.size or (shifts.size > 1 and near is None):
        many = f"{reference.times.size} and {other.times.size} edges"
        raise InputError(
            f"edges: {many} do not determine the shift; state a shift near it, such as shift = '12 ms'"
        )
    shift = float(shifts[0] if near is None else shifts[np.argmin(np.abs(shifts - near))])
    return ClockRelation(shift=shift, ratio=1.0, edges=1, shift_half_width=1.96 * timing)


def _fitted(
    reference: SignalEdges, other: SignalEdges, lag: int, timing: float
) -> tuple[float, ClockRelation] | None:
    """Return the misfit of the edges matched at a lag, and their relation; None if they do not fit."""
    sizes = reference.times.size, other.times.size
    here = slice(max(lag, 0), min(sizes[0], sizes[1] + lag))
    there = slice(here.start - lag, here.stop - lag)
    count = here.stop - here.start
    if count < max(2, math.ceil(_SHARE * min(sizes))) or (reference.signs[here] != other.signs[there]).any():
        return None
    one, two = reference.times[here], other.times[there]
    centred = two - two.mean()
    ratio = float(centred @ (one - one.mean()) / (centred @ centred))
    residual = one - one.mean() - ratio * centred
    if abs(ratio - 1) > _LARGEST_DRIFT or np.abs(residual).max() > 0.25 * float(np.diff(one).min()):
        return None
    free = count - 2
    scatter = float(np.linalg.norm(residual)) / math.sqrt(free) if free else 0.0
    half = max(scatter, timing) * (student(free) if free and scatter > timing else 1.96)
    return float(np.sqrt(np.mean(residual**2))), ClockRelation(
        shift=float(one.mean() - ratio * two.mean()),
        ratio=ratio,
        edges=count,
        shift_half_width=half / math.sqrt(count),
        ratio_half_width=half / float(np.linalg.norm(centred)),
    )
