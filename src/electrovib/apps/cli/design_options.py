"""Options of ``electrovib design``, by form."""

from __future__ import annotations

from typing import Annotated, TypeAlias

import typer

from electrovib.apps.cli.completion import parameter_paths, quantity_names, space_names

Want: TypeAlias = Annotated[
    str | None,
    typer.Option(
        metavar="'QUANTITY = VALUE'",
        help="Quantity of a sweep and its value: 'mean electrostatic_force = 50 mN'.",
        autocompletion=quantity_names,
        show_default=False,
    ),
]
Free: TypeAlias = Annotated[
    str | None,
    typer.Option(
        metavar="PATH",
        help="The parameter that is sought: drive.amplitude.",
        autocompletion=parameter_paths,
        show_default=False,
    ),
]
Between: TypeAlias = Annotated[
    str | None,
    typer.Option(
        metavar="LOW:HIGH",
        help="Range in which it is sought: 10V:400V; by default the range of the parameter.",
        show_default=False,
    ),
]
Limits: TypeAlias = Annotated[
    list[str] | None,
    typer.Option(
        metavar="FILE.toml",
        help="Further limits beside those of the scenario; the strictest counts. Repeatable.",
    ),
]
Output: TypeAlias = Annotated[
    str | None,
    typer.Option(
        "--output",
        "-o",
        help="Write the scenario with the result (.toml), all numbers (.json), or the drive as a waveform (.csv, .npy, ...).",
    ),
]
Target: TypeAlias = Annotated[
    str | None,
    typer.Option(
        metavar="TARGET",
        help="Force over time: 'sine 50 Hz 30 mN' (between 0 and 30 mN), 'sine 50 Hz 10 mN to 30 mN for 0.2 s',"
        " 'constant 5 mN for 1 s', or a file with the columns time and force.",
        show_default=False,
    ),
]
Method: TypeAlias = Annotated[
    str | None,
    typer.Option(
        metavar="METHOD", help="Method of the drive: dc, carrier, sqrt-am or current.", show_default=False
    ),
]
Carrier: TypeAlias = Annotated[
    str | None,
    typer.Option(
        metavar="FREQUENCY", help="Frequency of the carrier: '3 kHz'; chosen if absent.", show_default=False
    ),
]
Rate: TypeAlias = Annotated[
    str | None,
    typer.Option(
        metavar="RATE",
        help="Samples of the drive per second: '192 kHz'; chosen if absent.",
        show_default=False,
    ),
]
SpaceOf: TypeAlias = Annotated[
    str | None,
    typer.Option(
        "--space",
        metavar="SPACE",
        help="Distributions of uncertain parameters: fingers, or a TOML file; gives the distribution of the result.",
        autocompletion=space_names,
        show_default=False,
    ),
]
Draws: TypeAlias = Annotated[
    int | None, typer.Option("-n", help="Number of draws from the space; 200 by default.", show_default=False)
]
Seed: TypeAlias = Annotated[
    int | None, typer.Option(help="Seed of the draws; needed with --space.", show_default=False)
]
LinearOnly: TypeAlias = Annotated[
    bool,
    typer.Option("--linear", help="Propagate the space linearly instead of solving anew for every draw."),
]
Share: TypeAlias = Annotated[
    float | None,
    typer.Option(
        metavar="SHARE",
        help="Share of the fingers of --space that have to have the quantity: 0.9; needs --seed.",
        show_default=False,
    ),
]
Band: TypeAlias = Annotated[
    str | None,
    typer.Option(
        metavar="LOW:HIGH",
        help="With --share: band of the quantity, 20mN:60mN; --want then names the quantity alone.",
        show_default=False,
    ),
]
