"""The columns of a file, the signals that they probably are, and what to write to import them."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.errors import InputError
from electrovib.core.signals import SIGNALS
from electrovib.core.units import format_quantity
from electrovib.data.registry import format_of, read_recorded
from electrovib.data.spectrum import spectrum_of, split_part
from electrovib.data.unit_words import kind_and_factor

if TYPE_CHECKING:
    from collections.abc import Mapping

    from electrovib.core.arrays import Real
    from electrovib.data.recorded import Recorded


_MOST: Final = 60


def list_columns(
    path: str | Path,
    *,
    reader: str = "",
    delimiter: str | None = None,
    decimal_comma: bool | None = None,
    part: str | None = None,
) -> list[str]:
    """List the columns of a file, with their units, and an example of the options that import them."""
    place = Path(path)
    table, wanted = split_part(part)
    recorded = read_recorded(
        place, reader=reader, delimiter=delimiter, decimal_comma=decimal_comma, part=table
    )
    name = reader or format_of(place).name
    lines = [f"{place.name}: reader '{name}', {len(recorded.channels)} columns of {recorded.size} samples"]
    for number, each in enumerate(recorded.channels[:_MOST]):
        finite = each.values[np.isfinite(each.values)]
        ends = f"{finite.min():.6g} to {finite.max():.6g}" if finite.size else "no numbers"
        role = ", the time" if each.name == recorded.time else ""
        lines.append(f"  {number}  {each.name}  [{each.unit or 'unit not stated'}]  {ends}{role}")
    if len(recorded.channels) > _MOST:
        lines.append(f"  and {len(recorded.channels) - _MOST} more")
    if "table" in recorded.attributes:
        lines.append(f"  read: {recorded.attributes['table']}")
    if "left_out" in recorded.attributes:
        lines.append(f"  left out: {recorded.attributes['left_out']}")
    if "unsure" in recorded.attributes:
        lines.append(f"  not sure: {recorded.attributes['unsure']}")
    if "omitted" in recorded.attributes:
        lines.append(f"  not read: {recorded.attributes['omitted']}; choose with --set part=NAME")
    try:
        spectrum = spectrum_of(recorded, spectrum=wanted)
    except InputError as error:
        if any(each.name.lower().startswith("freq") for each in recorded.channels):
            return [*lines, f"not yet a spectrum: {error.problems[0].reason}"]
        return [*lines, _clock(recorded), *_example(recorded)]
    return [
        *lines,
        f"a spectrum of {'impedance' if spectrum.impedance is not None else 'permittivity'}: {spectrum.read_as}",
        *([spectrum.among] if spectrum.among else []),
        "to import it: -o spectrum.nc, or --as material -o material.toml",
    ]


def _clock(recorded: Recorded) -> str:
    if recorded.time:
        unit = next(each.unit for each in recorded.channels if each.name == recorded.time)
        unsure = f', for which the file states no unit: s are assumed; add --set time="{recorded.time} [ms]" if it is ms'
        return f"time: column '{recorded.time}'" + ("" if unit else unsure)
    if recorded.step is not None:
        return (
            f"time: a step of {format_quantity(recorded.step, 's')}, first sample at"
            f" {format_quantity(recorded.start, 's')}, as the file states"
        )
    return 'time: not stated; add --set time="COLUMN [s]" or --set step="10 us"'


def _example(recorded: Recorded) -> list[str]:
    """Return the options that import the columns whose unit or heading tells a signal, else the first one as a voltage."""
    columns = [each for each in recorded.channels if each.name != recorded.time]
    if not columns:
        return []
    proposed = proposed_columns(recorded) or (
        ProposedColumn(column=columns[0].name, signal="drive_voltage", unit="" if columns[0].unit else "V"),
    )
    options = [f'--column {each.signal}="{each.stated}"' for each in proposed]
    options += [f'--set scale.{each.signal}="{each.scale}"' for each in proposed if each.scale]
    lines = [f"to import it: {' '.join(options)} -o trace.nc"]
    if unsure := ", ".join(f"'{each.column}'" for each in proposed if each.unit):
        lines.append(f"the file states no unit for {unsure}: write the right one into the brackets")
    if scaled := ", ".join(each.scale for each in proposed if "/" in each.scale):
        lines.append(f"{scaled} stands for the sensitivity of the sensor: write that of yours")
    if unnamed := [each.column for each in proposed if each.signal == "drive_voltage" and not each.is_named]:
        sensor = "is the output of a sensor, take the signal that it measures, with --set scale.SIGNAL=..."
        lines.append(f"if '{unnamed[0]}' {sensor} SIGNAL=\"1.5 N/V\"")
    if turned := next((each.column for each in proposed if each.scale == "-1"), ""):
        lines.append(f"'{turned}' is negative; as normal_force a load is positive")
    if any(each.signal.endswith("_force") for each in proposed):
        lines.append("of a scenario with a [rig]: lateral_force_measured, normal_force_measured")
    return lines


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
