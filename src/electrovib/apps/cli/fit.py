"""``electrovib fit``, ``fit-laws``, ``fit-separately``, ``fit-material`` and ``fit-power-law``."""

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

    from electrovib.apps.recorded import Recordings
    from electrovib.recordings.fit.sessions import SeparateFits
    from electrovib.recordings.interval import EstimatedParameter
    from electrovib.view.fitted import FitResult


_RECORDED: Final = """
scenario
recordings...              Trace files from which parameters are estimated.
--free PATH,PATH,...       Parameters to estimate, as dotted paths; repeatable.
--quantity SIGNAL,...      Fit only this signal; repeatable.
--noise SIGNAL=VALUE       Standard deviation of a signal, with its unit; of an impedance relative to it: impedance=0.01;
    repeatable.
--zero SIGNAL,...          Signal whose zero is unknown and is fitted; repeatable.
--gain-error SIGNAL=SHARE  Relative standard uncertainty of the gain of a sensor, such as electrostatic_force='2 %'; repeatable.
--zero-error SIGNAL=VALUE  Standard uncertainty of the zero of a sensor, with its unit; repeatable.
--keep PART,...            Take the drive, load or motion of the scenario although the recordings hold their own; repeatable.
--set
--models
-o, --output PLACE         Folder for report.html, all figures, tables as .csv, and space.toml; or one of them: .html, a figure
    (.pdf, .svg, .png), .csv, .tex; of a joint fit .txt too, a text to paste.
--style
--all
--force
"""
_JOINT: Final = """
--varying PATH,...         Free parameters that differ between sessions; repeatable.
--session FILE=NAME        Session of a recording; by default each is its own; repeatable.
--compare-with SCENARIO    Another model of the same experiment, by AICc and BIC, among laws by evidence; repeatable.
"""


@takes(
    f"""{_RECORDED.strip()}
{_JOINT.strip()}
--posterior                Sample the posterior distribution too, with emcee; needs --seed.
--seed N                   Seed of the random numbers of --posterior.
-n N -> steps              Length of each chain of --posterior. [default: 2000]
""",
    example="electrovib fit my.toml a.nc b.nc --free friction.coefficient --noise 'lateral_force=5 mN' -o fit",
)
def fit(given: Arguments) -> None:
    """Estimate parameters of a scenario from recordings.

    Report each with its interval, what the data do not determine, and whether the model describes them; where it does not,
    the exit code is 3.
    """
    from electrovib.apps.fit import fit
    from electrovib.apps.progress import tracked
    from electrovib.recordings.fit.of_scenario import Sampling

    sampling = given.take("seed steps")
    if "posterior" in given and "seed" not in sampling:
        raise InputError("--posterior: state --seed, so that the samples can be repeated")
    if "seed" in sampling and "posterior" not in given:
        raise InputError("--seed: is that of --posterior, which is not given")
    with tracked("fitting") as progress:
        posterior = Sampling(**sampling, progress=progress) if given.pop("posterior", False) else None
        found = fit(**_asked(given, progress), posterior=posterior)
    _report(found, given)


@takes(
    f"""{_RECORDED.strip()}
{_JOINT.strip()}
--laws A,B,...             Force laws, all by default, each with and without the gap and the leaks of the scenario; repeatable.
--seed N                   Seed of the random numbers of nested sampling. [default: 0]
""",
    example="electrovib fit-laws my.toml a.nc --free contact.area --quantity electrostatic_force -o laws",
)
def fit_laws(given: Arguments) -> None:
    """Weigh which force law made recordings.

    Report how probable each law is by its evidence, what speaks against it, and the parameters of the scenario.
    """
    from electrovib.apps.fit import fit_laws
    from electrovib.apps.progress import tracked

    of_laws = given.take("laws seed")
    with tracked("fitting") as progress:
        found = fit_laws(**_asked(given, progress), **of_laws)
    _report(found, given)


@takes(_RECORDED)
def fit_separately(given: Arguments) -> None:
    """Estimate parameters from each recording alone.

    Make one table and one figure for all, with the scatter within and between recordings.
    """
    from electrovib.apps.fit import fit_separately
    from electrovib.apps.progress import tracked

    with tracked("fitting") as progress:
        found = fit_separately(**_asked(given, progress))
    lines = separate_summary(found) if "all" in given else brief(separate_verdict(found))
    _end([*lines, *warned(found)], given.get("output"), misfit=bool(found.misfits))


def _asked(given: Arguments, progress: object) -> dict[str, Any]:
    """Return what the fits of a scenario have in common: the scenario with its changes, and the recordings."""
    for text in given.get("free", []):
        path, sign, value = text.partition("=")
        if sign:
            begin = f"--set {path}={value.partition(':')[0]}"
            raise InputError(
                f"--free {text}: a fit takes the path alone, --free {path}; it begins at {begin}"
            )
    if "free" not in given:
        raise InputError("not given; for instance --free friction.coefficient", path="--free")
    known = _recordings(given)
    given.put_changes()
    return given.take("scenario free varying compare_with") | {
        "recordings": known, "output": given.get("output"), "force": "force" in given,
        "progress": progress,
    }  # fmt: skip


def _recordings(given: Arguments) -> Recordings:
    """Read what is known of the recordings."""
    from electrovib.apps.changes import read_changes
    from electrovib.apps.recorded import Recordings
    from electrovib.core.signals import SIGNALS
    from electrovib.recordings.fit.measured import PRESCRIBING, PROPORTIONAL

    stated = read_changes(given.get("set", []))
    of_recordings = PRESCRIBING.values()  # what a recording may contradict
    return Recordings(
        traces=given.pop("recordings"),
        noise=_of_signals(given.pop("noise", []), "--noise", relative=PROPORTIONAL),
        gain_error=_of_signals(given.pop("gain_error", []), "--gain-error", relative=SIGNALS),
        zero_error=_of_signals(given.pop("zero_error", []), "--zero-error"),
        session=dict(pair_of(text, "--session", "FILE=NAME") for text in given.pop("session", [])),
        settings={path: value for path, value in stated.items() if path.split(".")[0] in of_recordings},
        **given.take("quantity zero keep"),
    )


@takes(
    """
files...                   Spectra of impedance or permittivity of one material.
--form FORM                auto (by AICc), constant, constant-phase, debye, cole-cole, cole-cole-2, havriliak-negami, prony-4,
    gabriel ... [default: auto]
--band LOW..HIGH           Frequencies to fit: '100 Hz..100 kHz'.
--scatter FILE=SHARE       Relative standard deviation of the rows of a file, z.csv='1 %', of all files or of none; repeatable.
--systematic SHARE         Relative standard uncertainty of the modulus, common to all rows, '1 %'.
--reference FILE=VALUE     Spectrum of a known resistor, r.csv='51 kohm +- 1 %': gives systematic error and fixture; a bad one is
    refused.
--loss measured|none|unknown  Of permittivity without loss: a material without any, or the permittivity alone is fitted.
    [default: measured]
--column
--recipe
--set KEY=VALUE            Entry of the recipe: area='1 cm2', thickness='200 um', series_resistance='1 kohm',
    parallel_capacitance='2 pF' of the fixture, part, reader, delimiter, decimal_comma; repeatable.
--into SCENARIO            Scenario into which the material is put, as which it is written.
--layer
-o, --output PLACE         The material, or the scenario with it, as .toml; a page (.html), a figure, or a folder with all.
--style
--force
""",
    example="electrovib fit-material z.csv --set area='1 cm2' --set thickness='200 um' -o my_skin.toml",
)
def fit_material(given: Arguments) -> None:
    """Fit a dispersion to the spectra of a material.

    Report each parameter with its statistical interval and its systematic error.
    """
    from electrovib.apps.fit_material import SpectrumErrors, SpectrumRecipe, fit_material

    entries = recipe_of(given, only=OF_SAMPLE, of="the fit of a material")
    wanted = given.take("form loss into layer output force")
    scatter = dict(pair_of(text, "--scatter", "FILE=SHARE") for text in given.get("scatter", []))
    known: dict[str, Any] = {
        "scatter": {name: share_of(value, "--scatter") for name, value in scatter.items()},
        "systematic": given.get("systematic"),
    }
    if "reference" in given:
        known["reference"] = pair_of(given["reference"], "--reference", "FILE=VALUE")
    if "band" in given:
        low, dots, high = (part.strip() for part in given["band"].partition(".."))
        if not dots:
            raise InputError(f"--band {given['band']}: expected LOW..HIGH, such as '100 Hz..100 kHz'")
        wanted["band"] = low, high
    errors = SpectrumErrors(**known)
    show_answer(fit_material(given["files"], SpectrumRecipe(**entries), errors=errors, **wanted))
    _end([], given.get("output") or wanted.get("output"), misfit=False)


@takes(
    """
files...                   Tables of measured points.
--x COLUMN                 Column of the voltage, or what else y is a power of, with a unit where the file states none. [required]
--y COLUMN                 Column of the force, or of another quantity, likewise. [required]
--session-column COLUMN -> session  Column with the number of the session of each point; by default each file is one.
--recipe
--set KEY=VALUE            Entry of the recipe: part, reader, delimiter, decimal_comma; repeatable.
-o, --output PLACE         A table (.csv), a page (.html), a figure, or a folder with all.
--style
--force
""",
    example="electrovib fit-power-law monday.csv tuesday.csv --x 'voltage (V)' --y 'force (mN)' -o law.csv",
)
def fit_power_law(given: Arguments) -> None:
    """Fit a power law, such as that of force over voltage.

    Report the exponent with its interval, and its scatter between sessions.
    """
    from electrovib.recordings.fit.power_law import PowerLawFit, fit_power_law, read_points
    from electrovib.view.files import check_answer, save_answer

    entries = recipe_of(given, only=READING, of="the fit of a power law")
    entries.pop("columns", None)
    files, output, force = given["files"], given.get("output"), "force" in given
    if output is not None:
        check_answer(PowerLawFit, output, inputs=[Path(each) for each in files], force=force)
    along, values, sessions = read_points(files, **given.take("x y session"), **entries)
    law = fit_power_law(along, values, session=sessions)
    if output is not None:
        save_answer(law, output, force=force)
    show_answer(law)
    _end([], output, misfit=False)


def _report(found: FitResult, given: Arguments) -> None:
    """Print the verdict of a joint fit."""
    lines = summary(found) if "all" in given else brief(verdict(found))
    _end([*lines, *warned(found)], given.get("output"), misfit=bool(found.best.misfit.reasons))


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


def _of_signals(texts: Sequence[str], option: str, *, relative: Collection[str] = ()) -> dict[str, float]:
    """Read each ``SIGNAL=VALUE`` in the unit of the signal, or as a share of it."""
    from electrovib.core.errors import nearest
    from electrovib.core.signals import SIGNALS
    from electrovib.core.units import parse_quantity

    found: dict[str, float] = {}
    for text in texts:
        name, value = pair_of(text, option, f"SIGNAL={'SHARE' if relative is SIGNALS else 'VALUE'}")
        if name not in SIGNALS:
            raise InputError(f"{option} {text}: no signal has this name.{nearest(name, SIGNALS)}")
        try:
            found[name] = (
                share_of(value, option) if name in relative else parse_quantity(value, SIGNALS[name].unit)
            )
        except ValueError as error:
            raise InputError(f"{option} {text}: {error}") from None
        if option != "--noise" and not 0 <= found[name] < math.inf:
            raise InputError(
                f"error of {name} = {found[name]:g}: expected a finite standard uncertainty of 0 or more"
            )
    return found


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
