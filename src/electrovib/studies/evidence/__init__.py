"""Laws judged by what was measured: measurements as data, predictions over what was not printed, scores."""

from electrovib.studies.evidence.files import import_measurement, measurements
from electrovib.studies.evidence.function import evidence
from electrovib.studies.evidence.measurement import Measurement
from electrovib.studies.evidence.plan import ExperimentPlan, plan_experiment
from electrovib.studies.evidence.quantities import between
from electrovib.studies.evidence.result import Evidence
from electrovib.studies.evidence.score import Score, Standing, standings

__all__ = [
    "Evidence",
    "ExperimentPlan",
    "Measurement",
    "Score",
    "Standing",
    "between",
    "evidence",
    "import_measurement",
    "measurements",
    "plan_experiment",
    "standings",
]
