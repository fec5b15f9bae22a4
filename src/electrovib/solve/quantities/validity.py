"""Validity of the numbers that are computed from a scenario: the diagnostics of its run."""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING

from electrovib.core.diagnostics import Diagnostic
from electrovib.core.errors import ElectrovibError
from electrovib.solve.expanded import Expanded
from electrovib.solve.quantities.answer import declared_mean_squares

if TYPE_CHECKING:
    from electrovib.scenario import Scenario


@functools.lru_cache(maxsize=8)
def validity(scenario: Scenario) -> tuple[Diagnostic, ...]:
    """Judge a scenario, for every result that is no Trace of it."""
    try:
        expanded = Expanded(scenario)
        record = expanded.at(expanded.times, closely=True)
        return tuple(expanded.judge(record, declared_mean_squares)[0])
    except ElectrovibError as error:
        text = (
            f"the validity of this scenario is not known, because it cannot be simulated: {error.problems[0]}"
        )
        return (Diagnostic("validity", "unknown", text),)
