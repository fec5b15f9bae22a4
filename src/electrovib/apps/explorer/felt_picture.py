"""The plot of what is felt: the spectrum of a drive beside the detection threshold of a single sine."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.apps.explorer.pictures import FREQUENCY, Axis, PlottedCurve, figure, hover
from electrovib.physics.perception import Perception
from electrovib.studies.felt_spectrum import Stimulus, just_felt
from electrovib.view.style import COLOURS, prefix_for, pretty_unit

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from electrovib.scenario import Scenario
    from electrovib.studies.perceive import Percept

LOWEST, HIGHEST = 1.0, 2000.0
"""Frequencies of the plot of what is felt [Hz]."""
_FREQUENCIES: Final = np.geomspace(LOWEST, HIGHEST, 120)
_SPREAD: Final = "lowest to highest threshold that is possible"


def felt(percept: Percept, scenario: Scenario) -> list[dict[str, Any]]:
    """Plot the lines of the spectrum that perception evaluates, from 1 Hz to 2 kHz, and the level at which a sine is felt.

    The one plot has a bar for each line, and the amplitude over frequency of a single sine at the detection
    threshold, in the band of its spread where one is known; there is none where nothing varies.
    """
    lines = percept.spectrum
    kept = (lines.frequency >= LOWEST) & (lines.frequency <= HIGHEST) & (lines.amplitude > 0)
    if not np.any(kept):
        return []
    kept &= lines.amplitude > 1e-5 * lines.amplitude[kept].max()
    frequency, amplitude = lines.frequency[kept], lines.amplitude[kept]
    unit = "m" if lines.signal == "skin_displacement" else "N"
    title = f"Spectrum of the {'displacement of the skin' if unit == 'm' else 'lateral force'}"
    top = float(amplitude.max())
    prefix, scale = prefix_for(top, unit)
    shown_unit = pretty_unit(prefix + unit)
    low, level, high, name = detection(percept, scenario)
    words = Axis(f"amplitude [{shown_unit}]", "1", is_logarithmic=True)
    spread = PlottedCurve(_FREQUENCIES, high / scale, _SPREAD, COLOURS[1], fill_from=low / scale)
    curve = PlottedCurve(_FREQUENCIES, level / scale, name, COLOURS[1])
    plot = figure(title, FREQUENCY, words, [*([spread] if np.any(high > low) else []), curve])
    plot["data"][-1] |= {"showlegend": True, "hovertemplate": hover(shown_unit, name)}
    bars = {
        "type": "bar", "x": frequency.tolist(), "y": (amplitude / scale).tolist(), "width": (0.02 * frequency).tolist(),
        "marker": {"color": COLOURS[0]}, "name": "lines of the spectrum", "hovertemplate": hover(shown_unit, "line"),
    }  # fmt: skip
    plot["data"].insert(0, bars)
    layout = plot["layout"]
    least = float(np.nanmin(level))
    lowest = max(min(float(amplitude.min()), float(np.nanmin(low))), 1e-4 * top)
    highest = max(top, min(least, 100 * top))
    layout["xaxis"]["range"] = [math.log10(LOWEST), math.log10(HIGHEST)]
    layout["yaxis"]["range"] = [math.log10(lowest / scale) - 0.2, math.log10(highest / scale) + 0.3]
    layout["showlegend"], layout["margin"]["b"] = True, 80
    return [plot]


def detection(percept: Percept, scenario: Scenario) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any], str]:
    """Return the amplitude (n,) [N or m] of a single sine of a certain level over frequency, and its name.

    The amplitude stands between the lowest and the highest possible one; all three are the same without a threshold.

    A = 10^(L/20) / (max_c w_c(f) |C(f)|) with level L, weights w_c of the channels and compliance C of the
    skin: the inverse of the level that `electrovib.perceive` computes for one line. NaN where no channel is
    sensitive. The level is that of the detection threshold, measured or published; without any, that at which
    the sine is felt as strongly as the drive.
    """
    person = scenario.perception or Perception()
    given = person.compliance or scenario.finger
    if percept.sensation is not None:
        low, high = just_felt(Stimulus(percept.spectrum, person, given), _FREQUENCIES)
        low, high = (np.where(np.isfinite(high), each, np.nan) for each in (low, high))
        whose = "published, middle" if percept.left else "of the perception"
        return low, np.sqrt(low * high), high, f"detection threshold of a single sine ({whose})"
    weight = np.max([channel.weight(_FREQUENCIES) for channel in person.channels], axis=0)
    if given is not None and percept.spectrum.signal != "skin_displacement":
        weight = weight * np.abs(given.compliance(_FREQUENCIES))
    unfelt = np.full(weight.shape, np.nan)
    felt_alike = np.divide(10 ** (percept.level / 20), weight, out=unfelt, where=weight > 0)
    return felt_alike, felt_alike, felt_alike, "a single sine felt as strongly (no threshold is known)"
