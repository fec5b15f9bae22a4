"""Two records with clocks of their own as one Trace."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.diagnostics import read_diagnostics
from electrovib.core.errors import InputError, nearest
from electrovib.core.trace import make_trace
from electrovib.core.units import format_quantity
from electrovib.recordings.importing.common_edges import ClockRelation, match_edges
from electrovib.recordings.importing.periods import find_edges
from electrovib.recordings.importing.steps import resampled, seconds

if TYPE_CHECKING:
    from collections.abc import Mapping

    import xarray

    from electrovib.core.arrays import Real

_LONGEST: Final = 4000


@dataclass(frozen=True, kw_only=True)
class _Record:
    """Times [s] and signals over time of a Trace."""

    trace: xarray.Dataset
    time: Real
    signals: Mapping[str, Real]

    @property
    def step(self) -> float:
        """Median interval of the samples [s]."""
        return float(np.median(np.diff(self.time)))


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
    first, second = _record("reference", reference), _record("other", other)
    if not edges and shift is None:
        raise InputError("edges: state a signal whose edges both records hold, or a shift, such as '12 ms'")
    stated = None if shift is None else seconds("shift", shift)
    if edges:
        relation = _by_edges(first, second, edges, stated)
    else:
        assert stated is not None
        relation = ClockRelation(shift=stated, ratio=1.0)
    return _merged(first, second, relation)


def _record(option: str, trace: xarray.Dataset) -> _Record:
    """Return times and signals of a Trace, or refuse one without a time axis."""
    signals = {
        str(name): np.asarray(values, dtype=float)
        for name, values in trace.data_vars.items()
        if values.dims == ("time",)
    }
    if "time" not in trace.coords or trace.sizes["time"] < 2 or not signals:
        raise InputError(f"{option}: expected a Trace with two or more samples over time")
    time = np.asarray(trace["time"], dtype=float)
    return _Record(trace=trace, time=time, signals=signals)


def _by_edges(first: _Record, second: _Record, edges: str, stated: float | None) -> ClockRelation:
    """Return the relation of the clocks from the edges of a signal of each record."""
    one, sign, two = (part.strip() for part in edges.partition("="))
    found = []
    for name, record, what in ((one, first, "reference"), (two if sign else one, second, "other record")):
        if name not in record.signals:
            raise InputError(
                f"edges = {edges}: the {what} has no signal '{name}'.{nearest(name, record.signals)}"
            )
        values = record.signals[name]
        good = np.isfinite(values)
        if np.count_nonzero(good) < 2 or np.ptp(values[good]) == 0:
            raise InputError(f"edges = {edges}: '{name}' of the {what} has no edge")
        found.append(find_edges(record.time[good], values[good]))
    return match_edges(found[0], found[1], steps=(first.step, second.step), near=stated)


def _merged(first: _Record, second: _Record, relation: ClockRelation) -> xarray.Dataset:
    """Interpolate the second record onto the first, and combine the statements of both."""
    time = relation.shift + relation.ratio * second.time
    inside = (first.time >= time[0]) & (first.time <= time[-1])
    if np.count_nonzero(inside) < 2:
        raise InputError(
            f"shift: the records do not overlap; the reference has {_span(first.time)}, the other one after alignment"
            f" {_span(time)}"
        )
    grid = first.time[inside]
    signals = {name: values[inside] for name, values in first.signals.items()}
    added = [name for name in second.signals if name not in signals]
    if not added:
        raise InputError(f"other: it adds no signal; both have {', '.join(second.signals)}")
    for name in added:
        signals[name] = _onto(time, second.signals[name], grid)
    left = [name for name in second.signals if name not in added]
    words = [
        *_history(second.trace, prefix="second file: "),
        relation.sentence(),
        f"{', '.join(added)}: interpolated onto the {grid.size} samples of the first file that both records cover",
        *(
            [f"{', '.join(left)} of the second file omitted, because the first file has it too"]
            if left
            else []
        ),
    ]
    merged = make_trace(
        {name: (("time",), values) for name, values in signals.items()},
        {"time": grid},
        _attributes(first.trace, second.trace, words, relation),
    )
    for name in signals:  # such as the error of a calibration
        source = second if name in added else first
        merged[name].attrs = {**source.trace[name].attrs, **merged[name].attrs}
    return merged


def _onto(time: Real, values: Real, grid: Real) -> Real:
    """Interpolate to a grid; means over its steps where it is coarser than the samples."""
    even = np.diff(grid)
    if np.ptp(even) <= 1e-6 * even.mean():
        return resampled(time, values, grid)
    return np.asarray(np.interp(grid, time, values))


def _history(trace: xarray.Dataset, *, prefix: str = "") -> list[str]:
    return [f"{prefix}{line}" for line in str(trace.attrs.get("history", "")).split("\n") if line]


def _attributes(
    first: xarray.Dataset,
    second: xarray.Dataset,
    words: list[str],
    relation: ClockRelation,
) -> dict[str, str]:
    """Return the attributes of the first Trace with the statements of the second one."""
    diagnostics = [each.to_dict() for each in read_diagnostics(first.attrs.get("validity", "[]"))]
    diagnostics += [
        each.to_dict() | {"name": f"{each.name} (second file)"}
        for each in read_diagnostics(second.attrs.get("validity", "[]"))
    ]
    diagnostics.append(relation.diagnostic().to_dict())
    attributes = {str(name): value for name, value in first.attrs.items() if name != "format"}
    for name in ("file", "file_sha256", "reader", "options"):
        if name in second.attrs:
            attributes[f"second_{name}"] = str(second.attrs[name])[:_LONGEST]
    return attributes | {
        "history": "\n".join([*_history(first), *words]),
        "validity": json.dumps(diagnostics),
    }


def _span(time: Real) -> str:
    return f"{format_quantity(float(time[0]), 's')} to {format_quantity(float(time[-1]), 's')}"
