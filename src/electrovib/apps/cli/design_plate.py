"""``electrovib design-plate``."""

from __future__ import annotations

from typing import Annotated

import typer

from electrovib.apps.cli.completion import scenario_names
from electrovib.apps.cli.force import Force
from electrovib.apps.cli.options import Changes, Models
from electrovib.apps.cli.terminal import say, show


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("design-plate")(command)


def command(
    scenario: Annotated[
        str, typer.Argument(help="A TOML file or a paper's scenario.", autocompletion=scenario_names)
    ],
    over: Annotated[
        list[str] | None,
        typer.Option(
            metavar="PATH=FROM:TO:N[log]",
            help="Vary a parameter, for instance stack.insulator.thickness=1um:20um:10log; repeatable.",
        ),
    ] = None,
    material: Annotated[
        str | None, typer.Option(metavar="A,B,...", help="Materials of the insulator, each with all values.")
    ] = None,
    layer: Annotated[
        str,
        typer.Option(
            metavar="NAME", help="Layer of --material, if the plate has several.", show_default=False
        ),
    ] = "",
    maximise: Annotated[
        list[str] | None,
        typer.Option(
            metavar="QUANTITY",
            help="By default 'mean electrostatic_force'; the first one decides. Repeatable.",
        ),
    ] = None,
    minimise: Annotated[
        list[str] | None,
        typer.Option(
            metavar="QUANTITY",
            help="By default 'peak voltage'; also 'peak current', 'stored energy' or a varied parameter. Repeatable.",
        ),
    ] = None,
    limits: Annotated[
        list[str] | None,
        typer.Option(
            metavar="FILE.toml",
            help="Further limits beside those of the scenario; the strictest counts. Repeatable.",
        ),
    ] = None,
    refine: Annotated[int, typer.Option(metavar="ROUNDS", help="Add candidates around the best one.")] = 0,
    output: Annotated[
        str | None,
        typer.Option(
            "--output", "-o", help="Write all candidates (.csv), a page (.html) or the figure (.png, .svg)."
        ),
    ] = None,
    changes: Changes = None,
    models: Models = None,
    force: Force = False,
) -> None:
    """Find the insulator and the drive with the most force within all limits, what binds there, and the Pareto set."""
    del models  # imported by now
    from electrovib.apps.changes import read_changes
    from electrovib.apps.cli.table import as_text
    from electrovib.apps.progress import tracked
    from electrovib.study.plate import MAXIMISED, MINIMISED
    from electrovib.view.plate import design_plate

    wanted = read_changes(changes or [])
    with tracked("evaluating candidates") as progress:
        found = design_plate(
            scenario,
            over or [],
            materials=[name.strip() for name in (material or "").split(",") if name.strip()],
            layer=layer,
            maximise=maximise or MAXIMISED,
            minimise=minimise or MINIMISED,
            limits=list(limits or []),
            set=wanted,
            refine=refine,
            output=output,
            force=force,
            progress=progress,
        )
    say(found.answer, "")
    for table in found.tables:
        show(as_text(table))
    say(*found.notes)
    if output:
        say(f"written: {output}")
