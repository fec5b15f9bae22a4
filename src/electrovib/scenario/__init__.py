"""An experiment as one frozen tree of models, and how it is read."""

from electrovib.scenario.experiment import SCHEMA, Scenario
from electrovib.scenario.files import read_part
from electrovib.scenario.grids import AtRest, FrequencyGrid, InitialState, PeriodicState, TimeGrid
from electrovib.scenario.reading import (
    DEFAULT,
    Source,
    load,
    paper_of_preset,
    paper_scenario,
    read_scenario,
    scenario_of,
    sweep_of,
)
from electrovib.scenario.sources import is_default, not_in_paper

__all__ = [
    "DEFAULT",
    "SCHEMA",
    "AtRest",
    "FrequencyGrid",
    "InitialState",
    "PeriodicState",
    "Scenario",
    "Source",
    "TimeGrid",
    "is_default",
    "load",
    "not_in_paper",
    "paper_of_preset",
    "paper_scenario",
    "read_part",
    "read_scenario",
    "scenario_of",
    "sweep_of",
]
