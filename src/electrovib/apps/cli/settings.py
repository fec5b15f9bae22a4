"""Options before a command: ``electrovib --version``, ``electrovib --budget '1 h, 8 GB' run ...``."""

from __future__ import annotations

from typing import Annotated

import typer

from electrovib.apps.cli.options import Models
from electrovib.apps.cli.terminal import say


def _show(wanted: bool) -> None:
    if wanted:
        from electrovib.core.versions import versions

        for name, number in versions().items():
            say(f"{name} {number}")
        raise typer.Exit


def command(
    context: typer.Context,
    version: Annotated[
        bool,
        typer.Option(
            "--version",
            help="Show the versions of electrovib and of the packages it uses.",
            callback=_show,
            is_eager=True,
        ),
    ] = False,
    models: Models = None,
    budget: Annotated[
        str | None,
        typer.Option(
            metavar="TIME,MEMORY",
            envvar="ELECTROVIB_BUDGET",
            help="Time and memory a computation may use, '1 h, 8 GB'; more is refused. Default: 10 min, 4 GB.",
        ),
    ] = None,
) -> None:
    """Electrovibration: the force between a finger and a charged plate, from drive voltage to friction."""
    del version, models
    if budget is not None:
        from electrovib.core import budget as budgets

        context.with_resource(budgets.budget(**budgets.read_budget(budget)))
