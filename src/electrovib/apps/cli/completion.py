"""Names that the shell completes: of ready-made scenarios, of papers, of models."""

from __future__ import annotations

from collections.abc import Iterator

import typer


def scenario_names(incomplete: str) -> Iterator[str]:
    """Complete the name of a paper's scenario; only the paper that is already written is imported.

    Where several papers can be meant, their names are offered with a slash: ``author_year/``.
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
    """Complete the name of a model, a paper, a material, a skin or a scenario, with what it is."""
    from electrovib.studies.catalogue.items import everything

    for item in everything():
        if item.record.name.startswith(incomplete):
            yield item.record.name, item.record.kind


def paper_names(incomplete: str) -> Iterator[str]:
    """Complete the name of a paper, without importing it."""
    from electrovib.core import discovery

    yield from (name for name in discovery.paper_names() if name.startswith(incomplete))


def quantity_names(incomplete: str) -> Iterator[str]:
    """Complete the name of a quantity of a scenario."""
    from electrovib.core.signals import SIGNALS
    from electrovib.solve.quantities.names import TAKEN, signals_over_time

    for signal in signals_over_time():
        where = " in" if "layer" in SIGNALS[signal].dims else ""
        yield from (name for taken in TAKEN if (name := f"{taken} {signal}{where}").startswith(incomplete))


def space_names(incomplete: str) -> Iterator[str]:
    """Complete the name of a shipped population."""
    from electrovib.scenario.space.shipped import shipped_names

    yield from (name for name in shipped_names() if name.startswith(incomplete))


def parameter_paths(ctx: typer.Context, incomplete: str) -> Iterator[tuple[str, str]]:
    """Complete the dotted path of a physical parameter of the scenario that stands before it, with what it means."""
    from electrovib.core.errors import ElectrovibError
    from electrovib.scenario import read_scenario

    try:
        # the parser stops at an option without its value, and leaves the arguments before it unassigned
        scenario = read_scenario(ctx.params.get("scenario") or next(iter(ctx.args), ""))
    except ElectrovibError:
        return
    for path, _, quantity in scenario.parameters():
        if path.startswith(incomplete):
            yield path, quantity.doc
