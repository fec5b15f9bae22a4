"""``electrovib models``."""

from __future__ import annotations

from types import ModuleType
from typing import Annotated

import typer

from electrovib.apps.cli.completion import model_names
from electrovib.apps.cli.terminal import show


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("models")(command)


def command(
    query: Annotated[
        str,
        typer.Argument(
            help="A name, or a word to search for; without one, an overview.",
            show_default=False,
            autocompletion=model_names,
        ),
    ] = "",
    complete: Annotated[bool, typer.Option("--all", help="List every entry on a line of its own.")] = False,
    bibtex: Annotated[bool, typer.Option("--bibtex", help="Print BibTeX: of one paper, or of all.")] = False,
) -> None:
    """Show or search models, materials and papers.

    Without a name an overview; with the name of one entry everything about it; else what the words find.
    """
    from electrovib.study import catalogue

    if bibtex:
        _print_bibtex(query)
    else:
        show(str(catalogue.models(query, complete=complete)))


def _print_bibtex(name: str) -> None:
    from electrovib.core.discovery import paper_of, papers
    from electrovib.core.errors import InputError
    from electrovib.study import catalogue

    wanted = list(papers())
    if name:
        found = catalogue.find(name)
        wanted = [name if isinstance(found, ModuleType) else paper_of(found)]
        if wanted == [""]:
            raise InputError(f"'{name}' belongs to no paper; its reference: {found.reference or 'none'}")
    show("\n\n".join(catalogue.bibtex(papers()[key], key) for key in wanted))
