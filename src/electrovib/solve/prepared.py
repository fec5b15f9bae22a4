"""A scenario made ready once, which then answers at any times: signals, and how far they can be believed."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.scenario import PeriodicState
from electrovib.solve.choice import refuse_unsolved, solve
from electrovib.solve.diagnostics import diagnostics, solved, watched
from electrovib.solve.diagnostics.known import known_band, memory_lamps, worst_of
from electrovib.solve.diagnostics.memory import answer_errors
from electrovib.solve.effort import last_time, refuse_large
from electrovib.solve.mechanics.mechanical import mechanical, refuse_unsolved_mechanics
from electrovib.solve.stack.expand import modes, phasors

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.core.lamps import Lamp
    from electrovib.physics.force import ForceLaw
    from electrovib.scenario import Scenario
    from electrovib.solve.diagnostics.peaks import PeakRecord
    from electrovib.solve.electrics.solution import Solution
    from electrovib.solve.stack.section import ModalSection, PhasorSection


LATER_PERIODS: Final = 10
"""By which a period of a periodic state is judged as if it were a later one."""


@dataclass(frozen=True, kw_only=True)
class Record:
    """Signals of a scenario at some times.

    Parameters
    ----------
    times : ndarray, shape (n,)
        Increasing [s].
    solution : Solution
        What the drive does to the stack.
    signals : dict
        Dimensions and values of every signal over time, in its unit.
    how : dict
        Solver, its reason, errors and events.
    lamps : list of Lamp
        What the mechanics has to say.
    peaks : PeakRecord or None
        What is judged of the whole solution; None where these times show it well enough.
    """

    times: Real
    solution: Solution
    signals: dict[str, Any]
    how: dict[str, Any]
    lamps: list[Lamp]
    peaks: PeakRecord | None = None


class Prepared:
    """A scenario whose stack is in modes, ready to be asked at any times.

    Parameters
    ----------
    scenario : Scenario
        Everything.
    times : ndarray, shape (n,), optional
        Times of a run [s], over whose band materials are reduced to Debye terms; by default those of the scenario.

    Attributes
    ----------
    section : ModalSection
        The stack as modes.
    reduction_error : float
        Largest error of a polarisation reduced to Debye terms.

    Raises
    ------
    BudgetError
        If a run would take more time or memory than is allowed; nothing has been computed then.
    """

    def __init__(self, scenario: Scenario, times: Real | None = None) -> None:
        refuse_unsolved(scenario)
        refuse_unsolved_mechanics(scenario, last_time(scenario, times))
        refuse_large(scenario, times)
        self.scenario = scenario
        self.times = scenario.time.times(scenario.drive) if times is None else times
        self.section, self.reduction_error = modes(scenario, self.times)

    @functools.cached_property
    def declared(self) -> PhasorSection:
        """The stack over the scenario's frequencies, without leaks, exact for the materials as declared."""
        return phasors(self.scenario, self.scenario.frequency.frequencies(), leaks=False)

    def at(self, times: Real, *, closely: bool = False) -> Record:
        """Compute every signal over time.

        Parameters
        ----------
        times : ndarray, shape (n,)
            Increasing, >= 0 [s].
        closely : bool
            Look for the largest values between these times too, so that `judge` does not depend on them.

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
        peaks: PeakRecord | None = None
        if closely:
            solution, peaks = solved(scenario, section, times)
        else:
            solution = solve(scenario, section, times)
        between = functools.partial(solve, scenario, section, force_alone=True)
        moved = mechanical(scenario, times, solution, between)
        signals = solution.signals(tuple(section.names)) | moved.signals
        return Record(
            times=times,
            solution=solution,
            signals=signals,
            how=solution.how() | moved.how,
            lamps=moved.lamps,
            peaks=peaks,
        )

    def judge(self, record: Record) -> tuple[list[Lamp], dict[str, float]]:
        """Judge a record before it is handed out.

        Parameters
        ----------
        record : Record
            From `at`.

        Returns
        -------
        lamps : list of Lamp
            What holds for the solution; whether the times show it is for `sampling` to say.
        errors : dict of str to float
            ``reduction_error``, and of a law with a response in time ``transfer_error``; relative.
        """
        scenario, known = self.scenario, known_band(self.scenario)
        seen = self._seen(record)
        errors, stated = {}, {"reduction_error": self.reduction_error}
        if self.reduction_error:
            errors = answer_errors(scenario, self.section, seen.solution, seen.times, known=known)
        if scenario.force.causal:
            over_frequency = _transfer_error(scenario.force, self.section, self.declared, known)
            stated["transfer_error"] = max(over_frequency, worst_of(errors))
        peaks = record.peaks or watched(scenario, self.section, record.times, record.solution)
        spoken = [
            *diagnostics(scenario, self.section, peaks, record.times, record.signals),
            *memory_lamps(scenario, errors, seen.times, known=known, method=record.solution.method),
            *record.lamps,
            *scenario.force.lamps_over_frequency(self.declared),
        ]
        return spoken, stated

    def _seen(self, record: Record) -> Record:
        """Give what of a record is judged: no times nearer to a corner than those the materials were reduced for."""
        if record.times is self.times or not self.reduction_error:
            return record
        drive, settled = self.scenario.drive, isinstance(self.scenario.time.initial_state, PeriodicState)
        corners = np.append([] if settled else [0.0], drive.corners(float(record.times[-1]))[0])
        reduced_for = _since(corners, self.times)
        kept = _since(corners, record.times) >= np.min(reduced_for[reduced_for > 0], initial=np.inf)
        kept = kept if np.any(kept) else np.ones(len(kept), bool)
        later = 0.0
        if settled:
            later = LATER_PERIODS * (
                drive.period or 0.0
            )  # one period stands for all: what is left is never its end
        return replace(
            record,
            times=record.times[kept] + later,
            solution=record.solution.at(np.flatnonzero(kept)),
            signals={},
            lamps=[],
            peaks=None,
        )


def _since(corners: Real, times: Real) -> Real:
    """Time since the last corner [s]; infinite before the first."""
    last = np.append(-np.inf, corners)[np.searchsorted(corners, times, side="right")]
    return np.asarray(times - last)


def _transfer_error(
    law: ForceLaw, section: ModalSection, exact: PhasorSection, known: tuple[float, float]
) -> float:
    """Largest error of the law's amplitudes after reduction, against their largest magnitude, where known."""
    reduced, declared = law.amplitudes(section), law.amplitudes(exact)
    inside = (exact.frequency >= known[0]) & (exact.frequency <= known[1])
    if not np.any(inside):
        return math.nan
    errors = []
    for name, value in declared.items():
        scale = float(np.max(np.abs(value)))
        difference = reduced[name].at(exact.frequency[inside]) - value[inside]
        errors.append(float(np.max(np.abs(difference))) / (scale or 1.0))
    return max(errors)
