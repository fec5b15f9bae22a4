"""``electrovib export``."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import TYPE_CHECKING

from electrovib.apps.cli.options import Arguments, takes
from electrovib.apps.cli.terminal import say, warned
from electrovib.core.errors import InputError

if TYPE_CHECKING:
    from electrovib.exports.waveform import WrittenWaveform


@takes("""
scenario
[place] OUTPUT     The file to write, if not given by -o.
-o, --output FILE  A netlist .cir, or the drive as .csv, .npy, .mat, .wav or .pwl.
--limits
--as
--rate
--ramp
--largest-error
--full-scale
--gain
--edge
--amplifier-present
--set
--models
--force
""")
def command(given: Arguments) -> None:
    """Write a netlist for ngspice, or the drive as a waveform.

    A waveform is written only within declared limits.
    """
    from electrovib.apps.progress import tracked
    from electrovib.exports.scenario import WRITERS, export_netlist
    from electrovib.exports.waveform import FORMATS, export_waveform

    place, output = given.pop("place", ""), given.pop("output", "")
    if bool(place) == bool(output):
        raise InputError("name one file to write: electrovib export SCENARIO -o drive.csv", path="--output")
    path, suffix = place or output, Path(place or output).suffix.lower()
    given.read_set()
    if suffix not in FORMATS and "instrument" not in given:
        if suffix in WRITERS and (used := given.surplus("scenario place output set models force")):
            raise InputError(f"{flag}: belongs to a waveform; omit it for a netlist" for flag in used)
        with tracked("solving and writing"):
            written = export_netlist(
                given["scenario"], Path(path), changes=given["set"], force="force" in given
            )
        say(*warned(written), f"written: {written.path}")
        say(f"run it:  ngspice -b {shlex.quote(str(written.path))}")
        return
    for name, unit in {"rate": "Hz", "ramp": "s", "full_scale": "V"}.items():
        if name in given:
            given[name] = _number(given[name], unit, given.flags[name])
    with tracked("sampling and checking"):
        found = export_waveform(**given | edge_of(given), path=path)
    say(*warned(found), *waveform_lines(found))


def waveform_lines(found: WrittenWaveform) -> list[str]:
    """Return the notes of a waveform, its check and its file as lines."""
    from electrovib.studies.check.result import shown

    held = [
        f"{row.quantity} {shown(row.value, row.unit)}, limit {shown(row.limit, row.unit)}: {row.source}"
        for row in found.check.rows
        if row.limit is not None
    ]
    return [*found.notes, *held, f"written: {found.path}"]


def edge_of(given: Arguments) -> dict[str, float | str]:
    """Read the edge, if there is one: a time [s], or the word that stands for straight lines."""
    text = given.get("edge")
    return {"edge": text if text == "line" else _number(text, "s", "--edge")} if text else {}


def _number(text: str, unit: str, option: str) -> float:
    """Read a number with a unit."""
    from electrovib.core.units import parse_quantity

    try:
        return parse_quantity(text, unit)
    except ValueError as error:
        raise InputError(str(error), path=option, value=text) from None
