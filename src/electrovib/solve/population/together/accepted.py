"""Which scenarios are computed together, and why others are not."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from electrovib.core.changes import derived_at, stored_path
from electrovib.physics.contact import FixedArea
from electrovib.physics.friction import SteadyFriction
from electrovib.solve.choice import chosen
from electrovib.solve.electrics.solution import PERIODIC, TRANSIENT
from electrovib.solve.mechanics.lateral import resting
from electrovib.solve.population.together.refusal import NotTogetherError

if TYPE_CHECKING:
    from electrovib.scenario import Scenario

OF_LAYERS: Final = frozenset(
    {"stack_voltage", "interface_field", "field", "displacement", "effective_voltage"}
)
OF_MECHANICS: Final = frozenset({"normal_force", "sliding_speed", "lateral_force"})
OVER_TIME: Final = frozenset({"drive_voltage", "electrostatic_force"}) | OF_LAYERS | OF_MECHANICS
"""Signals over time that are computed together."""

_COLUMNS: Final = (
    "stack.",
    "circuit.",
    "contact.area",
    "drive.",
    "force.",
    "friction.",
    "load.normal_force",
)
"""Beginnings of the paths that may be columns."""


def refuse_apart(scenario: Scenario, free: tuple[str, ...], names: tuple[str, ...]) -> None:
    """Refuse scenarios whose fingers are computed one by one."""
    foreign = [name for name in names if name not in OVER_TIME]
    if foreign:
        raise NotTogetherError(f"the signal {foreign[0]} is computed for one finger at a time")
    method = chosen(scenario).method
    if method not in {PERIODIC, TRANSIENT}:
        raise NotTogetherError(f"the electrical solver is '{method.name}'")
    if scenario.circuit.amplifier is not None:
        raise NotTogetherError("there is an amplifier before the plate")
    if not isinstance(scenario.contact, FixedArea):
        raise NotTogetherError(
            f"the area of {type(scenario.contact).__name__} follows the force of each finger"
        )
    refuse_columns(scenario, free)
    if "lateral_force" in names:
        _refuse_memory(scenario)


def refuse_columns(scenario: Scenario, free: tuple[str, ...]) -> None:
    """Refuse parameters whose values cannot be a column."""
    if scenario.moisture is not None:
        raise NotTogetherError("moisture sets other parameters of each finger")
    for path in free:
        if derived_at(scenario, path) is not None and not path.startswith("drive."):
            raise NotTogetherError(f"{path} is derived from other parameters")
        if not stored_path(scenario, path).startswith(_COLUMNS):
            raise NotTogetherError(
                f"{path} is no number of the layers, the circuit, the drive, the law, the area, the load or the friction"
            )


def _refuse_memory(scenario: Scenario) -> None:
    """Refuse frictions that depend on the past."""
    if not isinstance(scenario.friction, SteadyFriction):
        raise NotTogetherError(f"{type(scenario.friction).__name__} has a memory")
    if resting(scenario.motion) and scenario.finger is not None:
        raise NotTogetherError("the skin holds a friction while the finger rests")
