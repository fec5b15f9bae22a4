"""``electrovib run``."""

from __future__ import annotations

from typing import Annotated, Any

import typer

from electrovib.core.errors import InputError


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("run")(command)


def command(
    scenario: Annotated[
        str,
        typer.Argument(
            help="A TOML file, a paper's scenario such as vezzoli_2014/fig6, or a Trace to repeat."
        ),
    ] = "vezzoli_2014/fig6",
    changes: Annotated[
        list[str] | None, typer.Option("--set", metavar="PATH=VALUE", help="Change a parameter; repeatable.")
    ] = None,
    over: Annotated[
        list[str] | None,
        typer.Option(metavar="PATH=FROM:TO:N[log]", help="Give the Trace this dimension; repeatable."),
    ] = None,
    output: Annotated[
        str | None, typer.Option("--output", "-o", help="Write the Trace: .nc, .csv or .mat.")
    ] = None,
    report: Annotated[str | None, typer.Option(help="Write a self-contained HTML report.")] = None,
) -> None:
    """Simulate a scenario; write its Trace and a report."""
    from electrovib.apps.run import run

    trace = run(scenario, set=read_changes(changes or []), over=over or [], output=output, report=report)
    for line in summary(trace, output, report):
        print(line)


def read_changes(texts: list[str]) -> dict[str, Any]:
    """Read ``path=value`` texts; a value that begins with a brace or bracket is TOML."""
    import tomllib

    found: dict[str, Any] = {}
    problems = []
    for text in texts:
        path, sign, value = text.partition("=")
        if not sign or not path.strip():
            problems.append(f"--set {text}: expected PATH=VALUE, for instance drive.high='150 V'")
            continue
        found[path.strip()] = value.strip()
        if value.strip()[:1] in {"{", "["}:
            try:
                found[path.strip()] = tomllib.loads(f"value = {value.strip()}")["value"]
            except tomllib.TOMLDecodeError as error:
                problems.append(f"--set {text}: not valid TOML: {error}")
    if problems:
        raise InputError(problems)
    return found


def summary(trace: Any, output: str | None, report: str | None) -> list[str]:
    """Say in a few lines what came out."""
    import json

    from electrovib.core.units import format_quantity

    lines = [trace.attrs["title"]] if trace.attrs["title"] else []
    for name in ("electrostatic_force", "lateral_force"):
        low, high = (
            format_quantity(float(edge), "N", digits=4) for edge in (trace[name].min(), trace[name].max())
        )
        lines.append(f"{name.replace('_', ' ')}: {low} to {high}")
    lines.append(f"solver: {trace.attrs['solver']} ({trace.attrs['solver_reason']})")
    lines += [
        f"{lamp['state']}: {lamp['text']}"
        for lamp in json.loads(trace.attrs["lamps"])
        if lamp["state"] == "warning"
    ]
    if trace.attrs["dropped_samples"]:
        lines.append(f"warning: {trace.attrs['dropped_samples']} samples of the drive were dropped")
    return lines + [f"written: {path}" for path in (output, report) if path]
