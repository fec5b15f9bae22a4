"""Signals of a scenario for many values of a few parameters at the same output times, as a fit needs them."""

from __future__ import annotations

from collections import OrderedDict
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.errors import InputError
from electrovib.core.signals import without
from electrovib.solve.closed_form.chain import ClosedElectrics, filter_of, offers
from electrovib.solve.electrics.over_frequency import capacitance, sine_of
from electrovib.solve.expanded import Expanded

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from electrovib.core.arrays import Real
    from electrovib.scenario import Scenario
    from electrovib.solve.mechanics.filters import Filter
    from electrovib.solve.one_by_one import ParametricScenario

_MECHANICAL: Final = frozenset({"friction", "finger", "rig"})
"""Parts of a scenario on which no electrical quantity depends."""
_KEPT: Final = 3
"""Number of electrical responses that are kept: a search returns to the point at which it computed derivatives."""


class Repeated:
    """Signals over time at fixed output times, as a function of the free parameters of a prepared scenario.

    Parameters
    ----------
    prepared : ParametricScenario
        Scenario and free parameters.
    names : sequence of str
        Names of signals over time.
    time : ndarray, shape (n,)
        Output times, increasing, >= 0 [s].

    Notes
    -----
    Linear layers under a drive of few straight pieces, with a law of second degree and linear friction and sensors behind it,
    are evaluated in closed form; all others as by `Prepared.signals`. The two differ by less than 1e-9 of the largest value
    in electrical signals, and by the stated error of the mechanics, at most 1e-6, in those behind a sensor or a skin.
    Electrical responses of the last few points are kept, so that another friction, finger or rig needs none of them again.
    """

    def __init__(self, prepared: ParametricScenario, names: Sequence[str], time: Real) -> None:
        self._prepared, self._time = prepared, time
        self._names = tuple(name for name in names if name != "capacitance")
        self._has_capacitance = len(self._names) < len(names)
        if self._has_capacitance and sine_of(prepared.base) is None:
            raise InputError(without("capacitance", ()))
        self._electrical = tuple(path for path in prepared.free if path.split(".")[0] not in _MECHANICAL)
        self._kept: OrderedDict[tuple[float, ...], tuple[Expanded, ClosedElectrics | None]] = OrderedDict()
        self._last: Expanded | None = None
        self._closed: ClosedElectrics | None = None
        self._filters: dict[str, tuple[tuple[Any, ...], Filter]] = {}

    def signals(self, values: Mapping[str, float]) -> dict[str, Real]:
        """Compute the signals."""
        scenario = self._prepared.scenario(values)
        own = capacitance(scenario, self._time) if self._has_capacitance else {}
        read = {name: row for name, (_, row) in own.items()}
        return read if not self._names else self._solved(scenario, values) | read

    def _solved(self, scenario: Scenario, values: Mapping[str, float]) -> dict[str, Real]:
        """Compute the signals that follow from the response to the drive."""
        expanded, closed = self._electrics(scenario, values)
        if closed is not None:
            found = closed.signals(scenario, self._time, self._names, find=self._filter_of)
            if found is not None:
                return found
        if expanded.scenario is not scenario:
            expanded = Expanded(scenario, self._time, before=expanded)
        record = expanded.at(self._time, wanted=self._names)
        missing = [name for name in self._names if name not in record.signals]
        if missing:
            raise InputError(without(missing[0], record.signals))
        return {name: np.asarray(record.signals[name][1]) for name in self._names}

    def _filter_of(self, scenario: Scenario, name: str) -> Filter:
        """Return the filter of a signal, the last one where nothing that it depends on has changed."""
        parts = (scenario.friction, scenario.finger, scenario.rig, scenario.motion)
        kept = self._filters.get(name)
        if kept is None or any(one is not other for one, other in zip(kept[0], parts, strict=True)):
            kept = self._filters[name] = (parts, filter_of(scenario, name))
        return kept[1]

    def _electrics(
        self, scenario: Scenario, values: Mapping[str, float]
    ) -> tuple[Expanded, ClosedElectrics | None]:
        """Return modes and, where it exists, the closed form of a point; those kept where they depend on the same values."""
        point = self._prepared.begin | dict(values)
        key = tuple(point[path] for path in self._electrical)
        if key in self._kept:
            self._kept.move_to_end(key)
            return self._kept[key]
        expanded = Expanded(scenario, self._time, before=self._last)
        closed = None
        if offers(scenario, self._names):
            closed = ClosedElectrics.of(
                scenario, expanded.section, self._time, self._names, before=self._closed
            )
        self._last, self._closed = expanded, closed or self._closed
        self._kept[key] = expanded, closed
        if len(self._kept) > _KEPT:
            self._kept.popitem(last=False)
        return expanded, closed
