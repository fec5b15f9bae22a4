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
    evidence,
    explore,
    export,
    fit,
    import_,
    init,
    list_,
    report,
    reproduce,
    run,
    settings,
    study,
    times,
)
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
    "Predict": (run, compare, study, evidence, reproduce),
    "Measure": (import_, times, fit, bench),
    "Plan": (design, check, export),
    "See": (explore, report, list_, init),
}
app.callback()(settings.command)
for _title, _modules in _GROUPS.items():
    for _module in _modules:
        _name = _module.__name__.rpartition(".")[2].strip("_")
        if _module is bench:
            app.add_typer(bench.group, name=_name, rich_help_panel=_title)
            continue
        _example = getattr(_module, "EXAMPLE", None)
        app.command(_name, cls=Command, rich_help_panel=_title, epilog=_example)(_module.command)


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
