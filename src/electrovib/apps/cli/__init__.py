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
    texture,
    times,
)
from electrovib.apps.cli.completion import complete_arguments
from electrovib.apps.cli.terminal import complain, prepare
from electrovib.apps.exit_codes import INTERRUPTED, MISTAKE
from electrovib.core.errors import ElectrovibError

_MOST: Final = 50  # mistakes shown at once

app = typer.Typer(
    name="electrovib",
    help="Electrovibration: the force between a finger and a charged plate, from drive voltage to friction.",
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


for _command in (
    scenarios,
    models,
    init,
    run,
    report,
    explore,
    compare,
    perceive,
    equilibrium,
    check,
    export,
    design,
    design_plate,
    texture,
    import_,
    fit,
    fit_material,
    fit_power_law,
    times,
    spaces,
    study,
    sensitivity,
    reproduce,
    bench,
    settings,
):
    _command.register(app)
complete_arguments(app)


def main() -> None:
    """Run the command line; each mistake of the user is one line on the error output, with exit code 2."""
    prepare()
    try:
        app()
    except ElectrovibError as error:
        _stop(*error.problems)
    except KeyboardInterrupt:
        _interrupted()
    except SystemExit as stop:  # typer ends with this code after an interrupt, without a message
        if stop.code == INTERRUPTED:
            _interrupted()
        raise
    except BrokenPipeError:
        sys.exit(1)
    except Exception as error:
        from electrovib.core.own_models import fault

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
