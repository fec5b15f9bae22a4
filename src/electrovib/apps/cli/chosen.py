"""The values of a paper's ready-made scenario that are not found in the paper, as one line of the terminal."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from electrovib.scenario import Scenario


def chosen(scenario: Scenario, source: str, *, without: Iterable[object] = ()) -> list[str]:
    """List the parameters whose values the paper does not give, in one line; none for a scenario of one's own.

    `source` is what the user named; `without` are dotted paths that are swept, which are omitted.
    """
    from electrovib.scenario import not_in_paper, paper_of_preset

    paper = paper_of_preset(source)
    found = not_in_paper(scenario, paper) if paper else {}
    swept = set(without)
    paths = ", ".join(path for path in found if path not in swept)
    return (
        [f"values not from {paper}: {paths} ('electrovib models {paper}' states their sources)"]
        if paths
        else []
    )
