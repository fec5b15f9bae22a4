"""The option ``--force``, the same for every command that writes."""

from __future__ import annotations

from typing import Annotated, TypeAlias

import typer

Force: TypeAlias = Annotated[
    bool, typer.Option("--force", help="Replace a file that electrovib did not write, or that was changed.")
]
