"""``electrovib spaces``."""

from __future__ import annotations

from typing import Annotated

import typer

from electrovib.apps.cli.terminal import show


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("spaces")(command)


def command(
    name: Annotated[
        str,
        typer.Argument(help="A population, for instance fingers; without one, all.", show_default=False),
    ] = "",
) -> None:
    """List populations of fingers.

    With a name, list the distributions of that population with their sources.
    """
    from electrovib.study import catalogue

    show(str(catalogue.spaces(name)))
