"""``electrovib design``, ``check`` and ``export``: a drive or a plate for what is wanted, its limits, and its files."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import typer

from electrovib.apps.cli.options import Arguments, pair_of, takes
from electrovib.apps.cli.terminal import answered, say, say_state, show, show_answer, warned
from electrovib.apps.exit_codes import FAILED, NOT_SHOWN
from electrovib.core.errors import InputError
from electrovib.core.units import number_in

if TYPE_CHECKING:
    from electrovib.studies.check import CheckResult

_EXTREMES: Final = {"maximum": "maximise", "minimum": "minimise"}
"""Word of a wish for a plate, and the argument that has its quantity."""
_OF_DESIGN: Final = "scenario set method carrier rate space n seed share limits"
_OF_PLATE: Final = "scenario set over materials layer refine limits"
_OF_EXPERIMENT: Final = "scenario set laws over space quantity noise limits n seed"
_OF_TEXTURE: Final = "scenario set texture path carrier frequency rate ramp limits"
_OF_SAMPLES: Final = "instrument largest_error full_scale gain edge amplifier_present"
"""Parameters of `electrovib.design`, `design_plate` and so on that are options."""
_FORCE: Final = "electrostatic_force"
"""Signal over time that a drive is to give."""


@takes(
    """
scenario
--want 'NAME = VALUE'  Quantity and its value: 'mean electrostatic_force = 50 mN'; with --share a band, '= 20 mN:60 mN'; of a
    plate '= maximum' or '= minimum', the first decides; of a drive the force over time: 'electrostatic_force = sine 50 Hz 30
    mN' (between 0 and 30 mN), '= sine 50 Hz 10 mN to 30 mN for 0.2 s', '= constant 5 mN for 1 s', or '= FILE' with the columns
    time and force; repeatable.
--free PATH[=LOW:HIGH]  The parameter that is sought, and in which range: drive.amplitude, drive.amplitude=10V:400V.
--method METHOD      Method of the drive: dc, carrier, sqrt-am or current.
--carrier FREQUENCY  Frequency of the carrier of a drive, '3 kHz'; of a texture none if absent.
--space
-n N                 Number of draws from --space; 200 by default.
--seed N             Seed of the draws; needed with --space.
--share SHARE        Share of the fingers of --space that have to have the quantity: 0.9; needs --seed.
--over
--material
--layer
--refine ROUNDS      Of a plate: rounds of candidates added around the best one, each at half the distance; 3 by default, 0 for
    none.
--quantity NAME      Of an experiment: what is measured; 'swing lateral_force' by default.
--noise VALUE        Of an experiment: standard deviation of one repeat, '10 %' of the value and '1 mN' of the sensor by default;
    repeatable.
--texture TEXTURE    A TOML file with the table of a texture, or the table: '{ model = "Grating", period = "2 mm", ... }'.
--path SPEED|FILE|TABLE  Of the finger on a texture: a speed such as '30 mm/s' for one stroke, or a file with the columns time, x
    (and y).
--frequency FREQUENCY  Of a texture without a carrier: where the gain of the force is taken; 100 Hz by default.
--rate
--ramp
--limits
-o, --output FILE    Write the scenario with the result (.toml), all numbers (.json), or the drive as a waveform (.csv, .npy,
    ...); a page (.html), a figure (.pdf, .svg, .png) or tables (.tex); of a plate all candidates (.csv).
--style
--as
--largest-error
--full-scale
--gain
--edge
--amplifier-present
--all
--set
--models A,B,...|FILE.py -> laws  Force laws: which point of the grid of --over tells them apart with the fewest repeats; needs
    --space. Or a Python file with models of your own; repeatable.
--force
""",
    example="electrovib design vezzoli_2014/fig6 --want 'peak electrostatic_force = 1 mN' --free drive.high",
)
def design(given: Arguments) -> None:
    """Find the parameter, drive or plate for a wanted force.

    With --free the values of a parameter that give a quantity, any quantity of a sweep; with --method the drive that gives a
    force over time; with --over or --material the insulator and the drive with the most force within all limits, what binds
    there, and the Pareto set; with --texture the drive that renders a texture under a finger, with the predicted friction; with
    two laws or more in --models the experiment that separates them.
    Exit code 1 if nothing gives what is wanted within the limits.
    """
    laws = given.read_laws()
    given.read_set()
    wishes = given.get("want", [])
    if laws:
        from electrovib.studies.evidence.plan import ExperimentPlan, plan_experiment

        given.only(f"{_OF_EXPERIMENT} output all", "the plan of an experiment")
        if missing := [f"--{name}" for name in ("over", "space") if name not in given]:
            raise InputError(f"--models {','.join(laws)}: needs {' and '.join(missing)} too")
        if "noise" in given:
            by_kind = {each.strip().endswith("%"): each.strip() for each in given["noise"]}
            given["noise"] = by_kind.get(True, 0.0), by_kind.get(False, 0.0)
        wanted = given.take(f"{_OF_EXPERIMENT} output force all") | {"laws": laws}
        answered(ExperimentPlan, plan_experiment, "comparing experiments", wanted)
    elif "texture" in given:
        given.only(f"{_OF_TEXTURE} {_OF_SAMPLES} output", "the drive of a texture")
        _render_texture(given)
    elif {"over", "materials"} & given.keys() or any(text.endswith(tuple(_EXTREMES)) for text in wishes):
        from electrovib.studies.design.plate import PlateDesign, design_plate

        given.only(f"{_OF_PLATE} want output", "the design of a plate")
        wanted = given.take(f"{_OF_PLATE} output force") | _extremes(wishes)
        answered(PlateDesign, design_plate, "evaluating candidates", wanted)
    else:
        given.only(
            f"{_OF_DESIGN} want free output edge amplifier_present all",
            "the design of a parameter or a drive",
        )
        _design(given, _wanted(wishes, with_share="share" in given) | _free(given.get("free")))


def _wanted(texts: Sequence[str], *, with_share: bool) -> dict[str, str]:
    """Read the one wish of a parameter or a drive: a quantity with its value or band, or the force over time."""
    if len(texts) > 1:
        raise InputError(
            "given several times, which only the design of a plate takes, with --over", path="--want"
        )
    for text in texts:
        name, sign, value = (part.strip() for part in text.partition("="))
        if sign and name == _FORCE:
            return {"target": value}
        if sign and with_share and ":" in value:
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


def _design(given: Arguments, wish: dict[str, Any]) -> None:
    """Print the parameter or the drive that gives what is wanted, and write it."""
    from electrovib.apps.progress import tracked
    from electrovib.core.files import inputs_noted
    from electrovib.exports.scenario import check_design_file, write_design
    from electrovib.studies.design import design

    file, of_file = given.get("output"), given.take("force") | edge_of(given)
    with inputs_noted() as inputs:
        if file:
            check_design_file(file, **of_file)
        with tracked("solving") as progress:
            found = design(**given.take(_OF_DESIGN), **wish, progress=progress)
        if file:
            check_design_file(file, inputs=inputs, **of_file)
    say(*(found.lines if "all" in given else found.verdict))
    if "all" not in given and (left := len(found.lines) - len(found.verdict)):
        say(f"--all prints {left} more lines: what it depends on and how it was computed.")
    if file:
        say(*write_design(found, file, **of_file, **given.take("amplifier_present")))
    if not found.is_achieved:
        raise typer.Exit(FAILED)


def _render_texture(given: Arguments) -> None:
    """Print what the drive of a texture reaches, and write it within limits."""
    from electrovib.apps.progress import tracked
    from electrovib.core.files import inputs_noted
    from electrovib.exports.waveform import check_waveform_file, export_waveform
    from electrovib.exports.waveform_formats import FORMATS
    from electrovib.studies.texture import TextureDrive, texture_drive
    from electrovib.studies.texture.set_up import amount

    if "path" not in given:
        raise InputError(
            "not given, but a texture is rendered along a path of the finger: --path '30 mm/s'", path="--path"
        )
    file = given.get("output")
    used = [given.flags[name] for name in ("instrument", "full_scale", "edge") if name in given]
    if used and not file:
        raise InputError("belongs to a file; name one with -o drive.csv", path=used[0])
    given |= edge_of(given)
    samples = given.take(f"{_OF_SAMPLES} force")
    of_file = {name: samples[name] for name in ("instrument", "edge", "force") if name in samples}
    if file and not used and Path(file).suffix.lower() not in FORMATS:
        wanted = given.take(f"{_OF_TEXTURE} output") | of_file
        answered(TextureDrive, texture_drive, "rendering and simulating", wanted)
        return
    if file:
        check_waveform_file(file, **of_file)
    with inputs_noted() as inputs, tracked("rendering and simulating"):
        found = texture_drive(**given.take(_OF_TEXTURE))
    show_answer(found)
    if not file:
        return
    check_waveform_file(file, inputs=inputs, **of_file)
    if "full_scale" in samples:
        samples["full_scale"] = amount(samples["full_scale"], "V", "--full-scale", low=1e-6, high=1e6)
    if "instrument" not in samples and not file.lower().endswith(".wav"):
        samples["rate"] = found.rate
    written = export_waveform(found.scenario, file, limits=given.get("limits"), **samples)
    say(*written.document.sentences, *written.document.remarks)  # its warnings are those of the texture


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

    def told(found: CheckResult, *, everything: bool) -> None:
        """Print the verdict in a few lines, after the tables that were asked for."""
        from electrovib.studies.check.result import HARDWARE

        for table in found.tables if everything else ():
            show(laid_out(table))
        if everything:
            say(*found.notes, "")
        if resistor is not None:
            show(laid_out(resistor.document.tables[0]))
        more = "" if everything else " (--all lists every limit, its source, and published currents)"
        first, *others = found.sentences
        say_state(found.state, first)
        say(*others, *warned(found), f"{HARDWARE}{more}")

    given |= {"drive": drive, "scenario": scenario}
    codes = {FAIL: FAILED, UNKNOWN: NOT_SHOWN}
    if code := codes.get(answered(CheckResult, check, "checking", given, told).state):
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


def edge_of(given: Arguments) -> dict[str, float | str]:
    """Read the edge, if there is one: a time [s], or the word that stands for straight lines."""
    text = given.get("edge")
    return {"edge": text if text == "line" else number_in("s", "--edge", text)} if text else {}
