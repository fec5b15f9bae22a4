"""The picture of a plot, for a notebook."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from electrovib.view.svg import to_png

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_RESOLUTION: Final = 192.0
"""Of the picture [dots per inch]: twice that at which it is shown, for screens with fine pixels."""


def picture(axes: Axes) -> tuple[bytes, dict[str, int]] | None:
    """Draw the figure of these Axes as PNG with width and height in pixels; None for one that pyplot shows by itself."""
    figure = axes.get_figure(root=True)
    if figure is None or figure.canvas.manager is not None:
        return None
    width, height = figure.get_size_inches()
    shown = _RESOLUTION / 2
    return to_png(figure, resolution=_RESOLUTION), {
        "width": round(width * shown),
        "height": round(height * shown),
    }
