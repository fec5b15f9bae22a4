"""``electrovib fit``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Final

import typer

from electrovib.apps.cli.fit_options import (
    CompareWith,
    Folder,
    Free,
    GainError,
    Keep,
    Noise,
    OnlySignal,
    PosteriorAsked,
    Recordings,
    Seed,
    Separately,
    Session,
    Steps,
    Vary,
    Zero,
    ZeroError,
    calibrations_of,
    names_of,
    noises_of,
    pair_of,
)
from electrovib.apps.cli.fit_words import brief, separate_summary, separate_verdict, summary, verdict
from electrovib.apps.cli.force import Force
from electrovib.apps.cli.options import Changes, Everything, Models
from electrovib.apps.cli.terminal import say, warned
from electrovib.apps.exit_codes import MISFIT

EXAMPLE: Final = (
    "electrovib fit my.toml a.nc b.nc --free friction.coefficient --noise 'lateral_force=5 mN' -o fit"
)

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence
    from typing import Any

    from electrovib.recordings.fit.posterior import Sampling
    from electrovib.scenario import Source


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("fit")(command)


def command(
    scenario: Annotated[
        str, typer.Argument(help="A TOML file or a paper's scenario; its values are where the search begins.")
    ],
    recordings: Recordings,
    free: Free,
    vary: Vary = None,
    session: Session = None,
    noise: Noise = None,
    zero: Zero = None,
    gain_error: GainError = None,
    zero_error: ZeroError = None,
    signal: OnlySignal = None,
    keep: Keep = None,
    compare_with: CompareWith = None,
    separately: Separately = False,
    posterior: PosteriorAsked = False,
    seed: Seed = None,
    steps: Steps = 2000,
    changes: Changes = None,
    output: Folder = None,
    everything: Everything = False,
    models: Models = None,
    force: Force = False,
) -> None:
    """Estimate parameters of a scenario from recordings.

    Report each with its interval, what the data do not determine, and whether the model describes them; where it does not,
    the exit code is 3.
    """
    del models  # imported by now
    from electrovib.apps.fit import fit
    from electrovib.apps.progress import tracked

    base = _base(scenario, changes)
    shared: dict[str, Any] = {
        "free": names_of(free),
        "signals": names_of(signal) if signal else None,
        "keep": names_of(keep or []),
        "stated": _stated(changes),
        "noise": noises_of(noise or []),
        "offsets": names_of(zero or []),
        "calibration": calibrations_of(gain_error or [], zero_error or []),
        "output": output,
        "force": force,
    }
    if separately:
        joint = {"vary": vary, "session": session, "compare-with": compare_with, "posterior": posterior}
        _separately(base, recordings, shared, joint=joint, everything=everything)
        return
    with tracked("fitting") as update:
        found = fit(
            base,
            recordings,
            varying=names_of(vary or []),
            sessions=dict(pair_of(text, "--session", "FILE=NAME") for text in session or []),
            compare_with=compare_with or [],
            posterior=_sampling(seed, steps, update) if posterior else None,
            **shared,
        )
    lines = summary(found) if everything else brief(verdict(found))
    _end([*lines, *warned(found)], output, misfit=bool(found.best.misfit.reasons))


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
    from electrovib.core.errors import InputError
    from electrovib.recordings.fit.posterior import Sampling

    if seed is None:
        raise InputError("--posterior: state --seed, so that the samples can be repeated")
    return Sampling(seed=seed, steps=steps, progress=update)


def _separately(
    base: Source,
    recordings: Sequence[str],
    shared: dict[str, Any],
    *,
    joint: Mapping[str, Sequence[str] | bool | None],
    everything: bool,
) -> None:
    """Fit each recording alone, and print the table."""
    from electrovib.apps.fit_separately import fit_separately
    from electrovib.apps.progress import tracked
    from electrovib.core.errors import InputError

    if surplus := [name for name, given in joint.items() if given]:
        raise InputError(f"--{surplus[0]}: belongs to a joint fit; omit it, or omit --separately")
    with tracked("fitting") as update:
        found = fit_separately(base, recordings, progress=update, **shared)
    lines = separate_summary(found) if everything else brief(separate_verdict(found))
    _end([*lines, *warned(found)], shared["output"], misfit=bool(found.misfits))


def _end(lines: Sequence[str], output: str | None, *, misfit: bool) -> None:
    """Print the result, and end with a code of its own where the model does not describe the data."""
    say(*lines)
    if output:
        say(f"written: {output}")
    if misfit:
        raise typer.Exit(MISFIT)
