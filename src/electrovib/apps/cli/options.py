"""Options that several commands share."""

from __future__ import annotations

from typing import Annotated, TypeAlias

import typer


def _use(context: typer.Context, files: list[str] | None) -> list[str] | None:
    if files and not context.resilient_parsing:
        from electrovib.core.own_models import use_models

        for file in files:
            use_models(file)
    return files


Models: TypeAlias = Annotated[
    list[str] | None,
    typer.Option(
        "--models",
        metavar="FILE.py",
        help="Python file with models of your own, which can then be named in a scenario; repeatable.",
        callback=_use,
        is_eager=True,
    ),
]
Changes: TypeAlias = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="PATH=VALUE",
        help="Change a parameter, or add an optional part: --set stack.gap='{ thickness = \"5 um\" }'; repeatable.",
    ),
]
Everything: TypeAlias = Annotated[
    bool, typer.Option("--all", help="Print also the explanations, assumptions and sources.")
]
