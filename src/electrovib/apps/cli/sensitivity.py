"""``electrovib sensitivity``."""

from __future__ import annotations

from typing import Annotated

import typer

from electrovib.apps.cli.completion import scenario_names
from electrovib.apps.cli.force import Force
from electrovib.apps.cli.options import Changes, Models
from electrovib.apps.cli.terminal import say, show, warned


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("sensitivity")(command)


def command(
    scenario: Annotated[
        str, typer.Argument(help="A TOML file or a paper's scenario.", autocompletion=scenario_names)
    ],
    space: Annotated[
        str, typer.Argument(help="A population such as fingers, or a TOML file with distributions.")
    ],
    quantity: Annotated[
        str, typer.Option(metavar="QUANTITY", help="For instance 'mean electrostatic_force', as for run.")
    ],
    n: Annotated[int, typer.Option("-n", help="Number of base draws, a power of 2.")],
    seed: Annotated[int, typer.Option(help="Seed of the draws.")],
    changes: Changes = None,
    output: Annotated[
        str | None,
        typer.Option(
            "--output",
            "-o",
            metavar="DIR",
            help="Folder for report.html, indices.csv, elasticities.csv and space.toml.",
        ),
    ] = None,
    models: Models = None,
    force: Force = False,
) -> None:
    """Report which parameters a quantity depends on most.

    The parameters vary as in a population; report also which to measure first.
    """
    del models  # imported by now
    from electrovib.apps.changes import read_changes
    from electrovib.apps.cli.table import as_text
    from electrovib.apps.progress import tracked
    from electrovib.scenario import read_scenario
    from electrovib.view.sensitivity import sensitivity

    base = read_scenario(scenario, changes=read_changes(changes)) if changes else scenario
    with tracked("evaluating draws") as progress:
        found = sensitivity(
            base, space, quantity=quantity, n=n, seed=seed, output=output, force=force, progress=progress
        )
    say(found.answer, "")
    for table in found.tables:
        show(as_text(table))
    say(*warned(found), *found.space.remarks)
    if output:
        say(f"written: {output}")
