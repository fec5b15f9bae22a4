"""Residuals of measurements beside predictions: a table and figures of a report."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.signals import signal
from electrovib.recordings.importing.beside import is_measured, residuals
from electrovib.view.envelope import envelope
from electrovib.view.pages import markup
from electrovib.view.style import COLOURS, NEUTRAL, new_figure, style
from electrovib.view.svg import inline, to_svg
from electrovib.view.units import label_axis, pretty_quantity

if TYPE_CHECKING:
    from collections.abc import Mapping

    import xarray
    from markupsafe import Markup
    from matplotlib.axes import Axes

    from electrovib.core.arrays import Real
    from electrovib.recordings.importing.beside import SignalResidual

_WIDTH: Final = 9.4
_HEIGHT: Final = 3.6
_MOST: Final = 6


@dataclass(frozen=True, kw_only=True)
class ResidualRow:
    """One row of the table: a measured signal beside a prediction of it."""

    measured: str
    predicted: str
    signal: str
    rms: str
    relative: str
    mean: str
    span: str
    svg: Markup | None


def residual_rows(traces: Mapping[str, xarray.Dataset]) -> list[ResidualRow]:
    """Compare every measurement of a report with every prediction, a row for each signal they share; sweeps are omitted."""
    plain = {label: trace for label, trace in traces.items() if "quantities" not in trace.attrs}
    rows: list[ResidualRow] = []
    for measured, recorded in plain.items():
        for predicted, computed in plain.items():
            if not is_measured(recorded) or is_measured(computed):
                continue
            for each in residuals(computed, recorded):
                rows.append(_row(each, measured, predicted, f"residual{len(rows)}", drawn=len(rows) < _MOST))
    return rows


def _row(found: SignalResidual, measured: str, predicted: str, name: str, *, drawn: bool) -> ResidualRow:
    unit = signal(found.name).unit
    along = signal(found.along).unit
    first, last = (pretty_quantity(float(end), along, digits=4) for end in found.axis[[0, -1]])
    words = found.name.replace("_", " ")
    if found.predicted_name != found.name:
        words += f" (predicted: {found.predicted_name.replace('_', ' ')})"
    return ResidualRow(
        measured=measured,
        predicted=predicted,
        signal=words,
        rms=pretty_quantity(found.rms, unit, digits=4),
        relative=f"{100 * found.relative_rms:.3g} %",
        mean=pretty_quantity(found.mean, unit, digits=4),
        span=f"{first} … {last}, {found.axis.size} samples",
        svg=_figure(found, measured, predicted, name) if drawn else None,
    )


def _figure(found: SignalResidual, measured: str, predicted: str, name: str) -> Markup:
    """Draw measurement and prediction, and their residual below; of an impedance the moduli."""
    figure = new_figure((_WIDTH, _HEIGHT))
    with style():
        above, below = figure.subplots(2, 1, sharex=True, height_ratios=[2, 1])
        words, unit = found.name.replace("_", " "), signal(found.name).unit
        complex_valued = np.iscomplexobj(found.measured)
        if complex_valued:
            words = f"modulus of {words}"
            above.set_yscale("log")
        if found.along == "frequency":
            above.set_xscale("log")
        _curve(above, found.axis, found.measured, COLOURS[0], measured)
        _curve(above, found.axis, found.predicted, COLOURS[1], predicted)
        _curve(below, found.axis, found.residual, COLOURS[0], "")
        below.axhline(0.0, color=NEUTRAL, linewidth=0.8)
        above.legend(loc="best")
        label_axis(above.yaxis, words, unit)
        label_axis(below.yaxis, "residual", unit)
        label_axis(below.xaxis, found.along, signal(found.along).unit)
    return markup(
        inline(to_svg(figure), name=name, words=f"{words}: {measured} beside {predicted}, and residual")
    )


def _curve(ax: Axes, axis: Real, values: np.ndarray, colour: str, label: str) -> None:
    x, y = envelope(axis, np.abs(values) if np.iscomplexobj(values) else np.asarray(values, dtype=float))
    ax.plot(x, y, color=colour, label=label or "_nolegend_")
