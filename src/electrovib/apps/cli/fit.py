"""``electrovib fit``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, TypeAlias

import typer

from electrovib.apps.cli.force import Force
from electrovib.apps.cli.options import Changes, Models
from electrovib.apps.cli.terminal import say

if TYPE_CHECKING:
    from collections.abc import Sequence

    from electrovib.apps.fit import FitResult


Vary: TypeAlias = Annotated[
    list[str] | None,
    typer.Option(metavar="PATH,...", help="Those of them that differ between sessions; repeatable."),
]
Session: TypeAlias = Annotated[
    list[str] | None,
    typer.Option(metavar="FILE=NAME", help="Session of a recording; by default each is its own. Repeatable."),
]
Noise: TypeAlias = Annotated[
    list[str] | None,
    typer.Option(
        metavar="SIGNAL=VALUE",
        help="Standard deviation of a signal, with its unit; of an impedance relative to it: impedance=0.01. Repeatable.",
    ),
]
Zero: TypeAlias = Annotated[
    list[str] | None,
    typer.Option(metavar="SIGNAL", help="Signal whose zero is unknown and is fitted; repeatable."),
]
OnlySignal: TypeAlias = Annotated[
    list[str] | None, typer.Option(metavar="SIGNAL", help="Fit only this signal; repeatable.")
]
CompareWith: TypeAlias = Annotated[
    list[str] | None,
    typer.Option(
        metavar="SCENARIO", help="Another model of the same experiment, compared by AICc and BIC; repeatable."
    ),
]
Folder: TypeAlias = Annotated[
    str | None,
    typer.Option(
        "--output",
        "-o",
        metavar="DIR",
        help="Folder for report.html, parameters.csv, parameters.toml and space.toml.",
    ),
]


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
    signal: OnlySignal = None,
    compare_with: CompareWith = None,
    changes: Changes = None,
    output: Folder = None,
    models: Models = None,
    force: Force = False,
) -> None:
    """Estimate parameters of a scenario from recordings, with intervals, and say what the data do not determine."""
    del models  # imported by now
    from electrovib.apps.changes import read_changes
    from electrovib.apps.fit import fit
    from electrovib.apps.progress import tracked
    from electrovib.scenario import read_scenario

    base = read_scenario(scenario, changes=read_changes(changes)) if changes else scenario
    with tracked("fitting"):
        found = fit(
            base,
            recordings,
            free=_names(free),
            varying=_names(vary or []),
            signals=_names(signal) if signal else None,
            noise=_noises(noise or []),
            offsets=_names(zero or []),
            sessions=dict(_pair(text, "--session", "FILE=NAME") for text in session or []),
            compare_with=compare_with or [],
            output=output,
            force=force,
        )
    say(*summary(found))
    if output:
        say(f"written: {output}")


def summary(found: FitResult) -> list[str]:
    """Report each estimate with its interval, what is not determined, and which model the data support."""
    from electrovib.core.units import format_quantity

    lines = []
    for row in found.rows:
        value = format_quantity(row.value, row.unit, digits=row.digits)
        if row.method:
            lower, upper = (
                format_quantity(end, row.unit, digits=row.digits) for end in (row.lower, row.upper)
            )
            lines.append(f"{row.name}: {value}, 95 % interval {lower} to {upper} ({row.method})")
            if row.note:
                lines.append(f"  {row.note}")
        else:
            lines.append(f"{row.name}: {value}, no interval: {row.note}")
    lines += [
        f"{each.recording}, {each.observed.signal}: {each.observed.x.size} samples, residual"
        f" {_spread(each.root_mean_square, each.observed.signal, relative=each.observed.relative)} rms"
        for each in found.best.residuals
    ]
    if found.comparison is not None:
        lines.append(found.comparison.sentence)
    if not found.best.estimate.converged:
        lines.append("warning: the search ended without having converged")
    return lines


def _spread(value: float, signal: str, *, relative: bool) -> str:
    from electrovib.core.signals import SIGNALS
    from electrovib.core.units import format_quantity

    return f"{100 * value:.3g} %" if relative else format_quantity(value, SIGNALS[signal].unit, digits=3)


def _names(texts: Sequence[str]) -> list[str]:
    return [name.strip() for text in texts for name in text.split(",") if name.strip()]


def _pair(text: str, option: str, form: str) -> tuple[str, str]:
    from electrovib.core.errors import InputError

    first, sign, second = text.rpartition("=")
    if not (sign and first.strip() and second.strip()):
        raise InputError(f"{option} {text}: expected {form}")
    return first.strip(), second.strip()


def _noises(texts: Sequence[str]) -> dict[str, float]:
    from electrovib.core.errors import InputError, nearest
    from electrovib.core.signals import SIGNALS
    from electrovib.core.units import parse_quantity
    from electrovib.recordings.fit.measured import PROPORTIONAL

    found = {}
    for text in texts:
        name, value = _pair(text, "--noise", "SIGNAL=VALUE")
        if name not in SIGNALS:
            raise InputError(f"--noise {text}: no signal has this name.{nearest(name, SIGNALS)}")
        unit = "1" if name in PROPORTIONAL else SIGNALS[name].unit
        try:
            found[name] = float(value) if _is_number(value) else parse_quantity(value, unit)
        except ValueError as error:
            raise InputError(f"--noise {text}: {error}") from None
    return found


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
