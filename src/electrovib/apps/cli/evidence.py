"""``electrovib evidence``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Final

import typer

from electrovib.apps.cli import options
from electrovib.apps.cli.answers import answered
from electrovib.apps.cli.terminal import show

if TYPE_CHECKING:
    from electrovib.studies.evidence import Evidence

EXAMPLE: Final = "electrovib evidence vezzoli -o evidence"


def command(
    word: Annotated[
        str, typer.Argument(help="Part of the name, title or group of measurements; all if absent.")
    ] = "",
    output: Annotated[
        str | None,
        typer.Option("--output", "-o", help="Page (.html), or a folder with the page and its tables."),
    ] = None,
    n: Annotated[int, typer.Option("-n", min=2, help="Draws of what a publication does not print.")] = 64,
    seed: Annotated[int, typer.Option(min=0, help="Of the draws.")] = 0,
    everything: options.Everything = False,
    force: options.Force = False,
) -> None:
    """Judge every law by what was measured.

    Each law is compared with every published measurement that it can predict.
    """
    from electrovib.apps.progress import items_shown
    from electrovib.studies.evidence import Evidence, evidence

    with items_shown("comparing with measurements"):
        answered(
            Evidence,
            evidence,
            words="comparing with measurements",
            output=output,
            force=force,
            show=lambda found: _show(found, everything=everything),
            measured=word,
            n=n,
            seed=seed,
        )


def _show(found: Evidence, *, everything: bool) -> None:
    """Print the failures and the laws; with everything also the measurements, and what could not be predicted."""
    said = found.document
    show("\n".join([*said.sentences, "", *map(str, said.numbers), ""]))
    for table in said.tables if everything else ():
        show(str(table))
    show("\n".join(said.remarks if everything else said.remarks[:1]))
