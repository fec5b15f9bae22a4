"""An experiment as one frozen tree of models, and how it is read.

`read_scenario` alone makes a Scenario of what a user has: a name, a file, tables, a Trace. Names of materials and stacks are
resolved there, once, so that a Trace holds the values and their sources and no longer depends on a library.
"""

from electrovib.scenario.experiment import Scenario as Scenario
from electrovib.scenario.files import read_part as read_part
from electrovib.scenario.files import skins as skins
from electrovib.scenario.grids import AtRest as AtRest
from electrovib.scenario.grids import FrequencyGrid as FrequencyGrid
from electrovib.scenario.grids import InitialState as InitialState
from electrovib.scenario.grids import PeriodicState as PeriodicState
from electrovib.scenario.grids import TimeGrid as TimeGrid
from electrovib.scenario.reading import DEFAULT as DEFAULT
from electrovib.scenario.reading import Source as Source
from electrovib.scenario.reading import changed_models as changed_models
from electrovib.scenario.reading import load as load
from electrovib.scenario.reading import paper_of_preset as paper_of_preset
from electrovib.scenario.reading import paper_scenario as paper_scenario
from electrovib.scenario.reading import plain as plain
from electrovib.scenario.reading import preset as preset
from electrovib.scenario.reading import read_scenario as read_scenario
from electrovib.scenario.reading import scenario_of as scenario_of
from electrovib.scenario.reading import sweep_of as sweep_of
from electrovib.scenario.sources import is_default as is_default
from electrovib.scenario.sources import not_in_paper as not_in_paper
from electrovib.scenario.sources import paper_named as paper_named
from electrovib.scenario.toml import SCHEMA as SCHEMA
