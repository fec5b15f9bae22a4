"""``electrovib fit``, ``fit-laws`` and ``fit-separately``.

Parameters
----------
recordings
    Trace files from which parameters are estimated.
free : PATH,PATH,...
    Parameters to estimate, as dotted paths; repeatable.
quantity : SIGNAL,...
    Fit only this signal; repeatable.
noise : SIGNAL=VALUE
    Standard deviation of a signal, with its unit; of an impedance relative to it: impedance=0.01; repeatable.
zero : SIGNAL,...
    Signal whose zero is unknown and is fitted; repeatable.
gain_error : SIGNAL=SHARE
    Relative standard uncertainty of the gain of a sensor, such as electrostatic_force='2 %'; repeatable.
zero_error : SIGNAL=VALUE
    Standard uncertainty of the zero of a sensor, with its unit; repeatable.
keep : PART,...
    Take the drive, load or motion of the scenario although the recordings hold their own; repeatable.
output : PLACE
    Folder for report.html, all figures, tables as .csv, and space.toml; or one of them: .html, a figure (.pdf, .svg, .png), .csv,
    .tex; of a joint fit .txt too, a text to paste.
varying : PATH,...
    Free parameters that differ between sessions; repeatable.
session : FILE=NAME
    Session of a recording; by default each is its own; repeatable.
compare_with : SCENARIO
    Another model of the same experiment, by AICc and BIC, among laws by evidence; repeatable.
"""

import math
from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING, Annotated

import typer

from electrovib.apps.cli import options
from electrovib.apps.cli.terminal import say, show_answer
from electrovib.apps.exit_codes import MISFIT
from electrovib.core.errors import InputError

if TYPE_CHECKING:
    from electrovib.apps.recorded import Recordings
    from electrovib.core.answer import Answer

Free = Annotated[
    list[str] | None, typer.Option(callback=options.split, autocompletion=options.parameter_paths)
]


def fit(
    *,
    scenario: options.Scenario,
    recordings: options.Files,
    free: Free = None,
    quantity: options.Names = None,
    noise: options.Texts = None,
    zero: options.Names = None,
    gain_error: options.Texts = None,
    zero_error: options.Texts = None,
    keep: options.Names = None,
    set: options.Changes = None,
    output: options.Output = None,
    _style: options.Style = None,
    all: options.Details = False,
    force: options.Flag = False,
    varying: options.Names = None,
    session: options.Texts = None,
    compare_with: options.Texts = None,
    posterior: options.Flag = False,
    seed: Annotated[int | None, options.number("--seed", int)] = None,
    steps: Annotated[int, options.number("-n", int)] = 2000,
) -> None:
    """Estimate parameters of a scenario from recordings.

    Report each with its interval, what the data do not determine, and whether the model describes them; where it does not,
    the exit code is 3.

    Parameters
    ----------
    posterior
        Sample the posterior distribution too, with emcee; needs --seed.
    seed : N
        Seed of the random numbers of --posterior.
    steps : N
        Length of each chain of --posterior.

    Examples
    --------
    electrovib fit my.toml a.nc b.nc --free friction.coefficient --noise 'lateral_force=5 mN' -o fit
    """
    from electrovib.apps.fit import fit
    from electrovib.apps.progress import tracked
    from electrovib.recordings.fit.of_scenario import Sampling

    if posterior and seed is None:
        raise InputError("--posterior: state --seed, so that the samples can be repeated")
    if seed is not None and not posterior:
        raise InputError("--seed: is that of --posterior, which is not given")
    paths = _free(free)
    errors = {"noise": noise, "gain_error": gain_error, "zero_error": zero_error}
    known = _recordings(recordings, set, **errors, quantity=quantity, zero=zero, keep=keep, session=session)
    joint = options.given(free=paths, varying=varying, compare_with=compare_with, output=output, force=force)
    with tracked("fitting") as progress:
        sampling = None if seed is None else Sampling(seed=seed, steps=steps, progress=progress)
        joint |= options.given(posterior=sampling, progress=progress)
        found = fit(options.changed(scenario, set), known, **joint)
    _end(found, output, everything=all, misfit=bool(found.best.misfit.reasons))


def fit_laws(
    *,
    scenario: options.Scenario,
    recordings: options.Files,
    free: Free = None,
    quantity: options.Names = None,
    noise: options.Texts = None,
    zero: options.Names = None,
    gain_error: options.Texts = None,
    zero_error: options.Texts = None,
    keep: options.Names = None,
    set: options.Changes = None,
    output: options.Output = None,
    _style: options.Style = None,
    all: options.Details = False,
    force: options.Flag = False,
    varying: options.Names = None,
    session: options.Texts = None,
    compare_with: options.Texts = None,
    laws: options.Names = None,
    seed: Annotated[int, options.number("--seed", int)] = 0,
) -> None:
    """Weigh which force law made recordings.

    Report how probable each law is by its evidence, what speaks against it, and the parameters of the scenario.

    Parameters
    ----------
    laws : A,B,...
        Force laws, all by default, each with and without the gap and the leaks of the scenario; repeatable.
    seed : N
        Seed of the random numbers of nested sampling.

    Examples
    --------
    electrovib fit-laws my.toml a.nc --free contact.area --quantity electrostatic_force -o laws
    """
    from electrovib.apps.fit import fit_laws
    from electrovib.apps.progress import tracked

    paths = _free(free)
    errors = {"noise": noise, "gain_error": gain_error, "zero_error": zero_error}
    known = _recordings(recordings, set, **errors, quantity=quantity, zero=zero, keep=keep, session=session)
    joint = options.given(free=paths, varying=varying, compare_with=compare_with, output=output)
    joint |= options.given(laws=laws, seed=seed, force=force)
    with tracked("fitting") as progress:
        found = fit_laws(options.changed(scenario, set), known, **joint | {"progress": progress})
    _end(found, output, everything=all, misfit=bool(found.best.misfit.reasons))


def fit_separately(
    *,
    scenario: options.Scenario,
    recordings: options.Files,
    free: Free = None,
    quantity: options.Names = None,
    noise: options.Texts = None,
    zero: options.Names = None,
    gain_error: options.Texts = None,
    zero_error: options.Texts = None,
    keep: options.Names = None,
    set: options.Changes = None,
    output: options.Output = None,
    _style: options.Style = None,
    all: options.Details = False,
    force: options.Flag = False,
) -> None:
    """Estimate parameters from each recording alone.

    Make one table and one figure for all, with the scatter within and between recordings.
    """
    from electrovib.apps.fit import fit_separately
    from electrovib.apps.progress import tracked

    paths = _free(free)
    errors = {"noise": noise, "gain_error": gain_error, "zero_error": zero_error}
    known = _recordings(recordings, set, **errors, quantity=quantity, zero=zero, keep=keep)
    with tracked("fitting") as progress:
        asked = options.given(free=paths, output=output, force=force, progress=progress)
        found = fit_separately(options.changed(scenario, set), known, **asked)
    _end(found, output, everything=all, misfit=bool(found.misfits))


def _free(paths: list[str] | None) -> list[str]:
    """Return the parameters to estimate, which are paths alone."""
    for text in paths or ():
        path, sign, value = text.partition("=")
        if sign:
            begin = f"--set {path}={value.partition(':')[0]}"
            raise InputError(
                f"--free {text}: a fit takes the path alone, --free {path}; it begins at {begin}"
            )
    if not paths:
        raise InputError("not given; for instance --free friction.coefficient", path="--free")
    return paths


def _recordings(
    traces: list[str], changes: Sequence[str] | None, **known: Sequence[str] | None
) -> "Recordings":
    """Read what is known of the recordings."""
    from electrovib.apps.recorded import Recordings
    from electrovib.core.signals import SIGNALS
    from electrovib.recordings.fit.measured import PRESCRIBING, PROPORTIONAL

    found, of_recordings = options.given(**known), PRESCRIBING.values()  # what a recording may contradict
    for name, relative in {"noise": PROPORTIONAL, "gain_error": SIGNALS, "zero_error": ()}.items():
        found[name] = _of_signals(found.get(name, ()), f"--{name.replace('_', '-')}", relative=relative)
    found["session"] = dict(
        options.pair_of(text, "--session", "FILE=NAME") for text in found.get("session", ())
    )
    stated = options.changes(changes).items()
    settings = {path: value for path, value in stated if path.split(".")[0] in of_recordings}
    return Recordings(traces=traces, settings=settings, **found)


def _end(found: "Answer", output: str | None, *, everything: bool, misfit: bool) -> None:
    """Print the result, and end with a code of its own where the model does not describe the data."""
    from electrovib.view.files import written

    show_answer(found, everything=everything)
    if output:
        say(written(output, lambda: found.document, found.files))
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
        name, value = options.pair_of(text, option, f"SIGNAL={'SHARE' if relative is SIGNALS else 'VALUE'}")
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
