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

    - `evaluation_surface`: medium in which it evaluates the Maxwell stress; `status`: that of its source.
    - `static`: attraction at a constant peak voltage in the steady state, with all conduction left out [N];
      `ratio`: over that of the Maxwell stress in the gap.
    - `early`, `late`: attraction 50 us and 50 ms after a step to the peak voltage [N]; NaN for a law without
      a response in time.
    - `mean`: time average of the attraction under a sine of the peak voltage, over frequency [N].
    - `step`: step response over time [N], empty for a law without one.
    - `polarity`: mean attraction during the step over that of a step of the opposite sign; exactly 1 where
      the response of no layer depends on the polarity, NaN for a law without a response in time.
    - `why`: explanation of the ratio; `warnings`: limits that are exceeded.
    - `breakdown`: how the air breaks down at the static force; empty where it does not.
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

    - `voltage`: peak voltage at which the laws are compared [V].
    - `entries`: from the largest to the smallest static force.
    - `answer`: which law to believe on this stack, and why, in one sentence.
    - `left_out`: law to the reason for which it is not in the comparison.
    - `frequency`, `time`: frequencies [Hz] and times [s] of `mean` and `step` of the entries.
    - `tables`, `panels`, `pages`: tables, figures and explanations of a report.
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
