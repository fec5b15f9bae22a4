"""``electrovib design-plate``."""

from __future__ import annotations

from typing import Annotated, Final

import typer

from electrovib.apps.cli.completion import scenario_names
from electrovib.apps.cli.design_options import Limits
from electrovib.apps.cli.design_plate_options import (
    LayerOf,
    Material,
    Maximise,
    Minimise,
    Output,
    Over,
    Refine,
)
from electrovib.apps.cli.force import Force
from electrovib.apps.cli.options import Changes, Models
from electrovib.apps.cli.terminal import say, show, warned

EXAMPLE: Final = "electrovib design-plate bau_2010/sine --over drive.amplitude=20V:200V:5"


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("design-plate")(command)


def command(
    scenario: Annotated[
        str, typer.Argument(help="A TOML file or a paper's scenario.", autocompletion=scenario_names)
    ],
    over: Over = None,
    material: Material = None,
    layer: LayerOf = "",
    maximise: Maximise = None,
    minimise: Minimise = None,
    limits: Limits = None,
    refine: Refine = None,
    output: Output = None,
    changes: Changes = None,
    models: Models = None,
    force: Force = False,
) -> None:
    """Find the insulator and the drive with the most force.

    All limits are respected; state which of them binds there, and the Pareto set.
    """
    del models  # imported by now
    from electrovib.apps.changes import read_changes
    from electrovib.apps.cli.table import as_text
    from electrovib.apps.progress import tracked
    from electrovib.study.design.plate import MAXIMISED, MINIMISED, ROUNDS
    from electrovib.view.plate import design_plate

    with tracked("evaluating candidates") as progress:
        found = design_plate(
            scenario,
            over or [],
            materials=[name.strip() for name in (material or "").split(",") if name.strip()],
            layer=layer,
            maximise=maximise or MAXIMISED,
            minimise=minimise or MINIMISED,
            limits=list(limits or []),
            set=read_changes(changes or []),
            refine=ROUNDS if refine is None else refine,
            output=output,
            force=force,
            progress=progress,
        )
    say(found.answer, "")
    for table in found.tables:
        show(as_text(table))
    say(*warned(found), *found.notes)
    if output:
        say(f"written: {output}")
