"""``electrovib fit-material``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from electrovib.apps.cli.force import Force
from electrovib.apps.cli.import_options import (
    Area,
    Columns,
    DecimalComma,
    Delimiter,
    LayerName,
    Part,
    ReaderName,
    SeriesResistance,
    Thickness,
)
from electrovib.apps.cli.terminal import say

if TYPE_CHECKING:
    from electrovib.recordings.spectra.fitted import FittedMaterial

FormName = Annotated[
    str,
    typer.Option(
        help="auto (by AICc), constant, constant-phase, debye, cole-cole, cole-cole-2, havriliak-negami, prony-4, gabriel ..."
    ),
]
Noises = Annotated[
    list[str] | None,
    typer.Option(
        metavar="FILE=SHARE",
        help="Relative standard deviation of the rows of a file, such as z.csv='1 %'; of all files or of none; repeatable.",
    ),
]
Systematic = Annotated[
    str | None,
    typer.Option(
        metavar="SHARE",
        help="Relative standard uncertainty of the modulus, common to all rows, such as '1 %'.",
    ),
]
Reference = Annotated[
    str | None,
    typer.Option(
        metavar="FILE=VALUE",
        help="Spectrum of a known resistor, r.csv='51 kohm +- 1 %': gives systematic error and fixture; a bad one is refused.",
    ),
]
Loss = Annotated[
    str,
    typer.Option(
        metavar="measured|none|unknown",
        help="Of a table of permittivity without loss: a material without any, or the permittivity alone is fitted.",
    ),
]
FixtureCapacitance = Annotated[
    str | None,
    typer.Option(
        help="Capacitance of the fixture, to subtract; that in parallel with --reference if not given."
    ),
]
Band = Annotated[str | None, typer.Option(help="Frequencies to fit: '100 Hz..100 kHz'.")]
Into = Annotated[
    str | None,
    typer.Option(metavar="SCENARIO", help="Write this scenario, with the material in its layer."),
]


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("fit-material")(command)


def command(
    files: Annotated[
        list[str],
        typer.Argument(metavar="FILE...", help="Spectra of impedance or permittivity of one material."),
    ],
    form: FormName = "auto",
    noise: Noises = None,
    systematic: Systematic = None,
    reference: Reference = None,
    loss: Loss = "measured",
    band: Band = None,
    area: Area = None,
    thickness: Thickness = None,
    series_resistance: SeriesResistance = "0 ohm",
    parallel_capacitance: FixtureCapacitance = None,
    column: Columns = None,
    reader: ReaderName = "",
    delimiter: Delimiter = None,
    decimal_comma: DecimalComma = None,
    part: Part = None,
    into: Into = None,
    layer: LayerName = "stratum_corneum",
    output: Annotated[
        str | None, typer.Option("--output", "-o", metavar="FILE.toml", help="Write the material.")
    ] = None,
    force: Force = False,
) -> None:
    """Fit a dispersion to measured spectra of a material.

    Report its statistical interval and systematic error.
    """
    from electrovib.apps.cli.fit_options import pair_of, share_of
    from electrovib.apps.cli.import_ import pairs
    from electrovib.apps.fit_material import fit_material

    noises = dict(pair_of(text, "--noise", "FILE=SHARE") for text in noise or [])
    found = fit_material(
        files,
        form=form,
        noise={name: share_of(value, "--noise") for name, value in noises.items()},
        systematic=None if systematic is None else share_of(systematic, "--systematic"),
        reference=None if reference is None else pair_of(reference, "--reference", "FILE=VALUE"),
        loss=loss,
        band=None if band is None else _band(band),
        area=area,
        thickness=thickness,
        series_resistance=series_resistance,
        parallel_capacitance=parallel_capacitance,
        columns=pairs("column", column),
        reader=reader,
        delimiter=delimiter,
        decimal_comma=decimal_comma,
        part=part,
        into=into,
        layer=layer,
        output=output,
        force=force,
    )
    say(*summary(found))
    if output:
        say(f"written: {output}")


def _band(text: str) -> tuple[str, str]:
    from electrovib.core.errors import InputError

    low, dots, high = (part.strip() for part in text.partition(".."))
    if not dots:
        raise InputError(f"--band {text}: expected LOW..HIGH, such as '100 Hz..100 kHz'")
    return low, high


def summary(found: FittedMaterial) -> list[str]:
    """Report how the material was fitted, each parameter with both uncertainties, and the diagnostics."""
    from electrovib.core.units import format_quantity
    from electrovib.recordings.spectra.fitted import both_uncertainties

    return [
        *found.history,
        *(
            f"{each.name}: {format_quantity(each.value, each.unit, digits=4)}, {both_uncertainties(each)}"
            for each in found.parameters
        ),
        *(f"{each.state}: {each.text}" for each in found.diagnostics),
    ]
