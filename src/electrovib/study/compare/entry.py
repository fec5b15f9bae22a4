"""Results of a comparison of force laws."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from electrovib.core.arrays import Real
from electrovib.core.diagnostics import Diagnostic
from electrovib.scenario import Scenario
from electrovib.solve.quantities.answer import validity
from electrovib.study.reproduction import Page, Panel, Table


@dataclass(frozen=True, kw_only=True)
class Entry:
    """One law on the stack.

    Parameters
    ----------
    name, evaluation_surface, status : str
        Name of the law, medium in which it evaluates the Maxwell stress, status of its source.
    static : float
        Attraction at a constant peak voltage in the steady state, with all conduction left out [N].
    ratio : float
        Static attraction over that of the Maxwell stress in the gap.
    early, late : float
        Attraction 50 us and 50 ms after a step to the peak voltage [N]; NaN for a law without a response in time.
    mean : ndarray, shape (frequencies,)
        Time average of the attraction under a sine of the peak voltage [N].
    step : ndarray, shape (times,) or (0,)
        Step response [N].
    polarity : float
        Mean attraction during the step over that of a step of the opposite sign; exactly 1 where the response of no layer
        depends on the polarity, NaN for a law without a response in time.
    why : str
        Explanation of the ratio.
    warnings : tuple of str
        Limits that are exceeded.
    breakdown : str
        How the air breaks down at the static force; empty where it does not.
    """

    name: str
    evaluation_surface: str
    status: str
    static: float
    ratio: float
    early: float
    late: float
    mean: Real
    step: Real
    polarity: float
    why: str
    warnings: tuple[str, ...]
    breakdown: str


@dataclass(frozen=True, kw_only=True)
class Comparison:
    """All laws on one scenario.

    Parameters
    ----------
    scenario : Scenario
        Scenario with the stack.
    voltage : float
        Peak voltage at which the laws are compared [V].
    entries : tuple of Entry
        From the largest to the smallest static force.
    answer : str
        Which law to believe on this stack, and why: one sentence.
    left_out : mapping of str to str
        Law to the reason for which it is not in the comparison.
    frequency, time : ndarray
        Frequencies [Hz] and times [s] of `mean` and `step`.
    tables, panels, pages
        Tables, figures and explanations of a report.
    """

    scenario: Scenario
    voltage: float
    entries: tuple[Entry, ...]
    answer: str
    left_out: Mapping[str, str]
    frequency: Real
    time: Real
    tables: tuple[Table, ...]
    panels: tuple[Panel, ...]
    pages: tuple[Page, ...]

    @property
    def diagnostics(self) -> tuple[Diagnostic, ...]:
        """Diagnostics of the scenario with its own law and drive."""
        return validity(self.scenario)
