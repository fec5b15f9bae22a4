"""Units as a person reads them: one prefix for a whole axis, Greek letters and raised powers in a text."""

from __future__ import annotations

import math
import re
from typing import TYPE_CHECKING, Final

from electrovib.core.units import KINDS, PREFIXES, SHOWN_PREFIXES, format_quantity

if TYPE_CHECKING:
    from matplotlib.axis import Axis

_FLAT = 1e-6
"""Relative spread below which a curve is drawn as the constant it is, instead of as magnified rounding."""
_FEW_DECADES: Final = 2.0


def pretty_unit(unit: str) -> str:
    """Write a unit with its proper letters: ``ohm m`` as Ω·m, ``um2`` as µm², the pure number as nothing."""
    if unit == "1":
        return ""
    text = unit.replace("ohm", "Ω").replace(" ", "·")
    text = re.sub(r"\bu(?=[A-Za-zΩ])", "µ", text)
    return text.replace("2", "²").replace("3", "³")


def pretty_quantity(value: float | None, unit: str, *, digits: int = 6) -> str:
    """Show a number to a person, or a dash where there is none.

    Parameters
    ----------
    value : float or None
        In SI.
    unit : str
        One of `electrovib.core.units.KINDS`, or any other text, which is then shown as it is.
    digits : int
        Significant digits at most.

    Returns
    -------
    str
        With prefix, Greek letters and raised powers.
    """
    if value is None:
        return "–"
    if unit not in KINDS:
        return f"{value:.{digits}g} {unit}".strip()
    number, _, symbol = format_quantity(value, unit, digits=digits).partition(" ")
    return f"{number} {pretty_unit(symbol)}".strip() if symbol else number


def typeset(text: str) -> str:
    """Write the units inside a sentence with their proper letters: ``250 uA`` as 250 µA, ``V^2`` as V²."""
    text = re.sub(r"(?<=\d )u(?=(?:[AVFCNSms]|ohm)(?:\b|/))", "µ", text)
    text = re.sub(r"(?<=\d )([kMGTmµ]?)ohm\b", r"\1Ω", text)
    return re.sub(r"(?<=\w)\^2\b", "²", text)


def prefix_for(largest: float, unit: str) -> tuple[str, float]:
    """Choose the prefix under which the largest number of an axis lies from 1 to 1000.

    Parameters
    ----------
    largest : float
        Largest absolute value, SI.
    unit : str
        SI unit; pure numbers, decibels and degrees take no prefix.

    Returns
    -------
    prefix : str
        One of `electrovib.core.units.SHOWN_PREFIXES`.
    scale : float
        What it stands for.
    """
    if unit not in KINDS or unit == "1" or not math.isfinite(largest) or largest <= 0:
        return "", 1.0
    power = 2 if re.match(r"[A-Za-z]+2", unit) else 1
    sizes = {prefix: 10.0 ** (PREFIXES[prefix] * power) for prefix in SHOWN_PREFIXES}
    fitting = [prefix for prefix, size in sizes.items() if largest >= 0.999999 * size]
    chosen = max(fitting, key=lambda prefix: sizes[prefix]) if fitting else SHOWN_PREFIXES[0]
    return chosen, sizes[chosen]


def label_axis(axis: Axis, words: str, unit: str) -> None:
    """Write an axis in one prefixed unit; the data stay in SI.

    Parameters
    ----------
    axis : matplotlib axis
        ``ax.xaxis`` or ``ax.yaxis``, with everything drawn.
    words : str
        What it shows.
    unit : str
        SI unit of the data.

    Notes
    -----
    A linear axis has the prefix in its label (``force [mN]``), a logarithmic one at each number (``10 k``).
    """
    if axis.get_scale() == "log":
        _decades(axis, plain=unit not in KINDS or unit == "1")
        shown = pretty_unit(unit)
    else:
        low, high = _open_up(axis)
        prefix, scale = prefix_for(max(abs(low), abs(high)), unit)
        axis.set_major_formatter(lambda value, _: f"{value / scale:.6g}".replace("-", "\N{MINUS SIGN}"))
        shown = pretty_unit(f"{prefix}{unit}" if unit != "1" else "1")
    axis.set_label_text(f"{words} [{shown}]" if shown else words)


def _open_up(axis: Axis) -> tuple[float, float]:
    """Give the range of the data, after widening the view of a curve that only varies by rounding."""
    low, high = (float(bound) for bound in axis.get_data_interval())
    if not (math.isfinite(low) and math.isfinite(high)):
        return 0.0, 1.0
    size = max(abs(low), abs(high))
    if axis is axis.axes.yaxis and 0 <= high - low < _FLAT * size:
        middle = (low + high) / 2
        axis.axes.set_ylim(middle - 0.2 * size, middle + 0.2 * size)
    return low, high


def _decades(axis: Axis, *, plain: bool) -> None:
    """Number a logarithmic axis by its decades, and in between where it has few of them."""
    from matplotlib.ticker import EngFormatter, FuncFormatter, LogLocator, NullFormatter

    low, high = (abs(float(bound)) for bound in axis.get_data_interval())
    few = low > 0 and math.isfinite(high) and math.log10(max(high, low) / low) < _FEW_DECADES
    prefixed = EngFormatter(sep="\N{THIN SPACE}", usetex=False)
    numbers = FuncFormatter(lambda value, _: f"{value:g}") if plain else prefixed
    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if few else (1.0,), numticks=12))
    axis.set_major_formatter(numbers)
    axis.set_minor_formatter(NullFormatter())
