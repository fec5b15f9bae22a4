"""The wanted quantity of many fingers as a function of the free parameter, each finger one draw from a space."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.errors import ElectrovibError, InputError
from electrovib.study.design.parameter.evaluation import Evaluation

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.scenario import Scenario
    from electrovib.study.design.parameter.wanted import Wanted

_QUADRATIC: Final = 1e-7
"""Largest relative deviation from the square of the free parameter, at any of the values at which it is compared."""
_FEW: Final = 3
"""DrawnFingers with which a shortcut is compared with the general solution."""


@dataclass(frozen=True)
class DrawnFingers:
    """Draws from a space, values in SI by dotted path, and the quantity of each of them."""

    scenario: Scenario
    wanted: Wanted
    draws: Mapping[str, Real]

    @property
    def count(self) -> int:
        """Number of fingers."""
        return len(next(iter(self.draws.values())))

    def draw(self, finger: int) -> dict[str, float]:
        """Return the values of one finger, in SI."""
        return {path: float(values[finger]) for path, values in self.draws.items()}

    def member(self, finger: int, at: float) -> Scenario:
        """Return the scenario of a finger with a value of the free parameter."""
        return self.scenario.replace({**self.draw(finger), self.wanted.free: at})

    def evaluation(self) -> Evaluation:
        """Return the quantity as a function of the parameters that vary."""
        return Evaluation(self.scenario, self.wanted, (*self.draws, self.wanted.free))

    def each_at(
        self,
        at: float,
        *,
        evaluation: Evaluation | None = None,
        progress: Callable[[int, int], None] | None = None,
    ) -> Real:
        """Compute the quantity of every finger at one value of the free parameter; one that is not known is refused."""
        together = self.together_at(at, progress=progress)
        if together is not None:
            return together
        own = evaluation or self.evaluation()
        found = np.empty(self.count)
        for finger in range(self.count):
            if progress is not None:
                progress(finger, self.count)
            found[finger] = self.one_at(own, finger, at)
        return found

    def together_at(self, at: float, *, progress: Callable[[int, int], None] | None = None) -> Real | None:
        """Compute the quantity of every finger in arrays at one value of the free parameter; None where there are none."""
        held = self.scenario.replace({self.wanted.free: at})
        others = {path: values for path, values in self.draws.items() if path != self.wanted.free}
        return Evaluation(held, self.wanted, tuple(others)).of_many(others, progress=progress)

    def one_at(self, evaluation: Evaluation, finger: int, at: float) -> float:
        """Compute the quantity of one finger by the general solution; one that is not known is refused."""
        try:
            value = evaluation({**self.draw(finger), self.wanted.free: at})
        except ElectrovibError as error:
            raise InputError(
                f"draw {finger}, {self.wanted.free} = {self.wanted.parameter(at)}: {error.problems[0]}"
            ) from error
        if math.isnan(value):
            raise InputError(
                f"draw {finger}, {self.wanted.free} = {self.wanted.parameter(at)}: {self.wanted.name} is not known"
            )
        return value

    def some(self) -> list[int]:
        """Return the indices of a few fingers: the first, the middle and the last one."""
        return [int(each) for each in np.unique(np.linspace(0, self.count - 1, _FEW).astype(int))]

    def is_quadratic(self) -> bool:
        """Return whether a few fingers have a quantity proportional to the square of the free parameter."""
        wanted, evaluation = self.wanted, self.evaluation()
        begin = reference(wanted)
        others = {begin / 2, 2 * begin, wanted.low, wanted.high} - {begin}
        others = {each for each in others if each > 0 and wanted.low <= each <= wanted.high}
        for finger in self.some():
            try:
                first = self.one_at(evaluation, finger, begin)
                for at in others:
                    expected = first * (at / begin) ** 2
                    if not abs(self.one_at(evaluation, finger, at) - expected) <= _QUADRATIC * abs(expected):
                        return False
            except ElectrovibError:
                return False
            if not first > 0:
                return False
        return bool(others)


def reference(wanted: Wanted) -> float:
    """Return the value of the free parameter at which gains are computed: the present one, or the middle of the range."""
    if wanted.low <= wanted.begin <= wanted.high and wanted.begin > 0:
        return wanted.begin
    return math.sqrt(wanted.low * wanted.high) if wanted.low > 0 else (wanted.low + wanted.high) / 2
