"""``electrovib bench run`` and ``electrovib bench init``."""

import json
from typing import Final

import typer

from electrovib.apps.cli import options
from electrovib.apps.cli.grouped import Command, Commands
from electrovib.apps.cli.terminal import complain, say, show, show_answer
from electrovib.apps.exit_codes import INTERRUPTED, Told

_TERMINATED: Final = 143
"""Exit code after SIGTERM, as a shell reports it."""


def run(
    *,
    experiment: options.ScenarioOptions,
    bench: options.Text = None,
    simulate: options.Flag = False,
    arm: options.Flag = False,
    finger: options.Text = None,
    seed: options.Seed = 0,
    into: options.FileOptions,
) -> None:
    """Play the drive of a scenario as one burst and record it.

    Without --simulate and --arm, print the plan.

    Parameters
    ----------
    bench : FILE
        Bench file; by default the set-up of Vezzoli et al. 2014.
    simulate
        Use simulated instruments, with our own model as the finger.
    arm
        Use the real instruments of the bench file.
    finger : SCENARIO
        Finger of the simulated set-up; by default that of the scenario.
    seed : N
        Seed of the noise of the simulated set-up.
    output : FILE
        Write the Trace: .nc, .csv or .mat.
    """
    from electrovib.apps.progress import heard
    from electrovib.bench.link import BenchStopped
    from electrovib.bench.run import plan_bench, run_bench

    show_answer(plan_bench(bench=bench, **experiment.asked))
    if not (simulate or arm):
        say("nothing was sent: give --simulate for a simulated set-up, or --arm for the real one")
        return
    asked = options.given(
        bench=bench, simulate=simulate, arm=arm, finger=finger, seed=seed, output=into.output
    )
    try:
        with heard("electrovib.bench", lambda step: say(f"step: {step.getMessage()}")):
            trace = run_bench(**experiment.asked, **asked, force=into.force, confirm=_confirm)
    except (KeyboardInterrupt, BenchStopped) as stop:
        try:
            complain(str(stop) or "interrupted")
        finally:  # also where a second interrupt keeps the line from being printed
            raise Told(_TERMINATED if isinstance(stop, BenchStopped) else INTERRUPTED)
    say(*json.loads(trace.attrs["comparisons"]), trace.attrs["left"])
    if into.output:
        say(f"written: {into.output}")


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
group.command("run", cls=Command)(options.spread_out(run))
group.command("init", cls=Command)(init)
