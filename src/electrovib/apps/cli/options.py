"""Options that several commands share."""

from __future__ import annotations

from typing import Annotated, TypeAlias

import typer

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
