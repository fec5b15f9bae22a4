"""The shipped populations of fingers as a page of the documentation."""

from __future__ import annotations

from typing import Final

from electrovib.core.status import STATUSES_EXPLAINED
from electrovib.scenario.space.shipped import shipped_names
from electrovib.study.catalogue.populations import HEADINGS, caption_of, entries_of, title_of

INTRODUCTION: Final = f"""# Populations of fingers

Probability distributions of the values in which fingers differ, for studies of many fingers and analyses of sensitivity:
`electrovib sensitivity SCENARIO fingers ...`, or `ev.read_space(SCENARIO, "fingers")`. A space of one's own is a TOML file of
the same form, which `ev.read_space(...).to_toml()` writes. The page is made from the declarations, and a test keeps it as they
are.

*Status* is how the source of the numbers was read: {STATUSES_EXPLAINED}. *Confidence* is how far the numbers are those of
fingertips, as judged here. What no source gives is called a choice. Unverified distributions are reported wherever the
population is used, and so are parameters that a scenario does not have.

Distributions: `Normal` (mean, deviation), `LogNormal` (median, factor: two thirds of all values lie between median/factor and
median times factor), `Uniform`, `LogUniform` (the logarithm is uniform), `Triangular` (low, likely, high), `Empirical` (values,
or file and column); low and high truncate any of them. Groups divide the population: of every division each finger
belongs to one group, with the stated share.
"""


def as_markdown() -> str:
    """Write the page: for each population a table of its distributions with their sources.

    Returns
    -------
    str
        Markdown.
    """
    return INTRODUCTION + "".join(_section(name) for name in shipped_names())


def _section(name: str) -> str:
    entries = list(entries_of(name))
    lines = [HEADINGS, tuple("---" for _ in HEADINGS), *(each.row for each in entries)]
    table = "\n".join(f"| {' | '.join(cell.replace('|', '/') for cell in line)} |" for line in lines)
    title = title_of(name)
    return f"\n## {name}\n\n{title[0].upper()}{title[1:]}. {caption_of(entries)}\n\n{table}\n"
