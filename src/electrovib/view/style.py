"""One style for every figure: colours that colour-blind readers can distinguish, unobtrusive axes, no global state.

What holds for every figure, in report, page, notebook and file; `tests/contract/test_figures.py` looks at all of them:

1. Points that were measured are drawn in every part of a figure.
2. What has one colour is one thing, and stands in one part: the band of a law with its median, points with their line.
3. At most `MOST` things in a figure, each in its own colour; references stand beside them in grey, one in a legend.
4. An axis names what it shows in words, with the unit; never a dotted path, an underscore or "value".
5. A caption says what one sees, never the name of a file; where curves are left out, it says how many there are.
"""

from __future__ import annotations

import sys
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from collections.abc import Iterator

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLOURS: Final = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#5c4a00")
"""Curves: Okabe and Ito's palette without its yellow, which is too faint for a line on white."""
FURTHER_COLOURS: Final = ("#870f0f", "#8a6be0", "#b0009a", "#7fb000", "#00b7c2")
"""Curves of a report that shows more than seven different things; at most five of them share a figure."""
PALETTE: Final = COLOURS + FURTHER_COLOURS
"""All colours of curves, by the look of a curve."""
MOST: Final = 5
"""Most things that one figure shows beside references."""
DASHES: Final = ("-", "--", ":", "-.", (0, (5, 1, 1, 1, 1, 1)), (0, (1, 3)))
LAYER_COLOURS: Final = {"insulator": "#5e3c99", "gap": "#8a8d2e", "stratum_corneum": "#6f4e37"}
"""The three usual layers; no curve that is not of a layer has one of these colours."""
OTHER_LAYERS: Final = ("#ff5c7a", "#2222e0", "#2e6b3a", "#9a8c98")
"""Layers of any other name, from the plate to the finger."""
NEUTRAL: Final = "#8a8a8a"
"""Reference lines and ranges, which are not curves."""
PALE: Final = "#b9a3d6"
"""Curves of the background, which one entry of the legend names together."""
AMOUNTS: Final = "cividis"
"""Colour map of amounts: the values of a sweep, and the filled contours of a map."""
SIZE: Final = (5.6, 3.6)
"""Width and height of a single plot [inch]."""

_RULES: Final[dict[str, Any]] = {
    "font.size": 9.0,
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],
    "mathtext.fontset": "dejavusans",
    "axes.titlesize": 9.5,
    "axes.titlelocation": "left",
    "axes.labelsize": 9.0,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": "#666666",
    "axes.linewidth": 0.7,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#e2e2e2",
    "grid.linewidth": 0.6,
    "xtick.color": "#666666",
    "ytick.color": "#666666",
    "xtick.labelcolor": "#222222",
    "ytick.labelcolor": "#222222",
    "xtick.labelsize": 8.0,
    "ytick.labelsize": 8.0,
    "legend.frameon": False,
    "legend.fontsize": 8.0,
    "legend.title_fontsize": 8.0,
    "lines.linewidth": 1.4,
    "lines.solid_capstyle": "butt",
    "figure.constrained_layout.use": True,
    "figure.constrained_layout.wspace": 0.04,
    "figure.constrained_layout.hspace": 0.07,
    "figure.dpi": 100.0,
    "savefig.dpi": 150.0,
    "path.simplify": True,
    "pdf.fonttype": 42,  # TrueType, which journals take
    "svg.fonttype": "path",
    "svg.hashsalt": "electrovib",
}


@contextmanager
def style() -> Iterator[None]:
    """Apply the style inside a ``with`` block; matplotlib's own settings are restored after it."""
    import matplotlib as mpl
    from matplotlib.rcsetup import cycler

    rules: Any = {**_RULES, "axes.prop_cycle": cycler(color=list(COLOURS))}
    with mpl.rc_context(rules):
        yield


def new_figure(size: tuple[float, float] = SIZE) -> Figure:
    """Return a figure made without pyplot, which neither shows it nor keeps it in memory."""
    from matplotlib.figure import Figure

    with style():
        return Figure(figsize=size)


@contextmanager
def drawing(ax: Axes | None, size: tuple[float, float] = SIZE) -> Iterator[Axes]:
    """Yield the Axes to draw into, the caller's or new ones, in the style of the package.

    A new figure belongs to pyplot if the caller has imported it, so that ``plt.show()`` shows it.
    """
    with style():
        if ax is None:
            pyplot = sys.modules.get("matplotlib.pyplot")
            figure = pyplot.figure(figsize=size) if pyplot else new_figure(size)
            ax = figure.add_subplot()
        yield ax


def layer_colours(names: list[str]) -> dict[str, str]:
    """Return the colour of each layer: the usual layers keep theirs, others follow in order."""
    others = [name for name in names if name not in LAYER_COLOURS]
    given = {name: OTHER_LAYERS[index % len(OTHER_LAYERS)] for index, name in enumerate(others)}
    return {name: LAYER_COLOURS.get(name) or given[name] for name in names}


def between(part: float) -> str:
    """Return the colour of a value of a sweep, from dark at 0 to light at 1, dark enough for white paper."""
    import matplotlib as mpl
    from matplotlib.colors import to_hex

    return to_hex(mpl.colormaps[AMOUNTS](0.85 * part))
