"""Plots of a page: over time, over frequency, and what is felt."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.apps.explorer.pictures.figure import LAYER_DASHES, Axis, PlottedCurve, figure, with_kept
from electrovib.core.signals import SIGNALS
from electrovib.physics.perception import Perception
from electrovib.studies.felt_spectrum import Stimulus, just_felt
from electrovib.view.style import COLOURS, FURTHER_COLOURS, NEUTRAL, layer_colours
from electrovib.view.units import prefix_for, pretty_quantity, pretty_unit

if TYPE_CHECKING:
    import xarray
    from numpy.typing import NDArray

    from electrovib.apps.explorer.computed import Computed
    from electrovib.scenario import Scenario
    from electrovib.studies.perceive import Percept


LOWEST, HIGHEST = 1.0, 2000.0
"""Frequencies of the plot [Hz]."""
_FREQUENCIES: Final = np.geomspace(LOWEST, HIGHEST, 120)


def felt(percept: Percept, scenario: Scenario) -> list[dict[str, Any]]:
    """Plot the lines of the spectrum that perception evaluates, from 1 Hz to 2 kHz, and the level at which a sine is felt.

    The one plot has a bar for each line, and the amplitude over frequency of a single sine at the detection
    threshold; there is none where nothing varies.
    """
    lines = percept.spectrum
    kept = (lines.frequency >= LOWEST) & (lines.frequency <= HIGHEST) & (lines.amplitude > 0)
    if not np.any(kept):
        return []
    kept &= lines.amplitude > 1e-5 * lines.amplitude[kept].max()
    frequency, amplitude = lines.frequency[kept], lines.amplitude[kept]
    unit = "m" if lines.signal == "skin_displacement" else "N"
    title = f"Spectrum of the {'displacement of the skin' if unit == 'm' else 'lateral force'}"
    prefix, scale = prefix_for(float(amplitude.max()), unit)
    shown_unit = pretty_unit(prefix + unit)
    level, name = detection(percept, scenario)
    words = Axis(f"amplitude [{shown_unit}]", "1", is_logarithmic=True)
    plot = figure(title, FREQUENCY, words, [PlottedCurve(_FREQUENCIES, level / scale, name, COLOURS[1])])
    (curve,) = plot["data"]
    bars = {
        "type": "bar",
        "x": frequency.tolist(),
        "y": (amplitude / scale).tolist(),
        "width": (0.02 * frequency).tolist(),
        "marker": {"color": COLOURS[0]},
        "name": "lines of the spectrum",
        "hovertemplate": f"%{{y:.4~g}} {shown_unit}<extra>line</extra>",
    }
    plot["data"] = [
        bars,
        curve | {"showlegend": True, "hovertemplate": f"%{{y:.4~g}} {shown_unit}<extra>{name}</extra>"},
    ]
    layout, top = plot["layout"], float(amplitude.max())
    lowest = max(float(amplitude.min()), 1e-4 * top)
    highest = max(top, min(float(np.nanmin(level)), 100 * top))
    layout["xaxis"]["range"] = [math.log10(LOWEST), math.log10(HIGHEST)]
    layout["yaxis"]["range"] = [math.log10(lowest / scale) - 0.2, math.log10(highest / scale) + 0.3]
    layout["showlegend"], layout["margin"]["b"] = True, 62
    return [plot]


def detection(percept: Percept, scenario: Scenario) -> tuple[NDArray[Any], str]:
    """Return the amplitude (n,) [N or m] of a single sine of a certain level over frequency, and its name.

    A = 10^(L/20) / (max_c w_c(f) |C(f)|) with level L, weights w_c of the channels and compliance C of the
    skin: the inverse of the level that `electrovib.perceive` computes for one line. NaN where no channel is
    sensitive. The level is that of the detection threshold, measured or published; without any, that at which
    the sine is felt as strongly as the drive.
    """
    person = scenario.perception or Perception()
    given = person.compliance or scenario.finger
    if percept.sensation is not None:
        low, high = just_felt(Stimulus(percept.spectrum, person, given), _FREQUENCIES)
        middle = np.sqrt(low * high)
        whose = "published, middle" if percept.left else "of the perception"
        return np.where(
            np.isfinite(middle), middle, np.nan
        ), f"detection threshold of a single sine ({whose})"
    weight = np.max([channel.weight(_FREQUENCIES) for channel in person.channels], axis=0)
    if given is not None and percept.spectrum.signal != "skin_displacement":
        weight = weight * np.abs(given.compliance(_FREQUENCIES))
    felt_alike = np.divide(
        10 ** (percept.level / 20), weight, out=np.full(weight.shape, np.nan), where=weight > 0
    )
    return felt_alike, "a single sine felt as strongly (no threshold is known)"


_COLOURS: Final = (*COLOURS, *FURTHER_COLOURS)


def laws(shown: Computed, others: Mapping[str, Computed]) -> list[dict[str, Any]]:
    """Plot the force of each law over time and over frequency; the law of the page has a solid line."""
    cases = {type(shown.scenario.force).__name__: shown, **others}
    plots = []
    for title, signal, coordinate, x in (
        ("Electrostatic force of each law", "electrostatic_force", "time", TIME),
        ("Mean force of each law under a sine", "mean_force", "frequency", FREQUENCY),
    ):
        curves = [
            PlottedCurve(
                case.values(coordinate),
                case.values(signal),
                name,
                _COLOURS[index % len(_COLOURS)],
                "dash" if index else "solid",
            )
            for index, (name, case) in enumerate(cases.items())
            if case.has(signal)
        ]
        if curves:
            plots.append(
                figure(title, x, Axis("force", "N", is_logarithmic=coordinate == "frequency"), curves)
            )
    return plots


def recorded(shown: Computed, measured: xarray.Dataset) -> list[dict[str, Any]]:
    """Plot each signal of a recording with the same signal of the page; the modulus of complex ones."""
    plots = []
    for name in map(str, measured.data_vars):
        dims = measured[name].dims
        if name not in SIGNALS or dims not in (("time",), ("frequency",)):
            continue
        dimension = str(dims[0])
        cases = [("recorded", measured, NEUTRAL, 4.0), ("computed", shown.trace, COLOURS[0], 1.8)]
        curves = [
            PlottedCurve(
                each[dimension].values,
                np.abs(values) if np.iscomplexobj(values) else values,
                words,
                colour,
                width=width,
            )
            for words, each, colour, width in cases
            if name in each and each[name].dims == dims
            for values in [each[name].values]
        ]
        declared = SIGNALS[name]
        axis = Axis(declared.doc.partition(",")[0], declared.unit, is_logarithmic=dimension == "frequency")
        plots.append(figure(name.replace("_", " "), TIME if dimension == "time" else FREQUENCY, axis, curves))
    return plots


TIME: Final = Axis("time", "s")
_VOLTAGES: Final = {
    "drive_voltage": "drive",
    "plate_voltage": "plate, behind the amplifier",
    "effective_voltage": "effective",
}
_COMPARABLE: Final = 20.0
"""Ratio of the largest voltages of two layers up to which both can be read on one axis."""
_CURRENTS: Final = {"drive_current": "drive"}
_ATTRACTION: Final = {"electrostatic_force": "attraction"}
_FORCES: Final = {
    "lateral_force": "friction",
    "lateral_force_measured": "friction as the tribometer reads it",
}


def over_time(shown: Computed, pinned: Sequence[Computed] = ()) -> list[dict[str, Any]]:
    """Plot voltages, attraction, friction and fields over time; results that are pinned have dashed curves."""
    plots = [
        _signals("Voltage", Axis("voltage", "V"), _VOLTAGES, shown, pinned),
        _signals("Drive current", Axis("current", "A"), _CURRENTS, shown, pinned),
        _signals("Electrostatic force", Axis("force", "N"), _ATTRACTION, shown, pinned),
        _signals("Lateral force", Axis("force", "N"), _FORCES, shown, pinned),
        _layers(shown),
    ]
    return [plot for plot in plots if plot is not None][:4]


def _signals(
    title: str, axis: Axis, names: dict[str, str], shown: Computed, pinned: Sequence[Computed]
) -> dict[str, Any] | None:
    curves = [
        PlottedCurve(
            each.values("time"),
            each.values(signal),
            f"{words}{kept}",
            COLOURS[index],
            dash,
            in_legend=not kept,
        )
        for each, dash, kept in with_kept(shown, pinned)
        for index, (signal, words) in enumerate(names.items())
        if _is_known(each, signal)
    ]
    if not curves:
        return None
    present = [words for signal, words in names.items() if _is_known(shown, signal)]
    if len(names) > 1 and len(present) == 1:  # the legend, which would name the only curve, is omitted
        title = f"{title}: {present[0]}"
    return figure(title, TIME, axis, curves)


def unknown_signals(shown: Computed) -> list[str]:
    """Return the names, in words, of the signals over time that have no value at all."""
    names = (*_VOLTAGES, *_CURRENTS, *_ATTRACTION, *_FORCES)
    return [name.replace("_", " ") for name in names if shown.has(name) and not _is_known(shown, name)]


def _is_known(shown: Computed, signal: str) -> bool:
    """Return whether a result has a signal over time with a finite value."""
    if not shown.has(signal) or shown.dimensions(signal) != ("time",):
        return False
    return bool(np.isfinite(shown.values(signal)).any())


def _layers(shown: Computed) -> dict[str, Any] | None:
    """Plot the voltage across each layer, its field times its thickness; relative ones where they differ by much."""
    if not shown.has("field"):
        return None
    layers = shown.scenario.stack.layers
    colours = layer_colours(list(layers))
    voltages = {name: shown.values("field", layer=name) * layer.thickness for name, layer in layers.items()}
    largest = {name: float(np.nanmax(np.abs(each), initial=0.0)) for name, each in voltages.items()}
    sizes = [each for each in largest.values() if each > 0]
    is_relative = bool(sizes) and max(sizes) > _COMPARABLE * min(sizes)
    curves = [
        PlottedCurve(
            shown.values("time"),
            each / largest[name] if is_relative and largest[name] > 0 else each,
            name.replace("_", " ")
            + (f" (1 is {pretty_quantity(largest[name], 'V', digits=3)})" if is_relative else ""),
            colours[name],
            LAYER_DASHES[place % len(LAYER_DASHES)],
        )
        for place, (name, each) in enumerate(voltages.items())
    ]
    if is_relative:
        return figure(
            "Voltage across each layer over its largest", TIME, Axis("voltage / largest", "1"), curves
        )
    return figure("Voltage across each layer", TIME, Axis("voltage", "V"), curves)


FREQUENCY: Final = Axis("frequency", "Hz", is_logarithmic=True)


def over_frequency(
    shown: Computed, pinned: Sequence[Computed] = (), *, band: Mapping[str, NDArray[Any]] | None = None
) -> list[dict[str, Any]]:
    """Plot the mean force, the time constant of each layer, its share of the voltage, and the impedance.

    Results that are pinned have dashed curves. `band` has ``frequency`` [Hz], ``low`` and ``high`` [N] of a
    population of fingers, each of shape (n,).
    """
    plots = [_force(shown, pinned, band), _time_constant(shown), _shares(shown), _impedance(shown, pinned)]
    return [plot for plot in plots if plot is not None]


def _force(
    shown: Computed, pinned: Sequence[Computed], band: Mapping[str, NDArray[Any]] | None
) -> dict[str, Any] | None:
    if not shown.has("mean_force"):
        return None
    curves = []
    if band is not None:
        curves.append(
            PlottedCurve(
                band["frequency"],
                band["high"],
                "5 to 95 % of fingers",
                COLOURS[5],
                fill_from=band["low"],
            )
        )
    curves += [
        PlottedCurve(
            each.values("frequency"),
            each.values("mean_force"),
            f"mean force of the scenario{kept}",
            dash=dash,
            in_legend=not kept,
        )
        for each, dash, kept in with_kept(shown, pinned)
        if each.has("mean_force")
    ]
    return figure("Mean force under a sine", FREQUENCY, Axis("force", "N", is_logarithmic=True), curves)


def _time_constant(shown: Computed) -> dict[str, Any] | None:
    """Plot permittivity over conductivity, the time in which a layer loses its charge."""
    colours = layer_colours(list(shown.scenario.stack.layers))
    frequency = shown.values("frequency")
    curves = []
    for place, name in enumerate(shown.scenario.stack.layers):
        value = shown.values("permittivity", layer=name)
        loss = -value.imag * 2 * np.pi * frequency
        if np.any(loss > 0):
            with np.errstate(divide="ignore"):
                tau = np.where(loss > 0, value.real / np.where(loss > 0, loss, 1.0), np.nan)
            dash = LAYER_DASHES[place % len(LAYER_DASHES)]
            curves.append(PlottedCurve(frequency, tau, name.replace("_", " "), colours[name], dash))
    if not curves:
        return None
    words = Axis("time constant", "s", is_logarithmic=True)
    return figure("Time constant of each layer: permittivity / conductivity", FREQUENCY, words, curves)


def _shares(shown: Computed) -> dict[str, Any] | None:
    if not shown.has("field_gain"):
        return None
    colours = layer_colours(list(shown.scenario.stack.layers))
    curves = [
        PlottedCurve(
            shown.values("frequency"),
            np.abs(shown.values("field_gain", layer=name)),
            name.replace("_", " "),
            colours[name],
            LAYER_DASHES[place % len(LAYER_DASHES)],
        )
        for place, name in enumerate(shown.scenario.stack.layers)
    ]
    words = Axis("share", "1", is_logarithmic=True)
    return figure("Share of the voltage across each layer", FREQUENCY, words, curves)


def _impedance(shown: Computed, pinned: Sequence[Computed]) -> dict[str, Any] | None:
    curves = [
        PlottedCurve(
            each.values("frequency"),
            np.abs(each.values("impedance")),
            f"magnitude{kept}",
            NEUTRAL if kept else COLOURS[2],
            dash,
            in_legend=not kept,
        )
        for each, dash, kept in with_kept(shown, pinned)
        if each.has("impedance")
    ]
    if not curves:
        return None
    words = Axis("impedance", "ohm", is_logarithmic=True, lowest=1e-12)
    return figure("Magnitude of the impedance", FREQUENCY, words, curves)
