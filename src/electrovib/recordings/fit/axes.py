"""The predictions of a scenario for the signals of a recording over time and over frequency."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.core.errors import ElectrovibError
from electrovib.solve.closed_form.repeated import Repeated
from electrovib.solve.electrics.over_frequency import over_frequency
from electrovib.solve.stack.expand import phasors

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from electrovib.core.arrays import Real
    from electrovib.recordings.fit.measured import Observed
    from electrovib.scenario import Scenario
    from electrovib.solve.one_by_one import ParametricScenario


def along(columns: Sequence[Observed], axis: str) -> tuple[list[int], Real, list[str]]:
    """Return which signals are over one axis, all values of that axis, increasing [s or Hz], and the names of the signals."""
    there = [number for number, each in enumerate(columns) if each.axis == axis]
    stamps = [columns[number].x for number in there]
    same = all(each is stamps[0] or np.array_equal(each, stamps[0]) for each in stamps[1:])
    names = list(dict.fromkeys(columns[number].signal for number in there))
    return there, stamps[0] if same else np.unique(np.concatenate(stamps)), names


def over_time(prepared: ParametricScenario, columns: Sequence[Observed]) -> Repeated | None:
    """Prepare the signals of a recording over time; None where none is over time."""
    if all(each.axis != "time" for each in columns):
        return None
    _, stamps, names = along(columns, "time")
    return Repeated(prepared, names, stamps)


def signals_over_frequency(
    scenario: Scenario, frequency: Real, names: Sequence[str]
) -> dict[str, NDArray[Any]]:
    """Predict signals over frequency, exactly, for the materials as declared."""
    variables = over_frequency(scenario, phasors(scenario, frequency))
    absent = [name for name in names if name not in variables or variables[name][0] != ("frequency",)]
    if absent:
        known = ", ".join(name for name, (dims, _) in variables.items() if dims == ("frequency",))
        raise ElectrovibError(
            f"'{absent[0]}' is not predicted over frequency by this scenario. Known: {known}."
        )
    return {name: np.asarray(variables[name][1]) for name in names}
