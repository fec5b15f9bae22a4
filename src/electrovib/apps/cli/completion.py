"""Names that the shell completes: of ready-made scenarios, of papers, of models."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, Final, get_args, get_type_hints

import typer


def scenario_names(incomplete: str) -> Iterator[str]:
    """Complete the name of a paper's scenario; only the paper that is already written is imported.

    Parameters
    ----------
    incomplete : str
        What stands on the command line.

    Yields
    ------
    str
        ``author_year/name``; ``author_year/`` where several papers can be meant.
    """
    from electrovib.core.discovery import offers, paper_names

    author_year, slash, _ = incomplete.partition("/")
    papers = [
        name for name in paper_names() if name == author_year or (not slash and name.startswith(author_year))
    ]
    if len(papers) > 1:
        yield from (f"{name}/" for name in papers)
        return
    for name in papers:
        yield from (
            found for found in offers(("scenarios",), of=name) if found.startswith(incomplete) or not slash
        )


def model_names(incomplete: str) -> Iterator[tuple[str, str]]:
    """Complete the name of a model, a paper, a material, a skin or a scenario.

    Parameters
    ----------
    incomplete : str
        What stands on the command line.

    Yields
    ------
    tuple of str
        Name, and what it is.
    """
    from electrovib.study.catalogue.items import everything

    for item in everything():
        if item.record.name.startswith(incomplete):
            yield item.record.name, item.record.kind


def paper_names(incomplete: str) -> Iterator[str]:
    """Complete the name of a paper, without importing it.

    Parameters
    ----------
    incomplete : str
        What stands on the command line.

    Yields
    ------
    str
        ``author_year``.
    """
    from electrovib.core import discovery

    yield from (name for name in discovery.paper_names() if name.startswith(incomplete))


ARGUMENTS: Final[dict[str, Callable[[str], Iterator[Any]]]] = {
    "scenario": scenario_names,
    "paper": paper_names,
}
"""Name of an argument, in whatever command, to what completes it."""


def complete_arguments(app: typer.Typer) -> None:
    """Let the shell complete the arguments of all registered commands that take a name of `ARGUMENTS`.

    Parameters
    ----------
    app : typer.Typer
        With its commands and groups of commands; an argument that declares a completion of its own keeps it.
    """
    for group in app.registered_groups:
        assert group.typer_instance is not None
        complete_arguments(group.typer_instance)
    for command in app.registered_commands:
        assert command.callback is not None
        hints = get_type_hints(command.callback, include_extras=True)
        for name in ARGUMENTS.keys() & hints.keys():
            for declared in get_args(hints[name])[1:]:
                declared.autocompletion = declared.autocompletion or ARGUMENTS[name]
            command.callback.__annotations__[name] = hints[name]
