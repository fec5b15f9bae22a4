"""Figures 1, 3 and 5 of the paper, drawn anew: the principle and the set-up, the circuit, and three states of the charge."""

from __future__ import annotations

import functools
import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.answer import Drawing
from electrovib.papers.vezzoli_2014 import values
from electrovib.papers.vezzoli_2014.values import scenarios
from electrovib.solve.simulate import simulate

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from electrovib.scenario import Scenario

STATES: Final = {
    "the voltage is switched on": 1e-6,
    "half has crossed the skin": values.TAU_MODEL * np.log(2),
    "all has crossed the skin": 8 * values.TAU_MODEL,
}
"""Times of figure 5 after the step [s]."""


@dataclass(frozen=True)
class Charge:
    """Charge on the plate, on the surface of the film and in the finger [C], and the attraction [N], at one time."""

    plate: float
    film: float
    finger: float
    force: float


def charges(scenario: Scenario, times: Sequence[float]) -> list[Charge]:
    """Compute where the charge is at these times, from the displacement in film and skin."""
    trace = simulate(scenario, time=np.array([0.0, *times])).isel(time=slice(1, None))
    film, skin = (
        values.AREA * trace.displacement.sel(layer=name).values for name in ("insulator", "stratum_corneum")
    )
    states = np.array([film, skin - film, -skin, trace.electrostatic_force.values])
    return [Charge(*map(float, state)) for state in states.T]


@functools.cache
def _told() -> dict[str, Any]:
    """Read the colours, and what the figures consist of."""
    return tomllib.loads(Path(__file__).with_name("drawings.toml").read_text(encoding="utf-8"))


def _colour(name: str) -> str:
    return str(_told()["colours"][name])


def panels() -> dict[int, Drawing]:
    """Return the drawings by the number of their figure."""
    insulator, skin = values.insulator_capacitance(), values.skin_capacitance()
    numbers = {
        "insulator": insulator / 1e-12,
        "skin": skin / 1e-9,
        "resistance": values.TAU_MODEL / skin / 1e6,
    }
    return {
        int(number): Drawing(
            id=f"fig{number}",
            title=f"Figure {number}: {each['title']}",
            plot=functools.partial(sheets, drawn=each["sheets"]) if "sheets" in each else states,
            size=(8.2, each["height"]),
            caption=each["caption"].format(**numbers),
        )
        for number, each in _told()["figures"].items()
    }


def sheets(figure: Figure, drawn: Sequence[Mapping[str, Any]]) -> None:
    """Draw sheets side by side, with equal units."""
    ratios = [each["size"][0] for each in drawn]
    axes = figure.subplots(1, len(drawn), width_ratios=ratios, squeeze=False)[0]
    for ax, each in zip(axes, drawn, strict=True):
        ax.set_aspect("equal")
        sheet(ax, *each["size"], title=each.get("title", ""), draw=each["draw"])


def states(figure: Figure) -> None:
    """Draw where the charge is after a step of the voltage, at three times."""
    step = scenarios()["fig6"].replace({"drive": {"model": "Step", "level": values.VOLTAGE}})
    found = charges(step, list(STATES.values()))
    for ax, state, (words, time) in zip(figure.subplots(1, 3), found, STATES.items(), strict=True):
        sheet(ax, 10.2, 6.2, title=f"{words}\nat {1e3 * time:.1f} ms: {1e3 * state.force:.1f} mN")
        stack(ax, state, full=found[-1].plate, force=found[0].force, size=8)


def stack(ax: Axes, state: Charge, *, full: float, force: float, most: int = 10, **more: Any) -> None:
    """Draw the layers with their charge, `most` signs for `full`, and the attraction, an arrow that is longest at `force`."""
    layers = (("plate", 0.0, 0.8), ("film", 0.8, 0.8), ("skin", 1.6, 0.9), ("finger", 2.5, 1.5))
    for name, low, height in layers:
        box(ax, (0, low, 10, height), colour=name)
        words(ax, name, at=(0.2, low + height / 2), **more)
    for charge, height in ((state.plate, 0.5), (state.film, 1.3), (state.finger, 2.8)):
        count = most * abs(charge) / full
        signs(ax, "+" if charge > 0 else "\u2212", count=count, height=height, ends=(2.8, 9.8))
    if state.force > 0.01 * force:
        arrow(ax, ((6.3, 4.1 + 1.9 * state.force / force), (6.3, 4.1)))


def sheet(ax: Axes, width: float, height: float, *, title: str = "", draw: Sequence[Any] = ()) -> None:
    """Make an Axes a sheet without scales, and draw on it what is listed."""
    ax.set(xlim=(0, width), ylim=(0, height), title=title)
    ax.axis("off")
    for each in draw:
        (kind, what), *more = each.items()
        KINDS[kind](ax, what, **dict(more))


def words(ax: Axes, text: str, *, at: tuple[float, float], colour: str = "ink", **more: Any) -> None:
    """Write words, by default to the right of a place."""
    ax.text(at[0], at[1], text, color=_colour(colour), zorder=5, **({"va": "center"} | more))


def box(
    ax: Axes,
    sides: Sequence[float],
    *,
    colour: str = "paper",
    rounding: float = 0.01,
    words: str = "",
    **more: Any,
) -> None:
    """Draw a box with words in its middle."""
    from matplotlib.patches import FancyBboxPatch

    left, low, width, height = sides
    shape = f"round,pad=0,rounding_size={rounding}"
    look: Any = {"facecolor": _colour(colour), "edgecolor": _colour("ink"), "linewidth": 0.8, "zorder": 3}
    ax.add_patch(FancyBboxPatch((left, low), width, height, boxstyle=shape, **look))
    KINDS["words"](ax, words, at=(left + width / 2, low + height / 2), ha="center", **more)


def wire(ax: Axes, points: Sequence[Sequence[float]], *, width: float = 1.3) -> None:
    """Draw a line through points."""
    ax.plot(*zip(*points, strict=True), color=_colour("ink"), linewidth=width, solid_joinstyle="miter")


def capacitor(ax: Axes, middle: Sequence[float], *, words: str) -> None:
    """Draw the plates of a capacitor over a vertical wire."""
    x, y = middle
    ax.plot((x, x), (y - 0.15, y + 0.15), color="white", linewidth=2.4)
    for height in (y - 0.15, y + 0.15):
        wire(ax, ((x - 0.6, height), (x + 0.6, height)), width=2.4)
    KINDS["words"](ax, words, at=(x + 0.9, y))


def arrow(
    ax: Axes, ends: Sequence[tuple[float, float]], *, words: str = "", colour: str = "positive", **more: Any
) -> None:
    """Draw an arrow, with words at its start."""
    look = {"arrowstyle": "-|>,head_width=0.25,head_length=0.5", "shrinkA": 0, "shrinkB": 0}
    ax.annotate(
        "", ends[1], ends[0], arrowprops=look | {"color": _colour(colour), "linewidth": 2.0}, zorder=5
    )
    KINDS["words"](ax, words, at=ends[0], colour=colour, **({"ha": "center", "va": "bottom"} | more))


def signs(ax: Axes, sign: str, *, count: float, height: float, ends: Sequence[float]) -> None:
    """Draw this many signs of charge, evenly between two ends."""
    colour = "positive" if sign == "+" else "negative"
    for place in np.linspace(ends[0], ends[1], 2 * round(count) + 1)[1::2]:
        words(ax, sign, at=(place, height), colour=colour, ha="center", weight="bold")


KINDS: Final[Mapping[str, Callable[..., None]]] = {
    "box": box,
    "wire": wire,
    "capacitor": capacitor,
    "arrow": arrow,
    "signs": signs,
    "words": words,
}
"""What a line of ``drawings.toml`` begins with, and what draws it."""
