"""An experiment as one frozen tree of models, and how it is read."""

from electrovib.scenario.experiment import Scenario
from electrovib.scenario.files import read_part, skins
from electrovib.scenario.grids import AtRest, FrequencyGrid, InitialState, PeriodicState, TimeGrid
from electrovib.scenario.presets import AIR, plain, preset, sourced
from electrovib.scenario.reading import (
    DEFAULT,
    Source,
    changed_models,
    load,
    paper_of_preset,
    paper_scenario,
    read_scenario,
    scenario_of,
    sweep_of,
)
from electrovib.scenario.sources import is_default, not_in_paper
from electrovib.scenario.toml import SCHEMA

__all__ = [
    "AIR",
    "DEFAULT",
    "SCHEMA",
    "AtRest",
    "FrequencyGrid",
    "InitialState",
    "PeriodicState",
    "Scenario",
    "Source",
    "TimeGrid",
    "changed_models",
    "is_default",
    "load",
    "not_in_paper",
    "paper_of_preset",
    "paper_scenario",
    "plain",
    "preset",
    "read_part",
    "read_scenario",
    "scenario_of",
    "skins",
    "sourced",
    "sweep_of",
]
