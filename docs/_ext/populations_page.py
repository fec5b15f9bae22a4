"""The shipped populations of fingers as a page of the documentation."""

from __future__ import annotations

from typing import Final

from rst import markdown

from electrovib.core.citation import STATUSES_EXPLAINED
from electrovib.scenario.space.shipped import shipped_names
from electrovib.studies.catalogue.found import HEADINGS, caption_of, entries_of, title_of

EXAMPLE: Final = """schema = 1
title = "fingers of our laboratory"
relations = ["stack.insulator.thickness < stack.stratum_corneum.thickness"]

[space]
"stack.insulator.thickness" = { model = "Uniform", low = "80 um", high = "100 um" }
"stack.stratum_corneum.thickness" = { model = "LogNormal", median = "200 um", factor = 1.2, high = "400 um" }
"friction.coefficient" = { model = "Normal", mean = 0.5, deviation = 0.1, low = 0.1, source = "our rig", status = "full text" }
"load.normal_force" = { model = "Empirical", values = ["0.4 N", "0.5 N", "0.7 N"] } # or file = "loads.csv", column = "load [N]"

[correlation]
"friction.coefficient ~ load.normal_force" = -0.4

[groups.moisture.dry]
share = 0.7
space."stack.stratum_corneum.material.conductivity" = { model = "LogUniform", low = "2 uS/m", high = "4 uS/m" }

[groups.moisture.moist]
share = 0.3
space."stack.stratum_corneum.material.conductivity" = { model = "LogUniform", low = "20 uS/m", high = "40 uS/m" }
"""
"""A space file; a test reads it."""
INTRODUCTION: Final = f"""# Populations of fingers

Probability distributions of the values in which fingers differ, for studies of many fingers and analyses of sensitivity:
`electrovib study SCENARIO --space fingers --sensitivity ...`, or `ev.read_space(SCENARIO, "fingers")`.
The page is made from the declarations, and a test keeps it as they are.

A population of one's own is a TOML file; `space.toml` of `electrovib fit` is one. Numbers are in SI, or texts with a unit:

```toml
{EXAMPLE}```

A correlation is the coefficient of a Gaussian copula: the rank correlation is 6/pi asin(r/2), whatever the distributions. A draw
that does not fulfil a relation is repeated, with the parameters that depend on it. Draw i depends on the seed, the path and i
alone. A distribution that can leave the range of its parameter is refused; `low` and `high` truncate it.

*Status* is how the source of the numbers was read: {STATUSES_EXPLAINED}. *Confidence* is how far the numbers are those of
fingertips, as judged here. What no source gives is called a choice. Unverified distributions are reported wherever the
population is used, and so are parameters that a scenario does not have.

Distributions: `Normal` (mean, deviation), `LogNormal` (median, factor: two thirds of all values lie between median/factor and
median times factor), `Uniform`, `LogUniform` (the logarithm is uniform), `Triangular` (low, likely, high), `Empirical` (values,
or file and column); low and high truncate any of them. Groups divide the population: of every division each finger
belongs to one group, with the stated share.
"""


def as_markdown() -> str:
    """Write the page: for each population a table of its distributions with their sources."""
    return INTRODUCTION + "".join(_section(name) for name in shipped_names())


def _section(name: str) -> str:
    entries = list(entries_of(name))
    table = markdown(HEADINGS, [each.row for each in entries])
    title = title_of(name)
    return f"\n## {name}\n\n{title[0].upper()}{title[1:]}. {caption_of(entries)}\n\n{table}"


if __name__ == "__main__":
    print(as_markdown(), end="")
