"""The wanted quantity as a function of the free parameter."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.budget import Work, allowed, budget, refuse_beyond
from electrovib.solve.costs import CASE, CASE_MEMORY
from electrovib.solve.effort import last_time, works
from electrovib.solve.prepare import Prepared
from electrovib.study.sweep.felt import felt

if TYPE_CHECKING:
    from electrovib.core.diagnostics import Diagnostic
    from electrovib.scenario import Scenario
    from electrovib.study.design.parameter.wanted import Wanted

_EVALUATION_TIMES: Final = 200
"""Approximate number of times at which the solution of an evaluation is computed."""
_LEAST: Final = 5.0
"""Estimated computing time that every evaluation may take [s]."""
_MORE: Final = 5.0
"""Estimated computing time of an evaluation, over that of the scenario as it is, up to which it is made."""


class Evaluation:
    """The wanted quantity as a function of the parameters at the dotted paths `free`; all others keep their values."""

    def __init__(self, scenario: Scenario, wanted: Wanted, free: tuple[str, ...]) -> None:
        self.wanted = wanted
        signal, layer = wanted.signal
        name = wanted.name if wanted.at is None else f"peak {signal}" + (f" in {layer}" if layer else "")
        self.prepared = Prepared(scenario, free=free, quantities=[] if wanted.is_felt else [name])
        self.most = min(allowed().time, max(_LEAST, _MORE * estimate(scenario)))

    def __call__(self, values: Mapping[str, float]) -> float:
        """Compute the quantity for values in SI by path; NaN where it is not known."""
        point = {path: float(value) for path, value in values.items()}
        with budget(time=self.most):
            if self.wanted.is_felt:
                return felt(self.wanted.name, self.prepared.scenario(point))[0]
            if self.wanted.at is not None:
                return self._at_time(point, self.wanted.at)
            return float(self.prepared(point)[self.wanted.name])

    def _at_time(self, point: Mapping[str, float], time: float) -> float:
        signal, layer = self.wanted.signal
        values = self.prepared.signals(point, names=[signal], time=[time])[signal]
        if layer:
            values = values[list(self.prepared.base.stack.layers).index(layer)]
        return float(values[0])

    def scenario(self, values: Mapping[str, float]) -> Scenario:
        """Return the scenario with these values."""
        return self.prepared.scenario(values)

    def warnings(self, values: Mapping[str, float]) -> list[Diagnostic]:
        """Return the diagnostics of the quantity with these values that are not ``ok``, breakdown and limits included."""
        if self.wanted.is_felt:
            return [each for each in felt(self.wanted.name, self.scenario(values))[1] if each.state != "ok"]
        return [each for each in self.prepared.judged(values).diagnostics if each.state != "ok"]


def estimate(scenario: Scenario) -> float:
    """Estimate the computing time of one evaluation of a scenario [s]."""
    times = np.linspace(0.0, last_time(scenario), _EVALUATION_TIMES)
    return CASE + sum(work.time for work in works(scenario, times))


def refuse_long(scenario: Scenario, count: int, *, what: str, remedy: str) -> None:
    """Refuse more evaluations than the budget allows, before the first."""
    work = Work(
        what=f"{count} evaluations for {what}",
        time=count * estimate(scenario),
        memory=CASE_MEMORY + 64.0 * count,
        remedy=remedy,
    )
    refuse_beyond([work], what="this design")
