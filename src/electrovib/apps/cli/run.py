"""``electrovib run``."""

from __future__ import annotations

from typing import Annotated, Any

import typer

FORCES = ("electrostatic_force", "lateral_force")


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

    trace = run(scenario, set=changes or [], over=over or [], output=output, report=report)
    for line in summary(trace, output, report, source=scenario):
        print(line)


def summary(trace: Any, output: str | None, report: str | None, *, source: str = "") -> list[str]:
    """Say in a few lines what came out, and what of a paper's scenario is not found in the paper."""
    import json

    from electrovib.apps.cli.chosen import chosen
    from electrovib.solve.scenario import scenario_of

    lines = [trace.attrs["title"]] if trace.attrs["title"] else []
    lines += [f"{name.replace('_', ' ')}: {_range(trace, name)}" for name in FORCES]
    lines += chosen(scenario_of(trace), source, without=trace.dims) if source else []
    lines.append(f"solver: {trace.attrs['solver']} ({trace.attrs['solver_reason']})")
    if trace.attrs.get("reduction_error"):
        error = 100 * float(trace.attrs.get("transfer_error", float("nan")))
        lines.append(f"error of the answer through materials reduced to relaxations: at most {error:.2g} %")
    lines += [
        f"{lamp['state']}: {lamp['text']}"
        for lamp in json.loads(trace.attrs["lamps"])
        if lamp["state"] == "warning"
    ]
    if "friction_solver" in trace.attrs:
        lines.append(f"friction: {trace.attrs['friction_solver']}")
    if dropped := trace.attrs["dropped_samples"]:
        words = "1 sample of the drive was" if dropped == 1 else f"{dropped} samples of the drive were"
        lines.append(f"warning: {words} dropped")
    return lines + [f"written: {path}" for path in (*_files(trace, output), report) if path]


def _range(trace: Any, name: str) -> str:
    """Write the range of a force, and at how many of its times it is not known."""
    from electrovib.core.units import format_quantity
    from electrovib.view.summary import not_known

    values = trace[name]
    if missing := not_known(trace, name):
        if not bool(values.notnull().any()):
            return missing
        missing = f", {missing}"
    low, high = (format_quantity(float(edge), "N", digits=4) for edge in (values.min(), values.max()))
    return f"{low} to {high}{missing}"


def _files(trace: Any, output: str | None) -> list[str]:
    """Name what `save` wrote: a CSV file holds one dimension, so there may be two."""
    from pathlib import Path

    from electrovib.data.traces import csv_files

    if output is None or Path(output).suffix.lower() != ".csv":
        return [output] if output else []
    return [str(path) for path in csv_files(trace.sizes, Path(output))]
