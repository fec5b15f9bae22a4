"""A scenario with one leaking slab: which layers it has, what cannot be combined with it, and its response."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from electrovib.core.errors import InputError
from electrovib.physics.stack import pieces
from electrovib.scenario import PeriodicState
from electrovib.solve.electrics.amplifier.unlimited import amplified
from electrovib.solve.electrics.leaks.branch import leaky_response
from electrovib.solve.electrics.leaks.leak import leak_alone, leak_section
from electrovib.solve.electrics.linear.answer import refuse_gaps_of_a_law
from electrovib.solve.stack.expand import Surroundings
from electrovib.solve.stack.keys import FieldOf

if TYPE_CHECKING:
    from collections.abc import Mapping

    from electrovib.physics.stack import Layer
    from electrovib.scenario import Scenario
    from electrovib.solve.electrics.solution import Question, Solution
    from electrovib.solve.stack.keys import Key
    from electrovib.solve.stack.transfer import Transfer


def leaking_slab(layers: Mapping[str, Layer], *, second: float) -> tuple[str, ...]:
    """Return the names of the layers with a leak, which are pieces of one slab."""
    slabs = leaking_slabs(layers)
    if len(slabs) > 1:
        listed = " and ".join(f"stack.{slab[0]}.leak" for slab in slabs)
        raise InputError(
            f"{listed}: only one layer of a stack may have a leak; give the others a material that conducts"
        )
    if slabs and second:
        raise InputError(
            f"stack.{slabs[0][0]}.leak: with a second electrode two layers would leak; use Grounded or Floating"
        )
    return slabs[0] if slabs else ()


def leaking_slabs(layers: Mapping[str, Layer]) -> list[tuple[str, ...]]:
    """Return the layers with a leak, pieces of one slab together."""
    return [slab for slab in pieces(layers) if layers[slab[0]].leak is not None]


def leaks(scenario: Scenario) -> bool:
    """Return whether a layer has a non-ohmic leak."""
    return any(layer.leak is not None for layer in scenario.stack.layers.values())


def refuse_leak(scenario: Scenario) -> None:
    """Refuse parts of a scenario that cannot be combined with a leaking layer."""
    layers = scenario.stack.layers
    name = next(iter(leaking_slab(layers, second=Surroundings.of(scenario).second)), None)
    refuse_gaps_of_a_law(scenario, name)
    if scenario.circuit.amplifier is not None:
        from electrovib.solve.electrics.amplifier.amplifier import refuse_amplified

        refuse_amplified(scenario.drive, scenario.circuit.amplifier, settled=False)
    if name is not None and isinstance(scenario.time.initial_state, PeriodicState):
        raise InputError(
            f"time.initial_state = PeriodicState: layer '{name}' leaks by {type(layers[name].leak).__name__}, which is"
            " non-ohmic, so its periodic state is not known beforehand. Start AtRest and evaluate a late period"
        )


def answer_with_leak(question: Question) -> Solution:
    """Compute the response of a stack with one leaking layer to a voltage or a current."""
    scenario, section = question.scenario, question.section
    layers, around = scenario.stack.layers, Surroundings.of(scenario)
    slab = leaking_slab(layers, second=around.second)
    leak = layers[slab[0]].leak
    assert leak is not None
    beside: dict[Key, Transfer] = {}
    for name in slab:  # one current density flows through all pieces
        if scenario.drive.quantity == "current":
            own = leak_alone(section, layers, name, area=around.area)
        else:
            own = leak_section(section, layers, name, area=around.area, element=around.element)
        for key, transfer in question.wanted(own).items():
            beside[key] = beside[key] + transfer if key in beside else transfer
    driven, control = question.wanted(section), FieldOf(slab[0])
    amplifier = scenario.circuit.amplifier
    if amplifier is not None:  # without limits it prescribes the plate's voltage, whatever leaks
        driven = amplified(driven, amplifier)
    solution = leaky_response(driven, beside, scenario.drive, question.times, leak=leak, control=control)
    if amplifier is None:
        return solution
    found = dict(solution.found)
    found["amplifier_current"] = found.pop("stray current") + found["current"]
    return replace(solution, found=found)
