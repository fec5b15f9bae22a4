"""Figures as a journal prints them: one column of 85 mm, text of 8 pt, inside the Axes of 7 pt, nothing cut."""

from __future__ import annotations

import re
import textwrap
from typing import TYPE_CHECKING, Any, Final

from electrovib.view.style import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WIDTH: Final = 0.085 / 0.0254
"""Of one column of a journal [inch]."""
TEXT: Final = 8.0
INSIDE: Final = 7.0
"""Size of the text, and of that inside the Axes [pt]."""
_LETTER: Final = 0.072
"""Mean width of a letter of this size [inch]."""
_LINE: Final = 0.17
"""Height of a line of text [inch]."""
_HEIGHT: Final = 0.66 * WIDTH
"""Height of Axes with their labels, at least [inch]."""
_NAMES: Final = 1.5
"""Largest width of names along the vertical axis [inch]."""
_KEY: Final = 0.6
"""Width of a line and its margins in a legend [inch]."""


def one_column(figure: Figure) -> None:
    """Put a figure into one column: its Axes below each other, texts of one size and broken into lines, the legend below."""
    with style():
        heights = _below_each_other(figure)
        figure.set_size_inches(WIDTH, sum(heights.values()))
        for text in figure.findobj(match=_is_text):
            text.set_fontsize(TEXT)  # type: ignore[attr-defined]
        _legend_below(figure)
        figure.draw_without_rendering()
        for ax in figure.axes:
            box, height = ax.get_position(), heights.get(ax, _HEIGHT)
            for place in ("left", "center", "right"):
                ax.set_title(
                    _broken(ax.get_title(loc=place), WIDTH * (1 - box.x0) - 0.1), loc=place, fontsize=TEXT
                )
            middle = (box.x0 + box.x1) / 2
            ax.set_xlabel(_broken(ax.get_xlabel(), 2 * WIDTH * min(middle, 1 - middle) - 0.1))
            ax.set_ylabel(_broken(ax.get_ylabel(), height - _LINE))
            for text in ax.texts:
                text.set_fontsize(INSIDE)
                room = WIDTH - text.get_window_extent().x0 / figure.dpi
                text.set_text(_broken(text.get_text(), room))


def _is_text(artist: object) -> bool:
    from matplotlib.text import Text

    return isinstance(artist, Text)


def _below_each_other(figure: Figure) -> dict[Axes, float]:
    """Put Axes that stand side by side below each other; return the height of each [inch], of Axes in one place once."""
    places: dict[tuple[int, int], list[Axes]] = {}
    for ax in figure.axes:
        if spec := ax.get_subplotspec():
            places.setdefault((spec.rowspan.start, spec.colspan.start), []).append(ax)
    ordered = [places[at] for at in sorted(places)]
    shares: Any = ordered[0][0].get_gridspec().get_height_ratios()  # type: ignore[union-attr]
    heights = {
        places[at][0]: max(_HEIGHT * shares[at[0]] / max(shares), _names_broken(places[at][0]))
        for at in sorted(places)
    }
    grid = figure.add_gridspec(len(ordered), 1, height_ratios=list(heights.values()))
    for row, some in enumerate(ordered):
        for ax in some:
            ax.set_subplotspec(grid[row])
    return heights


def _names_broken(ax: Axes) -> float:
    """Break long names along the vertical axis into lines; return the height that they need [inch], 0 without names."""
    from matplotlib.text import Annotation
    from matplotlib.ticker import FixedLocator

    if not isinstance(ax.yaxis.get_major_locator(), FixedLocator):
        return 0.0
    said = sum(isinstance(each, Annotation) for each in ax.texts)
    names = [re.sub(r"([./])(?=\w)", r"\1 ", each.get_text()) for each in ax.get_yticklabels()]
    broken = [re.sub(r"([./]) ", r"\1", _broken(name, _NAMES)) for name in names]
    ax.set_yticks(ax.get_yticks(), broken)
    lines = max((each.count("\n") + 1 for each in broken), default=0)
    return 3 * _LINE + _LINE * max((lines + 0.5) * len(broken), 2 * said)


def _broken(text: str, width: float) -> str:
    """Break a text into lines of a width [inch]; formulas stay whole."""
    held = re.sub(r"\$[^$]*\$", lambda found: found[0].replace(" ", "\0"), text)
    return "\n".join(textwrap.wrap(held, max(int(width / _LETTER), 8))).replace("\0", " ")


def _legend_below(figure: Figure) -> None:
    """Put the legends of the Axes into one below them, where it covers nothing; each entry stands once."""
    legends = [legend for ax in figure.axes if (legend := ax.get_legend()) is not None]
    entries: dict[str, Any] = {
        _broken(text.get_text(), WIDTH - _KEY): handle
        for legend in legends
        for text, handle in zip(legend.get_texts(), legend.legend_handles, strict=True)
    }
    title = next((words for legend in legends if (words := legend.get_title().get_text())), None)
    for legend in legends:
        legend.remove()
    if entries:
        longest = max(len(line) for words in entries for line in words.split("\n"))
        figure.legend(
            list(entries.values()), list(entries), title=title, loc="outside lower left", alignment="left",
            fontsize=TEXT, title_fontsize=TEXT, ncols=max(1, int(WIDTH / (_KEY + _LETTER * longest))),
        )  # fmt: skip
    for legend in figure.legends:
        figure.set_figheight(figure.get_figheight() + legend.get_window_extent().height / figure.dpi)
