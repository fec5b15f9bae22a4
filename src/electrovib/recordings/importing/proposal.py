"""The signals that the columns of a file probably are, by their units and then by their headings."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.signals import SIGNALS
from electrovib.data.unit_words import kind_and_factor

if TYPE_CHECKING:
    from collections.abc import Mapping

    from electrovib.core.arrays import Real
    from electrovib.data.recorded import Recorded

_WORDS: Final[Mapping[str, str]] = {
    "normal_force": r"f ?[nz]|.*\b(normal|vertical|load(?! ?cell)|down ?force|last|normalkraft|press(ing)?|effort normal)\b.*",
    "lateral_force": r"f ?[txyrf]?|.*\b(lateral|tangential\w*|shear|friction|horizontal|reib\w*|querkraft|frottement)\b.*"
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


def proposed_columns(recorded: Recorded) -> tuple[ProposedColumn, ...]:
    """Propose a signal, each once, for each column whose unit tells one, or else its heading."""
    found: dict[str, ProposedColumn] = {}
    for channel in recorded.channels:
        if channel.name == recorded.time:
            continue
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


def _signal(name: str, kind: str) -> str:
    """Return the signal of a column with this heading and SI unit; empty if nothing tells it."""
    heading = re.sub(r"[\s_.:\-]+", " ", name.lower()).strip()
    named = next((signal for signal, form in _WORDS.items() if re.fullmatch(form, heading)), "")
    if not kind or (named and (SIGNALS[named].unit == kind or kind == "V")):
        return named
    return _BY_UNIT.get(kind, "")
