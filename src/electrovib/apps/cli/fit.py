"""``electrovib fit``: the parameters of a scenario, a material or a power law, by what it is given."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import typer

from electrovib.apps.cli.import_ import OF_SAMPLE, READING, recipe_of
from electrovib.apps.cli.options import Arguments, pair_of, takes
from electrovib.apps.cli.terminal import say, show_answer, warned
from electrovib.apps.exit_codes import MISFIT
from electrovib.core.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Collection, Sequence

    from electrovib.recordings.calibration import CalibrationError
    from electrovib.recordings.fit.sessions import SeparateFits
    from electrovib.recordings.interval import EstimatedParameter
    from electrovib.view.fitted import FitResult


_OF_EACH: Final = "files free noise offsets gain_error zero_error signals keep separately set output all"
_OF_ALL: Final = "varying sessions compare_with posterior seed steps"
_OF_MATERIAL: Final = "files noise gain_error form reference loss band layer columns recipe set output"
_OF_LAW: Final = "files columns recipe set output"


@takes(
    """
files... [SCENARIO] FILE...  A scenario, and Trace files from which its parameters are estimated; or spectra of impedance or
    permittivity of one material; or tables of measured points of a power law.
--free PATH,PATH,...       Parameters to estimate, as dotted paths; repeatable.
--vary PATH,... -> varying  Those of them that differ between sessions; repeatable.
--session FILE=NAME -> sessions  Session of a recording; by default each is its own; repeatable.
--noise SIGNAL=VALUE       Standard deviation of a signal, with its unit; of an impedance relative to it: impedance=0.01; of a
    spectrum that of the rows of a file: z.csv='1 %', of all files or of none; repeatable.
--zero SIGNAL,... -> offsets  Signal whose zero is unknown and is fitted; repeatable.
--gain-error SIGNAL=SHARE  Relative standard uncertainty of the gain of a sensor, such as electrostatic_force='2 %'; of the
    modulus of a spectrum, common to all rows: impedance='1 %'; repeatable.
--zero-error SIGNAL=VALUE  Standard uncertainty of the zero of a sensor, with its unit; repeatable.
--quantity SIGNAL,... -> signals  Fit only this signal; repeatable.
--keep PART,...            Take the drive, load or motion of the scenario although the recordings hold their own; repeatable.
--compare-with SCENARIO    Another model of the same experiment, compared by AICc and BIC; repeatable.
--separately               Fit each recording alone; one table and one figure for all, with the scatter within and between
    recordings.
--posterior                Sample the posterior distribution too, with emcee; needs --seed.
--seed N                   Seed of the random numbers of --posterior, and of --models, there 0 by default.
-n N -> steps              Length of each chain of --posterior. [default: 2000]
--form FORM                Of a material: auto (by AICc), constant, constant-phase, debye, cole-cole, cole-cole-2,
    havriliak-negami, prony-4, gabriel ... [default: auto]
--reference FILE=VALUE     Spectrum of a known resistor, r.csv='51 kohm +- 1 %': gives systematic error and fixture; a bad one is
    refused.
--loss measured|none|unknown  Of a table of permittivity without loss: a material without any, or the permittivity alone is
    fitted. [default: measured]
--band LOW..HIGH           Frequencies of a spectrum to fit: '100 Hz..100 kHz'.
--layer
--column
--recipe
--set PATH=VALUE           Change a parameter of the scenario; of a spectrum or a table an entry of the recipe of an import:
    area='1 cm2', thickness='200 um', series_resistance='1 kohm', parallel_capacitance='2 pF' of the fixture, part, reader,
    delimiter, decimal_comma; repeatable.
-o, --output PLACE         Folder for report.html, all figures, parameters.csv, correlations.csv, parameters.toml, space.toml and
    fit.txt, a text to paste; or one of them: .txt, .html, a figure (.pdf, .svg, .png), .csv, .tex. Of a material, or
    the scenario with it in --layer, .toml too; of a power law its table as .csv.
--style
--all
--models A,B,...|FILE.py -> laws  Force laws, or all: which of them made the recordings, each with and without the gap and the
    leaks of the scenario, by their evidence. Or a Python file with models of your own; repeatable.
--force
""",
    example="electrovib fit my.toml a.nc b.nc --free friction.coefficient --noise 'lateral_force=5 mN' -o fit",
)
def fit(given: Arguments) -> None:
    """Estimate parameters of a scenario from recordings.

    Report each with its interval, what the data do not determine, and whether the model describes them; where it does not,
    the exit code is 3. Without --free, fit a dispersion to the spectra of a material, with its statistical interval and
    systematic error; with the columns x and y, a power law such as that of force over voltage, with the scatter of its
    exponent between sessions.
    """
    files, laws = given["files"], given.read_laws()
    if laws is not None and ("free" not in given or "separately" in given):
        raise InputError("laws are weighed by a joint fit of a scenario, with --free", path="--models")
    scenario = files[0] if "free" in given or _is_scenario(files[0]) else None
    recorded = files if scenario is None else files[1:]
    columns = {text.partition("=")[0].strip() for text in given.get("columns", [])}
    if set_too := next((each for each in given.get("free", []) if "=" in each), ""):
        path, _, value = set_too.partition("=")
        begin = f"--set {path}={value.partition(':')[0]}"
        raise InputError(f"--free {set_too}: 'fit' takes the path alone, --free {path}; it begins at {begin}")
    if "free" in given:
        _fit_scenario(files[0], recorded, given, laws)
    elif scenario is None and columns & {"x", "y"}:  # which no spectrum has
        given.only(_OF_LAW, "the fit of a power law")
        entries = recipe_of(given, only=READING, of="the fit of a power law")
        _fit_power_law(files, entries, given.get("output"), force="force" in given)
    elif scenario is None or "layer" in given:
        given.only(_OF_MATERIAL, "the fit of a material; name --free to estimate parameters of a scenario")
        _fit_material(scenario, recorded, given)
    else:
        raise InputError(
            "not given; for instance --free friction.coefficient, or --layer NAME to put a material into the scenario",
            path="--free",
        )


def _is_scenario(first: str) -> bool:
    """Tell whether the first argument is a scenario, and no file of what was measured."""
    from electrovib.core.files import kind_of

    return first.lower().endswith(".toml") or not (Path(first).suffix or kind_of(first) == "file")


def _fit_scenario(scenario: str, recorded: list[str], given: Arguments, laws: list[str] | None) -> None:
    """Fit all recordings together, or each alone."""
    from electrovib.apps.changes import read_changes
    from electrovib.recordings.fit.measured import PRESCRIBING, PROPORTIONAL

    if "separately" in given:
        given.only(_OF_EACH, "--separately, but to a joint fit")
    else:
        given.only(f"{_OF_EACH} {_OF_ALL}", "the fit of a scenario")
    wanted = given.take("free signals keep offsets output force")
    wanted |= {} if laws is None else {"laws": laws, "seed": given.get("seed", 0)}
    noises = given.get("noise", [])
    wanted["noise"] = dict(_of_signal(text, "--noise", relative=PROPORTIONAL) for text in noises)
    wanted["calibration"] = calibrations_of(given.get("gain_error", []), given.get("zero_error", []))
    stated = read_changes(given.get("set", []))
    of_recordings = PRESCRIBING.values()  # what a recording may contradict
    wanted["stated"] = {path: value for path, value in stated.items() if path.split(".")[0] in of_recordings}
    given["scenario"] = scenario
    given.put_changes()
    (_fit_separately if "separately" in given else _fit_jointly)(given, recorded, wanted)


def _fit_jointly(given: Arguments, recorded: list[str], wanted: dict[str, Any]) -> None:
    """Fit all recordings together, and print the verdict."""
    from electrovib.apps.fit import fit
    from electrovib.apps.progress import tracked
    from electrovib.recordings.fit.of_scenario import Sampling

    wanted |= given.take("varying compare_with")
    wanted["sessions"] = dict(pair_of(text, "--session", "FILE=NAME") for text in given.get("sessions", []))
    with tracked("fitting") as progress:
        if "posterior" in given:
            if "seed" not in given:
                raise InputError("--posterior: state --seed, so that the samples can be repeated")
            wanted["posterior"] = Sampling(**given.take("seed steps"), progress=progress)
        found = fit(given["scenario"], recorded, **wanted)
    lines = summary(found) if "all" in given else brief(verdict(found))
    _end([*lines, *warned(found)], wanted.get("output"), misfit=bool(found.best.misfit.reasons))


def _fit_separately(given: Arguments, recorded: list[str], wanted: dict[str, Any]) -> None:
    """Fit each recording alone, and print the table."""
    from electrovib.apps.fit import fit_separately
    from electrovib.apps.progress import tracked

    with tracked("fitting") as progress:
        found = fit_separately(given["scenario"], recorded, progress=progress, **wanted)
    lines = separate_summary(found) if "all" in given else brief(separate_verdict(found))
    _end([*lines, *warned(found)], wanted.get("output"), misfit=bool(found.misfits))


def _fit_material(scenario: str | None, files: list[str], given: Arguments) -> None:
    """Fit a dispersion to spectra, and write the material, or the scenario with it."""
    from electrovib.apps.fit_material import fit_material

    wanted = given.take("form loss layer output force")
    wanted |= recipe_of(given, only=OF_SAMPLE, of="the fit of a material")
    noises = dict(pair_of(text, "--noise", "FILE=SHARE") for text in given.get("noise", []))
    gains = dict(pair_of(text, "--gain-error", "impedance=SHARE") for text in given.get("gain_error", []))
    if gains and set(gains) != {"impedance"}:
        raise InputError("of a spectrum: expected impedance=SHARE, once", path="--gain-error")
    wanted["noise"] = {name: share_of(value, "--noise") for name, value in noises.items()}
    if gains:
        wanted["systematic"] = share_of(gains["impedance"], "--gain-error")
    if "reference" in given:
        wanted["reference"] = pair_of(given["reference"], "--reference", "FILE=VALUE")
    if "band" in given:
        low, dots, high = (part.strip() for part in given["band"].partition(".."))
        if not dots:
            raise InputError(f"--band {given['band']}: expected LOW..HIGH, such as '100 Hz..100 kHz'")
        wanted["band"] = low, high
    show_answer(fit_material(files, into=scenario, **wanted))
    _end([], wanted.get("output"), misfit=False)


def _fit_power_law(files: Sequence[str], entries: dict[str, Any], output: str | None, *, force: bool) -> None:
    """Fit a power law to tables of points, and write its sessions as a table."""
    from electrovib.recordings.fit.power_law import PowerLawFit, fit_power_law, read_points
    from electrovib.view.files import check_answer, save_answer

    columns = entries.pop("columns")
    if not {"x", "y"} <= columns.keys() <= {"x", "y", "session"}:
        raise InputError(
            "a power law takes x=COLUMN and y=COLUMN, and may take session=COLUMN", path="--column"
        )
    inputs = [Path(each) for each in files]
    if output is not None:
        check_answer(PowerLawFit, output, inputs=inputs, force=force)
    along, values, sessions = read_points(files, **{"session": ""} | columns, **entries)
    law = fit_power_law(along, values, session=sessions)
    if output is not None:
        save_answer(law, output, force=force)
    show_answer(law)
    _end([], output, misfit=False)


def _end(lines: Sequence[str], output: str | None, *, misfit: bool) -> None:
    """Print the result, and end with a code of its own where the model does not describe the data."""
    say(*lines)
    if output:
        say(f"written: {output}")
    if misfit:
        raise typer.Exit(MISFIT)


def share_of(text: str, option: str) -> float:
    """Read a relative standard deviation, such as ``1 %`` or ``0.01``."""
    from electrovib.core.units import parse_quantity

    try:
        return parse_quantity(text, "1")
    except ValueError:
        raise InputError(f"{option} {text}: expected a share such as '1 %' or 0.01") from None


def calibrations_of(gains: Sequence[str], zeros: Sequence[str]) -> dict[str, CalibrationError]:
    """Read the calibration errors of signals: shares of the gain, and zeros in the unit of each signal."""
    from electrovib.core.signals import SIGNALS
    from electrovib.recordings.calibration import CalibrationError

    found = dict(_of_signal(text, "--gain-error", relative=SIGNALS) for text in gains)
    at_zero = dict(_of_signal(text, "--zero-error") for text in zeros)
    for name, error in (*found.items(), *at_zero.items()):
        if not 0 <= error < float("inf"):
            raise InputError(
                f"error of {name} = {error:g}: expected a finite standard uncertainty of 0 or more"
            )
    names = dict.fromkeys([*found, *at_zero])
    return {name: CalibrationError(gain=found.get(name, 0.0), zero=at_zero.get(name, 0.0)) for name in names}


def _of_signal(text: str, option: str, *, relative: Collection[str] = ()) -> tuple[str, float]:
    """Read ``SIGNAL=VALUE`` in the unit of the signal, or as a share of it."""
    from electrovib.core.errors import nearest
    from electrovib.core.signals import SIGNALS
    from electrovib.core.units import parse_quantity

    name, value = pair_of(text, option, f"SIGNAL={'SHARE' if relative is SIGNALS else 'VALUE'}")
    if name not in SIGNALS:
        raise InputError(f"{option} {text}: no signal has this name.{nearest(name, SIGNALS)}")
    if name in relative:
        return name, share_of(value, option)
    try:
        return name, parse_quantity(value, SIGNALS[name].unit)
    except ValueError as error:
        raise InputError(f"{option} {text}: {error}") from None


_MOST: Final = 5  # lines of a verdict


def posterior_lines(found: FitResult) -> list[str]:
    """Report the posterior distribution of each parameter, and the diagnostics of its chains."""
    from electrovib.core.units import format_quantity

    if found.posterior is None:
        return []
    units = {row.name: (row.unit, row.digits) for row in found.rows}
    lines, steps = [], found.posterior.steps
    for name, time in found.posterior.autocorrelation_time.items():
        unit, digits = units[name]
        lower, upper = (format_quantity(each, unit, digits=digits) for each in found.posterior.interval(name))
        lines.append(
            f"{name}: posterior 95 % interval {lower} to {upper}; autocorrelation time {time:.3g} of {steps} steps"
        )
    return lines + [
        f"warning: the samples may not represent the posterior: {each}" for each in found.posterior.problems
    ]


def brief(lines: Sequence[str]) -> list[str]:
    """Return five lines at most, of which the last one states what is omitted."""
    if len(lines) <= _MOST:
        return list(lines)
    return [*lines[: _MOST - 1], f"and {len(lines) - _MOST + 1} more lines: --all prints them"]


def separate_verdict(found: SeparateFits) -> list[str]:
    """State which recordings the model does not describe or that could not be fitted, and the means over all."""
    lines = [f"{record}: failed: {why}" for record, why in found.failures.items()]
    lines = [f"warning: {record}: {why}" for record, why in found.misfits.items()] + lines
    if len(lines) > 2:
        counted = f"{len(found.misfits)} of {len(found.fits)} recordings, and {len(found.failures)} could not be fitted"
        lines = [lines[0], f"warning: the model does not describe {counted}: --all names them"]
    return lines + _mean_lines(found) if found.means else separate_summary(found)


def separate_summary(found: SeparateFits) -> list[str]:
    """Report the estimates of each recording with their intervals, and their mean and scatter over the recordings."""
    lines = []
    for each in found.fits:
        if each.found is None:
            lines.append(f"{each.record}: failed: {each.problem}")
            continue
        fitted = [line for row in each.rows for line in row_lines(row)]
        lines += [f"{each.record}:", *(f"  {line}" for line in (*each.found.prescribed, *fitted))]
        if not each.found.estimate.converged:
            lines.append("  warning: the search ended without having converged")
        if each.record in found.misfits:
            lines.append(f"  warning: {found.misfits[each.record]}")
    return lines + _mean_lines(found)


def _mean_lines(found: SeparateFits) -> list[str]:
    """Report the mean of each parameter over the recordings, and its scatter."""
    lines = []
    for row in found.means:
        first, *notes = row_lines(row)
        counted = len(found.spreads[row.name].values)
        lines += [first.replace(row.name, f"{row.name}, mean of {counted} recordings", 1), *notes]
    return lines


def row_lines(row: EstimatedParameter) -> list[str]:
    """Write one estimate with its interval, or why it has none."""
    from electrovib.core.units import format_quantity

    line = f"{row.name}: {row.in_words(row.unit, why=row.note)}"
    if not row.method:
        return [line]
    if math.isfinite(row.systematic):
        ends = (format_quantity(end, row.unit, digits=row.digits) for end in row.systematic_ends)
        line += f", by calibration {' to '.join(ends)}"
    return [line, f"  {row.note}"] if row.note else [line]


def verdict(found: FitResult) -> list[str]:
    """State whether the model describes the data, which one they support, and each estimate with its interval."""
    lines = _compared(found) + _warnings(found)
    means = [row for row in found.rows if row.method == "sessions"]
    lines += [line for row in means for line in row_lines(row)]
    lines += posterior_lines(found)
    for row in found.rows:
        if row not in means:  # a note that two estimates share is stated once
            lines += [line for line in row_lines(row) if line not in lines]
    return lines


def _compared(found: FitResult, *, each: bool = False) -> list[str]:
    """State which model the data support, and of `each` that was weighed its probability and what speaks against it."""
    from electrovib.view.fitted import per_cent

    if found.comparison is None:
        return []
    lines = [found.comparison.sentence] if found.comparison.sentence else []
    if each and found.comparison.is_weighed:
        lines += [
            f"  {one.name}: {per_cent(one.probability)}{f'; {one.against}' if one.against else ''}"
            for one in found.comparison.candidates
        ]
        lines += [f"  {name}: not fitted: {why}" for name, why in found.comparison.refused.items()]
    return lines


def _warnings(found: FitResult) -> list[str]:
    lines = [f"warning: {found.best.misfit.sentence}"] if found.best.misfit.sentence else []
    lines += ["; ".join(found.best.prescribed)] if found.best.prescribed else []
    if not found.best.estimate.converged:
        lines.append("warning: the search ended without having converged")
    return lines


def summary(found: FitResult) -> list[str]:
    """Report each estimate with its interval, what is not determined, and which model the data support."""
    lines = _compared(found, each=True) + _warnings(found)
    lines += [line for row in found.rows for line in row_lines(row)]
    lines += [
        f"{each.recording}, {each.observed.signal}: {each.observed.x.size} samples, residual"
        f" {_spread(each.root_mean_square, each.observed.signal, relative=each.observed.relative)} rms"
        for each in found.best.residuals
    ]
    return lines + posterior_lines(found)


def _spread(value: float, signal: str, *, relative: bool) -> str:
    from electrovib.core.signals import SIGNALS
    from electrovib.core.units import format_quantity

    return f"{100 * value:.3g} %" if relative else format_quantity(value, SIGNALS[signal].unit, digits=3)
