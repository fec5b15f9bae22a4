"""The two pictures at the beginning of README and site: `python docs/_ext/first_pictures.py` draws them anew."""

from __future__ import annotations

from pathlib import Path
from typing import Final

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

import electrovib as ev
from electrovib.papers.vezzoli_2014 import drawings, values
from electrovib.view.pages import to_png
from electrovib.view.style import COLOURS, new_figure, style

FOLDER: Final = Path(__file__).parents[1] / "images"
INK: Final = "#333333"
PRESET: Final = "vezzoli_2014/fig6"
MOMENTS: Final = {"before": -8e-3, "at the peak": values.RAMP, "faded": 0.1}
"""Times of the three small drawings from the beginning of the ramp [s]."""
LETTERS: Final = {"first": 11.0, "evidence": 9.8}
"""Size of the letters of each picture, large enough for a telephone, on which it is 350 pixels wide [pt]."""


def first() -> Figure:
    """Draw the voltage, the attraction that rises and fades, the measured range, and where the charge is."""
    scenario = ev.load(PRESET)
    time = np.linspace(0.0, 0.12, 481)
    trace = ev.simulate(scenario, time=time)
    states = [drawings.Charge(0.0, 0.0, 0.0, 0.0), *drawings.charges(scenario, list(MOMENTS.values())[1:])]
    figure = new_figure((5.0, 4.7))
    rows = figure.add_gridspec(3, 3, height_ratios=(0.55, 1.45, 1.5))
    above = figure.add_subplot(rows[0, :])
    axes = figure.add_subplot(rows[1, :], sharex=above)
    ms, force = 1e3 * np.append(-12e-3, time), 1e3 * np.append(0.0, trace.electrostatic_force.values)
    above.plot(ms, 1e-3 * np.append(0.0, trace.drive_voltage.values), color=INK)
    above.set(ylabel="[kV]", ylim=(-0.1, 1.25), yticks=(0, 1))
    above.text(44, 0.45, "voltage on the plate", color=INK)
    above.label_outer()
    axes.plot(ms, force, color=COLOURS[0], linewidth=2.6)
    axes.text(44, 1.7, "attraction of the\nfinger, computed", color=COLOURS[0], va="center")
    low, high = (1e3 * each for each in values.FORCE_MEASURED)
    axes.plot((127, 127), (low, high), color=COLOURS[1], linewidth=7, solid_capstyle="butt")
    axes.text(
        122,
        4.2,
        "measured change of friction,\n8 people: 2 to 5 mN",
        color=COLOURS[1],
        ha="right",
        va="center",
    )
    axes.set(
        xlabel="time [ms]", ylabel="force [mN]", xlim=(-12, 131), ylim=(-0.3, 5.4), xticks=range(0, 121, 20)
    )
    largest, full = max(each.force for each in states), states[-1].plate
    for number, ((words, moment), state) in enumerate(zip(MOMENTS.items(), states, strict=True), start=1):
        place = 1e3 * moment, 1e3 * state.force
        axes.plot(*place, "o", markersize=15, color="white", markeredgecolor=COLOURS[0], zorder=4)
        axes.annotate(str(number), place, ha="center", va="center_baseline", color=COLOURS[0], zorder=5)
        small = figure.add_subplot(rows[2, number - 1])
        drawings.sheet(small, 10.1, 6.0, title=f"{number}  {words}")
        drawings.stack(small, state, full=full, force=largest, most=8, size=9)
    return figure


def laws() -> Figure:
    """Draw the laws against what was measured on fingers."""
    drawing = ev.evidence("finger").document.figures[0]
    figure = new_figure(drawing.size)
    drawing.plot(figure)
    return figure


PICTURES: Final = {"first": first, "evidence": laws}
"""File name of each picture to the function that draws it."""


def picture(name: str) -> bytes:
    """Return a picture as it is in the repository."""
    sizes = ("font.size", "axes.titlesize", "axes.labelsize", "xtick.labelsize", "ytick.labelsize")
    with style(), mpl.rc_context(dict.fromkeys(sizes, LETTERS[name])):
        return to_png(PICTURES[name](), resolution=200.0)


if __name__ == "__main__":
    for name in PICTURES:
        (FOLDER / f"{name}.png").write_bytes(picture(name))
