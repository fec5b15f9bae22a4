"""``electrovib --version``."""

from __future__ import annotations

from typing import Annotated

import typer

from electrovib.apps.cli.terminal import say


def register(app: typer.Typer) -> None:
    """Add the option."""
    app.callback()(command)


def _show(wanted: bool) -> None:
    if wanted:
        from electrovib.core.versions import versions

        for name, number in versions().items():
            say(f"{name} {number}")
        raise typer.Exit


def command(
    version: Annotated[
        bool,
        typer.Option(
            "--version", help="Show the versions of electrovib and its parts.", callback=_show, is_eager=True
        ),
    ] = False,
) -> None:
    """Electrovibration: the force between a finger and a charged plate, from drive voltage to friction."""
    del version
