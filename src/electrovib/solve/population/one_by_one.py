"""Signals of many fingers, each scenario solved by itself."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.errors import InputError
from electrovib.core.signals import SIGNALS
from electrovib.solve.electrics.over_frequency import over_frequency
from electrovib.solve.parametric import ParametricScenario
from electrovib.solve.stack.expand import phasors

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    from electrovib.core.arrays import Real
    from electrovib.scenario import Scenario

KERNEL: Final = "one scenario at a time"
"""Kernel that is stated where no kernel over fingers is used."""


class OneByOne:
    """Fingers of any scenario, each solved by itself.

    Parameters
    ----------
    scenario : Scenario
        Experiment with the values that are the same for all fingers.
    free : sequence of str
        Dotted paths of the parameters that differ between fingers.
    names : sequence of str
        Signals, all over time or all over frequency.
    time : ndarray, shape (n,), optional
        Output times [s]; None for signals over frequency.
    band : ndarray, shape (m,), optional
        Times over whose band materials are reduced [s]; by default the output times.
    """

    def __init__(
        self,
        scenario: Scenario,
        free: Sequence[str],
        names: Sequence[str],
        time: Real | None,
        band: Real | None = None,
    ) -> None:
        self.names, self.time, self.band = tuple(names), time, band
        self.prepared = ParametricScenario(scenario, free)

    def signals(
        self, draws: Mapping[str, Real], *, out: Mapping[str, NDArray[Any]] | None = None
    ) -> dict[str, Any]:
        """Return the signals of fingers."""
        columns = {path: values.tolist() for path, values in draws.items()}
        rows: list[dict[str, Any]] = []
        for finger in range(len(next(iter(columns.values())))):
            point = {path: values[finger] for path, values in columns.items()}
            try:
                rows.append(self._of(point))
            except InputError as error:
                raise of_finger(error, finger, point) from error
        return {
            name: np.stack([row[name] for row in rows], out=(out or {}).get(name), casting="same_kind")
            for name in self.names
        }

    def _of(self, point: Mapping[str, float]) -> dict[str, Any]:
        """Return the signals of one finger."""
        if self.time is not None:
            return self.prepared.signals(point, names=self.names, time=self.time, band=self.band)
        member = self.prepared.scenario(point)
        found = over_frequency(member, phasors(member, member.frequency.frequencies()))
        return {name: found[name][1] for name in self.names}


def of_finger(error: InputError, finger: int, point: Mapping[str, float]) -> InputError:
    """Return the error of one finger, with its index and its values."""
    listed = ", ".join(f"{path} = {value:.6g}" for path, value in point.items())
    return InputError(f"{problem} (finger {finger} of the call: {listed})" for problem in error.problems)


def over_which(names: Sequence[str]) -> str:
    """Return whether signals are over time or over frequency."""
    axes = {SIGNALS[name].dims[-1] for name in names}
    if len(axes) != 1:
        what = "signals over time and signals over frequency" if axes else "no signal"
        raise InputError(f"signals = {', '.join(names)}: {what}; ask for one kind in a call")
    return axes.pop()
