"""Explanations of why the static force of a law differs from that of the Maxwell stress in the gap."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from electrovib.core.units import format_quantity
from electrovib.physics.circuit import Grounded
from electrovib.physics.conduction import Conduction
from electrovib.physics.force import needed_layer
from electrovib.scenario import Scenario

AGREES = 0.01
"""Relative difference up to which an explanation accounts for a ratio."""


def static_permittivity(scenario: Scenario, name: str) -> float:
    """Return the real relative permittivity of a layer at 1 Hz, without conduction."""
    return float(scenario.stack.layers[name].material.bound_permittivity(1.0).real)


def explain(scenario: Scenario, *, ratio: float) -> str:
    """Explain by surface, permittivity and gap a static force that is `ratio` times the Maxwell stress in the gap."""
    expected, words = _reason(scenario)
    if expected is None:
        said = f"{words}: {ratio:.4g} of the Maxwell stress in the gap here"
    elif abs(ratio / expected - 1) > AGREES:
        return (
            f"{words} would give {expected:.4g} of the Maxwell stress in the gap, but the law gives {ratio:.4g}: it has"
            " further terms"
        )
    elif expected == 1:
        return words
    else:
        said = f"{words}: {expected:.4g} of the Maxwell stress in the gap"
    return said + _equal_gap(scenario, ratio)


def _electrical(scenario: Scenario) -> tuple[float, float]:
    """Return the electrical thickness of the whole stack and of the stack without the gap [m]."""
    layers = scenario.stack.layers
    each = {name: layer.thickness / static_permittivity(scenario, name) for name, layer in layers.items()}
    gap = scenario.stack.gap_name
    return sum(each.values()), sum(value for name, value in each.items() if name != gap)


def _equal_gap(scenario: Scenario, ratio: float) -> str:
    """Return the gap of equal Maxwell stress in words, where the gap does not change the voltage."""
    whole, solid = _electrical(scenario)
    name = scenario.stack.gap_name
    filling = static_permittivity(scenario, name) if name else 1.0
    gap = filling * whole / ratio**0.5 - solid
    if not isinstance(scenario.circuit.return_path, Grounded) or gap <= 0:
        return ""
    return (
        f", as much as the Maxwell stress in the gap at a gap of {format_quantity(float(f'{gap:.2g}'), 'm')}"
    )


def _reason(scenario: Scenario) -> tuple[float | None, str]:
    surface, layers, gap = scenario.force.evaluation_surface, scenario.stack.layers, scenario.stack.gap_name
    permittivity = {name: static_permittivity(scenario, name) for name in layers}
    electrical, solid = _electrical(scenario)
    in_gap = permittivity[gap] if gap else 1.0
    if surface == "gap":
        if gap is None:
            return 1.0, "the field of a vanishing gap"
        less = f"{(solid / (permittivity[gap] * electrical)) ** 2:.3g} of the force of a vanishing one"
        return 1.0, f"the field in a gap of {format_quantity(layers[gap].thickness, 'm')}, {less}"
    if surface == "effective medium":
        length = scenario.stack.thickness - (0.0 if gap is None else layers[gap].thickness)
        # V^2/(K L) against V^2/(eps_gap K + g)^2, the voltage being the same
        expected = (in_gap * electrical) ** 2 / (solid * length)
        beside = "" if gap is None else ", and it takes no account of the gap"
        return (
            expected,
            f"energy over geometric thickness, effective permittivity {length / solid:.4g}{beside}",
        )
    read = layers_read(scenario)
    if len(read) == 1:
        value = permittivity[read[0]]
        return in_gap**2 / value, f"the same displacement in the {read[0]}, permittivity {value:.4g}"
    return None, f"the Maxwell stress is evaluated in the {surface}"


def layers_read(scenario: Scenario) -> tuple[str, ...]:
    """Return the layers that the force law reads: those nearest to the interface of the roles that it needs."""
    found = (needed_layer(scenario.stack.roles, wanted) for wanted in scenario.force.needs)
    return tuple(name for name in found if name is not None)


def conducting(scenario: Scenario) -> tuple[str, ...]:
    """Return the layers that conduct, from plate to finger."""
    layers = scenario.stack.layers.items()
    return tuple(name for name, layer in layers if layer.material.conductivity or layer.leak is not None)


def listed(names: Iterable[str]) -> str:
    """Join names as a list: ``a``, ``a and b``, ``a, b and c``."""
    *first, last = names
    return f"{', '.join(first)} and {last}" if first else last


def knows_polarity(scenario: Scenario) -> bool:
    """Return whether the response of a layer depends on the polarity: it rectifies, or is charged at time 0."""
    layers = scenario.stack.layers.values()
    return any(layer.initial_charge or (layer.leak and not _odd(layer.leak)) for layer in layers)


def _odd(leak: Conduction) -> bool:
    fields = np.geomspace(1.0, 1e9, 19)
    return np.allclose(leak.current_density(fields), -leak.current_density(-fields), rtol=1e-12, atol=0.0)


def in_time(scenario: Scenario, *, early: float, late: float) -> str:
    """Explain how the force changes from just after a step to 50 ms later, and which layer causes it."""
    if early <= 0:
        return "starts at 0 N"
    names, change = conducting(scenario), late / early
    if abs(change - 1) < 1e-2:
        though = f", although {_conduct(names)}" if names else ": nothing conducts"
        return f"keeps its force while the voltage is held{though}"
    size = f"rises by a factor {change:.3g}" if change > 1 else f"falls to {change:.2g} of its initial value"
    return f"{size} while the voltage is held: {_because(_place(scenario), names, rises=change > 1)}"


def _place(scenario: Scenario) -> str:
    """Return the layer in which the law evaluates the Maxwell stress, or the name of its evaluation surface."""
    read = layers_read(scenario)
    if len(read) == 1:
        return read[0]
    gap = scenario.stack.gap_name
    return gap if gap and scenario.force.evaluation_surface == "gap" else scenario.force.evaluation_surface


def _because(surface: str, names: tuple[str, ...], *, rises: bool) -> str:
    others = [name for name in names if name != surface]
    if not names:
        return "layers still polarise, or the return path still charges"
    if rises and others:
        return f"{_conduct(others)}, so the field moves from there to the surface that this law evaluates"
    if not rises and surface in names:
        return f"{_conduct([surface])}, so the field moves from there to the other layers"
    if not rises and surface == "effective medium":
        return f"{_conduct(names)}, and this law counts charge that has crossed as lost"
    return _conduct(names)


def _conduct(names: Iterable[str]) -> str:
    chosen = [f"the {name}" for name in names]
    return f"{listed(chosen)} {'conduct' if len(chosen) > 1 else 'conducts'}"
