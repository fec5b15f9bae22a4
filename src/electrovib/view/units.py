"""Units for readers: one prefix for a whole axis, Greek letters and raised powers in a text."""

from __future__ import annotations

import math
import re
from typing import TYPE_CHECKING, Final

from electrovib.core.units import KINDS, PREFIXES, SHOWN_PREFIXES, format_quantity

if TYPE_CHECKING:
    from matplotlib.axis import Axis

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
