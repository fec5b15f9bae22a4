"""One style for every figure, that of a journal included: colours for colour-blind readers, no global state.

What holds for every figure, in report, page, notebook and file; `tests/contract/test_figures.py` looks at all of them:

1. Points that were measured are drawn in every part of a figure.
2. What has one colour is one thing, and stands in one part: the band of a law with its median, points with their line.
3. At most `MOST` things in a figure, each in its own colour; references stand beside them in grey, one in a legend.
4. An axis names what it shows in words, with the unit; never a dotted path, an underscore or "value".
5. A caption says what one sees, never the name of a file; where curves are left out, it says how many there are.
"""

from __future__ import annotations

import functools
import math
import re
import sys
import textwrap
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from electrovib.core.units import KINDS, PREFIXES, SHOWN_PREFIXES, format_quantity

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.figure import Figure

_FLAT = 1e-6
"""Relative spread below which a curve is drawn as the constant it is, instead of as magnified rounding."""
_FEW_DECADES: Final = 2.5
_NO_DECADE: Final = 0.7
"""Decades below which 1, 2, 5 would leave an axis with one number or none."""
_SHORTEST, _LONGEST = 0.0099, 1010.0
"""Smallest and largest number of a logarithmic axis that is written out, in the unit of its label."""
_PLAIN: Final = (0.099, 2.02e4)
"""Smallest and largest number of a logarithmic axis in the SI unit itself."""
_MANY_DECADES: Final = 4.1
"""Decades above which a logarithmic axis has powers of ten."""


def pretty_unit(unit: str) -> str:
    """Write a unit with its proper letters: ``ohm m`` as Ω·m, ``um2`` as µm², the pure number as nothing."""
    if unit == "1":
        return ""
    text = unit.replace("ohm", "Ω").replace(" ", "·")
    text = re.sub(r"\bu(?=[A-Za-zΩ])", "µ", text)
    return text.replace("2", "²").replace("3", "³")


def pretty_quantity(value: float | None, unit: str, *, digits: int = 6) -> str:
    """Show a number to a person, with prefix, Greek letters and raised powers; a dash where there is none."""
    if value is None:
        return "–"
    if unit not in KINDS:
        return f"{value:.{digits}g} {unit}".strip()
    number, _, symbol = format_quantity(value, unit, digits=digits).partition(" ")
    return f"{number} {pretty_unit(symbol)}".strip() if symbol else number


def typeset(text: str) -> str:
    """Write the units inside a sentence with their proper letters: ``250 uA`` as 250 µA, ``V^2`` as V²."""
    text = re.sub(r"(?<=\d )u(?=(?:[AVFCJWNSms]|ohm)(?:\b|/))", "µ", text)
    text = re.sub(r"(?<=\d )([kMGTmµ]?)ohm\b", r"\1Ω", text)
    return re.sub(r"(?<=\w)\^2\b", "²", text)


def prefix_for(largest: float, unit: str) -> tuple[str, float]:
    """Choose the prefix, and its factor, under which the largest number of an axis lies between 1 and 1000."""
    if unit not in KINDS or unit == "1" or not math.isfinite(largest) or largest <= 0:
        return "", 1.0
    power = 2 if re.match(r"[A-Za-z]+2", unit) else 1
    sizes = {prefix: 10.0 ** (PREFIXES[prefix] * power) for prefix in SHOWN_PREFIXES}
    fitting = [prefix for prefix, size in sizes.items() if largest >= 0.999999 * size]
    chosen = max(fitting, key=lambda prefix: sizes[prefix]) if fitting else SHOWN_PREFIXES[0]
    return chosen, sizes[chosen]


def label_axis(axis: Axis, words: str, unit: str, *, base: float = 0.0) -> None:
    """Label an axis in words and one unit; the data stay in SI.

    A linear axis, which counts from `base`, has one prefixed unit in its label (``force [mN]``). So has a
    logarithmic one of at most four decades (``ramp [ms]``: 0.1, 1, 10); over more decades it has powers of
    ten of the SI unit. The numbers themselves never carry a prefix.
    """
    if axis.get_scale() == "log":
        prefix = _decades(axis, unit)
    else:
        low, high = _open_up(axis)
        size = max(abs(low - base), abs(high - base))
        prefix, scale = prefix_for(size, unit)
        axis.set_major_formatter(
            lambda value, _: _plain((value - base) / scale if abs(value - base) > _FLAT * size else 0.0)
        )
    shown = pretty_unit(f"{prefix}{unit}" if unit != "1" else "1")
    axis.set_label_text(f"{words} [{shown}]" if shown else words)


def _plain(number: float) -> str:
    """Write the number at a tick."""
    return f"{number:.6g}".replace("-", "\N{MINUS SIGN}")


def _open_up(axis: Axis) -> tuple[float, float]:
    """Return the range of the data, after widening the view of a curve that varies by rounding only."""
    low, high = (float(bound) for bound in axis.get_data_interval())
    if not (math.isfinite(low) and math.isfinite(high)):
        return 0.0, 1.0
    size = max(abs(low), abs(high))
    if axis is axis.axes.yaxis and 0 <= high - low < _FLAT * size:
        middle = (low + high) / 2
        axis.axes.set_ylim(middle - 0.2 * size, middle + 0.2 * size)
    return low, high


def _decades(axis: Axis, unit: str) -> str:
    """Number a logarithmic axis by its decades, and between them where it has few; return the prefix of its unit."""
    from matplotlib.ticker import (
        FuncFormatter,
        LogFormatterSciNotation,
        LogLocator,
        MaxNLocator,
        NullFormatter,
    )

    low, high = (abs(float(bound)) for bound in axis.get_data_interval())
    decades = math.log10(max(high, low) / low) if low > 0 and math.isfinite(high) else math.inf
    if decades < _NO_DECADE:
        axis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10]))
    else:
        parts = (1.0, 2.0, 5.0) if decades < _FEW_DECADES else (1.0,)
        axis.set_major_locator(LogLocator(subs=parts, numticks=12))
    axis.set_minor_formatter(NullFormatter())
    found = _prefix_over_decades(low, high, unit)
    if found is None:
        axis.set_major_formatter(LogFormatterSciNotation(labelOnlyBase=False, minor_thresholds=(9, 9)))
        return ""
    prefix, scale = found
    axis.set_major_formatter(FuncFormatter(lambda value, _: _plain(value / scale)))
    return prefix


def _prefix_over_decades(low: float, high: float, unit: str) -> tuple[str, float] | None:
    """Choose the prefix under which all numbers of an axis are short; None where powers of ten are shorter."""
    if not (0 < low <= high < math.inf):
        return "", 1.0
    if math.log10(high / low) > _MANY_DECADES:
        return None
    if low >= _PLAIN[0] and high <= _PLAIN[1]:
        return "", 1.0
    candidates = [""] if unit not in KINDS or unit == "1" else SHOWN_PREFIXES
    power = 2 if re.match(r"[A-Za-z]+2", unit) else 1
    sizes = {prefix: 10.0 ** (PREFIXES[prefix] * power) for prefix in candidates}
    short = {
        prefix: max(abs(math.log10(low / size)), abs(math.log10(high / size)))
        for prefix, size in sizes.items()
        if low / size >= _SHORTEST and high / size <= _LONGEST
    }
    if not short:
        return None
    best = min(short, key=lambda prefix: short[prefix])
    return best, sizes[best]


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


@functools.cache
def _rules() -> Any:
    """Read the settings of matplotlib."""
    import matplotlib as mpl
    from matplotlib.rcsetup import cycler

    found = mpl.rc_params_from_file(Path(__file__).parent / "figures.mplstyle", use_default_template=False)
    return {**found, "axes.prop_cycle": cycler(color=list(COLOURS))}


@contextmanager
def style() -> Iterator[None]:
    """Apply the style inside a ``with`` block; matplotlib's own settings are restored after it."""
    import matplotlib as mpl

    with mpl.rc_context(_rules()):
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


def legends_taken(axes: Sequence[Axes]) -> tuple[dict[str, Any], str]:
    """Remove the legends of Axes, and return their entries, each once, and the title of the first that has one."""
    legends = [legend for ax in axes if (legend := ax.get_legend()) is not None]
    entries: dict[str, Any] = {}
    for legend in legends:
        for text, handle in zip(legend.get_texts(), legend.legend_handles, strict=True):
            entries.setdefault(text.get_text(), handle)
        legend.remove()
    return entries, next((words for legend in legends if (words := legend.get_title().get_text())), "")


def _legend_below(figure: Figure) -> None:
    """Put the legends of the Axes into one below them, where it covers nothing; each entry stands once."""
    found, title = legends_taken(figure.axes)
    entries = {_broken(text, WIDTH - _KEY): handle for text, handle in found.items()}
    if entries:
        longest = max(len(line) for words in entries for line in words.split("\n"))
        figure.legend(
            list(entries.values()), list(entries), title=title or None, loc="outside lower left", alignment="left",
            fontsize=TEXT, title_fontsize=TEXT, ncols=max(1, int(WIDTH / (_KEY + _LETTER * longest))),
        )  # fmt: skip
    for legend in figure.legends:
        figure.set_figheight(figure.get_figheight() + legend.get_window_extent().height / figure.dpi)
