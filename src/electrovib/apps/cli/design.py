"""``electrovib design``: a parameter, a drive, a plate or a texture, by what is free and what is wanted."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any, Final, TypeAlias

import typer

from electrovib.apps.cli import options
from electrovib.apps.cli.answers import answered
from electrovib.apps.cli.export import edge_of, waveform_lines
from electrovib.apps.cli.options import (
    Text,
    Texts,
    given,
    many,
    names_of,
    only,
    option,
    output,
    pair_of,
    parameter_paths,
    quantity_names,
)
from electrovib.apps.cli.terminal import say, show_answer
from electrovib.core.errors import InputError

EXAMPLE: Final = (
    "electrovib design vezzoli_2014/fig6 --want 'peak electrostatic_force = 1 mN' --free drive.high"
)
_EXTREMES: Final = {"maximum": "maximise", "minimum": "minimise"}
"""Word of a wish for a plate, and the argument that has its quantity."""
_OF_DESIGN: Final = "method carrier rate space n seed linear share limits"
_OF_PLATE: Final = "over layer refine limits"
_OF_TEXTURE: Final = "texture path carrier frequency rate ramp limits"
_OF_SAMPLES: Final = "instrument largest_error full_scale gain edge amplifier_present"
"""Parameters of `electrovib.design`, `design_plate`, `texture_drive` and `export_waveform` that are options."""
_FORCE: Final = "electrostatic_force"
"""Signal over time that a drive is to give."""

Want: TypeAlias = Annotated[
    Texts,
    many(
        "'NAME = VALUE'",
        "Quantity and its value: 'mean electrostatic_force = 50 mN'; with --share a band, '= 20 mN:60 mN'; of a plate"
        " '= maximum' or '= minimum', the first decides; of a drive the force over time: 'electrostatic_force = sine 50 Hz"
        " 30 mN' (between 0 and 30 mN), '= sine 50 Hz 10 mN to 30 mN for 0.2 s', '= constant 5 mN for 1 s', or '= FILE'"
        " with the columns time and force",
        autocompletion=quantity_names,
    ),
]
Free: TypeAlias = Annotated[
    Text,
    option(
        "The parameter that is sought, and in which range: drive.amplitude, drive.amplitude=10V:400V.",
        metavar="PATH[=LOW:HIGH]",
        autocompletion=parameter_paths,
    ),
]
Method: TypeAlias = Annotated[
    Text, option("Method of the drive: dc, carrier, sqrt-am or current.", metavar="METHOD")
]
Carrier: TypeAlias = Annotated[
    Text,
    option("Frequency of the carrier of a drive, '3 kHz'; of a texture none if absent.", metavar="FREQUENCY"),
]
N: TypeAlias = Annotated[int | None, option("Number of draws from --space; 200 by default.", "-n")]
Seed: TypeAlias = Annotated[int | None, option("Seed of the draws; needed with --space.")]
Linear: TypeAlias = Annotated[
    bool, option("Propagate --space linearly instead of solving anew for every draw.", "--linear")
]
Share: TypeAlias = Annotated[
    float | None,
    option(
        "Share of the fingers of --space that have to have the quantity: 0.9; needs --seed.",
        metavar="SHARE",
    ),
]
Refine: TypeAlias = Annotated[
    int | None,
    option(
        "Of a plate: rounds of candidates added around the best one, each at half the distance; 3 by default, 0 for none.",
        metavar="ROUNDS",
    ),
]
Texture: TypeAlias = Annotated[
    Text,
    option(
        'A TOML file with the table of a texture, or the table: \'{ model = "Grating", period = "2 mm", ... }\'.',
        metavar="TEXTURE",
    ),
]
Path: TypeAlias = Annotated[
    Text,
    option(
        "Of the finger on a texture: a speed such as '30 mm/s' for one stroke, or a file with the columns time, x (and y).",
        metavar="SPEED|FILE|TABLE",
    ),
]
Frequency: TypeAlias = Annotated[
    str,
    option(
        "Of a texture without a carrier: where the gain of the force is taken; 100 Hz by default.",
        metavar="FREQUENCY",
    ),
]
File: TypeAlias = Annotated[
    Text,
    output(
        "Write the scenario with the result (.toml), all numbers (.json), or the drive as a waveform (.csv, .npy, ...); of a"
        " plate all candidates (.csv), a page (.html) or the figure (.png, .svg)."
    ),
]


def command(
    context: typer.Context,
    scenario: options.Scenario,
    want: Want = None,
    free: Free = None,
    method: Method = None,
    carrier: Carrier = None,
    space: options.Space = None,
    n: N = None,
    seed: Seed = None,
    linear: Linear = False,
    share: Share = None,
    over: options.Over = None,
    material: options.Material = None,
    layer: options.Layer = "",
    refine: Refine = None,
    texture: Texture = None,
    path: Path = None,
    frequency: Frequency = "",
    rate: options.Rate = "",
    ramp: options.Ramp = "",
    limits: options.Limits = None,
    file: File = None,
    instrument: options.Instrument = "",
    largest_error: options.LargestError = 0.01,
    full_scale: options.FullScale = "",
    gain: options.Gain = 1.0,
    edge: options.Edge = "",
    amplifier_present: options.AmplifierPresent = False,
    everything: options.Everything = False,
    changes: options.Changes = None,
    models: options.Models = None,
    force: options.Force = False,
) -> None:
    """Find the parameter, drive or plate for a wanted force.

    With --free the values of a parameter that give a quantity, any quantity of a sweep; with --method the drive that gives a
    force over time; with --over or --material the insulator and the drive with the most force within all limits, what binds
    there, and the Pareto set; with --texture the drive that renders a texture under a finger, with the predicted friction.
    Exit code 1 if nothing gives what is wanted within the limits.
    """
    from electrovib.apps.changes import read_changes

    played = given(context, "amplifier_present") | {"edge": edge_of(edge)}
    changed = {"set": read_changes(changes or [])}
    if texture is not None:
        only(context, f"{_OF_TEXTURE} {_OF_SAMPLES} scenario file changes", "the drive of a texture")
        played |= given(context, _OF_SAMPLES) | {"edge": edge_of(edge)}
        _render_texture(scenario, changed | given(context, _OF_TEXTURE), file, played, force=force)
    elif over or material or any(text.endswith(tuple(_EXTREMES)) for text in want or []):
        only(context, f"{_OF_PLATE} scenario want material file changes", "the design of a plate")
        asked = given(context, _OF_PLATE) | _extremes(want or [])
        _design_plate(
            scenario, changed | asked | {"materials": names_of([material or ""])}, file, force=force
        )
    else:
        others = "scenario want free file edge amplifier_present everything changes"
        only(context, f"{_OF_DESIGN} {others}", "the design of a parameter or a drive")
        asked = given(context, _OF_DESIGN) | _wanted(want or [], share=share) | _free(free)
        _design(scenario, changed | asked, file, played, force=force, everything=everything)


def _wanted(texts: Sequence[str], *, share: float | None) -> dict[str, str]:
    """Read the one wish of a parameter or a drive: a quantity with its value or band, or the force over time."""
    if len(texts) > 1:
        raise InputError(
            "given several times, which only the design of a plate takes, with --over", path="--want"
        )
    for text in texts:
        name, sign, value = (part.strip() for part in text.partition("="))
        if sign and name == _FORCE:
            return {"target": value}
        if sign and share is not None and ":" in value:
            return {"want": name, "band": value}
    return {"want": texts[0]} if texts else {}


def _free(text: str | None) -> dict[str, str]:
    """Read the free parameter, and the range in which it is sought."""
    if not text:
        return {}
    name, sign, ends = (part.strip() for part in text.partition("="))
    return {"free": name, "between": ends} if sign else {"free": name}


def _extremes(texts: Sequence[str]) -> dict[str, list[str]]:
    """Read what is to be largest and what smallest."""
    found: dict[str, list[str]] = {}
    for text in texts:
        name, word = pair_of(text, "--want", "'NAME = maximum' or 'NAME = minimum' of a plate")
        if word not in _EXTREMES:
            raise InputError(f"--want {text}: of a plate expected 'NAME = maximum' or 'NAME = minimum'")
        found.setdefault(_EXTREMES[word], []).append(name)
    return found


def _design(
    scenario: str,
    asked: dict[str, Any],
    file: str | None,
    of_waveform: dict[str, Any],
    *,
    force: bool,
    everything: bool,
) -> None:
    """Print the parameter or the drive that gives what is wanted, and write it."""
    from electrovib.apps.exit_codes import FAILED
    from electrovib.apps.progress import tracked
    from electrovib.core.files import inputs_noted
    from electrovib.exports.scenario import check_design_file, write_design
    from electrovib.studies.design import design

    with inputs_noted() as inputs:
        if file:
            check_design_file(file, edge=of_waveform["edge"], force=force)
        with tracked("solving") as progress:
            found = design(scenario, **asked, progress=progress)
        if file:
            check_design_file(file, edge=of_waveform["edge"], inputs=inputs, force=force)
    say(*(found.lines if everything else found.verdict))
    if not everything and (left := len(found.lines) - len(found.verdict)):
        say(f"--all prints {left} more lines: what it depends on and how it was computed.")
    if file:
        say(*write_design(found, file, force=force, **of_waveform))
    if not found.is_achieved:
        raise typer.Exit(FAILED)


def _design_plate(scenario: str, asked: dict[str, Any], file: str | None, *, force: bool) -> None:
    """Print the best plate and the Pareto set, and write all candidates."""
    from electrovib.studies.design.plate import PlateDesign, design_plate

    answered(
        PlateDesign,
        design_plate,
        words="evaluating candidates",
        output=file,
        force=force,
        scenario=scenario,
        progress=None,
        **asked,
    )


def _render_texture(
    scenario: str, asked: dict[str, Any], file: str | None, of_waveform: dict[str, Any], *, force: bool
) -> None:
    """Print what the drive of a texture reaches, and write it within limits."""
    from electrovib.apps.progress import tracked
    from electrovib.core.files import inputs_noted
    from electrovib.exports.waveform import check_waveform_file, export_waveform
    from electrovib.studies.texture import texture_drive
    from electrovib.studies.texture.set_up import amount

    if "path" not in asked:
        raise InputError(
            "not given, but a texture is rendered along a path of the finger: --path '30 mm/s'", path="--path"
        )
    edge, instrument = of_waveform["edge"], of_waveform.get("instrument", "")
    full_scale = of_waveform.pop("full_scale", "")
    of_file = {"--as": instrument, "--full-scale": full_scale, "--edge": edge}
    if not file and (used := [name for name, value in of_file.items() if value]):
        raise InputError("belongs to a file; name one with -o drive.csv", path=used[0])
    if file:
        check_waveform_file(file, instrument=instrument, edge=edge, force=force)
    with inputs_noted() as inputs, tracked("rendering and simulating"):
        found = texture_drive(scenario, **asked)
    show_answer(found)
    if not file:
        return
    check_waveform_file(file, instrument=instrument, edge=edge, inputs=inputs, force=force)
    rate = None if instrument or file.lower().endswith(".wav") else found.rate
    level = amount(full_scale, "V", "--full-scale", low=1e-6, high=1e6) if full_scale else None
    written = export_waveform(
        found.scenario,
        file,
        limits=asked.get("limits"),
        rate=rate,
        full_scale=level,
        force=force,
        **of_waveform,
    )
    say(*waveform_lines(written))
