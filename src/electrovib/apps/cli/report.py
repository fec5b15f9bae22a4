"""``electrovib report``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from electrovib.apps.cli.force import Force
from electrovib.apps.cli.import_ import pairs
from electrovib.apps.cli.import_options import Columns, Scales, TimeColumn
from electrovib.apps.cli.options import Models
from electrovib.apps.cli.terminal import say


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("report")(command)


def command(
    traces: Annotated[list[str], typer.Argument(help="Trace files, overlaid in one report.")],
    output: Annotated[str, typer.Option("--output", "-o", help="The HTML file to write.")] = "report.html",
    column: Columns = None,
    time: TimeColumn = "",
    scale: Scales = None,
    models: Models = None,
    force: Force = False,
) -> None:
    """Write one report of several Traces, overlaid.

    With --column other files are imported as measurements.
    """
    del models  # imported by now
    from electrovib.apps.progress import tracked
    from electrovib.view.report import report

    found = _imported(traces, pairs("column", column), time=time, scale=pairs("scale", scale))
    with tracked("drawing the report"):
        written = report(found or traces, output, force=force)
    say(f"written: {written}", *_without_parameters(traces))


def _imported(
    names: list[str], columns: dict[str, str], *, time: str, scale: dict[str, str]
) -> dict[str, Any]:
    """Import the files that are neither Traces nor scenarios; label to Trace or file name, empty without columns."""
    from electrovib.core.errors import DataFileError, InputError
    from electrovib.data.traces import open_if_trace
    from electrovib.recordings.importing import import_file

    if not columns:
        if time or scale:
            raise InputError(
                f"--{'time' if time else 'scale'}: belongs to --column SIGNAL=COLUMN, which is missing"
            )
        return {}
    found: dict[str, Any] = {}
    for name in names:
        label = Path(name).stem if Path(name).stem not in found else name
        found[label] = name
        if Path(name).is_file() and Path(name).suffix.lower() != ".toml":
            try:
                found[label] = open_if_trace(name)
                if found[label] is name:
                    found[label] = import_file(name, columns, time=time, scale=scale)
            except DataFileError:
                found[label] = import_file(name, columns, time=time, scale=scale)
    return found


def _without_parameters(traces: list[str]) -> list[str]:
    """Explain for which Traces the report shows signals only, because a model of their scenario is missing."""
    from electrovib.core.errors import InputError
    from electrovib.core.trace import is_trace
    from electrovib.data.traces import open_if_trace
    from electrovib.scenario import scenario_of

    lines: list[str] = []
    for name in traces:
        try:
            found = open_if_trace(name)
        except InputError:  # a file of an instrument
            continue
        if not is_trace(found) or "scenario" not in found.attrs:
            continue
        try:
            scenario_of(found)
        except InputError as error:
            lines += [f"{name}: shown without its parameters: {problem}" for problem in error.problems]
    return lines
