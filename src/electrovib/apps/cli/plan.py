"""A value, a drive, a plate or an experiment for what is wanted; ``check`` and ``export``: its limits, and its files."""

from __future__ import annotations

import functools
import shlex
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import typer

from electrovib.apps.cli.options import Arguments, takes
from electrovib.apps.cli.terminal import answered, say, show, show_answer, warned
from electrovib.apps.exit_codes import FAILED, NOT_SHOWN
from electrovib.core.errors import InputError
from electrovib.core.units import number_in

if TYPE_CHECKING:
    from electrovib.studies.check import CheckResult
    from electrovib.studies.design import Designed

_SOUGHT: Final = """
--free PATH[=LOW:HIGH]  The parameter that is sought, and in which range: drive.amplitude, drive.amplitude=10V:400V. [required]
"""
_WRITTEN: Final = """
--limits
-o, --output FILE    Write the scenario with the result (.toml), all numbers (.json), or its drive as a waveform (.csv, .npy,
    ...); a page (.html), a figure (.pdf, .svg, .png) or tables (.tex).
--style
--edge
--all
--set
--models
--force
"""


@takes(
    """
scenario
--want 'NAME = VALUE'  Quantity and its value: 'mean electrostatic_force = 50 mN'; of a signal at one time 'electrostatic_force at
    20 ms = 1 mN'. [required]
"""
    + _SOUGHT
    + _WRITTEN,
    example="electrovib find-value vezzoli_2014/fig6 --want 'peak electrostatic_force = 1 mN' --free drive.high",
)
def find_value(given: Arguments) -> None:
    """Find the value of a parameter for a wanted quantity.

    Exit code 1 if no value gives it within the limits.
    """
    from electrovib.studies.design import find_value
    from electrovib.studies.design.result import DesignedParameter

    _designed(DesignedParameter, find_value, "solving", given)


@takes(
    """
scenario
--want 'NAME = VALUE'  Quantity and its least value, 'mean electrostatic_force = 50 mN', or its band, '= 20 mN:60 mN'. [required]
--space  [required]
--share SHARE        Share of the fingers that have to have the quantity: 0.9. [required]
--seed N             Seed of the draws. [required]
-n N                 Number of draws. [default: 1000]
"""
    + _SOUGHT
    + _WRITTEN
)
def value_for_share(given: Arguments) -> None:
    """Find the value that suffices for a share of people.

    Exit code 1 if the share is not reached within the limits.
    """
    from electrovib.studies.design.share import DesignedForShare, value_for_share

    _designed(DesignedForShare, value_for_share, "solving", given)


@takes(
    """
scenario
--target FORCE       The force over time: 'sine 50 Hz 30 mN' (between 0 and 30 mN), 'sine 50 Hz 10 mN to 30 mN for 0.2 s',
    'constant 5 mN for 1 s', or a file with the columns time and force. [required]
--method METHOD      dc, carrier, sqrt-am or current. [required]
--carrier FREQUENCY  Frequency of the carrier, '3 kHz'; chosen if absent.
--rate
"""
    + _WRITTEN,
    example="electrovib drive-for-force vezzoli_2014/fig6 --target 'sine 50 Hz 1 mN' --method carrier",
)
def drive_for_force(given: Arguments) -> None:
    """Find the drive that gives a force over time.

    Exit code 1 if the predicted force does not follow it to 1 % within the limits.
    """
    from electrovib.studies.design.drive import DesignedDrive, drive_for_force

    _designed(DesignedDrive, drive_for_force, "solving", given)


@takes(
    """
scenario
--texture TEXTURE    A TOML file with the table of a texture, or the table: '{ model = "Grating", period = "2 mm", ... }'.
    [required]
--path SPEED|FILE|TABLE  Of the finger: a speed such as '30 mm/s' for one stroke, or a file with the columns time, x (and y).
    [required]
--carrier FREQUENCY  Frequency of the carrier, '3 kHz'; none if absent.
--frequency FREQUENCY  Without a carrier: where the gain of the force is taken; 100 Hz by default.
--rate
--ramp
"""
    + _WRITTEN
)
def texture_drive(given: Arguments) -> None:
    """Compute the drive that renders a texture under a finger."""
    from electrovib.studies.texture.drive import TextureDrive, texture_drive

    _designed(TextureDrive, texture_drive, "rendering and simulating", given)


@takes(
    """
scenario
--over
--materials
--layer
--maximise NAME      Quantity that is to be largest, or a varied path; the first decides; mean electrostatic_force by default;
    repeatable.
--minimise NAME      Quantity that is to be smallest, or a varied path; peak voltage by default; repeatable.
--limits
--refine ROUNDS      Rounds of candidates added around the best one, each at half the distance; 0 keeps to the given ones.
    [default: 3]
-o, --output FILE    Write all candidates (.csv), all numbers (.json), the best scenario (.toml), a page (.html), a figure (.pdf,
    .svg, .png) or tables (.tex).
--style
--set
--models
--force
"""
)
def plan_plate(given: Arguments) -> None:
    """Find the plate with the most force within limits."""
    from electrovib.studies.design.plate import PlateDesign, plan_plate

    given.read_set()
    answered(PlateDesign, plan_plate, "evaluating candidates", given)


@takes(
    """
scenario
--models A,B,...|FILE.py -> laws  The force laws, two or more; or a Python file with laws of your own; repeatable. [required]
--over PATH=FROM:TO:N[log]  What can be chosen: a parameter and its values; repeatable. [required]
--space  [required]
--quantity NAME      What is measured; 'swing lateral_force' by default.
--noise VALUE        Standard deviation of one repeat: '10 %' of the value and '1 mN' of the sensor by default; repeatable.
--limits
-n N                 Draws from --space. [default: 64]
--seed N             Of the draws. [default: 0]
-o, --output FILE    Write a page (.html), a figure (.pdf, .svg, .png) or tables (.csv, .tex).
--style
--all
--set
--force
"""
)
def plan_experiment(given: Arguments) -> None:
    """Find the experiment that tells force laws apart soonest."""
    from electrovib.studies.evidence.plan import ExperimentPlan, plan_experiment

    given["models"] = given.read_laws() or []
    given.read_set()
    if "noise" in given:
        by_kind = {each.strip().endswith("%"): each.strip() for each in given["noise"]}
        given["noise"] = by_kind.get(True, 0.0), by_kind.get(False, 0.0)
    answered(ExperimentPlan, plan_experiment, "comparing experiments", given)


def _designed(kind: type[Designed], compute: Callable[..., Designed], words: str, given: Arguments) -> None:
    """Compute, print and write a design, its drive as a waveform too; exit code 1 if it does not give what is wanted."""
    from electrovib.exports.scenario import check_design_file, write_design

    given.read_set()
    edge = edge_of(given)
    given.pop("edge", None)
    check, write = functools.partial(check_design_file, **edge), functools.partial(write_design, **edge)
    found = answered(kind, compute, words, given, check=check, write=write)
    if not found.is_achieved:
        raise typer.Exit(FAILED)


@takes(
    """
first SCENARIO|DRIVE  The scenario; or, before a scenario, a file with the columns time and voltage.
[second] SCENARIO     The scenario in which that drive is checked.
--limits
--series-resistor     Compute the smallest resistor that holds the body current if the insulator fails.
-o, --output FILE|DIR  Write the result: .csv, .json, .html, a figure (.pdf, .svg, .png), tables (.tex), or a folder with all.
--style
--all
--set
--models
--force
""",
    example="electrovib check vezzoli_2014/fig6 --set limits.voltage='1 kV'",
)
def check(given: Arguments) -> None:
    """Compare voltage, current and breakdown with limits.

    Charge, energy and breakdown of each layer, with the gap open and closed, are compared too. Exit code 0 within all limits,
    1 if one is exceeded, 5 if the set-up is not shown to be safe.
    """
    from electrovib.core.answer import laid_out
    from electrovib.studies.check import CheckResult, check
    from electrovib.studies.check.result import FAIL, UNKNOWN
    from electrovib.studies.check.series import series_resistor

    given.read_set()
    drive, scenario = given.pop("first"), given.pop("second", "")
    if not scenario:
        drive, scenario = None, drive
    resistor = None
    if given.pop("series_resistor", False):
        resistor = series_resistor(scenario, limits=given.get("limits"), set=given["set"])

    def print_outcome(found: CheckResult, *, everything: bool) -> None:
        """Print the outcome, after the resistor that was asked for."""
        if resistor is not None:
            show(laid_out(resistor.document.tables[0]))
        show_answer(found, everything=everything, state=found.state)

    given |= {"drive": drive, "scenario": scenario}
    codes = {FAIL: FAILED, UNKNOWN: NOT_SHOWN}
    if code := codes.get(answered(CheckResult, check, "checking", given, print_outcome).state):
        raise typer.Exit(code)


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
def export(given: Arguments) -> None:
    """Write a netlist for ngspice, or the drive as a waveform.

    A waveform is written only within declared limits.
    """
    from electrovib.apps.progress import tracked
    from electrovib.exports.scenario import WRITERS, export_netlist
    from electrovib.exports.waveform import export_waveform
    from electrovib.exports.waveform_formats import FORMATS

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
            given[name] = number_in(unit, given.flags[name], given[name])
    with tracked("sampling and checking"):
        found = export_waveform(**given | edge_of(given), path=path)
    show_answer(found)


def edge_of(given: Arguments) -> dict[str, Any]:
    """Read the edge, if there is one: a time [s], or the word that stands for straight lines."""
    text = given.get("edge")
    return {"edge": text if text == "line" else number_in("s", "--edge", text)} if text else {}
