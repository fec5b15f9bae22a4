"""Figures of the explanations, drawn from `computed` into the repository by ``python docs/_ext/figures.py``.

A test draws them again and compares the curves.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any, Final

import computed
import numpy as np
from docutils import nodes
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from sphinx.application import Sphinx

from electrovib.view.pages import to_svg
from electrovib.view.style import COLOURS, LAYER_COLOURS, NEUTRAL, new_figure, style

FOLDER: Final = Path(__file__).parents[1] / "images" / "computed"
MAPS: Final = (0.0, 10.0, 20.0, 30.0, 40.0)
"""Voltages of the maps of a contact [V]."""
LAW_COLOURS: Final = dict(zip(computed.FORMS, COLOURS, strict=False))
LAYERS: Final = (
    ("electrode", 0.0, 0.5, "#c9c9c9"),
    ("insulator", 0.5, 1.0, LAYER_COLOURS["insulator"]),
    ("stratum corneum", 1.5, 1.4, LAYER_COLOURS["stratum_corneum"]),
    ("conducting tissue", 2.9, 0.8, "#f2c6b4"),
)
"""Name, lower edge, thickness (not to scale) and colour of each layer of the drawing."""


def drawn(name: str) -> str:
    """Draw a figure as SVG."""
    with style():
        return to_svg(FIGURES[name]())


def mechanism() -> Figure:
    """Draw the charges of the law of Vezzoli et al. 2014, and the attraction after a step and under a sine."""
    figure = new_figure((8.4, 6.6))
    (early, late), (left, right) = figure.subplots(2, 2, height_ratios=[1.0, 1.2])
    layers(early, "Charges in the law of Vezzoli et al. 2014: just after a step ...", at=2.9)
    layers(late, "... and several time constants later", at=1.5)
    for number, (label, found) in enumerate(computed.responses().items()):
        line: dict[str, Any] = {"color": COLOURS[number], "label": label, "ls": ("-", "--", "-.")[number]}
        left.plot(1e3 * found.time, found.force, **line)
        right.semilogx(found.frequency, found.mean, **line)
    tau = computed.time_constant()
    left.axvline(1e3 * tau / 2, color=NEUTRAL, lw=0.8)
    left.text(1e3 * tau / 2 + 0.4, 0.5, f"$\\tau/2$ = {1e3 * tau / 2:.2f} ms", color="#444444")
    corner = 1 / (2 * np.pi * tau)
    right.axvline(corner, color=NEUTRAL, lw=0.8)
    right.text(corner * 1.15, 0.1, f"$1/(2\\pi\\tau)$ = {corner:.1f} Hz", color="#444444")
    left.set(xlabel="time after the step [ms]", ylabel="attraction over that just after the step")
    left.set(title="It fades after a step ...", ylim=(0, 1.35))
    right.set(xlabel="frequency of the sine [Hz]", ylabel="mean attraction over that at 10 kHz")
    right.set(title="... and grows with frequency", ylim=(0, 1.35))
    left.legend(loc="upper right")
    return figure


def layers(axes: Axes, title: str, *, at: float) -> None:
    """Draw the layers with the charge of the plate, and the opposite charge at one height."""
    for name, low, thickness, colour in LAYERS:
        axes.add_patch(Rectangle((0, low), 10, thickness, color=colour, alpha=0.35, lw=0))
        axes.text(10.2, low + thickness / 2, name, va="center")
    for place in np.linspace(0.8, 9.2, 8):
        axes.text(place, 0.36, "+", ha="center", va="center", weight="bold", color="#b00000")
        axes.text(place, at + 0.13, "\u2212", ha="center", va="center", weight="bold", color="#0030b0")
    axes.set(title=title, xlim=(0, 14.5), ylim=(0, 3.75))
    axes.axis("off")


def laws() -> Figure:
    """Draw the static force of each law over the gap, on the film and on the coating."""
    figure = new_figure((8.4, 4.0))
    for axes, found in zip(figure.subplots(1, 2), computed.forces(), strict=True):
        axes.loglog(
            1e6 * found.gap, found.in_gap, color=LAW_COLOURS["MaxwellStressInGap"], label="MaxwellStressInGap"
        )
        for law, force in found.others.items():
            if law != "MaxwellStressInGap":
                axes.axhline(force, color=LAW_COLOURS[law], ls="--", label=law)
        axes.set(xlabel="gap [µm]", ylabel="static attraction on 1 cm² [N]", title=found.stack.name)
        axes.set_ylim(1e-4, 300)
    axes.legend(loc="upper right")
    return figure


def causality() -> Figure:
    """Draw the effective voltage by both readings of the formula, before and during a ramp."""
    found = computed.readings()
    figure = new_figure((7.0, 3.4))
    axes = figure.add_subplot()
    axes.axvspan(-20, 0, color="#eeeeee", lw=0)
    axes.text(-19.5, 1.02, "the voltage is still 0", color="#444444")
    axes.plot(1e3 * found.time, found.as_printed, color=COLOURS[1], ls="--", label="Vezzoli2014PerFrequency")
    axes.plot(1e3 * found.time, found.causal, color=COLOURS[0], label="Vezzoli2014Causal")
    axes.set(xlabel="time from the beginning of the ramp [ms]", ylabel="effective voltage, relative")
    axes.set(xlim=(-20, 40), ylim=(-0.1, 1.35))
    axes.legend(loc="upper right")
    return figure


def tutorial() -> Figure:
    """Draw the recording of the tutorial with the scenario before and after the fit."""
    found = computed.recording()
    figure = new_figure((7.0, 3.2))
    axes = figure.add_subplot()
    axes.plot(1e3 * found.time, 1e3 * found.recorded, ".", ms=2.5, color=NEUTRAL, label="recording")
    for number, (thickness, force) in enumerate(found.curves.items()):
        label = ("my.toml, {:.0f} µm", "fit, {:.1f} µm")[number].format(1e6 * thickness)
        axes.plot(1e3 * found.time, 1e3 * force, ("--", "-")[number], color=COLOURS[number], label=label)
    axes.set(xlabel="time [ms]", ylabel="attraction [mN]")
    axes.legend(loc="upper right")
    return figure


def gap() -> Figure:
    """Draw where a rough contact is attracted, and its attraction over the voltage beside plates at the mean gap."""
    found = computed.gaps()
    figure = new_figure((8.4, 3.6))
    where, over = figure.subplots(1, 2)
    where.plot(1e6 * found.gap, 100 * found.area, color=COLOURS[0], label="area")
    where.plot(1e6 * found.gap, 100 * found.attraction, color=COLOURS[1], ls="--", label="attraction")
    mean = 1e6 * float(found.found.mean_gap[-1])
    where.axvline(mean, color=NEUTRAL, lw=0.8)
    where.text(mean + 0.1, 8, "mean gap", color="#444444")
    where.set(
        xlabel="gap up to [µm]", ylabel="share [%]", ylim=(0, 105), title="At 40 V: where the attraction is"
    )
    where.legend(loc="center right")
    voltage = found.found.voltage
    over.plot(voltage, 1e-3 * found.found.attraction, color=COLOURS[1], ls="--", label="rough contact")
    over.plot(voltage, 1e-3 * found.found.plates, color=COLOURS[2], label="plates at the mean gap")
    over.axhline(1e-3 * found.found.stack.pressure, color=NEUTRAL, lw=0.8)
    over.text(1, 1e-3 * found.found.stack.pressure + 0.15, "load", color="#444444")
    over.set(
        xlabel="voltage [V]", ylabel="attraction per area [kPa]", title="Over the voltage", ylim=(-0.3, 5.8)
    )
    over.legend(loc="upper left", bbox_to_anchor=(0, 0.82))
    return figure


def maps() -> Figure:
    """Draw the gaps of that contact at some voltages side by side, in cells of one width: a page may show one at a time."""
    found = computed.gaps().found
    figure = new_figure((3.6 * len(MAPS), 3.3))
    figure.set_layout_engine("none")
    largest = 1e6 * max(float(rest.gap.max()) for rest in found.rests)
    for place, volts in enumerate(MAPS):
        rest = found.rests[list(found.voltage).index(volts)]
        axes = figure.add_axes(((place + 0.2) / len(MAPS), 0.17, 0.7 / len(MAPS), 0.7))
        axes.set(xlabel="along the plate [mm]", ylabel="across the plate [mm]", facecolor=COLOURS[1])
        axes.set_title(f"{volts:g} V: {100 * rest.contact_share:.2g} % touches (orange)")
        away = np.ma.masked_where(rest.pressure > 0, 1e6 * rest.gap)
        look: dict[str, Any] = {"cmap": "Blues", "vmin": 0.0, "vmax": largest, "interpolation": "none"}
        image = axes.imshow(away, origin="lower", extent=(0.0, 1.0, 0.0, 1.0), **look)
        axes.grid(visible=False)
        figure.colorbar(image, ax=axes, label="gap [µm]")
    return figure


FIGURES: Final = {
    "gap": gap,
    "maps": maps,
    "mechanism": mechanism,
    "laws": laws,
    "causality": causality,
    "tutorial": tutorial,
}
"""File name of each figure to the function that draws it."""


def scrollable(
    app: Sphinx, name: str, template: str, context: dict[str, Any], document: nodes.document | None
) -> None:
    """Let a figure that is wider than a phone be scrolled with the keyboard."""
    del app, name, template, document
    if "body" in context:
        context["body"] = re.sub(
            r'<p>(?=<img (?![^>]*class="equation))', '<p class="figure" tabindex="0">', context["body"]
        )


def setup(app: Sphinx) -> dict[str, bool]:
    """Change the pages as they are written."""
    app.connect("html-page-context", scrollable)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


if __name__ == "__main__":
    FOLDER.mkdir(parents=True, exist_ok=True)
    for name in FIGURES:
        (FOLDER / f"{name}.svg").write_text(drawn(name), encoding="utf-8")
