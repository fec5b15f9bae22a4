"""``electrovib run``."""

from __future__ import annotations

import math
from typing import Annotated, Any, Final

import typer

from electrovib.apps.cli.force import Force
from electrovib.apps.cli.options import Changes, Models
from electrovib.apps.cli.terminal import say

_ROUNDING: Final = 1e-12
"""Share of the largest force below which the smallest one is printed as 0."""
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
    changes: Changes = None,
    over: Annotated[
        list[str] | None,
        typer.Option(metavar="PATH=FROM:TO:N[log]", help="Sweep a parameter; repeatable."),
    ] = None,
    quantities: Annotated[
        list[str] | None,
        typer.Option(
            "--quantity",
            metavar="NAME",
            help="Quantity of each case, for instance 'mean electrostatic_force'; repeatable.",
        ),
    ] = None,
    records: Annotated[
        bool, typer.Option("--records", help="Keep the signals over time of each case of a sweep too.")
    ] = False,
    output: Annotated[
        str | None, typer.Option("--output", "-o", help="Write the result: .nc, .csv or .mat.")
    ] = None,
    report: Annotated[str | None, typer.Option(help="Write a self-contained HTML report.")] = None,
    models: Models = None,
    force: Force = False,
) -> None:
    """Simulate or sweep a scenario.

    Write its Trace, or a table of numbers, and a report.
    """
    del models  # imported by now
    from electrovib.apps.run import run

    trace = run(
        scenario,
        set=changes or [],
        over=over or [],
        quantities=quantities or [],
        records=records,
        output=output,
        report=report,
        force=force,
    )
    say(*summary(trace, output, report, source=scenario))


def summary(trace: Any, output: str | None, report: str | None, *, source: str = "") -> list[str]:
    """Summarise the result in a few lines, with the values of a paper's scenario that are not found in the paper."""
    from electrovib.apps.cli.chosen import chosen
    from electrovib.apps.cli.map_lines import is_map, judged
    from electrovib.core.diagnostics import diagnostics_of, warning_lines
    from electrovib.scenario import scenario_of

    lines = [trace.attrs["title"]] if trace.attrs["title"] else []
    if "over" in trace.attrs:
        lines += _numbers(trace)
    else:
        lines += [f"{name.replace('_', ' ')}: {_range(trace, name)}" for name in FORCES]
    if trace.attrs.get("reduction_error") and "transfer_error" in trace.attrs:
        name, of = "transfer_error", ""
        if "attraction_error" in trace.attrs:
            name, of = "attraction_error", " of the peak attraction"
        error = 100 * float(trace.attrs[name])
        lines.append(f"error through materials reduced to relaxations: at most {error:.2g} %{of}")
    if is_map(trace):
        lines += judged(trace, output, report)
    else:
        lines += warning_lines(diagnostics_of(trace))
    lines += chosen(scenario_of(trace), source, without=trace.dims) if source else []
    lines.append(f"solver: {trace.attrs['solver']}")
    if "friction_solver" in trace.attrs:
        lines.append(f"friction: {trace.attrs['friction_solver']}")
    if dropped := trace.attrs["dropped_samples"]:
        words = "1 sample of the drive was" if dropped == 1 else f"{dropped} samples of the drive were"
        lines.append(f"warning: {words} dropped")
    return lines + [f"written: {path}" for path in (*_files(trace, output), report) if path]


def _range(trace: Any, name: str) -> str:
    """Return the range of a force over the whole run, and the number of times at which it is unknown."""
    from electrovib.core.units import format_quantity
    from electrovib.view.summary import not_known, quantities_of_run

    if missing := not_known(trace, name):
        if not bool(trace[name].notnull().any()):
            return missing
        missing = f", {missing}"
    ends = quantities_of_run(trace, [f"{end} {each}" for each in FORCES for end in ("minimum", "maximum")])
    found = [ends.get(f"{end} {name}", math.nan) for end in ("minimum", "maximum")]
    if not all(map(math.isfinite, found)):
        found = [float(trace[name].min()), float(trace[name].max())]
        missing = missing or " at the output times"
    least, most = found
    if abs(least) < _ROUNDING * abs(most):
        least = 0.0
    low, high = (format_quantity(edge, "N", digits=4) for edge in (least, most))
    if low == high and most > least:
        high += f" (a change of {format_quantity(most - least, 'N', digits=4)})"
    return f"{low} to {high}{missing}"


def _numbers(trace: Any) -> list[str]:
    """Return the range of each quantity of a sweep, and where its ends are."""
    from electrovib.apps.cli.map_lines import is_map
    from electrovib.view.swept import quantity_ranges

    over = ", ".join(
        f"{path} ({trace.sizes[path]} values)" for path in trace.sizes if path in trace.attrs["over"]
    )
    ranges = quantity_ranges(trace, plain=True, named=not is_map(trace))
    lines = [f"over {over}; numbers of {trace.attrs['taken_over']}"] if over else []
    return lines + [f"{name}: {text}" for name, text in ranges.items()]


def _files(trace: Any, output: str | None) -> list[str]:
    """Return the files that `save` wrote: a CSV file has one dimension, so there may be two."""
    from pathlib import Path

    from electrovib.data.traces import csv_files

    if output is None or Path(output).suffix.lower() != ".csv":
        return [output] if output else []
    return [str(path) for path in csv_files(trace.sizes, Path(output))]
