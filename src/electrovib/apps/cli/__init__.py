"""The command line: each command reads its arguments and calls the public function of the same name."""

from __future__ import annotations

import sys
from typing import Final, NoReturn

import typer

from electrovib.apps.cli import (
    bench,
    check,
    compare,
    design,
    design_plate,
    equilibrium,
    explore,
    export,
    fit,
    fit_material,
    fit_power_law,
    import_,
    init,
    models,
    perceive,
    report,
    reproduce,
    run,
    scenarios,
    sensitivity,
    settings,
    spaces,
    study,
    swipe,
    texture,
    times,
)
from electrovib.apps.cli.completion import complete_arguments
from electrovib.apps.cli.grouped import Command, Commands
from electrovib.apps.cli.terminal import complain, prepare, unprinted
from electrovib.apps.exit_codes import INTERRUPTED, MISTAKE, UNPRINTED, Told
from electrovib.core.errors import ElectrovibError

_MOST: Final = 50  # mistakes shown at once

app = typer.Typer(
    name="electrovib",
    cls=Commands,
    help="Electrovibration: the force between a finger and a charged plate, from drive voltage to friction.",
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


_GROUPS: Final = {
    "Predict": (run, compare, study, sensitivity, equilibrium, perceive, reproduce),
    "Measure": (import_, times, swipe, fit, fit_material, fit_power_law, bench),
    "Plan": (design, design_plate, texture, check, export),
    "See": (explore, report, scenarios, models, spaces, init),
}
settings.register(app)
for _title, _commands in _GROUPS.items():
    for _command in _commands:
        _command.register(app)
        if _command is bench:
            app.registered_groups[-1].rich_help_panel = _title
            continue
        _info = app.registered_commands[-1]
        _info.cls, _info.rich_help_panel = Command, _title
        _info.epilog = getattr(_command, "EXAMPLE", None)
complete_arguments(app)


def main() -> None:
    """Run the command line; each mistake of the user is one line on the error output, with exit code 2."""
    prepare()
    try:
        _run()
    except SystemExit as stop:
        if unprinted() and not stop.code:
            sys.exit(UNPRINTED)
        raise


def _run() -> None:
    """Run the command line up to its exit code."""
    try:
        app()
    except ElectrovibError as error:
        _stop(*error.problems)
    except KeyboardInterrupt:
        _interrupted()
    except SystemExit as stop:  # typer ends with this code after an interrupt, without a message
        if stop.code == INTERRUPTED and not isinstance(stop, Told):
            _interrupted()
        raise
    except Exception as error:
        from electrovib.core.own_models import fault

        if isinstance(error, OSError) and unprinted():
            sys.exit(UNPRINTED)
        if not (line := fault(error)):
            raise
        _stop(line)


def _interrupted() -> NoReturn:
    complain("interrupted, nothing was left half written")
    sys.exit(INTERRUPTED)


def _stop(*lines: str) -> None:
    complain(*lines[:_MOST])
    if len(lines) > _MOST:
        complain(f"and {len(lines) - _MOST} more mistakes")
    sys.exit(MISTAKE)
