"""Plot of the spectrum that a finger feels."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.apps.explorer.pictures.figure import Axis, figure
from electrovib.apps.explorer.pictures.over_frequency import FREQUENCY
from electrovib.view.style import COLOURS
from electrovib.view.units import prefix_for, pretty_unit

if TYPE_CHECKING:
    from electrovib.study.percept import Percept


def felt(percept: Percept) -> list[dict[str, Any]]:
    """Plot the lines of the spectrum that perception evaluates, from 1 Hz to 2 kHz.

    Parameters
    ----------
    percept : Percept
        From `electrovib.perceive`.

    Returns
    -------
    figures : list of dict
        One plot with a stem for each line; empty where nothing varies.
    """
    lines = percept.spectrum
    kept = (lines.frequency >= 1) & (lines.frequency <= 2000) & (lines.amplitude > 0)
    if not np.any(kept):
        return []
    kept &= lines.amplitude > 1e-5 * lines.amplitude[kept].max()
    frequency, amplitude = lines.frequency[kept], lines.amplitude[kept]
    unit = "m" if lines.signal == "skin_displacement" else "N"
    plot = figure("Spectrum", FREQUENCY, Axis("amplitude", unit), [])
    prefix, scale = prefix_for(float(amplitude.max()), unit)
    del plot["layout"]["yaxis"]["range"]  # that of no curves
    plot["layout"]["yaxis"]["title"]["text"] = f"amplitude [{pretty_unit(prefix + unit)}]"
    plot["data"] = [
        {
            "type": "bar",
            "x": frequency.tolist(),
            "y": (amplitude / scale).tolist(),
            "width": (0.04 * frequency).tolist(),
            "marker": {"color": COLOURS[0]},
            "name": lines.signal.replace("_", " "),
        }
    ]
    return [plot]
