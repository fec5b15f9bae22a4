"""The figures of a report: the stack, small multiples over time, the response over frequency; sweeps over parameters."""

from __future__ import annotations

import functools
from contextlib import nullcontext
from typing import TYPE_CHECKING, Any, Final

from electrovib.core.answer import Drawing
from electrovib.core.paths import words_at
from electrovib.view import plots
from electrovib.view.lines import (
    has,
    legends_collected,
    scenario_or_none,
    shown_value,
    swept_paths,
    swept_units,
)
from electrovib.view.plots.layers import figure_height
from electrovib.view.plots.over_time import has_layer_voltages
from electrovib.view.style import legends_taken
from electrovib.view.summary import is_sweep, quantities_of

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    import xarray
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from electrovib.scenario import Scenario

_WIDTH: Final = 9.4
"""Of a figure that fills the page [inch]; with it the letters come out at their size."""
_ROW, _ALONE = 2.75, 3.8
"""Height of a row of two plots, and of a single plot [inch]."""
_LETTER: Final = 0.072
"""Width of a letter in a legend [inch]."""
_MOST_STACKS: Final = 4
_DRAWN_OVER: Final = 2
"""Parameters of a sweep that a plot runs over; of further ones the first and the last value are drawn."""
BEYOND: Final = (
    "plate_voltage",
    "amplifier_current",
    "gap",
    "capacitance",
    "normal_force",
    "sliding_speed",
    "gross_contact_area",
    "real_contact_area",
    "bristle_deflection",
    "skin_displacement",
    "skin_speed",
    "normal_force_measured",
    "lateral_force_measured",
)
"""Signals beside the drive and the forces, in the order of the chain."""


def figures(traces: Mapping[str, xarray.Dataset], scenarios: Mapping[str, Scenario]) -> list[Drawing]:
    """Draw all figures for which the Traces have signals."""
    runs = {label: trace for label, trace in traces.items() if not is_sweep(trace)}
    drawn = _stacks(scenarios)
    for number, (label, trace) in enumerate(traces.items()):
        if is_sweep(trace):
            drawn += _over_parameters(trace, label if len(traces) > 1 else "", f"sweep{number}")
    if not runs:
        return drawn
    return [*drawn, *_over_time(runs), *_beyond(runs), *_over_frequency(runs)]


def _over_parameters(trace: xarray.Dataset, label: str, name: str) -> list[Drawing]:
    """Draw the quantities of a sweep: a curve over one parameter, a map over two, some maps over more."""
    paths = [path for path in swept_paths(trace) if trace.sizes[path] > 1]
    names = [each for each in quantities_of(trace) if trace[each].notnull().any()]
    if not paths or not names:
        return []
    held = paths[:-_DRAWN_OVER]
    picks = [dict.fromkeys(held, 0), dict.fromkeys(held, -1)] if held else [{}]
    figures = []
    for place, pick in enumerate(picks):
        chosen = trace.isel(pick)
        wanted: list[tuple[str, Callable[..., Axes]]] = [
            (words_at(None, each), functools.partial(_one_quantity, trace=chosen, name=each))
            for each in names
        ]
        units = swept_units(trace)
        at = ", ".join(f"{path} = {shown_value(chosen[path].item(), units.get(path, ''))}" for path in held)
        scenario = scenario_or_none(trace)
        over = " and ".join(f"the {words_at(scenario, path)}" for path in paths[-_DRAWN_OVER:])
        title = f"Over {over}" + (f": {label}" if label else "")
        caption = f"Taken over {trace.attrs.get('taken_over', 'each case')}" + (f", at {at}." if at else ".")
        figures += _multiples({}, wanted, title, f"{name}_{place}", caption=caption)
    return figures


def _one_quantity(_: Any, *, trace: xarray.Dataset, name: str, ax: Axes) -> Axes:
    return plots.quantity(trace, name, ax=ax)


def _stacks(scenarios: Mapping[str, Scenario]) -> list[Drawing]:
    """Draw each different stack once."""
    found: dict[tuple[str, str, str], list[str]] = {}
    for label, scenario in scenarios.items():
        drawn_from = (
            scenario.stack.canonical(),
            scenario.circuit.canonical(),
            scenario.force.evaluation_surface,
        )
        found.setdefault(drawn_from, []).append(label)
    groups = list(found.values())
    left = ", ".join(labels[0] for labels in groups[_MOST_STACKS:])
    captions = [
        f"Stack of {', '.join(labels)}." if len(groups) > 1 else "" for labels in groups[:_MOST_STACKS]
    ]
    if left:
        captions[-1] += f" Not drawn: {left}."
    return [
        _stack(scenarios[labels[0]], number, caption)
        for number, (labels, caption) in enumerate(zip(groups, captions, strict=False))
    ]


def _stack(scenario: Scenario, number: int, caption: str) -> Drawing:
    return Drawing(
        id=f"stack{number}",
        title="Stack",
        plot="stack",
        of=scenario,
        size=(_WIDTH, figure_height(scenario)),
        caption=caption,
        words=f"Layers from the plate to the finger: {', '.join(scenario.stack.layers)}.",
    )


def _over_time(traces: Mapping[str, xarray.Dataset]) -> list[Drawing]:
    """Draw drive, effective voltage or layer voltages, attraction and friction over time."""
    wanted: list[tuple[str, Callable[..., Axes]]] = []
    if has(traces, "drive_voltage"):
        wanted.append(("drive", plots.drive))
    if has(traces, "effective_voltage"):
        wanted.append(("effective voltage", plots.effective_voltage))
    elif any(has_layer_voltages(trace) for trace in traces.values()):
        wanted.append(("voltage across each layer", plots.layer_voltages))
    if has(traces, "electrostatic_force"):
        wanted.append(("electrostatic force", plots.force))
    if has(traces, "lateral_force"):
        wanted.append(("lateral force", plots.lateral_force))
    return _multiples(traces, wanted, "Over time", "time")


def _beyond(traces: Mapping[str, xarray.Dataset]) -> list[Drawing]:
    """Draw the signals of amplifier, contact, finger and rig that change in some Trace."""
    wanted: list[tuple[str, Callable[..., Axes]]] = [
        (name.replace("_", " "), functools.partial(plots.over_time, name=name))
        for name in BEYOND
        if any(_moves(trace, name) for trace in traces.values())
    ]
    return _multiples(traces, wanted, "Amplifier, contact, finger and rig", "beyond")


def _moves(trace: xarray.Dataset, name: str) -> bool:
    """Return whether a Trace has a signal that changes in time."""
    if name not in trace or "time" not in trace[name].dims:
        return False
    values = trace[name]
    spread = float((values.max("time") - values.min("time")).max())
    return spread > 1e-9 * float(abs(values).max())


def _over_frequency(traces: Mapping[str, xarray.Dataset]) -> list[Drawing]:
    wanted: list[tuple[str, Callable[..., Axes]]] = []
    if has(traces, "mean_force"):
        wanted.append(("frequency response of the force", plots.frequency_response))
    if has(traces, "effective_voltage_gain") or has(traces, "field_gain"):
        wanted.append(("gain", plots.gain))
    caption = "Time mean of the force under a sine with the peak voltage of the drive, in the periodic state."
    return _multiples(
        traces, wanted, "Over frequency", "frequency", caption=caption if has(traces, "mean_force") else ""
    )


def _multiples(
    traces: Mapping[str, xarray.Dataset],
    wanted: Sequence[tuple[str, Callable[..., Axes]]],
    title: str,
    name: str,
    *,
    caption: str = "",
) -> list[Drawing]:
    """Lay plots out in two columns, with one legend for what they share; none without plots."""
    if not wanted:
        return []
    rows = -(-len(wanted) // 2)
    height = _ROW * rows if len(wanted) > 1 else _ALONE
    words = f"{title}: {', '.join(words for words, _ in wanted)}"
    plot = functools.partial(_draw_multiples, traces=traces, wanted=wanted, rows=rows)
    return [Drawing(id=name, title=title, plot=plot, size=(_WIDTH, height), caption=caption, words=words)]


def _draw_multiples(
    figure: Figure,
    *,
    traces: Mapping[str, xarray.Dataset],
    wanted: Sequence[tuple[str, Callable[..., Axes]]],
    rows: int,
) -> None:
    axes = figure.subplots(rows, min(2, len(wanted)), squeeze=False).ravel()
    for ax in axes[len(wanted) :]:
        ax.remove()
    shared = len(traces) > 1 or any(swept_paths(trace) for trace in traces.values())
    with legends_collected() if shared else nullcontext():
        for (words, plot), ax in zip(wanted, axes[: len(wanted)], strict=True):
            plot(traces, ax=ax)
            ax.set_title(words)
    if shared:
        _share_legend(figure, list(axes[: len(wanted)]))


def _share_legend(figure: Figure, axes: Sequence[Axes]) -> None:
    """Collect the legends of several plots into one above them, each entry once."""
    entries, title = legends_taken(axes)
    if not entries:
        return
    columns = max(1, int(_WIDTH / (0.5 + _LETTER * max(len(text) for text in entries))))
    figure.legend(
        list(entries.values()),
        list(entries),
        title=title.replace("\n", ", ") or None,
        loc="outside upper left",
        ncols=min(len(entries), columns),
        alignment="left",
    )
    figure.set_figheight(figure.get_figheight() + 0.17 * (-(-len(entries) // columns) + bool(title)))
