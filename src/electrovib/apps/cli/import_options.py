"""Options of ``electrovib import``, one alias for each."""

from __future__ import annotations

from typing import Annotated

import typer

_OF_SIGNAL = "SIGNAL=TEXT"

SourceFile = Annotated[str, typer.Argument(help="Any file that a reader takes; see --list.")]

Output = Annotated[
    str | None,
    typer.Option("--output", "-o", help="Write the Trace (.nc, .csv, .mat) or the material (.toml)."),
]

Columns = Annotated[
    list[str] | None,
    typer.Option(
        metavar="SIGNAL=COLUMN",
        help='Column of a signal, with a unit where the file states none: drive_voltage="Ch1 [V]"; repeatable.',
    ),
]

TimeColumn = Annotated[str, typer.Option(help='Column of the times, such as "t [us]".')]

TimeStep = Annotated[str | None, typer.Option(help="Time between samples, such as '10 us'.")]

Stamps = Annotated[str, typer.Option(help="Time stamps that do not increase: refuse, or keep_increasing.")]

Scales = Annotated[
    list[str] | None,
    typer.Option(metavar=_OF_SIGNAL, help='Sensitivity, such as lateral_force_measured="4/9 N/V".'),
]

Calibrations = Annotated[
    list[str] | None,
    typer.Option(
        metavar="SIGNAL=FILE",
        help="Table of readings and known values, both with units, whose line is the scale; repeatable.",
    ),
]

Part = Annotated[
    str | None, typer.Option(help="Sheet, table or array to read, where the file holds several.")
]

With = Annotated[
    str | None,
    typer.Option(
        "--with", metavar="TRACE", help="Imported Trace whose clock and samples the signals are put onto."
    ),
]

Edges = Annotated[
    str,
    typer.Option(help="Of --with: signal whose edges both hold, or A=B: A of TRACE, B of FILE."),
]

ClockShift = Annotated[
    str | None, typer.Option(help="Of --with: time to add to the stamps of FILE, exactly or near the edges.")
]

Offsets = Annotated[
    list[str] | None,
    typer.Option(metavar=_OF_SIGNAL, help='Value to subtract, such as drive_voltage="20 mV".'),
]

Shifts = Annotated[
    list[str] | None, typer.Option(metavar=_OF_SIGNAL, help="Time to add to the stamps of one signal.")
]

Trigger = Annotated[
    str, typer.Option(metavar="SIGNAL", help="Signal whose first rise through mid-range becomes time 0.")
]

Baselines = Annotated[
    list[str] | None,
    typer.Option(metavar=_OF_SIGNAL, help='Span whose mean is subtracted: SIGNAL="0 s..2 s".'),
]

Detrended = Annotated[
    list[str] | None,
    typer.Option(metavar="SIGNAL", help="Subtract the fitted straight line; repeatable."),
]

Crop = Annotated[str | None, typer.Option(help="Span of time to keep: '0.1 s..0.5 s'.")]

Resample = Annotated[str | None, typer.Option(help="Step of an even time grid, such as '100 us'.")]

ReaderName = Annotated[str, typer.Option(help="Name of a reader; found from the file without it.")]

Delimiter = Annotated[str | None, typer.Option(help="Of text: one character, or '' for blanks.")]

DecimalComma = Annotated[
    bool | None, typer.Option("--decimal-comma/--decimal-point", help="Of text: the decimal sign.")
]

Becomes = Annotated[
    str,
    typer.Option("--as", help="What the file becomes: trace, or material (of a spectrum, written as .toml)."),
]

Area = Annotated[str | None, typer.Option(help="Of a material: area of the sample, '1 cm2'.")]

Thickness = Annotated[str | None, typer.Option(help="Of a material: thickness of the sample, '200 um'.")]

SeriesResistance = Annotated[
    str, typer.Option(help="Of a material: resistance in series with the sample, to subtract.")
]

ParallelCapacitance = Annotated[
    str, typer.Option(help="Of a material: capacitance of the fixture, to subtract.")
]

Conductivity = Annotated[
    str, typer.Option(help="Of a material: conductivity at zero frequency, which no spectrum gives.")
]

LayerName = Annotated[str, typer.Option(help="Of a material: the layer it is written for.")]

Listed = Annotated[bool, typer.Option("--list", help="List the readers.")]

Averaged = Annotated[
    str, typer.Option(metavar="SIGNAL", help="Average all signals over the periods of this one.")
]
