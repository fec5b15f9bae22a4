"""Scenarios, Traces and sweeps in a notebook: models and parameters with sources; how far to believe a result, its numbers."""

from __future__ import annotations

import base64
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from electrovib.core.citation import UNVERIFIED
from electrovib.core.diagnostics import STATES, diagnostics_of
from electrovib.core.signals import FORMAT, SIGNALS
from electrovib.view import plots, summary
from electrovib.view.pages import filled, to_png
from electrovib.view.plots.layers import return_path
from electrovib.view.plots.layers import values as values_of
from electrovib.view.style import layer_colours, new_figure, pretty_quantity, pretty_unit, style
from electrovib.view.summary import is_sweep, quantities_of, swept_texts

if TYPE_CHECKING:
    from collections.abc import Iterable

    import xarray
    from matplotlib.axes import Axes

    from electrovib.core.diagnostics import Diagnostic
    from electrovib.physics.stack import Layer
    from electrovib.scenario import Scenario


@dataclass(frozen=True, kw_only=True)
class ShownLayer:
    """One layer of the stack as it is drawn; its role is ``"plate"``, ``"gap"`` or ``"finger"``."""

    name: str
    thickness: str
    material: str
    role: str
    colour: str
    evaluated: bool


def scenario_html(scenario: Scenario) -> str:
    """Write a scenario as HTML for a notebook."""
    parameters = [row for row in summary.parameter_rows({"": scenario}, {}) if row.values != ("–",)]
    given = [row for row in parameters if not row.sources[0].startswith(summary.DEFAULT)]
    models = summary.model_rows(scenario)
    return filled(
        "notebook_scenario.html.jinja",
        title=f"Scenario: {scenario.titled() or 'without a title'}",
        layers=layers_of(scenario),
        return_path=return_path(scenario),
        models=[(row, _is_unverified(row.facts)) for row in models],
        given=given,
        defaults=[row for row in parameters if row not in given],
        mark=UNVERIFIED,
        unverified=sum(_is_unverified(row.sources) for row in parameters)
        + sum(_is_unverified(row.facts) for row in models),
    )


def layers_of(scenario: Scenario) -> list[ShownLayer]:
    """List the layers from the finger, which is drawn on top, down to the plate."""
    stack = scenario.stack
    colours, roles = layer_colours([*stack.layers]), stack.roles
    found = [
        ShownLayer(
            name=name.replace("_", " "),
            thickness=pretty_quantity(layer.thickness, "m"),
            material=_material(layer, scenario),
            role=roles[name],
            colour=colours[name],
            evaluated=scenario.force.evaluation_surface == name,
        )
        for name, layer in stack.layers.items()
    ]
    return found[::-1]


def _material(layer: Layer, scenario: Scenario) -> str:
    """Write model, substance and values of a layer."""
    text = f"{type(layer.material).__name__}: {values_of(layer, scenario)}"
    substance = layer.material.substance
    return f"{substance}, {text}" if substance and substance not in text else text


def _is_unverified(texts: Iterable[Any]) -> bool:
    return any(UNVERIFIED in str(text) for text in texts)


_DRAWN: Final = ("electrostatic_force", "lateral_force", "lateral_force_measured", "drive_voltage")
"""Of a Trace over time, the first of these that it has is drawn."""
_RESOLUTION: Final = 80.0
"""Of the small figure [dots per inch]."""
_OVER: Final = frozenset({"time", "frequency"})
"""Dimensions of a Trace; a Dataset without them, such as its mean over time, is shown as xarray does."""
_MOST_DRAWN: Final = 2
"""Swept parameters up to which a quantity of a sweep can be drawn."""


def is_own(dataset: xarray.Dataset) -> bool:
    """Return whether a Dataset is a Trace of this package, or a part of one that still runs over something."""
    return dataset.attrs.get("format") == FORMAT and (is_sweep(dataset) or not _OVER.isdisjoint(dataset.dims))


def trace_html(trace: xarray.Dataset) -> str:
    """Write a Trace or a sweep as HTML for a notebook."""
    return filled(
        "notebook_trace.html.jinja",
        title=_title(trace),
        diagnostics=_by_state(trace),
        sentences=_sentences(trace),
        numbers=_numbers(trace),
        swept=swept_texts(trace),
        dimensions=_dimensions(trace),
        signals=_signals(trace),
        provenance=summary.provenance(trace),
        figure=_figure(trace),
    )


def trace_text(trace: xarray.Dataset) -> str:
    """Write a Trace or a sweep in a few lines: title, warnings, states of the diagnostics, key numbers, dimensions."""
    found = _by_state(trace)
    lines = [_title(trace)]
    lines += [f"warning: {each.text}" for each in found["warning"]]
    counts = [f"{len(found[state])} {state}" for state in reversed(STATES) if found[state]]
    if counts:
        lines.append(f"validity: {', '.join(counts)}")
    lines += _sentences(trace)
    lines += [f"{what}: {text}" for what, text in _numbers(trace).items()]
    lines.append(f"dimensions: {_dimensions(trace)}")
    return "\n".join(lines)


def _title(trace: xarray.Dataset) -> str:
    kind = "Sweep" if is_sweep(trace) else "Trace"
    return f"{kind}: {trace.attrs.get('title') or trace.attrs.get('source') or 'without a title'}"


def _sentences(trace: xarray.Dataset) -> list[str]:
    """Return the sentences that the reduction of a recording has written."""
    return str(trace.attrs.get("words", "")).splitlines()


def _by_state(trace: xarray.Dataset) -> dict[str, list[Diagnostic]]:
    """Sort the validity diagnostics by their state."""
    found = diagnostics_of(trace)
    return {state: [each for each in found if each.state == state] for state in reversed(STATES)}


def _numbers(trace: xarray.Dataset) -> dict[str, str]:
    """Return the key numbers of the signals, or of the quantities, that the Dataset still has."""
    if is_sweep(trace):
        whole = all(name in trace for name in quantities_of(trace))
        return summary.key_numbers(trace) if whole else {}
    if not trace.sizes.get("time"):
        return {}
    shown = trace if "layer" in trace.dims else trace.drop_vars("field", errors="ignore")
    return summary.key_numbers(shown, quick=True)


def _dimensions(trace: xarray.Dataset) -> str:
    return ", ".join(f"{name} ({size})" for name, size in trace.sizes.items()) or "none"


def _signals(trace: xarray.Dataset) -> list[tuple[str, str, str, str]]:
    """List the variables: name, unit, meaning, dimensions."""
    found = []
    for name, values in trace.data_vars.items():
        known = SIGNALS.get(str(name))
        unit = known.unit if known else str(values.attrs.get("units", ""))
        dims = ", ".join(map(str, values.dims))
        found.append((str(name), pretty_unit(unit), known.doc if known else "", dims))
    return found


def _figure(trace: xarray.Dataset) -> str:
    """Draw the first force or voltage over time, or the first quantity of a sweep, as PNG in base 64; empty without one."""
    axes = _drawn(trace)
    if axes is None:
        return ""
    figure = axes.get_figure(root=True)
    assert figure is not None
    content = to_png(figure, resolution=_RESOLUTION)
    figure.clear()
    return base64.b64encode(content).decode("ascii")


def _drawn(trace: xarray.Dataset) -> Axes | None:
    if is_sweep(trace):
        for name in quantities_of(trace):
            many = [size for size in trace[name].sizes.values() if size > 1] if name in trace else []
            if 1 <= len(many) <= _MOST_DRAWN:
                return plots.quantity(trace, name, ax=_new_axes())
        return None
    for name in _DRAWN:
        if name in trace and "time" in trace[name].dims and trace.sizes["time"] > 1:
            return plots.over_time(trace, name, ax=_new_axes())
    return None


def _new_axes() -> Axes:
    """Make the Axes of a figure that pyplot does not know, so that no notebook shows it a second time."""
    with style():
        return new_figure().add_subplot()
