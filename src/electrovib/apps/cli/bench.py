"""``electrovib bench run`` and ``electrovib bench init``."""

from __future__ import annotations

import json
from typing import Final

import typer

from electrovib.apps.cli.grouped import Command, Commands
from electrovib.apps.cli.options import Arguments, takes
from electrovib.apps.cli.terminal import complain, say, show, show_answer
from electrovib.apps.exit_codes import INTERRUPTED, Told

_TERMINATED: Final = 143
"""Exit code after SIGTERM, as a shell reports it."""


@takes("""
scenario
--bench FILE       Bench file; by default the set-up of Vezzoli et al. 2014.
--simulate         Use simulated instruments, with our own model as the finger.
--arm              Use the real instruments of the bench file.
--finger SCENARIO  Finger of the simulated set-up; by default that of the scenario.
--seed N           Seed of the noise of the simulated set-up. [default: 0]
--set
-o, --output FILE  Write the Trace: .nc, .csv or .mat.
--models
--force
""")
def run(given: Arguments) -> None:
    """Play the drive of a scenario as one burst and record it.

    Without --simulate and --arm, print the plan.
    """
    from electrovib.bench.link import BenchStopped
    from electrovib.bench.run import plan_bench, run_bench

    given.read_set()
    plan = plan_bench(given["scenario"], bench=given.get("bench"), set=given["set"])
    show_answer(plan)
    if not {"simulate", "arm"} & given.keys():
        say("nothing was sent: give --simulate for a simulated set-up, or --arm for the real one")
        return
    try:
        trace = run_bench(**given, confirm=_confirm, report=lambda step: say(f"step: {step}"))
    except (KeyboardInterrupt, BenchStopped) as stop:
        try:
            complain(str(stop) or "interrupted")
        finally:  # also where a second interrupt keeps the line from being printed
            raise Told(_TERMINATED if isinstance(stop, BenchStopped) else INTERRUPTED)
    say(*json.loads(trace.attrs["comparisons"]), trace.attrs["left"])
    if "output" in given:
        say(f"written: {given['output']}")


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
