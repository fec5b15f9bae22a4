"""Parameters from data: least squares with exact derivatives, intervals, and what the data do not determine."""

from electrovib.recordings.fit.least_squares import FreeParameter as FreeParameter
from electrovib.recordings.fit.least_squares import LeastSquaresEstimate as LeastSquaresEstimate
from electrovib.recordings.fit.least_squares import least_squares as least_squares
from electrovib.recordings.fit.measured import MeasuredTrace as MeasuredTrace
from electrovib.recordings.fit.of_scenario import fit_scenario as fit_scenario
from electrovib.recordings.fit.problem import CancelledError as CancelledError
from electrovib.recordings.fit.result import ScenarioFit as ScenarioFit
from electrovib.recordings.recording import CalibrationError as CalibrationError
