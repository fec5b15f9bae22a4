"""Parameters from data: least squares with exact derivatives, intervals, and what the data do not determine."""

from electrovib.recordings.fit.estimate import Estimate as Estimate
from electrovib.recordings.fit.function import fit_function as fit_function
from electrovib.recordings.fit.least_squares import FreeParameter as FreeParameter
from electrovib.recordings.fit.least_squares import least_squares as least_squares
from electrovib.recordings.fit.measured import Measured as Measured
from electrovib.recordings.fit.of_scenario import ScenarioFit as ScenarioFit
from electrovib.recordings.fit.of_scenario import fit as fit
