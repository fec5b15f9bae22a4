"""A scenario made ready once, which then answers at any times: signals, and how far they can be believed."""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from electrovib.solve.diagnostics import diagnostics
from electrovib.solve.electrical import electrical
from electrovib.solve.expand import modes, phasors
from electrovib.solve.mechanical import mechanical

if TYPE_CHECKING:
    from electrovib.core.lamps import Lamp
    from electrovib.solve.electrical import Electrical
    from electrovib.solve.scenario import Scenario
    from electrovib.solve.section import PhasorSection
    from electrovib.solve.transfer import Real


@dataclass(frozen=True)
class Record:
    """Signals of a scenario at some times.

    Parameters
    ----------
    times : ndarray, shape (n,)
        Increasing [s].
    answer : Electrical
        What the drive does to the stack.
    signals : dict
        Dimensions and values of every signal over time, in its unit.
    how : dict
        Solver, its reason, errors and events.
    lamps : list of Lamp
        What the mechanics has to say.
    """

    times: Real
    answer: Electrical
    signals: dict[str, Any]
    how: dict[str, Any]
    lamps: list[Lamp]


class Solution:
    """A scenario whose stack is solved, ready to be asked at any times.

    Parameters
    ----------
    scenario : Scenario
        Everything.

    Attributes
    ----------
    section : ModalSection
        The stack as modes.
    reduction_error : float
        Largest error of a polarisation reduced to Debye terms.
    """

    def __init__(self, scenario: Scenario) -> None:
        self.scenario = scenario
        self.section, self.reduction_error = modes(scenario)

    @functools.cached_property
    def declared(self) -> PhasorSection:
        """The stack over the scenario's frequencies, without leaks, exact for the materials as declared."""
        return phasors(self.scenario, self.scenario.frequency.frequencies(), leaks=False)

    def at(self, times: Real) -> Record:
        """Compute every signal over time.

        Parameters
        ----------
        times : ndarray, shape (n,)
            Increasing, >= 0 [s].

        Returns
        -------
        Record
            At these times.

        Raises
        ------
        NotCausalError
            If the force law has no response in time to this drive.
        InputError
            If models do not go together.
        """
        scenario, section = self.scenario, self.section
        answer = electrical(scenario, section, times)
        between = functools.partial(electrical, scenario, section, force_alone=True)
        moved = mechanical(scenario, times, answer, between)
        signals = answer.signals(section) | moved.signals
        return Record(times, answer, signals, answer.choice | moved.how, moved.lamps)

    def judge(self, record: Record) -> list[Lamp]:
        """Judge a record before it is handed out.

        Parameters
        ----------
        record : Record
            From `at`.

        Returns
        -------
        list of Lamp
            What holds for the solution; whether the times show it is for `sampling` to say.
        """
        spoken = diagnostics(self.scenario, self.section, record.answer, record.times, record.signals)
        return [*spoken, *record.lamps, *self.scenario.force.lamps_over_frequency(self.declared)]
