"""Signals that the columns of a file probably are, by heading and unit, and the column that is probably the time."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.signals import SIGNALS
from electrovib.data.recorded import is_unit_of_time
from electrovib.data.unit_words import kind_and_factor

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from electrovib.core.arrays import Real
    from electrovib.data.recorded import DataColumn, Recorded


_WORDS: Final[Mapping[str, str]] = {
    "normal_force": r".*\b(f ?[nz]|(force|kraft) ?z|f ?norm(al)?) ?\d*\b.*|.*\bz (force|kraft)\b.*"
    r"|.*\b(normal|vertical|load(?! ?cell)|down ?force|last|normalkraft|press(ing)?|effort normal)\b.*",
    "lateral_force": r"f|.*\bf ?([txyrf] ?\d*|tan(gential)?)\b.*"
    r"|.*\b(lateral|tangential\w*|shear|friction|horizontal|reib\w*|querkraft|frottement)\b.*"
    r"|.*(force|kraft|effort|load ?cell).*",
    "current": r"i|.*\b(current|strom|courant|amp(ere)?s?)\b.*",
    "sliding_speed": r".*\b(sliding )?(speed|velocity|geschwindigkeit|vitesse)\b.*",
    "plate_voltage": r".*\b(plate|electrode) (voltage|potential|spannung)\b.*",
    "drive_voltage": r"u|v|hv|.*(volt|spannung|tension|\bdrive\b).*",
    "capacitance": r"cp?|.*\b(capacit(y|ance)|kapazit(ä|ae)t|capacité)\b.*",
    "gap": r".*\b(gap|spalt|entrefer)\b.*",
    "gross_contact_area": r".*\b(area|fl(ä|ae)che|surface)\b.*",
}
"""Signal to the pattern of its headings, in small letters, without separators; the first one that fits is taken."""
_RATIO: Final = re.compile(r".*\b(cof|coeff?(icient)?|mu|µ|μ|ratio|reibwert|reib\w*zahl)\b.*")
"""Headings of a ratio of two forces, which is no force."""
_UNSURE: Final = re.compile(r".*\b((f|force|kraft) ?y ?\d*|y (force|kraft))\b.*")
"""Headings of a force along y, which is lateral or normal."""
_TIME: Final = re.compile(r".*\b(time|time ?stamp|t|zeit|temps|x)\b.*")
_COUNT: Final = re.compile(r".*\b(index|nr|no|number|points?|samples?|rows?|steps?|cycles?|segment|#|n)\b.*|")
_BY_UNIT: Final[Mapping[str, str]] = {
    "N": "lateral_force",
    "V": "drive_voltage",
    "A": "current",
    "m/s": "sliding_speed",
    "m2": "gross_contact_area",
    "F": "capacitance",
}
"""SI unit to the signal that a column in this unit is where its heading says nothing else."""


@dataclass(frozen=True, kw_only=True)
class ProposedColumn:
    """What a column probably is.

    `unit` is the SI unit of the signal, to be confirmed where the file states no unit; else empty. `scale` is
    an example of a sensitivity where the unit is that of a sensor, ``"-1"`` for a load that is negative; else
    empty.
    """

    column: str
    signal: str
    unit: str = ""
    scale: str = ""

    @property
    def stated(self) -> str:
        """The column as an import expects it."""
        return f"{self.column} [{self.unit}]" if self.unit else self.column

    @property
    def is_named(self) -> bool:
        """Whether the heading itself tells the signal, not the unit alone."""
        return _signal(self.column, "") == self.signal

    @property
    def is_sure(self) -> bool:
        """Whether the heading names one direction of a force alone."""
        return not _UNSURE.fullmatch(_words(self.column))


def proposed_time(recorded: Recorded) -> DataColumn | None:
    """Return the column that is probably the time: of those that may be it one that is called so, or the first."""
    found = possible_times(recorded)
    return next((each for each in found if _TIME.fullmatch(_words(each.name))), found[0] if found else None)


def possible_times(recorded: Recorded) -> list[DataColumn]:
    """Return the columns that may be times: they increase, in a unit of time, or without a unit and a signal."""
    return [
        each
        for each in recorded.channels
        if (is_unit_of_time(each.unit) or not (each.unit or _signal(each.name, "")))
        and rises(each.values)
        and (_TIME.fullmatch(_words(each.name)) or not _COUNT.fullmatch(_words(each.name)))
    ]


def may_be_voltage(column: DataColumn) -> bool:
    """Return whether a column without a unit may be an example of a voltage: neither the time by its name, nor rising."""
    return not (column.unit or _TIME.fullmatch(_words(column.name)) or rises(column.values))


def rises(values: Real) -> bool:
    """Return whether each number exceeds the one before."""
    return values.size > 1 and bool((np.diff(values) > 0).all())


def proposed_columns(
    recorded: Recorded, columns: Sequence[DataColumn] | None = None
) -> tuple[ProposedColumn, ...]:
    """Propose a signal, each once, for each of the columns whose unit tells one, or else its heading."""
    if columns is None:
        columns = [each for each in recorded.channels if each.name != recorded.time]
    found: dict[str, ProposedColumn] = {}
    for channel in sorted(columns, key=lambda each: bool(_UNSURE.fullmatch(_words(each.name)))):
        kind = (kind_and_factor(channel.unit) or ("",))[0] if channel.unit else ""
        signal = _signal(channel.name, kind)
        if not signal or signal in found or (channel.unit and not kind):
            continue
        target = SIGNALS[signal].unit
        found[signal] = ProposedColumn(
            column=channel.name,
            signal=signal,
            unit="" if kind else target,
            scale=f"1.5 {target}/{channel.unit}"
            if kind not in ("", target)
            else _sign(signal, channel.values),
        )
    return tuple(found.values())


def _sign(signal: str, values: Real) -> str:
    """Return the factor that makes a load positive, where the tribometer writes it as a negative number."""
    pressed = values[np.isfinite(values)]
    return "-1" if signal == "normal_force" and pressed.size and np.median(pressed) < 0 else ""


def _words(name: str) -> str:
    """Return a heading in small letters, with a blank for each separator and before each capital behind a small letter."""
    return re.sub(r"[\s_.:/\-]+|(?<=[a-z])(?=[A-Z])", " ", name).lower().strip()


def _signal(name: str, kind: str) -> str:
    """Return the signal of a column with this heading and SI unit; empty if nothing tells it."""
    heading = _words(name)
    own = SIGNALS.get(heading.replace(" ", "_"))
    if own and own.dims == ("time",) and kind in ("", own.unit):
        return heading.replace(" ", "_")
    if kind in ("", "1") and _RATIO.fullmatch(heading):
        return ""
    named = next((signal for signal, form in _WORDS.items() if re.fullmatch(form, heading)), "")
    if not kind or (named and (SIGNALS[named].unit == kind or kind == "V")):
        return named
    return _BY_UNIT.get(kind, "")
