"""``electrovib report``."""

from __future__ import annotations

from typing import Annotated

import typer

from electrovib.apps.cli.force import Force
from electrovib.apps.cli.terminal import say


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("report")(command)


def command(
    traces: Annotated[list[str], typer.Argument(help="Trace files, overlaid in one report.")],
    output: Annotated[str, typer.Option("--output", "-o", help="The HTML file to write.")] = "report.html",
    force: Force = False,
) -> None:
    """Draw one report of any Traces."""
    from electrovib.apps.progress import tracked
    from electrovib.view.report import report

    with tracked("drawing the report"):
        say(f"written: {report(traces, output, force=force)}")
