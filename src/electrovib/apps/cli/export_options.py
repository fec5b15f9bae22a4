"""Options of ``electrovib export``."""

from __future__ import annotations

from typing import Annotated

import typer

Output = Annotated[
    str,
    typer.Option(
        "--output",
        "-o",
        help="A netlist .cir, or the drive as .csv, .npy, .mat, .wav or .pwl.",
        show_default=False,
    ),
]
Place = Annotated[
    str, typer.Argument(metavar="OUTPUT", help="The file to write, if not given by -o.", show_default=False)
]
FurtherLimits = Annotated[
    list[str] | None,
    typer.Option(
        "--limits",
        metavar="FILE.toml",
        help="Further limits of a waveform; the strictest counts. Repeatable.",
    ),
]
Instrument = Annotated[
    str,
    typer.Option("--as", metavar="hp_33120a", help="Instrument whose codes are written.", show_default=False),
]
Rate = Annotated[
    str, typer.Option(metavar="FREQUENCY", help="Samples per second; chosen if absent.", show_default=False)
]
Ramp = Annotated[
    str,
    typer.Option(
        metavar="TIME",
        help="Multiply the drive by ramps from and to 0 V of this duration.",
        show_default=False,
    ),
]
LargestError = Annotated[
    float,
    typer.Option(metavar="SHARE", help="Error over the largest voltage above which nothing is written."),
]
FullScale = Annotated[
    str, typer.Option(metavar="VOLTAGE", help="Voltage of the drive at full scale.", show_default=False)
]
Gain = Annotated[
    float, typer.Option(metavar="NUMBER", help="Voltage of the drive over that of the instrument.")
]
Edge = Annotated[
    str,
    typer.Option(
        metavar="TIME|line",
        help="How samples follow each other where a waveform is played: held, with an edge that takes this time, or joined by"
        " straight lines (line).",
        show_default=False,
    ),
]
AmplifierPresent = Annotated[
    bool,
    typer.Option(
        "--amplifier-present",
        help="The amplifier of the scenario stands before the plate: its bandwidth and limits count.",
    ),
]
