"""``electrovib fit``: the parameters of a scenario, a material or a power law, by what it is given."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final, TypeAlias

import typer

from electrovib.apps.cli import options
from electrovib.apps.cli.fit_words import (
    brief,
    law_summary,
    material_summary,
    separate_summary,
    separate_verdict,
    summary,
    verdict,
)
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
    scenario_names,
)
from electrovib.apps.cli.recipe import OF_SAMPLE, READING, recipe_of
from electrovib.apps.cli.terminal import say, warned
from electrovib.apps.exit_codes import MISFIT
from electrovib.core.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Sequence

    from electrovib.recordings.calibration import CalibrationError
    from electrovib.recordings.fit.of_scenario import Sampling
    from electrovib.scenario import Source


EXAMPLE: Final = (
    "electrovib fit my.toml a.nc b.nc --free friction.coefficient --noise 'lateral_force=5 mN' -o fit"
)

_OF_EACH: Final = (
    "files free noise zero gain_error zero_error quantity keep separately changes folder everything"
)
_OF_ALL: Final = "vary session compare_with posterior seed steps"
_OF_MATERIAL: Final = "files noise gain_error form reference loss band layer column recipe changes folder"
_OF_LAW: Final = "files column recipe changes folder"

Files: TypeAlias = Annotated[
    list[str],
    typer.Argument(
        metavar="[SCENARIO] FILE...",
        help="A scenario, and Trace files from which its parameters are estimated; or spectra of impedance or permittivity"
        " of one material; or tables of measured points of a power law.",
        autocompletion=scenario_names,
    ),
]
Free: TypeAlias = Annotated[Texts, many("PATH,PATH,...", "Parameters to estimate, as dotted paths")]
Vary: TypeAlias = Annotated[Texts, many("PATH,...", "Those of them that differ between sessions")]
Session: TypeAlias = Annotated[
    Texts,
    many(
        "FILE=NAME",
        "Session of a recording; by default each is its own",
    ),
]
Noise: TypeAlias = Annotated[
    Texts,
    many(
        "SIGNAL=VALUE",
        "Standard deviation of a signal, with its unit; of an impedance relative to it: impedance=0.01; of a spectrum"
        " that of the rows of a file: z.csv='1 %', of all files or of none",
    ),
]
Zero: TypeAlias = Annotated[Texts, many("SIGNAL", "Signal whose zero is unknown and is fitted")]
GainError: TypeAlias = Annotated[
    Texts,
    many(
        "SIGNAL=SHARE",
        "Relative standard uncertainty of the gain of a sensor, such as electrostatic_force='2 %'; of the modulus of a"
        " spectrum, common to all rows: impedance='1 %'",
    ),
]
ZeroError: TypeAlias = Annotated[
    Texts, many("SIGNAL=VALUE", "Standard uncertainty of the zero of a sensor, with its unit")
]
Quantity: TypeAlias = Annotated[Texts, many("SIGNAL", "Fit only this signal")]
Keep: TypeAlias = Annotated[
    Texts,
    many("PART", "Take the drive, load or motion of the scenario although the recordings hold their own"),
]
CompareWith: TypeAlias = Annotated[
    Texts, many("SCENARIO", "Another model of the same experiment, compared by AICc and BIC")
]
Separately: TypeAlias = Annotated[
    bool,
    typer.Option(
        "--separately",
        help="Fit each recording alone; one table and one figure for all, with the scatter within and between recordings.",
    ),
]
Posterior: TypeAlias = Annotated[
    bool,
    typer.Option("--posterior", help="Sample the posterior distribution too, with emcee; needs --seed."),
]
Seed: TypeAlias = Annotated[int | None, option("Seed of the random numbers of --posterior.")]
Steps: TypeAlias = Annotated[int, typer.Option("-n", help="Length of each chain of --posterior.")]
FormAsked: TypeAlias = Annotated[
    str,
    typer.Option(
        help="Of a material: auto (by AICc), constant, constant-phase, debye, cole-cole, cole-cole-2, havriliak-negami,"
        " prony-4, gabriel ..."
    ),
]
Reference: TypeAlias = Annotated[
    Text,
    option(
        "Spectrum of a known resistor, r.csv='51 kohm +- 1 %': gives systematic error and fixture; a bad one is refused.",
        metavar="FILE=VALUE",
    ),
]
Loss: TypeAlias = Annotated[
    str,
    typer.Option(
        metavar="measured|none|unknown",
        help="Of a table of permittivity without loss: a material without any, or the permittivity alone is fitted.",
    ),
]
Band: TypeAlias = Annotated[Text, option("Frequencies of a spectrum to fit: '100 Hz..100 kHz'.")]
Changes: TypeAlias = Annotated[
    Texts,
    many(
        "PATH=VALUE",
        "Change a parameter of the scenario; of a spectrum or a table an entry of the recipe of an import: area='1 cm2',"
        " thickness='200 um', series_resistance='1 kohm', parallel_capacitance='2 pF' of the fixture, part, reader,"
        " delimiter, decimal_comma",
        "--set",
    ),
]
Folder: TypeAlias = Annotated[
    Text,
    output(
        "Folder for report.html, parameters.csv, parameters.toml and space.toml; or the material, or the scenario with it"
        " in --layer, as .toml; or the table of a power law as .csv."
    ),
]


def command(
    context: typer.Context,
    files: Files,
    free: Free = None,
    vary: Vary = None,
    session: Session = None,
    noise: Noise = None,
    zero: Zero = None,
    gain_error: GainError = None,
    zero_error: ZeroError = None,
    quantity: Quantity = None,
    keep: Keep = None,
    compare_with: CompareWith = None,
    separately: Separately = False,
    posterior: Posterior = False,
    seed: Seed = None,
    steps: Steps = 2000,
    form: FormAsked = "auto",
    reference: Reference = None,
    loss: Loss = "measured",
    band: Band = None,
    layer: options.Layer = "",
    column: options.Column = None,
    recipe: options.Recipe = None,
    changes: Changes = None,
    folder: Folder = None,
    everything: options.Everything = False,
    models: options.Models = None,
    force: options.Force = False,
) -> None:
    """Estimate parameters of a scenario from recordings.

    Report each with its interval, what the data do not determine, and whether the model describes them; where it does not,
    the exit code is 3. Without --free, fit a dispersion to the spectra of a material, with its statistical interval and
    systematic error; with the columns x and y, a power law such as that of force over voltage, with the scatter of its
    exponent between sessions.
    """
    base, recorded = (files[0], files[1:]) if free else _scenario_of(files)
    written: dict[str, Any] = {"output": folder, "force": force}
    if not free and base is None and _is_power_law(column):
        only(context, _OF_LAW, "the fit of a power law")
        entries = recipe_of(recipe, changes, column, only=READING, of="the fit of a power law")
        return _fit_power_law(files, entries, folder, force=force)
    if not free and (base is None or layer):
        only(context, _OF_MATERIAL, "the fit of a material; name --free to estimate parameters of a scenario")
        written |= recipe_of(recipe, changes, column, only=OF_SAMPLE, of="the fit of a material")
        written |= _errors_of_spectra(noise, gain_error, reference, band) | given(context, "form loss")
        return _fit_material(base, recorded, layer, written)
    if not free:
        raise InputError(
            "not given; for instance --free friction.coefficient, or --layer NAME to put a material into the scenario",
            path="--free",
        )
    only(
        context, _OF_EACH if separately else f"{_OF_EACH} {_OF_ALL}",
        "--separately, but to a joint fit" if separately else "the fit of a scenario",
    )  # fmt: skip
    written |= {"free": names_of(free), "signals": names_of(quantity) or None, "keep": names_of(keep)}
    written |= {"offsets": names_of(zero), "noise": noises_of(noise or []), "stated": _stated(changes)}
    written["calibration"] = calibrations_of(gain_error or [], zero_error or [])
    if separately:
        return _fit_separately(_base(base or "", changes), recorded, written, everything=everything)
    written |= {"varying": names_of(vary), "compare_with": compare_with or []}
    written["sessions"] = dict(pair_of(text, "--session", "FILE=NAME") for text in session or [])
    sampled = (seed, steps) if posterior else None
    return _fit_jointly(_base(base or "", changes), recorded, written, sampled, everything=everything)


def _scenario_of(files: Sequence[str]) -> tuple[str | None, list[str]]:
    """Split a scenario that stands first from the files of what was measured; None if there is none."""
    first = files[0]
    named = not Path(first).suffix and not Path(first).is_file()
    return (first, list(files[1:])) if first.lower().endswith(".toml") or named else (None, list(files))


def _is_power_law(column: Texts) -> bool:
    """Tell whether a column is that of x or y, which no spectrum has."""
    return any(text.partition("=")[0].strip() in {"x", "y"} for text in column or [])


def _base(scenario: str, changes: list[str] | None) -> Source:
    """Return the scenario with the changes of the command; its name where there are none."""
    from electrovib.apps.changes import read_changes
    from electrovib.scenario import read_scenario

    return read_scenario(scenario, changes=read_changes(changes)) if changes else scenario


def _stated(changes: list[str] | None) -> dict[str, Any]:
    """Return the changes of the command that a recording may contradict."""
    from electrovib.apps.changes import read_changes
    from electrovib.recordings.fit.measured import PRESCRIBING

    stated = read_changes(changes) if changes else {}
    return {path: value for path, value in stated.items() if path.split(".")[0] in PRESCRIBING.values()}


def _sampling(seed: int | None, steps: int, update: Callable[[int, int], None]) -> Sampling:
    """Read the options of the posterior distribution."""
    from electrovib.recordings.fit.of_scenario import Sampling

    if seed is None:
        raise InputError("--posterior: state --seed, so that the samples can be repeated")
    return Sampling(seed=seed, steps=steps, progress=update)


def _fit_jointly(
    base: Source,
    recordings: Sequence[str],
    shared: dict[str, Any],
    sampled: tuple[int | None, int] | None,
    *,
    everything: bool,
) -> None:
    """Fit all recordings together, and print the verdict."""
    from electrovib.apps.fit import fit
    from electrovib.apps.progress import tracked

    with tracked("fitting") as update:
        posterior = None if sampled is None else _sampling(*sampled, update)
        found = fit(base, recordings, posterior=posterior, **shared)
    lines = summary(found) if everything else brief(verdict(found))
    _end([*lines, *warned(found)], shared["output"], misfit=bool(found.best.misfit.reasons))


def _fit_separately(
    base: Source, recordings: Sequence[str], shared: dict[str, Any], *, everything: bool
) -> None:
    """Fit each recording alone, and print the table."""
    from electrovib.apps.fit_separately import fit_separately
    from electrovib.apps.progress import tracked

    with tracked("fitting") as update:
        found = fit_separately(base, recordings, progress=update, **shared)
    lines = separate_summary(found) if everything else brief(separate_verdict(found))
    _end([*lines, *warned(found)], shared["output"], misfit=bool(found.misfits))


def _fit_material(into: str | None, files: Sequence[str], layer: str, asked: dict[str, Any]) -> None:
    """Fit a dispersion to spectra, and write the material, or the scenario with it."""
    from electrovib.apps.fit_material import fit_material

    found = fit_material(files, into=into, layer=layer or "stratum_corneum", **asked)
    _end(material_summary(found), asked["output"], misfit=False)


def _errors_of_spectra(
    noise: Texts, gain_error: Texts, reference: str | None, band: str | None
) -> dict[str, Any]:
    """Read the noise of the rows of each file, the error common to all, and which rows are fitted."""
    noises = dict(pair_of(text, "--noise", "FILE=SHARE") for text in noise or [])
    gains = dict(pair_of(text, "--gain-error", "impedance=SHARE") for text in gain_error or [])
    if gains and set(gains) != {"impedance"}:
        raise InputError("of a spectrum: expected impedance=SHARE, once", path="--gain-error")
    return {
        "noise": {name: share_of(value, "--noise") for name, value in noises.items()},
        "systematic": share_of(gains["impedance"], "--gain-error") if gains else None,
        "reference": None if reference is None else pair_of(reference, "--reference", "FILE=VALUE"),
        "band": None if band is None else _band(band),
    }


def _band(text: str) -> tuple[str, str]:
    low, dots, high = (part.strip() for part in text.partition(".."))
    if not dots:
        raise InputError(f"--band {text}: expected LOW..HIGH, such as '100 Hz..100 kHz'")
    return low, high


def _fit_power_law(files: Sequence[str], entries: dict[str, Any], output: str | None, *, force: bool) -> None:
    """Fit a power law to tables of points, and write its sessions as a table."""
    from electrovib.data.atomic import check_writable, write_text
    from electrovib.data.marks import Form
    from electrovib.recordings.fit.power_law import fit_power_law, power_law_csv, read_points

    columns = entries.pop("columns")
    if not {"x", "y"} <= columns.keys() <= {"x", "y", "session"}:
        raise InputError(
            "a power law takes x=COLUMN and y=COLUMN, and may take session=COLUMN", path="--column"
        )
    target = None if output is None else Path(output)
    if target is not None:
        if target.suffix.lower() != ".csv":
            raise InputError(f"the table is written as .csv, not as '{target.suffix}'", path=target)
        check_writable({target: Form.TABLE}, inputs=[Path(each) for each in files], force=force)
    along, values, sessions = read_points(files, **{"session": ""} | columns, **entries)
    law = fit_power_law(along, values, session=sessions)
    if target is not None:
        write_text(target, power_law_csv(law), Form.TABLE, force=force)
    _end(law_summary(law), output, misfit=False)


def _end(lines: Sequence[str], output: str | None, *, misfit: bool) -> None:
    """Print the result, and end with a code of its own where the model does not describe the data."""
    say(*lines)
    if output:
        say(f"written: {output}")
    if misfit:
        raise typer.Exit(MISFIT)


def share_of(text: str, option: str) -> float:
    """Read a relative standard deviation, such as ``1 %`` or ``0.01``."""
    from electrovib.core.errors import InputError

    number, per_cent = text.strip().removesuffix("%").strip(), text.strip().endswith("%")
    if not _is_number(number):
        raise InputError(f"{option} {text}: expected a share such as '1 %' or 0.01")
    return float(number) / (100 if per_cent else 1)


def noises_of(texts: Sequence[str]) -> dict[str, float]:
    """Read the noise of signals, in the unit of each or relative to it."""
    from electrovib.recordings.fit.measured import PROPORTIONAL

    return dict(_of_signal(text, "--noise", relative=PROPORTIONAL) for text in texts)


def calibrations_of(gains: Sequence[str], zeros: Sequence[str]) -> dict[str, CalibrationError]:
    """Read the calibration errors of signals: shares of the gain, and zeros in the unit of each signal."""
    from electrovib.core.errors import InputError, nearest
    from electrovib.core.signals import SIGNALS
    from electrovib.recordings.calibration import CalibrationError

    found: dict[str, float] = {}
    for text in gains:
        name, value = pair_of(text, "--gain-error", "SIGNAL=SHARE")
        if name not in SIGNALS:
            raise InputError(f"--gain-error {text}: no signal has this name.{nearest(name, SIGNALS)}")
        found[name] = share_of(value, "--gain-error")
    at_zero = dict(_of_signal(text, "--zero-error") for text in zeros)
    for name, error in (*found.items(), *at_zero.items()):
        if not 0 <= error < float("inf"):
            raise InputError(
                f"error of {name} = {error:g}: expected a finite standard uncertainty of 0 or more"
            )
    names = dict.fromkeys([*found, *at_zero])
    return {name: CalibrationError(gain=found.get(name, 0.0), zero=at_zero.get(name, 0.0)) for name in names}


def _of_signal(text: str, option: str, *, relative: Collection[str] = ()) -> tuple[str, float]:
    """Read ``SIGNAL=VALUE`` in the unit of the signal; a number without unit is in SI."""
    from electrovib.core.errors import InputError, nearest
    from electrovib.core.signals import SIGNALS
    from electrovib.core.units import parse_quantity

    name, value = pair_of(text, option, "SIGNAL=VALUE")
    if name not in SIGNALS:
        raise InputError(f"{option} {text}: no signal has this name.{nearest(name, SIGNALS)}")
    unit = "1" if name in relative else SIGNALS[name].unit
    try:
        return name, float(value) if _is_number(value) else parse_quantity(value, unit)
    except ValueError as error:
        raise InputError(f"{option} {text}: {error}") from None


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
