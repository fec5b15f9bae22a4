"""The falling edge: causes that could make the second peak of the trapezoidal pulse differ from the first.

The paper states only that on the discharging parts there is a difference between model and measurement, and suspects
the sensor. Each candidate cause here is the paper's own scenario with one change.
"""

from electrovib.papers.vezzoli_2014.falling_edge.candidates import Candidate, candidates
from electrovib.papers.vezzoli_2014.falling_edge.outcomes import (
    Outcome,
    outcome,
    outcomes,
    periodic_asymmetry,
)
from electrovib.papers.vezzoli_2014.falling_edge.shown import panels, rows, table

__all__ = [
    "Candidate",
    "Outcome",
    "candidates",
    "outcome",
    "outcomes",
    "panels",
    "periodic_asymmetry",
    "rows",
    "table",
]
