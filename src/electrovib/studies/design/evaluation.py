"""The wanted quantity as a function of the parameters that are free or drawn."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.budget import BudgetError, allowed, budget
from electrovib.core.errors import ElectrovibError, InputError
from electrovib.solve.meter import clock
from electrovib.solve.population.fingers import TOGETHER
from electrovib.solve.prepare import Prepared
from electrovib.studies.sweep.run import felt

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.core.diagnostics import Diagnostic
    from electrovib.scenario import Scenario
    from electrovib.studies.design.wanted import Wanted

_LEAST: Final = 5.0
"""Computing time that every evaluation may take [s]."""
_MORE: Final = 5.0
"""Computing time that an evaluation may take, over that of the scenario as it is."""


class Evaluation:
    """The wanted quantity as a function of the parameters at the dotted paths `free`; all others keep their values."""

    def __init__(self, scenario: Scenario, wanted: Wanted, free: tuple[str, ...]) -> None:
        self.wanted = wanted
        signal, layer = wanted.signal
        name = wanted.name if wanted.at is None else f"peak {signal}" + (f" in {layer}" if layer else "")
        self.prepared = Prepared(scenario, free=free, quantities=[] if wanted.is_felt else [name])

    @functools.cached_property
    def most(self) -> float:
        """Computing time that an evaluation may take [s]; of the scenario as it is one is made, which may take the budget."""
        began = clock()
        try:
            self._at({path: value for path, value in self.prepared.begin.items() if value is not None})
        except BudgetError:
            raise
        except ElectrovibError:  # each evaluation states why it cannot be made
            pass
        return min(allowed().time, max(_LEAST, _MORE * (clock() - began)))

    def __call__(self, values: Mapping[str, float]) -> float:
        """Compute the quantity for values in SI by path; NaN where it is not known."""
        most = self.most
        try:
            with budget(time=most):
                return self._at({path: float(value) for path, value in values.items()})
        except BudgetError as error:  # of this evaluation, not of the design
            raise InputError(error.problems) from None

    def of_many(
        self, draws: Mapping[str, Real], *, progress: Callable[[int, int], None] | None = None
    ) -> Real | None:
        """Compute the quantity of many points in arrays; None without arrays, or where one is refused or not known."""
        if self.wanted.is_felt or self.wanted.at is not None or self.prepared.method != TOGETHER:
            return None
        try:
            found: Real = self.prepared(draws, progress=progress)[self.wanted.name]
        except BudgetError:
            raise
        except ElectrovibError:
            return None
        return None if np.isnan(found).any() else found

    def _at(self, point: dict[str, float]) -> float:
        wanted, prepared = self.wanted, self.prepared
        if wanted.is_felt:
            return felt(wanted.name, prepared.scenario(point))[0]
        if wanted.at is None:
            return float(prepared(point)[wanted.name])
        signal, layer = wanted.signal
        values = prepared.signals(point, names=[signal], time=[wanted.at])[signal]
        return float(values[list(prepared.base.stack.layers).index(layer)][0] if layer else values[0])

    def scenario(self, values: Mapping[str, float]) -> Scenario:
        """Return the scenario with these values."""
        return self.prepared.scenario(values)

    def warnings(self, values: Mapping[str, float]) -> list[Diagnostic]:
        """Return the diagnostics of the quantity with these values that are not ``ok``, breakdown and limits included."""
        if self.wanted.is_felt:
            found = felt(self.wanted.name, self.scenario(values))[1]
        else:
            found = list(self.prepared.judged(values).diagnostics)
        return [each for each in found if each.state != "ok"]
