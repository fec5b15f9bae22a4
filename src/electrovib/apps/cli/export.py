"""``electrovib export``."""

from __future__ import annotations

import shlex
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Annotated

import typer

from electrovib.apps.cli import options
from electrovib.apps.cli.options import output
from electrovib.apps.cli.terminal import say, warned

if TYPE_CHECKING:
    from electrovib.exports.waveform import WrittenWaveform


def command(
    scenario: options.Scenario,
    place: Annotated[
        str,
        typer.Argument(metavar="OUTPUT", help="The file to write, if not given by -o.", show_default=False),
    ] = "",
    file: Annotated[str, output("A netlist .cir, or the drive as .csv, .npy, .mat, .wav or .pwl.")] = "",
    limits: options.Limits = None,
    instrument: options.Instrument = "",
    rate: options.Rate = "",
    ramp: options.Ramp = "",
    largest_error: options.LargestError = 0.01,
    full_scale: options.FullScale = "",
    gain: options.Gain = 1.0,
    edge: options.Edge = "",
    amplifier_present: options.AmplifierPresent = False,
    changes: options.Changes = None,
    models: options.Models = None,
    force: options.Force = False,
) -> None:
    """Write a netlist for ngspice, or the drive as a waveform.

    A waveform is written only within declared limits.
    """
    from electrovib.apps.changes import read_changes
    from electrovib.apps.progress import tracked
    from electrovib.core.errors import InputError
    from electrovib.exports.scenario import WRITERS, export_netlist
    from electrovib.exports.waveform import export_waveform
    from electrovib.exports.waveform_formats import FORMATS

    if bool(place) == bool(file):
        raise InputError("name one file to write: electrovib export SCENARIO -o drive.csv", path="--output")
    target, wanted = place or file, read_changes(changes or [])
    given = {
        "--limits": limits, "--as": instrument, "--rate": rate, "--ramp": ramp, "--full-scale": full_scale,
        "--edge": edge, "--amplifier-present": amplifier_present,
    }  # fmt: skip
    used = [name for name, value in given.items() if value]
    if not instrument and not target.lower().endswith(tuple(FORMATS)):
        if used and target.lower().endswith(tuple(WRITERS)):
            raise InputError(f"{name}: belongs to a waveform; omit it for a netlist" for name in used)
        with tracked("solving and writing"):
            written = export_netlist(scenario, FilePath(target), changes=wanted, force=force)
        say(*warned(written), f"written: {written.path}")
        say(f"run it:  ngspice -b {shlex.quote(str(written.path))}")
        return
    with tracked("sampling and checking"):
        found = export_waveform(
            scenario, target, set=wanted, limits=list(limits or []), instrument=instrument,
            rate=_number(rate, "Hz", "--rate"), ramp=_number(ramp, "s", "--ramp"), largest_error=largest_error,
            full_scale=_number(full_scale, "V", "--full-scale"), gain=gain, edge=edge_of(edge),
            amplifier_present=amplifier_present, force=force,
        )  # fmt: skip
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


def edge_of(text: str) -> float | str | None:
    """Read an optional edge: a time [s], or the word that stands for straight lines."""
    return text if text == "line" else _number(text, "s", "--edge")


def _number(text: str, unit: str, option: str) -> float | None:
    """Read an optional number with a unit."""
    from electrovib.core.errors import InputError
    from electrovib.core.units import parse_quantity

    if not text:
        return None
    try:
        return parse_quantity(text, unit)
    except ValueError as error:
        raise InputError(str(error), path=option, value=text) from None
