"""Names that the shell completes: of ready-made scenarios, of models, of force laws."""

from __future__ import annotations

from collections.abc import Iterator


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
