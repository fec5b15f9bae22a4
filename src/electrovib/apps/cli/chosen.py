"""What a paper's ready-made scenario does not find in its paper, as one line of the terminal."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from electrovib.scenario import Scenario


def chosen(scenario: Scenario, source: str, *, without: Iterable[object] = ()) -> list[str]:
    """Name the values that the paper does not give; nothing of a scenario of one's own.

    Parameters
    ----------
    scenario : Scenario
        As it was run.
    source : str
        What the user asked for: a file, or a paper's scenario such as ``vezzoli_2014/fig6``.
    without : iterable of str
        Paths that are swept.

    Returns
    -------
    list of str
        One line, or none.
    """
    from electrovib.scenario import not_in_paper, paper_of_preset

    paper = paper_of_preset(source)
    found = not_in_paper(scenario, paper) if paper else {}
    swept = set(without)
    values = ", ".join(f"{path} {value}" for path, value in found.items() if path not in swept)
    told = f"not found in {paper}, chosen or derived here: {values} ('electrovib models {paper}' says how)"
    return [told] if values else []
