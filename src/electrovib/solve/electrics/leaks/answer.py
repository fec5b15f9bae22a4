"""A scenario with one leaking layer: which layer it is, what cannot be combined with it, and its response."""

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
    """Return the name of the layer with a leak.

    Parameters
    ----------
    layers : mapping of str to Layer
        From the plate to the finger.
    second : float
        First contact area over that of a second contact; 0 for none.

    Returns
    -------
    name : str or None
        The layer with a leak; None if all layers are linear.

    Raises
    ------
    InputError
        If several layers leak, or if there is a second contact, whose layers would leak as well.
    """
    names = [name for name, layer in layers.items() if layer.leak is not None]
    if len(names) > 1:
        listed = " and ".join(f"stack.{name}.leak" for name in names)
        raise InputError(
            f"{listed}: only one layer of a stack may have a leak; give the others a material that conducts"
        )
    if names and second:
        raise InputError(
            f"stack.{names[0]}.leak: with a second electrode two layers would leak; use Grounded or Floating"
        )
    return names[0] if names else None


def leaks(scenario: Scenario) -> bool:
    """Return whether a layer has a non-ohmic leak."""
    return any(layer.leak is not None for layer in scenario.stack.layers.values())


def refuse_leak(scenario: Scenario) -> None:
    """Refuse parts of a scenario that cannot be combined with a leaking layer.

    Parameters
    ----------
    scenario : Scenario
        With a leaking layer.

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
            f"time.initial_state = PeriodicState: layer '{name}' leaks by {type(layers[name].leak).__name__}, which is"
            " non-ohmic, so its periodic state is not known beforehand. Start AtRest and evaluate a late period"
        )


def answer_with_leak(question: Question) -> Solution:
    """Compute the response of a stack with one leaking layer to a voltage or a current.

    Parameters
    ----------
    question : Question
        Of a scenario that `refuse_leak` accepts.

    Returns
    -------
    Solution
        With the error of its time integration.
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
