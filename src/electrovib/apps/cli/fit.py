"""``electrovib fit``, ``fit-laws``, ``fit-separately``, ``fit-material`` and ``fit-power-law``."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import typer

from electrovib.apps.cli.import_ import OF_SAMPLE, READING, recipe_of
from electrovib.apps.cli.options import Arguments, pair_of, takes
from electrovib.apps.cli.terminal import answered, say, show_answer
from electrovib.apps.exit_codes import MISFIT
from electrovib.core.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping, Sequence

    from electrovib.apps.recorded import Recordings
    from electrovib.core.answer import Answer


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
    _end(found, given, misfit=bool(found.best.misfit.reasons))


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
    _end(found, given, misfit=bool(found.best.misfit.reasons))


@takes(_RECORDED)
def fit_separately(given: Arguments) -> None:
    """Estimate parameters from each recording alone.

    Make one table and one figure for all, with the scatter within and between recordings.
    """
    from electrovib.apps.fit import fit_separately
    from electrovib.apps.progress import tracked

    with tracked("fitting") as progress:
        found = fit_separately(**_asked(given, progress))
    _end(found, given, misfit=bool(found.misfits))


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
    _end(fit_material(given["files"], SpectrumRecipe(**entries), errors=errors, **wanted), wanted)


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

    entries = recipe_of(given, only=READING, of="the fit of a power law")
    entries.pop("columns", None)

    def fitted(files: list[str], **columns: Any) -> PowerLawFit:
        along, values, sessions = read_points(files, **columns, **entries)
        return fit_power_law(along, values, session=sessions)

    answered(PowerLawFit, fitted, "fitting", given.take("files x y session output force"))


def _end(found: Answer, given: Mapping[str, Any], *, misfit: bool = False) -> None:
    """Print the result, and end with a code of its own where the model does not describe the data."""
    show_answer(found, everything="all" in given)
    if "output" in given:
        say(f"written: {given['output']}")
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
