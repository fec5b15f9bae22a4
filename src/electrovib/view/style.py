"""One look for every figure: colours that colour-blind readers can tell apart, quiet axes, no global state."""

from __future__ import annotations

import sys
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from collections.abc import Iterator

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLOURS: Final = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#333333")
"""Okabe and Ito's palette without its yellow, which is too faint for a line on white."""
DASHES: Final = ("-", "--", ":", "-.", (0, (5, 1, 1, 1, 1, 1)), (0, (1, 3)))
LAYER_COLOURS: Final = {"insulator": "#0072b2", "gap": "#009e73", "stratum_corneum": "#d55e00"}
"""The three layers of the set-up of Vezzoli et al. 2014 look the same in every figure."""
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
    "svg.fonttype": "path",
    "svg.hashsalt": "electrovib",
}


@contextmanager
def style() -> Iterator[None]:
    """Apply the look inside a ``with`` block; matplotlib's own settings come back after it."""
    import matplotlib as mpl
    from matplotlib.rcsetup import cycler

    rules: Any = {**_RULES, "axes.prop_cycle": cycler(color=list(COLOURS))}
    with mpl.rc_context(rules):
        yield


def new_figure(size: tuple[float, float] = SIZE) -> Figure:
    """Make a figure without pyplot: nothing is shown and nothing is kept alive."""
    from matplotlib.figure import Figure

    with style():
        return Figure(figsize=size)


@contextmanager
def drawing(ax: Axes | None, size: tuple[float, float] = SIZE) -> Iterator[Axes]:
    """Give the Axes to draw into, in the style of the package.

    Parameters
    ----------
    ax : Axes or None
        The caller's, or None for those of a new figure. The new figure belongs to pyplot if the caller has
        imported pyplot, so that ``plt.show()`` shows it; pyplot is never imported here.
    size : tuple of float
        Of a new figure [inch].

    Yields
    ------
    Axes
        Where to draw.
    """
    with style():
        if ax is None:
            pyplot = sys.modules.get("matplotlib.pyplot")
            figure = pyplot.figure(figsize=size) if pyplot else new_figure(size)
            ax = figure.add_subplot()
        yield ax


def layer_colours(names: list[str]) -> dict[str, str]:
    """Give each layer its colour: the known ones theirs, others what is left of the palette.

    Parameters
    ----------
    names : list of str
        Layers from plate to finger.

    Returns
    -------
    dict of str to str
        Name to colour.
    """
    left = [colour for colour in COLOURS if colour not in LAYER_COLOURS.values()]
    others = [name for name in names if name not in LAYER_COLOURS]
    given = {name: left[index % len(left)] for index, name in enumerate(others)}
    return {name: LAYER_COLOURS.get(name) or given[name] for name in names}


def between(part: float) -> str:
    """Give the colour of a value of a sweep: from dark at 0 to light at 1, never too faint for white paper."""
    import matplotlib as mpl
    from matplotlib.colors import to_hex

    return to_hex(mpl.colormaps["viridis"](0.85 * part))
