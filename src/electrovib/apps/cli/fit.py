"""``electrovib fit``."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated

import typer

from electrovib.apps.cli.fit_options import (
    CompareWith,
    Folder,
    GainError,
    Noise,
    OnlySignal,
    PosteriorAsked,
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
from electrovib.apps.cli.force import Force
from electrovib.apps.cli.options import Changes, Models
from electrovib.apps.cli.terminal import say

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence
    from typing import Any

    from electrovib.apps.fit import FitResult
    from electrovib.recordings.fit.sampling import Sampling
    from electrovib.recordings.fit.separate import SeparateFits
    from electrovib.recordings.fit.table import EstimatedParameter
    from electrovib.scenario import Source


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("fit")(command)


def command(
    scenario: Annotated[
        str, typer.Argument(help="A TOML file or a paper's scenario; its values are where the search begins.")
    ],
    recordings: Annotated[
        list[str],
        typer.Argument(metavar="RECORD...", help="Trace files with signals over time or frequency."),
    ],
    free: Annotated[
        list[str],
        typer.Option(metavar="PATH,PATH,...", help="Parameters to estimate, as dotted paths; repeatable."),
    ],
    vary: Vary = None,
    session: Session = None,
    noise: Noise = None,
    zero: Zero = None,
    gain_error: GainError = None,
    zero_error: ZeroError = None,
    signal: OnlySignal = None,
    compare_with: CompareWith = None,
    separately: Separately = False,
    posterior: PosteriorAsked = False,
    seed: Seed = None,
    steps: Steps = 2000,
    changes: Changes = None,
    output: Folder = None,
    models: Models = None,
    force: Force = False,
) -> None:
    """Estimate parameters of a scenario from recordings.

    Report each with its interval, and what the data do not determine.
    """
    del models  # imported by now
    from electrovib.apps.fit import fit
    from electrovib.apps.progress import tracked

    base = _base(scenario, changes)
    shared: dict[str, Any] = {
        "free": names_of(free),
        "signals": names_of(signal) if signal else None,
        "noise": noises_of(noise or []),
        "offsets": names_of(zero or []),
        "calibration": calibrations_of(gain_error or [], zero_error or []),
        "output": output,
        "force": force,
    }
    if separately:
        joint = {"vary": vary, "session": session, "compare-with": compare_with, "posterior": posterior}
        _separately(base, recordings, shared, joint=joint)
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
    say(*summary(found))
    if output:
        say(f"written: {output}")


def _base(scenario: str, changes: list[str] | None) -> Source:
    """Return the scenario with the changes of the command; its name where there are none."""
    from electrovib.apps.changes import read_changes
    from electrovib.scenario import read_scenario

    return read_scenario(scenario, changes=read_changes(changes)) if changes else scenario


def _sampling(seed: int | None, steps: int, update: Callable[[int, int], None]) -> Sampling:
    """Read the options of the posterior distribution."""
    from electrovib.core.errors import InputError
    from electrovib.recordings.fit.sampling import Sampling

    if seed is None:
        raise InputError("--posterior: state --seed, so that the samples can be repeated")
    return Sampling(seed=seed, steps=steps, progress=update)


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


def _separately(
    base: Source,
    recordings: Sequence[str],
    shared: dict[str, Any],
    *,
    joint: Mapping[str, Sequence[str] | bool | None],
) -> None:
    """Fit each recording alone, and print the table."""
    from electrovib.apps.fit_separately import fit_separately
    from electrovib.apps.progress import tracked
    from electrovib.core.errors import InputError

    if surplus := [name for name, given in joint.items() if given]:
        raise InputError(f"--{surplus[0]}: belongs to a joint fit; omit it, or omit --separately")
    with tracked("fitting") as update:
        found = fit_separately(base, recordings, progress=update, **shared)
    say(*separate_summary(found))
    if shared["output"]:
        say(f"written: {shared['output']}")


def separate_summary(found: SeparateFits) -> list[str]:
    """Report the estimates of each recording with their intervals, and their mean and scatter over the recordings."""
    lines = []
    for each in found.fits:
        if each.found is None:
            lines.append(f"{each.record}: failed: {each.problem}")
            continue
        fitted = [line for row in each.rows for line in row_lines(row)]
        lines += [f"{each.record}:", *(f"  {line}" for line in fitted)]
        if not each.found.estimate.converged:
            lines.append("  warning: the search ended without having converged")
    for row in found.means:
        first, *notes = row_lines(row)
        counted = len(found.spreads[row.name].values)
        lines += [first.replace(row.name, f"{row.name}, mean of {counted} recordings", 1), *notes]
    return lines


def row_lines(row: EstimatedParameter) -> list[str]:
    """Write one estimate with its interval, or why it has none."""
    from electrovib.core.units import format_quantity

    value = format_quantity(row.value, row.unit, digits=row.digits)
    if not row.method:
        return [f"{row.name}: {value}, no interval: {row.note}"]
    lower, upper = (format_quantity(end, row.unit, digits=row.digits) for end in (row.lower, row.upper))
    line = f"{row.name}: {value}, 95 % interval {lower} to {upper} ({row.method})"
    if math.isfinite(row.systematic):
        ends = (format_quantity(end, row.unit, digits=row.digits) for end in row.systematic_interval)
        line += f", by calibration {' to '.join(ends)}"
    return [line, f"  {row.note}"] if row.note else [line]


def summary(found: FitResult) -> list[str]:
    """Report each estimate with its interval, what is not determined, and which model the data support."""
    lines = [line for row in found.rows for line in row_lines(row)]
    lines += [
        f"{each.recording}, {each.observed.signal}: {each.observed.x.size} samples, residual"
        f" {_spread(each.root_mean_square, each.observed.signal, relative=each.observed.relative)} rms"
        for each in found.best.residuals
    ]
    lines += posterior_lines(found)
    if found.comparison is not None:
        lines.append(found.comparison.sentence)
    if not found.best.estimate.converged:
        lines.append("warning: the search ended without having converged")
    return lines


def _spread(value: float, signal: str, *, relative: bool) -> str:
    from electrovib.core.signals import SIGNALS
    from electrovib.core.units import format_quantity

    return f"{100 * value:.3g} %" if relative else format_quantity(value, SIGNALS[signal].unit, digits=3)
