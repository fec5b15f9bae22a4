"""``electrovib init``."""

from __future__ import annotations

from typing import Annotated

import typer

from electrovib.apps.cli.force import Force


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("init")(command)


def command(
    scenario: Annotated[str, typer.Argument(help="A paper's scenario, or a file.")] = "vezzoli_2014/fig6",
    output: Annotated[str | None, typer.Option("--output", "-o", help="The TOML file to write.")] = None,
    force: Force = False,
) -> None:
    """Print a scenario as a commented TOML file to start from."""
    from electrovib.apps.init import init

    text = init(scenario, output=output, force=force)
    print(text if output is None else f"written: {output}", end="" if output is None else "\n")
