"""``electrovib bench run`` and ``electrovib bench init``."""

from __future__ import annotations

import json
from typing import Annotated, Final

import typer

from electrovib.apps.cli import options
from electrovib.apps.cli.grouped import Command, Commands
from electrovib.apps.cli.terminal import complain, say, show
from electrovib.apps.exit_codes import INTERRUPTED, Told

_TERMINATED: Final = 143
"""Exit code after SIGTERM, as a shell reports it."""


def run(
    scenario: options.Scenario,
    bench: Annotated[
        str | None,
        typer.Option(
            "--bench", metavar="FILE", help="Bench file; by default the set-up of Vezzoli et al. 2014."
        ),
    ] = None,
    simulate: Annotated[
        bool, typer.Option("--simulate", help="Use simulated instruments, with our own model as the finger.")
    ] = False,
    arm: Annotated[bool, typer.Option("--arm", help="Use the real instruments of the bench file.")] = False,
    finger: Annotated[
        str | None,
        typer.Option(
            metavar="SCENARIO", help="Finger of the simulated set-up; by default that of the scenario."
        ),
    ] = None,
    seed: Annotated[int, typer.Option(help="Seed of the noise of the simulated set-up.")] = 0,
    changes: options.Changes = None,
    output: Annotated[
        str | None, typer.Option("--output", "-o", help="Write the Trace: .nc, .csv or .mat.")
    ] = None,
    models: options.Models = None,
    force: options.Force = False,
) -> None:
    """Play the drive of a scenario as one burst and record it.

    Without --simulate and --arm, print the plan.
    """
    from electrovib.apps.changes import read_changes
    from electrovib.bench.link import BenchStopped
    from electrovib.bench.run import plan_bench, run_bench

    changed = read_changes(changes or [])
    plan = plan_bench(scenario, bench=bench, set=changed)
    say(*plan.lines())
    if not (simulate or arm):
        say("nothing was sent: give --simulate for a simulated set-up, or --arm for the real one")
        return
    try:
        trace = run_bench(
            scenario, bench=bench, simulate=simulate, arm=arm, finger=finger, seed=seed, set=changed,
            output=output, force=force, confirm=_confirm, report=lambda step: say(f"step: {step}"),
        )  # fmt: skip
    except (KeyboardInterrupt, BenchStopped) as stop:
        try:
            complain(str(stop) or "interrupted")
        finally:  # also where a second interrupt keeps the line from being printed
            raise Told(_TERMINATED if isinstance(stop, BenchStopped) else INTERRUPTED)
    say(*json.loads(trace.attrs["comparisons"]), trace.attrs["left"])
    if output:
        say(f"written: {output}")


def init() -> None:
    """Print a bench file to start from.

    It is that of Vezzoli et al. 2014: electrovib bench init > bench.toml.
    """
    from electrovib.bench.settings import default_text

    show(default_text().rstrip("\n"))


def _confirm(words: str) -> bool:
    try:
        return typer.confirm(words, default=False)
    except typer.Abort:  # Ctrl-C, or no terminal to answer from
        return False


group = typer.Typer(
    cls=Commands,
    help="Play a drive on a real or simulated set-up.",
    no_args_is_help=True,
    rich_markup_mode=None,
)
group.command("run", cls=Command)(run)
group.command("init", cls=Command)(init)
