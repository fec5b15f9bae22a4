"""``electrovib report``."""

from __future__ import annotations

from typing import Annotated

import typer

from electrovib.apps.cli.force import Force
from electrovib.apps.cli.options import Models
from electrovib.apps.cli.terminal import say


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("report")(command)


def command(
    traces: Annotated[list[str], typer.Argument(help="Trace files, overlaid in one report.")],
    output: Annotated[str, typer.Option("--output", "-o", help="The HTML file to write.")] = "report.html",
    models: Models = None,
    force: Force = False,
) -> None:
    """Write one report of several Traces, overlaid."""
    del models  # imported by now
    from electrovib.apps.progress import tracked
    from electrovib.view.report import report

    with tracked("drawing the report"):
        written = report(traces, output, force=force)
    say(f"written: {written}", *_without_parameters(traces))


def _without_parameters(traces: list[str]) -> list[str]:
    """Explain for which Traces the report shows signals only, because a model of their scenario is missing."""
    from electrovib.core.errors import InputError
    from electrovib.core.trace import is_trace
    from electrovib.data.traces import open_if_trace
    from electrovib.scenario import scenario_of

    lines: list[str] = []
    for name in traces:
        found = open_if_trace(name)
        if not is_trace(found) or "scenario" not in found.attrs:
            continue
        try:
            scenario_of(found)
        except InputError as error:
            lines += [f"{name}: shown without its parameters: {problem}" for problem in error.problems]
    return lines
