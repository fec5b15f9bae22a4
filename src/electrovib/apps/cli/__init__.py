"""The command line: each command reads its arguments and calls the public function of the same name."""

import sys
from typing import Annotated, Any, Final, NoReturn

import typer

from electrovib.apps.cli import (
    bench,
    compare,
    fit,
    fit_tables,
    import_,
    options,
    plan,
    run,
    see,
    study,
    times,
)
from electrovib.apps.cli.grouped import Command, Commands
from electrovib.apps.cli.terminal import complain, prepare, say, unprinted
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


_GROUPS: Final[dict[str, tuple[Any, ...]]] = {
    "Predict": (run.run, compare.compare, study.study, compare.evidence, compare.reproduce),
    "Measure": (
        import_.import_,
        times.times,
        fit.fit,
        fit.fit_laws,
        fit.fit_separately,
        fit_tables.fit_material,
        fit_tables.fit_power_law,
        fit_tables.fit_contact,
        bench.group,
    ),
    "Plan": (
        plan.find_value,
        plan.value_for_share,
        plan.drive_for_force,
        plan.texture_drive,
        plan.plan_plate,
        plan.plan_experiment,
        plan.check,
        plan.export,
    ),
    "See": (see.explore, see.report, see.list_, see.init),
}


def _show_versions(wanted: bool) -> None:
    if wanted:
        from electrovib.core.versions import versions

        say(*(f"{name} {number}" for name, number in versions().items()))
        raise typer.Exit


@app.callback()
def settings(
    context: typer.Context,
    *,
    _version: Annotated[bool, typer.Option("--version", callback=_show_versions, is_eager=True)] = False,
    _models: options.Models = None,
    budget: Annotated[str | None, typer.Option(envvar="ELECTROVIB_BUDGET")] = None,
) -> None:
    """Electrovibration: the force between a finger and a charged plate, from drive voltage to friction.

    Parameters
    ----------
    version
        Show the versions of electrovib and of the packages it uses.
    budget : TIME,MEMORY
        Time and memory a computation may use, '1 h, 8 GB'; more is refused. Default: 10 min, 4 GB.
    """
    options.refuse_blank(context)
    if budget:
        from electrovib.core import budget as budgets

        context.with_resource(budgets.budget(**budgets.read_budget(budget)))


for _title, _commands in _GROUPS.items():
    for _each in _commands:
        if isinstance(_each, typer.Typer):
            app.add_typer(_each, name="bench", rich_help_panel=_title)
        else:
            _name = _each.__name__.strip("_").replace("_", "-")
            app.command(_name, cls=Command, rich_help_panel=_title)(options.spread_out(_each))


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
        app(prog_name="electrovib")
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
