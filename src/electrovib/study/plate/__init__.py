"""Design of a plate: insulator and drive within breakdown, current and perception."""

from electrovib.study.plate.candidates import PlateCandidate
from electrovib.study.plate.function import MAXIMISED, MINIMISED, ROUNDS, find_plate
from electrovib.study.plate.objectives import Objective
from electrovib.study.plate.pareto import pareto_set
from electrovib.study.plate.result import PlateDesign

__all__ = [
    "MAXIMISED",
    "MINIMISED",
    "ROUNDS",
    "Objective",
    "PlateCandidate",
    "PlateDesign",
    "find_plate",
    "pareto_set",
]
