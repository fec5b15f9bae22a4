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
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any

import typer

from electrovib.apps.cli import options
from electrovib.apps.cli.terminal import finish
from electrovib.apps.exit_codes import MISFIT
from electrovib.core.errors import InputError

if TYPE_CHECKING:
    from electrovib.core.answer import Answer

Free = Annotated[
    list[str] | None, typer.Option(callback=options.split, autocompletion=options.parameter_paths)
]


@dataclass(frozen=True, kw_only=True)
class FitOptions(options.ScenarioOptions):
    """A scenario, recordings with what is known of them, and which parameters are estimated."""

    recordings: options.Files
    free: Free = None
    quantity: options.Names = None
    noise: options.Texts = None
    zero: options.Names = None
    gain_error: options.Texts = None
    zero_error: options.Texts = None
    keep: options.Names = None


@dataclass(frozen=True, kw_only=True)
class JointFitOptions:
    """What a fit of several recordings together takes too."""

    varying: options.Names = None
    session: options.Texts = None
    compare_with: options.Texts = None


def fit(
    *,
    fitted: FitOptions,
    joint: JointFitOptions,
    posterior: options.Flag = False,
    seed: Annotated[int | None, options.number("--seed", int)] = None,
    steps: Annotated[int, options.number("-n", int)] = 2000,
    saved: options.AnswerOptions,
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
    asked = _asked(fitted, saved, joint)
    with tracked("fitting") as progress:
        sampling = None if seed is None else Sampling(seed=seed, steps=steps, progress=progress)
        found = fit(**asked | {"posterior": sampling, "progress": progress})
    _end(found, saved, misfit=bool(found.best.misfit.reasons))


def fit_laws(
    *,
    fitted: FitOptions,
    joint: JointFitOptions,
    laws: options.Names = None,
    seed: options.Seed = 0,
    saved: options.AnswerOptions,
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

    asked = _asked(fitted, saved, joint) | options.given(laws=laws)
    with tracked("fitting") as progress:
        found = fit_laws(**asked | {"seed": seed, "progress": progress})
    _end(found, saved, misfit=bool(found.best.misfit.reasons))


def fit_separately(*, fitted: FitOptions, saved: options.AnswerOptions) -> None:
    """Estimate parameters from each recording alone.

    Make one table and one figure for all, with the scatter within and between recordings.
    """
    from electrovib.apps.fit import fit_separately
    from electrovib.apps.progress import tracked

    asked = _asked(fitted, saved)
    with tracked("fitting") as progress:
        found = fit_separately(**asked, progress=progress)
    _end(found, saved, misfit=bool(found.misfits))


def _asked(
    fitted: FitOptions, saved: options.AnswerOptions, joint: JointFitOptions | None = None
) -> dict[str, Any]:
    """Return what the function of a fit takes: which parameters, what is known of the recordings, and where they go."""
    from electrovib.apps.recorded import Recordings
    from electrovib.core.signals import SIGNALS
    from electrovib.recordings.fit.measured import PRESCRIBING, PROPORTIONAL

    joint, of_recordings = joint or JointFitOptions(), PRESCRIBING.values()  # what a recording may contradict
    free = _free(fitted.free)
    errors: dict[str, Any] = {
        name: _of_signals(getattr(fitted, name) or (), f"--{name.replace('_', '-')}", relative=relative)
        for name, relative in (("noise", PROPORTIONAL), ("gain_error", SIGNALS), ("zero_error", ()))
    }
    sessions = dict(options.pair_of(text, "--session", "FILE=NAME") for text in joint.session or ())
    stated = fitted.asked["set"].items()
    known = Recordings(
        traces=fitted.recordings,
        settings={path: value for path, value in stated if path.split(".")[0] in of_recordings},
        session=sessions,
        **errors,
        **options.given(quantity=fitted.quantity, zero=fitted.zero, keep=fitted.keep),
    )
    more = options.given(varying=joint.varying, compare_with=joint.compare_with, output=saved.output)
    return {"scenario": fitted.changed, "recordings": known, "free": free, "force": saved.force} | more


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


def _end(found: "Answer", saved: options.AnswerOptions, *, misfit: bool) -> None:
    """Print the result, and end with a code of its own where the model does not describe the data."""
    finish(found, saved)
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
