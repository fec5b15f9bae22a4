"""Numbers that somebody measured, as data: the set-up as a scenario, what was varied, the values, and what was not printed."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np

from electrovib.core.arrays import Real
from electrovib.core.citation import STATUSES, UNVERIFIED
from electrovib.core.errors import InputError, gathered, nearest
from electrovib.core.paths import quantity_at, words_at
from electrovib.core.units import KINDS
from electrovib.data.unit_words import kind_and_factor
from electrovib.scenario import Scenario
from electrovib.solve.quantities.names import read_name

PRINTED, DATA, FIGURE, QUOTED = "printed", "data file", "read from a figure", "quoted by others"
HOW: Final = (PRINTED, DATA, FIGURE, QUOTED)
"""How a number came here, from best to worst."""
SPREADS: Final = ("people", "repeats", "devices", "digits", "a choice")
"""What a spread is: between people, between repeats on one rig, between devices, the printed digits; or assumed here."""

AT_LEAST, AT_MOST = "at least", "at most"
BOUNDS: Final = ("", AT_LEAST, AT_MOST)
"""What a printed number is of the quantity: its value, or a bound of it."""


def unit_of(quantity: str, per: str, scenario: Scenario) -> str:
    """Return the SI unit of a quantity of a scenario, by its name, or of its quotient with a second one."""
    own, *under = (read_name(each, tuple(scenario.stack.layers)).unit for each in (quantity, per) if each)
    if not under:
        return own
    found = kind_and_factor(f"{own}/{under[0].replace('/', '*')}")
    if found is None and own not in under:
        raise InputError(f"per = '{per}': there is no unit for {own} over {under[0]}")
    return found[0] if found else "1"


def check_unit(unit: str, quantity: str, per: str, scale: float, scenario: Scenario) -> None:
    """Refuse the name of a quantity that does not exist, and a unit that is not its own where no scale converts it."""
    own = unit_of(quantity, per, scenario)
    if unit not in KINDS:
        if known := kind_and_factor(unit):
            why = f"expected '{known[0]}', because numbers without a unit are in SI"
            raise InputError(f"unit = '{unit}': {why}")
        raise InputError(f"unit = '{unit}': expected a unit.{nearest(unit, KINDS)}")
    if scale == 1 and unit != own:
        over = f" over {per}" if per else ""
        raise InputError(
            f"unit = '{unit}': {quantity}{over} is in {own}; give the values in it, or scale, the factor between the two, such"
            " as 1 over an area"
        )


@dataclass(frozen=True, kw_only=True)
class Measurement:
    """A quantity that was measured once, or over one parameter of a set-up.

    - `title`, `source`: what was measured, and where in the publication it stands.
    - `scenario`: the set-up; what the publication prints is in it.
    - `quantity`: what was measured, as ``electrovib run --quantity`` names it, or a function of the scenario that
      computes it; `per` is a second quantity by which the first is divided, that of the set-up with `per_changes` where
      these are given, and the same quantity where it is empty then; `scale` is a factor, for instance the inverse of an
      area for a stress.
    - `unit`: SI unit of the values.
    - `over`, `at`: dotted path of the parameter that was varied, and its values in SI.
    - `values`: what was measured, positive, shape (n,) as `at`, in SI.
    - `spread`: standard deviation over the value, of each; `spread_of` says between what, one of `SPREADS`.
    - `bound`: one of `BOUNDS`: whether the quantity is at least or at most what `values` has.
    - `error_of`: the line, figure or table of this source whose errors all its numbers share: they count as one.
    - `same_as`: own name of a measurement of this publication that has these values too: they count once.
    - `unknown`: dotted path to the distribution of what the publication does not print, as in a space file, with the
      source of the range; `of_model` the same for parameters that one model alone has, by its name, and None for a
      layer of the set-up that this model replaces, such as ``stack.gap`` for a law with gaps of its own.
    - `calibrated_by`: other measurements of the same set-up by name, each of which alone calibrates a model before it
      predicts this one; `calibrated_at`: values of `at` that calibrate the others.
    - `made`: names of models that were made from these numbers, which they cannot judge.
    - `judges`: path of the model whose candidates are compared, ``force`` for the laws.
    - `how`: one of `HOW`; `status`: how the publication was read.
    - `group`: the people who measured; their measurements are not independent of each other.
    - `on`: ``finger`` or what else was attracted; `note`: a trap, such as a contradiction with another source.
    - `cause`: of a measurement that no candidate reaches the likely cause, and the experiment that would decide.
    """

    title: str
    source: str
    scenario: Scenario
    quantity: str | Callable[[Scenario], float]
    unit: str
    values: tuple[float, ...]
    spread: tuple[float, ...]
    spread_of: str
    group: str
    how: str
    status: str
    on: str = "finger"
    bound: str = ""
    error_of: str = ""
    same_as: str = ""
    per: str = ""
    per_changes: Mapping[str, Any] = field(default_factory=dict)
    scale: float = 1.0
    over: str = ""
    at: tuple[float, ...] = ()
    unknown: Mapping[str, Any] = field(default_factory=dict)
    of_model: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    calibrated_by: Mapping[str, Measurement] = field(default_factory=dict)
    calibrated_at: tuple[float, ...] = ()
    made: tuple[str, ...] = ()
    judges: str = "force"
    note: str = ""
    cause: str = ""

    def __post_init__(self) -> None:
        """Refuse a measurement that cannot be scored: all mistakes at once."""
        counts = [len(self.values), len(self.spread), len(self.at) if self.over else 1]
        numbers = np.array([*self.values, *self.spread])
        wrong = numbers[~((numbers > 0) & np.isfinite(numbers))].tolist()
        problems = list[str]()
        if len(set(counts)) != 1 or not self.values:
            each = "values, spread and at need one number for each point; they have {}, {} and {}"
            problems.append(each.format(*counts))
        if wrong:
            problems.append(f"values and spread are positive numbers, unlike {wrong[0]:g}")
        if self.bound not in BOUNDS:
            problems.append(f"bound = '{self.bound}': '{AT_LEAST}' or '{AT_MOST}', or none")
        for name, known in (("how", HOW), ("spread_of", SPREADS)):
            if (given := getattr(self, name)) not in known:
                problems.append(f"{name} = '{given}': one of {', '.join(known)}")
        if self.status not in STATUSES or self.status in {UNVERIFIED, "derived"}:
            why = "a measurement was read, it is neither derived nor cited from memory"
            problems.append(f"status = '{self.status}': {why}")
        problems += _calibration_problems(self)
        with gathered(problems):
            if not callable(self.quantity):
                check_unit(self.unit, self.quantity, divisor(self), self.scale, self.scenario)
            self.scenario.replace(dict(self.per_changes))
        if problems:
            raise InputError(f"measurement '{self.title}': {each}" for each in problems)

    @property
    def points(self) -> Real:
        """Values of the parameter that was varied, NaN where none was."""
        return np.array(self.at) if self.over else np.full(1, np.nan)

    @property
    def named(self) -> str:
        """Name of the quantity; of a function, which has none, the first words of the title."""
        if callable(self.quantity):
            return re.split(r" over | in |,", self.title)[0]
        return f"{self.quantity} / {self.per}" if self.per else self.quantity

    @property
    def called(self) -> str:
        """Who measured it, as the source begins, or the group where it begins with a number."""
        first = self.source.partition(",")[0]
        return self.group if first.startswith("doi:") else first

    @property
    def axis(self) -> tuple[str, str]:
        """Words and SI unit of the parameter that was varied."""
        if not self.over:
            return "", "1"
        return words_at(self.scenario, self.over), quantity_at(self.scenario, self.over).unit


def divisor(stated: Any) -> Any:
    """Return the quantity by which the first is divided, none if empty."""
    return stated.per or (stated.quantity if stated.per_changes else "")


def numbers_of(name: str, measured: Measurement) -> frozenset[tuple[str, ...]]:
    """Return what counts as one number: each value, once in all, or all that share the errors of a line, figure or table."""
    if measured.error_of:
        return frozenset({(measured.group, measured.source, measured.error_of)})
    name = f"{name.rpartition('/')[0]}/{measured.same_as}" if measured.same_as else name
    return frozenset((name, str(place)) for place in range(len(measured.values)))


def _calibration_problems(measured: Measurement) -> list[str]:
    """Say what cannot calibrate: values that are not there or are all there are, bounds, and models of another place."""
    own, at = set(measured.calibrated_at), ", ".join(f"{each:g}" for each in measured.at)
    problems = [
        f"calibrated_by: '{name}' has bounds, or judges another model than that at {measured.judges}"
        for name, by in measured.calibrated_by.items()
        if by.bound or by.judges != measured.judges
    ]
    if own and (measured.bound or not own < set(measured.at)):
        problems.append(f"calibrated_at: expected some of at ({at}), but not all, and no bounds")
    return problems
