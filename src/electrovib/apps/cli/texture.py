"""``electrovib texture``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from electrovib.apps.cli.export_options import (
    AmplifierPresent,
    Edge,
    FullScale,
    FurtherLimits,
    Gain,
    Instrument,
    LargestError,
    Rate,
)
from electrovib.apps.cli.force import Force
from electrovib.apps.cli.options import Changes, Models
from electrovib.apps.cli.terminal import say, warned
from electrovib.apps.cli.texture_options import Carrier, Frequency, Output, Path, Ramp, TextureTable

if TYPE_CHECKING:
    from collections.abc import Mapping

    from electrovib.study.texture import TextureDrive


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("texture")(command)


def command(
    scenario: Annotated[
        str, typer.Argument(help="A TOML file, a paper's scenario such as vezzoli_2014/fig6, or a Trace.")
    ],
    texture: TextureTable,
    path: Path,
    carrier: Carrier = "",
    frequency: Frequency = "100 Hz",
    rate: Rate = "",
    ramp: Ramp = "1 ms",
    limits: FurtherLimits = None,
    output: Output = "",
    instrument: Instrument = "",
    largest_error: LargestError = 0.01,
    full_scale: FullScale = "",
    gain: Gain = 1.0,
    edge: Edge = "",
    amplifier_present: AmplifierPresent = False,
    changes: Changes = None,
    models: Models = None,
    force: Force = False,
) -> None:
    """Compute the drive that renders a texture under a finger.

    Predict its friction along a path of the finger, and write the drive within limits.
    """
    del models  # imported by now
    from electrovib.apps.changes import read_changes
    from electrovib.apps.cli.export import edge_of, lines_of
    from electrovib.apps.progress import tracked
    from electrovib.core.files import inputs_noted
    from electrovib.export.waveform import check_waveform_file, export_waveform
    from electrovib.study.texture import texture_drive

    if not output:
        _refuse({"--as": instrument, "--full-scale": full_scale, "--edge": edge})
    declared = list(limits or [])
    if output:
        check_waveform_file(output, instrument=instrument, edge=edge_of(edge), force=force)
    with inputs_noted() as inputs, tracked("rendering and simulating"):
        found = texture_drive(
            scenario,
            texture=texture,
            path=path,
            carrier=carrier or None,
            frequency=frequency,
            rate=rate or None,
            ramp=ramp,
            limits=declared,
            set=read_changes(changes or []),
        )
    say(*summary(found), *warned(found))
    if output:
        check_waveform_file(output, instrument=instrument, edge=edge_of(edge), inputs=inputs, force=force)
        written = export_waveform(
            found.scenario, output, limits=declared, instrument=instrument,
            rate=None if instrument or output.lower().endswith(".wav") else found.rate,
            largest_error=largest_error, full_scale=_voltage(full_scale), gain=gain, edge=edge_of(edge),
            amplifier_present=amplifier_present, force=force,
        )  # fmt: skip
        say(*lines_of(written))


def _refuse(options: Mapping[str, str]) -> None:
    """Refuse options of a file where none is written."""
    from electrovib.core.errors import InputError

    if used := [name for name, value in options.items() if value]:
        raise InputError("belongs to a file; name one with -o drive.csv", path=used[0])


def _voltage(text: str) -> float | None:
    """Read an optional full scale [V]."""
    from electrovib.study.texture.set_up import amount

    return amount(text, "V", "--full-scale", low=1e-6, high=1e6) if text else None


def summary(found: TextureDrive) -> list[str]:
    """Return what a drive of a texture reaches, as lines."""
    import numpy as np

    from electrovib.core.units import format_quantity

    known = found.predicted_friction[np.isfinite(found.predicted_friction)]
    span = (
        f"friction {format_quantity(float(known.min()), 'N', digits=5)} to {format_quantity(float(known.max()), 'N', digits=5)}"
        if len(known)
        else "the friction is not determined: the finger rests"
    )
    return [
        *found.notes,
        f"wanted attraction up to {format_quantity(float(np.max(found.wanted_force)), 'N', digits=4)}, predicted up to"
        f" {format_quantity(float(np.max(found.predicted_force)), 'N', digits=4)}; {span}",
        found.misfit_in_words,
        f"{len(found.times)} samples in {format_quantity(float(found.times[-1]), 's', digits=4)}, up to"
        f" {format_quantity(float(np.max(np.abs(found.voltages))), 'V', digits=4)}, from 0 V to 0 V",
    ]
