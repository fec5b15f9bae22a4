"""Options of ``electrovib design-plate``."""

from __future__ import annotations

from typing import Annotated, TypeAlias

import typer

Over: TypeAlias = Annotated[
    list[str] | None,
    typer.Option(
        metavar="PATH=FROM:TO:N[log]",
        help="Vary a parameter, for instance stack.insulator.thickness=1um:20um:10log; repeatable.",
    ),
]
Material: TypeAlias = Annotated[
    str | None, typer.Option(metavar="A,B,...", help="Materials of the insulator, each with all values.")
]
LayerOf: TypeAlias = Annotated[
    str,
    typer.Option(metavar="NAME", help="Layer of --material, if the plate has several.", show_default=False),
]
Maximise: TypeAlias = Annotated[
    list[str] | None,
    typer.Option(
        metavar="QUANTITY", help="By default 'mean electrostatic_force'; the first one decides. Repeatable."
    ),
]
Minimise: TypeAlias = Annotated[
    list[str] | None,
    typer.Option(
        metavar="QUANTITY",
        help="By default 'peak voltage'; also 'peak current', 'stored energy' or a varied parameter. Repeatable.",
    ),
]
Refine: TypeAlias = Annotated[
    int | None,
    typer.Option(
        metavar="ROUNDS",
        help="Rounds of candidates added around the best one, each at half the distance; 3 by default, 0 for none.",
        show_default=False,
    ),
]
Output: TypeAlias = Annotated[
    str | None,
    typer.Option(
        "--output", "-o", help="Write all candidates (.csv), a page (.html) or the figure (.png, .svg)."
    ),
]
