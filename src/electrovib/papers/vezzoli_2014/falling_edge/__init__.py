"""The falling edge: what could make the second pulse of the trapezoidal pulse differ from the first, each as a switch.

The paper says only that on the discharging parts there is a difference between model and measurement, and suspects
the sensor. Each candidate here is the paper's own scenario with one thing changed.
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
