"""``electrovib scenarios``."""

from __future__ import annotations

from typing import Annotated

import typer

from electrovib.apps.cli.completion import scenario_names
from electrovib.apps.cli.terminal import show


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("scenarios")(command)


def command(
    query: Annotated[
        str,
        typer.Argument(
            help="A name, or words to search for: touchscreen, 3M, figure 6, Trapezium; without one, all.",
            show_default=False,
            autocompletion=scenario_names,
        ),
    ] = "",
) -> None:
    """List ready-made scenarios, or search them.

    Each line has the figure or the statement of its paper that the scenario reproduces.
    """
    from electrovib.study import catalogue

    show(str(catalogue.scenarios(query)))
