"""Design of a plate: insulator and drive within breakdown, current and perception."""

from electrovib.studies.design.plate.candidates import Objective, PlateCandidate
from electrovib.studies.design.plate.function import MAXIMISED, MINIMISED, ROUNDS, design_plate
from electrovib.studies.design.plate.result import PlateDesign, pareto_set

__all__ = [
    "MAXIMISED",
    "MINIMISED",
    "ROUNDS",
    "Objective",
    "PlateCandidate",
    "PlateDesign",
    "design_plate",
    "pareto_set",
]
