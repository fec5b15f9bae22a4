"""An experiment as one frozen tree of models, and how it is read."""

from electrovib.solve.scenario.experiment import SCHEMA, Scenario
from electrovib.solve.scenario.grids import AtRest, FrequencyGrid, InitialState, PeriodicState, TimeGrid
from electrovib.solve.scenario.reading import (
    DEFAULT,
    load,
    load_scenario,
    paper_scenario,
    scenario_of,
)

__all__ = [
    "DEFAULT",
    "SCHEMA",
    "AtRest",
    "FrequencyGrid",
    "InitialState",
    "PeriodicState",
    "Scenario",
    "TimeGrid",
    "load",
    "load_scenario",
    "paper_scenario",
    "scenario_of",
]
