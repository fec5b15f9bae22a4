"""Options of ``electrovib texture``."""

from __future__ import annotations

from typing import Annotated

import typer

TextureTable = Annotated[
    str,
    typer.Argument(
        metavar="TEXTURE",
        help='A TOML file with the table of a texture, or the table: \'{ model = "Grating", period = "2 mm", ... }\'.',
    ),
]
Path = Annotated[
    str,
    typer.Option(
        metavar="SPEED|FILE|TABLE",
        help="A speed such as '30 mm/s' for one stroke, or a file with the columns time and x (and y).",
    ),
]
Carrier = Annotated[
    str,
    typer.Option(metavar="FREQUENCY", help="Carrier that is modulated; none if absent.", show_default=False),
]
Frequency = Annotated[
    str, typer.Option(metavar="FREQUENCY", help="Without a carrier, where the gain of the force is taken.")
]
Ramp = Annotated[str, typer.Option(metavar="TIME", help="Ramp from and to 0 V at either end.")]
Output = Annotated[
    str,
    typer.Option("--output", "-o", help="The drive as .csv, .npy, .mat, .wav or .pwl.", show_default=False),
]
