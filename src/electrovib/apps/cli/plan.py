"""A value, a drive, a plate or an experiment for what is wanted; ``check`` and ``export``: its limits, and its files.

Parameters
----------
free : PATH[=LOW:HIGH]
    The parameter that is sought, and in which range: drive.amplitude, drive.amplitude=10V:400V.
output : FILE
    Write the scenario with the result (.toml), all numbers (.json), or its drive as a waveform (.csv, .npy, ...); a page (.html),
    a figure (.pdf, .svg, .png) or tables (.tex).
"""

import functools
import shlex
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from electrovib.apps.cli import options
from electrovib.apps.cli.terminal import answered, say, show, show_answer, warned
from electrovib.apps.exit_codes import FAILED, NOT_SHOWN
from electrovib.core.errors import InputError
from electrovib.core.units import number_in

if TYPE_CHECKING:
    from electrovib.studies.design.result import Designed

Free = Annotated[str, typer.Option(autocompletion=options.parameter_paths)]
Want = Annotated[str, typer.Option(autocompletion=options.quantity_names)]


@dataclass(frozen=True, kw_only=True)
class DesignOptions(options.LimitOptions):
    """In which scenario and within which limits something is sought, and how its drive is played."""

    edge: options.Text = None


def find_value(
    *,
    want: Want,
    free: Free,
    designing: DesignOptions,
    saved: options.AnswerOptions,
) -> None:
    """Find the value of a parameter for a wanted quantity.

    Exit code 1 if no value gives it within the limits.

    Parameters
    ----------
    want : 'NAME = VALUE'
        Quantity and its value: 'mean electrostatic_force = 50 mN'; of a signal at one time 'electrostatic_force at 20 ms = 1 mN'.

    Examples
    --------
    electrovib find-value vezzoli_2014/fig6 --want 'peak electrostatic_force = 1 mN' --free drive.high
    """
    from electrovib.studies.design.result import DesignedParameter
    from electrovib.studies.design.value import find_value

    asked = options.given(want=want, free=free)
    _designed(DesignedParameter, find_value, "solving", asked, designing, saved)


def value_for_share(
    *,
    want: Want,
    space: options.Space,
    share: Annotated[float, options.number("--share")],
    seed: options.Seed,
    n: options.Count = 1000,
    free: Free,
    designing: DesignOptions,
    saved: options.AnswerOptions,
) -> None:
    """Find the value that suffices for a share of people.

    Exit code 1 if the share is not reached within the limits.

    Parameters
    ----------
    want : 'NAME = VALUE'
        Quantity and its least value, 'mean electrostatic_force = 50 mN', or its band, '= 20 mN:60 mN'.
    share : SHARE
        Share of the fingers that have to have the quantity: 0.9.
    seed : N
        Seed of the draws.
    n : N
        Number of draws.
    """
    from electrovib.studies.design.share.function import value_for_share
    from electrovib.studies.design.share.result import DesignedForShare

    asked = options.given(want=want, free=free, space=space, share=share, seed=seed, n=n)
    _designed(DesignedForShare, value_for_share, "solving", asked, designing, saved)


def drive_for_force(
    *,
    target: options.Needed,
    method: options.Needed,
    carrier: options.Text = None,
    rate: options.Text = None,
    designing: DesignOptions,
    saved: options.AnswerOptions,
) -> None:
    """Find the drive that gives a force over time.

    Exit code 1 if the predicted force does not follow it to 1 % within the limits.

    Parameters
    ----------
    target : FORCE
        The force over time: 'sine 50 Hz 30 mN' (between 0 and 30 mN), 'sine 50 Hz 10 mN to 30 mN for 0.2 s', 'constant 5 mN for
        1 s', or a file with the columns time and force.
    method : METHOD
        dc, carrier, sqrt-am or current.
    carrier : FREQUENCY
        Frequency of the carrier, '3 kHz'; chosen if absent.

    Examples
    --------
    electrovib drive-for-force vezzoli_2014/fig6 --target 'sine 50 Hz 1 mN' --method carrier
    """
    from electrovib.studies.design.drive.function import DesignedDrive, drive_for_force

    asked = options.given(target=target, method=method, carrier=carrier, rate=rate)
    _designed(DesignedDrive, drive_for_force, "solving", asked, designing, saved)


def texture_drive(
    *,
    texture: options.Needed,
    path: options.Needed,
    carrier: options.Text = None,
    rate: options.Text = None,
    ramp: options.Text = None,
    designing: DesignOptions,
    saved: options.AnswerOptions,
) -> None:
    """Compute the drive that renders a texture under a finger.

    Parameters
    ----------
    texture : TEXTURE
        A TOML file with the table of a texture, or the table: '{ model = "Grating", period = "2 mm", ... }'.
    path : SPEED|FILE|TABLE
        Of the finger: a speed such as '30 mm/s' for one stroke, or a file with the columns time, x (and y).
    carrier : FREQUENCY
        Frequency of the carrier, '3 kHz'; none if absent, and the gain of the force is that at 100 Hz.
    """
    from electrovib.studies.texture.drive import TextureDrive, texture_drive

    asked = options.given(texture=texture, path=path, carrier=carrier, rate=rate, ramp=ramp)
    _designed(TextureDrive, texture_drive, "rendering and simulating", asked, designing, saved)


def plan_plate(
    *,
    over: options.Texts = None,
    materials: options.Names = None,
    layer: options.Text = None,
    maximise: options.Texts = None,
    minimise: options.Texts = None,
    experiment: options.LimitOptions,
    saved: options.AnswerOptions,
) -> None:
    """Find the plate with the most force within limits.

    Parameters
    ----------
    maximise : NAME
        Quantity that is to be largest, or a varied path; the first decides; mean electrostatic_force by default; repeatable.
    minimise : NAME
        Quantity that is to be smallest, or a varied path; peak voltage by default; repeatable.
    output : FILE
        Write all candidates (.csv), all numbers (.json), the best scenario (.toml), a page (.html), a figure (.pdf, .svg, .png)
        or tables (.tex).
    """
    from electrovib.studies.design.plate.function import plan_plate
    from electrovib.studies.design.plate.result import PlateDesign

    asked = options.given(over=over, materials=materials, layer=layer, maximise=maximise, minimise=minimise)
    answered(PlateDesign, plan_plate, "evaluating candidates", experiment.asked | asked, saved)


def plan_experiment(
    *,
    models: Annotated[list[str], typer.Option()],
    over: Annotated[list[str], typer.Option()],
    space: options.Space,
    quantity: options.Text = None,
    noise: options.Texts = None,
    n: options.Count = 64,
    seed: options.Seed = 0,
    experiment: options.LimitOptions,
    saved: options.AnswerOptions,
) -> None:
    """Find the experiment that tells force laws apart soonest.

    Parameters
    ----------
    models : A,B,...|FILE.py
        The force laws, two or more; or a Python file with laws of your own; repeatable.
    over : PATH=FROM:TO:N[log]
        What can be chosen: a parameter and its values; repeatable.
    quantity : NAME
        What is measured; 'swing lateral_force' by default.
    noise : VALUE
        Standard deviation of one repeat: '10 %' of the value and '1 mN' of the sensor by default; repeatable.
    n : N
        Draws from --space.
    seed : N
        Of the draws.
    output : FILE
        Write a page (.html), a figure (.pdf, .svg, .png) or tables (.csv, .tex).
    """
    from electrovib.studies.evidence.plan import ExperimentPlan, plan_experiment

    laws = options.read_laws(models) or []
    asked = options.given(models=laws, over=over, space=space, quantity=quantity, n=n, seed=seed)
    if noise:
        by_kind = {each.strip().endswith("%"): each.strip() for each in noise}
        asked["noise"] = by_kind.get(True, 0.0), by_kind.get(False, 0.0)
    answered(ExperimentPlan, plan_experiment, "comparing experiments", experiment.asked | asked, saved)


def _designed(
    kind: "type[Designed]",
    compute: "Callable[..., Designed]",
    words: str,
    asked: dict[str, Any],
    designing: DesignOptions,
    saved: options.AnswerOptions,
) -> None:
    """Compute, print and write a design, its drive as a waveform too; exit code 1 if it does not give what is wanted."""
    from electrovib.exports.save import check_design_file, write_design

    edge = edge_of(designing.edge)
    check, write = functools.partial(check_design_file, **edge), functools.partial(write_design, **edge)
    found = answered(kind, compute, words, designing.asked | asked, saved, check=check, write=write)
    if not found.is_achieved:
        raise typer.Exit(FAILED)


def check(
    *,
    first: Annotated[str, typer.Argument()],
    second: Annotated[str | None, typer.Argument()] = None,
    limits: options.Texts = None,
    series_resistor: options.Flag = False,
    set: options.Changes = None,
    saved: options.AnswerOptions,
) -> None:
    """Compare voltage, current and breakdown with limits.

    Charge, energy and breakdown of each layer, with the gap open and closed, are compared too. Exit code 0 within all limits,
    1 if one is exceeded, 5 if the set-up is not shown to be safe.

    Parameters
    ----------
    first : SCENARIO|DRIVE
        The scenario; or, before a scenario, a file with the columns time and voltage.
    second : SCENARIO
        The scenario in which that drive is checked.
    series_resistor
        Compute the smallest resistor that holds the body current if the insulator fails.
    output : FILE|DIR
        Write the result: .csv, .json, .html, a figure (.pdf, .svg, .png), tables (.tex), or a folder with all.

    Examples
    --------
    electrovib check vezzoli_2014/fig6 --set limits.voltage='1 kV'
    """
    from electrovib.core.answer import laid_out
    from electrovib.studies.check import CheckResult, check
    from electrovib.studies.check.result import FAIL, UNKNOWN
    from electrovib.studies.check.series import series_resistor as resistor_of

    changes = options.changes(set)
    drive, scenario = (first, second) if second else (None, first)
    resistor = resistor_of(scenario, limits=limits, set=changes) if series_resistor else None

    def print_outcome(found: "CheckResult", *, everything: bool) -> None:
        """Print the outcome, after the resistor that was asked for."""
        if resistor is not None:
            show(laid_out(resistor.document.tables[0]))
        show_answer(found, everything=everything, state=found.state)

    asked = {"drive": drive, "scenario": scenario, "limits": limits, "set": changes}
    codes = {FAIL: FAILED, UNKNOWN: NOT_SHOWN}
    if code := codes.get(answered(CheckResult, check, "checking", asked, saved, show=print_outcome).state):
        raise typer.Exit(code)


def export(
    context: typer.Context,
    *,
    experiment: options.LimitOptions,
    place: Annotated[str | None, typer.Argument()] = None,
    instrument: Annotated[str | None, typer.Option("--instrument", "--as")] = None,
    rate: options.Text = None,
    ramp: options.Text = None,
    full_scale: options.Text = None,
    gain: Annotated[float, options.number("--gain")] = 1.0,
    edge: options.Text = None,
    into: options.FileOptions,
) -> None:
    """Write a netlist for ngspice, or the drive as a waveform.

    A waveform is written only within declared limits; bandwidth and limits of circuit.amplifier count only where its hardware is
    named.

    Parameters
    ----------
    place : OUTPUT
        The file to write, if not given by -o.
    output : FILE
        A netlist .cir, or the drive as .csv, .npy, .mat, .wav or .pwl.
    instrument : NAME
        Instrument whose codes are written: hp_33120a.
    full_scale : VOLTAGE
        Voltage of the drive at full scale.
    gain : NUMBER
        Voltage of the drive over that of the instrument.
    """
    from electrovib.apps.progress import tracked
    from electrovib.exports.save import WRITERS, export_netlist
    from electrovib.exports.waveform import export_waveform
    from electrovib.exports.waveform_formats import WAVEFORM_FORMATS, Scaling

    if bool(place) == bool(into.output):
        raise InputError("name one file to write: electrovib export SCENARIO -o drive.csv", path="--output")
    path = str(place or into.output)
    suffix, known = Path(path).suffix.lower(), experiment.asked
    if suffix not in WAVEFORM_FORMATS and not instrument:
        if suffix in WRITERS and (used := options.surplus(context, "scenario place output set force")):
            raise InputError(f"{flag}: belongs to a waveform; omit it for a netlist" for flag in used)
        with tracked("solving and writing"):
            written = export_netlist(known["scenario"], Path(path), changes=known["set"], force=into.force)
        say(*warned(written), f"written: {written.path}")
        say(f"run it:  ngspice -b {shlex.quote(str(written.path))}")
        return
    asked = known | options.given(instrument=instrument) | edge_of(edge)
    for name, (unit, text) in {"rate": ("Hz", rate), "ramp": ("s", ramp)}.items():
        if text:
            asked[name] = number_in(unit, f"--{name}", text)
    full = number_in("V", "--full-scale", full_scale) if full_scale else None
    asked["scaling"] = Scaling(full_scale=full, gain=gain)
    with tracked("sampling and checking"):
        found = export_waveform(path=path, force=into.force, **asked)
    show_answer(found)


def edge_of(text: str | None) -> dict[str, Any]:
    """Read the edge, if there is one: a time [s], or the word that stands for straight lines."""
    if not text or text == "line":
        return {"edge": text} if text else {}
    try:
        return {"edge": number_in("s", "--edge", text)}
    except InputError:
        steps = "expected a time, for instance '10 us', in which an output that holds its samples steps"
        lines = "or 'line' for one that joins them by straight lines"
        raise InputError(f"{steps}, {lines}", path="--edge", value=text) from None
