"""Numbers that somebody measured, as data: the set-up as a scenario, what was varied, the values, and what was not printed."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.citation import STATUSES, UNVERIFIED
from electrovib.core.discovery import offers
from electrovib.core.errors import InputError
from electrovib.core.paths import quantity_at
from electrovib.scenario import Scenario

if TYPE_CHECKING:
    from electrovib.core.arrays import Real

PRINTED, DATA, FIGURE, QUOTED = "printed", "data file", "read from a figure", "quoted by others"
HOW: Final = (PRINTED, DATA, FIGURE, QUOTED)
"""How a number came here, from best to worst."""
SPREADS: Final = ("people", "repeats", "devices", "digits", "a choice")
"""What a spread is: between people, between repeats on one rig, between devices, the printed digits; or assumed here."""


@dataclass(frozen=True, kw_only=True)
class Measurement:
    """A quantity that was measured once, or over one parameter of a set-up.

    - `title`, `source`: what was measured, and where in the publication it stands.
    - `scenario`: the set-up; what the publication prints is in it.
    - `quantity`: what was measured, as ``electrovib run --quantity`` names it, or a function of the scenario that
      computes it; `per` is a second quantity by which the first is divided, and `scale` a factor, for instance the
      inverse of an area for a stress.
    - `unit`: SI unit of the values.
    - `over`, `at`: dotted path of the parameter that was varied, and its values in SI.
    - `values`: what was measured, positive, shape (n,) as `at`, in SI.
    - `spread`: standard deviation over the value, of each; `spread_of` says between what, one of `SPREADS`.
    - `unknown`: dotted path to the distribution of what the publication does not print, as in a space file, with the
      source of the range; `of_model` the same for parameters that one model alone has, by its name, and None for a
      layer of the set-up that this model replaces, such as ``stack.gap`` for a law with gaps of its own.
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
    per: str = ""
    scale: float = 1.0
    over: str = ""
    at: tuple[float, ...] = ()
    unknown: Mapping[str, Any] = field(default_factory=dict)
    of_model: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    made: tuple[str, ...] = ()
    judges: str = "force"
    note: str = ""
    cause: str = ""

    def __post_init__(self) -> None:
        """Refuse a measurement that cannot be scored: all mistakes at once."""
        counts = {len(self.values), len(self.spread), len(self.at) if self.over else 1}
        numbers = np.array([*self.values, *self.spread])
        problems = [
            message
            for wrong, message in (
                (len(counts) != 1 or not self.values, "values, spread and at need one number for each point"),
                (not np.all((numbers > 0) & np.isfinite(numbers)), "values and spread are positive numbers"),
                (self.how not in HOW, f"how = '{self.how}': one of {', '.join(HOW)}"),
                (
                    self.spread_of not in SPREADS,
                    f"spread_of = '{self.spread_of}': one of {', '.join(SPREADS)}",
                ),
                (
                    self.status not in STATUSES or self.status in {UNVERIFIED, "derived"},
                    f"status = '{self.status}': a measurement was read, it is neither derived nor cited from memory",
                ),
            )
            if wrong
        ]
        if problems:
            raise InputError(f"measurement '{self.title}': {each}" for each in problems)

    @property
    def points(self) -> Real:
        """Values of the parameter that was varied, NaN where none was."""
        return np.array(self.at) if self.over else np.full(1, np.nan)

    @property
    def axis(self) -> tuple[str, str]:
        """Name and SI unit of the parameter that was varied."""
        return (self.over, quantity_at(self.scenario, self.over).unit) if self.over else ("", "1")


def measurements(word: str = "") -> dict[str, Measurement]:
    """Collect what the papers, ours and those of other packages, declare as measured.

    Parameters
    ----------
    word : str
        Part of a name ``author_year/name``, a title or a group; all if empty.

    Returns
    -------
    dict of str to Measurement
        By ``author_year/name``.

    Raises
    ------
    InputError
        If no measurement has the word; the groups are listed.
    """
    known: dict[str, Measurement] = offers(("measurements",))
    found = {
        name: each
        for name, each in known.items()
        if word.casefold() in f"{name} {each.title} {each.group} {each.on}".casefold()
    }
    if not found:
        groups = ", ".join(sorted({each.group for each in known.values()}))
        raise InputError(f"no measurement is called '{word}'. Groups that measured: {groups}")
    return found
