"""A scenario with one leaking layer: which layer it is, what does not go with it, and its answer."""

from __future__ import annotations

from typing import TYPE_CHECKING

from electrovib.core.errors import InputError
from electrovib.scenario import PeriodicState
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


def leaking_layer(layers: Mapping[str, Layer], *, second: float) -> str | None:
    """Find the layer with a leak.

    Parameters
    ----------
    layers : mapping of str to Layer
        From the plate to the finger.
    second : float
        First contact area over that of a second contact; 0 for none.

    Returns
    -------
    str or None
        Its name; None if all layers are linear.

    Raises
    ------
    InputError
        If there are several, or a second contact, whose layers would leak too.
    """
    names = [name for name, layer in layers.items() if layer.leak is not None]
    if len(names) > 1:
        listed = " and ".join(f"stack.{name}.leak" for name in names)
        raise InputError(
            f"{listed}: one layer of a stack may have a leak; give the others a material that conducts"
        )
    if names and second:
        raise InputError(
            f"stack.{names[0]}.leak: with a second electrode there are two such layers; use Grounded or Floating"
        )
    return names[0] if names else None


def leaks(scenario: Scenario) -> bool:
    """Tell whether a layer leaks out of proportion to its field."""
    return any(layer.leak is not None for layer in scenario.stack.layers.values())


def refuse_leak(scenario: Scenario) -> None:
    """Refuse what does not go with a leaking layer.

    Parameters
    ----------
    scenario : Scenario
        With one.

    Raises
    ------
    InputError
        If there are several leaks or contacts, the law has gaps of its own, or the periodic state is asked for.
    """
    layers = scenario.stack.layers
    name = leaking_layer(layers, second=Surroundings.of(scenario).second)
    refuse_gaps_of_a_law(scenario, name)
    if name is not None and isinstance(scenario.time.initial_state, PeriodicState):
        raise InputError(
            f"time.initial_state = PeriodicState: layer '{name}' leaks by {type(layers[name].leak).__name__}, not in"
            " proportion to its field, so its periodic state is not known beforehand. Start AtRest and look at a late period"
        )


def answer_with_leak(question: Question) -> Solution:
    """Answer of a stack with one leaking layer to a voltage or a current.

    Parameters
    ----------
    question : Question
        Of a scenario that `refuse_leak` lets through.

    Returns
    -------
    Solution
        With the error of its march.
    """
    scenario, section = question.scenario, question.section
    layers, around = scenario.stack.layers, Surroundings.of(scenario)
    name = leaking_layer(layers, second=around.second)
    assert name is not None
    leak = layers[name].leak
    assert leak is not None
    if scenario.drive.quantity == "current":
        beside = leak_alone(section, layers, name, area=around.area)
    else:
        beside = leak_section(section, layers, name, area=around.area, element=around.element)
    driven, leaking = question.wanted(section), question.wanted(beside)
    return leaky_response(driven, leaking, scenario.drive, question.times, leak=leak, control=FieldOf(name))
