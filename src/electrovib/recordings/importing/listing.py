"""The columns of a file as a text, with what to write to import them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.errors import InputError
from electrovib.core.units import format_quantity
from electrovib.data.readers.registry import format_of, read_recorded
from electrovib.data.readers.spectrum import spectrum_of

if TYPE_CHECKING:
    from electrovib.data.readers.recorded import DataColumn, Recorded

_MOST: Final = 60


def list_columns(
    path: str | Path,
    *,
    reader: str = "",
    delimiter: str | None = None,
    decimal_comma: bool | None = None,
    part: str | None = None,
) -> list[str]:
    """List the columns of a file, with their units, and an example of the options that import them.

    Parameters
    ----------
    path : str or Path
        The file.
    reader : str
        Name of the reader; found from the file if empty.
    delimiter : str, optional
        Of text: one character; found if not given.
    decimal_comma : bool, optional
        Of text: whether decimals are written with a comma; found if not given.
    part : str, optional
        Sheet, table or array to read.

    Returns
    -------
    list of str
        Lines of text.

    Raises
    ------
    DataFileError
        If the file cannot be read.
    """
    place = Path(path)
    recorded = read_recorded(
        place, reader=reader, delimiter=delimiter, decimal_comma=decimal_comma, part=part
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
    if "omitted" in recorded.attributes:
        lines.append(f"  not read: {recorded.attributes['omitted']}; choose with --part NAME")
    try:
        spectrum = spectrum_of(recorded)
    except InputError as error:
        if any(each.name.lower().startswith("freq") for each in recorded.channels):
            return [*lines, f"not yet a spectrum: {error.problems[0].reason}"]
        return [*lines, _clock(recorded), *_example(recorded)]
    return [
        *lines,
        f"a spectrum of {'impedance' if spectrum.impedance is not None else 'permittivity'}: {spectrum.read_as}",
        "to import it: -o spectrum.nc, or --as material -o material.toml",
    ]


def _clock(recorded: Recorded) -> str:
    if recorded.time:
        return f"time: column '{recorded.time}'"
    if recorded.step is not None:
        return (
            f"time: a step of {format_quantity(recorded.step, 's')}, first sample at"
            f" {format_quantity(recorded.start, 's')}, as the file states"
        )
    return 'time: not stated; add --time "COLUMN [s]" or --step "10 us"'


def _example(recorded: Recorded) -> list[str]:
    """Return the options that would import the first column that is not the time, and the next one as of a force sensor."""
    columns = [each for each in recorded.channels if each.name != recorded.time]
    if not columns:
        return []
    first, sensor = columns[0], columns[1] if columns[1:] else columns[0]
    signals = {"V": "drive_voltage", "N": "lateral_force", "A": "current"}
    signal = signals.get(first.unit.lstrip("mkun") or "V", "lateral_force")
    return [
        f'to import it: --column {signal}="{_with_unit(first)}" -o trace.nc',
        f'of a force sensor: --column lateral_force="{_with_unit(sensor)}" --scale lateral_force="1.5 N/V"'
        " (lateral_force_measured for a scenario with a [rig])",
    ]


def _with_unit(channel: DataColumn) -> str:
    return channel.name if channel.unit else f"{channel.name} [V]"
