"""Plot of the spectrum that a finger feels."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.apps.explorer.pictures.axis import Axis
from electrovib.apps.explorer.pictures.figure import PlottedCurve, figure
from electrovib.apps.explorer.pictures.over_frequency import FREQUENCY
from electrovib.apps.explorer.pictures.over_time import TIME
from electrovib.core.signals import SIGNALS
from electrovib.physics.perception import Perception
from electrovib.studies.sensation import just_felt
from electrovib.view.style import COLOURS, FURTHER_COLOURS, NEUTRAL
from electrovib.view.units import prefix_for, pretty_unit

if TYPE_CHECKING:
    import xarray
    from numpy.typing import NDArray

    from electrovib.apps.explorer.computed import Computed
    from electrovib.scenario import Scenario
    from electrovib.studies.percept import Percept

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
        low, high = just_felt(percept.spectrum, person, given, _FREQUENCIES)
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
