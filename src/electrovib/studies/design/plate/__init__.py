"""Design of a plate: insulator and drive within breakdown, current and perception."""

from electrovib.studies.design.plate.function import PlateCandidate as PlateCandidate
from electrovib.studies.design.plate.function import plan_plate as plan_plate
from electrovib.studies.design.plate.result import PlateDesign as PlateDesign
from electrovib.studies.design.plate.result import pareto_set as pareto_set
