"""Why a law's static force differs from that of the Maxwell stress in the gap, in words made from numbers."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from electrovib.core.units import format_quantity
from electrovib.physics.circuit import Grounded
from electrovib.physics.conduction import Conduction
from electrovib.physics.force import needed_layer
from electrovib.scenario import Scenario

AGREES = 0.01
"""Relative difference up to which an explanation is said to account for a ratio."""


def static_permittivity(scenario: Scenario, name: str) -> float:
    """Real relative permittivity of a layer at 1 Hz, conduction apart."""
    return float(scenario.stack.layers[name].material.bound_permittivity(1.0).real)


def explain(scenario: Scenario, *, ratio: float) -> str:
    """Account for a static force by plane, permittivity and gap.

    Parameters
    ----------
    scenario : Scenario
        Stack and law.
    ratio : float
        Static force of the law over that of the Maxwell stress in the gap.

    Returns
    -------
    str
        Without a full stop; says so when the known reasons do not give the ratio.
    """
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
    """Electrical thickness of the whole stack and of what is not the gap [m]."""
    layers = scenario.stack.layers
    each = {name: layer.thickness / static_permittivity(scenario, name) for name, layer in layers.items()}
    gap = scenario.stack.gap_name
    return sum(each.values()), sum(value for name, value in each.items() if name != gap)


def _equal_gap(scenario: Scenario, ratio: float) -> str:
    """Name the gap of air in which the Maxwell stress would pull as much, where the gap does not change the voltage."""
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
    plane, layers, gap = scenario.force.evaluation_surface, scenario.stack.layers, scenario.stack.gap_name
    permittivity = {name: static_permittivity(scenario, name) for name in layers}
    electrical, solid = _electrical(scenario)
    in_gap = permittivity[gap] if gap else 1.0
    if plane == "gap":
        if gap is None:
            return 1.0, "the field of a vanishing gap"
        less = f"{(solid / (permittivity[gap] * electrical)) ** 2:.3g} of the force of a vanishing one"
        return 1.0, f"the field in a gap of {format_quantity(layers[gap].thickness, 'm')}, {less}"
    read = layers_read(scenario)
    if len(read) == 1:
        value = permittivity[read[0]]
        return in_gap**2 / value, f"the same displacement in the {read[0]}, permittivity {value:.4g}"
    if plane == "effective medium":
        length = sum(layers[name].thickness for name in read)
        solid = sum(layers[name].thickness / permittivity[name] for name in read)
        # V^2/(K L) against V^2/(eps_gap K + g)^2, the voltage being the same
        expected = (in_gap * electrical) ** 2 / (solid * length)
        medium = length / solid
        beside = "" if gap is None else ", and it takes no account of the gap"
        return expected, f"energy over geometric thickness, effective permittivity {medium:.4g}{beside}"
    return None, f"cut free at the {plane}"


def layers_read(scenario: Scenario) -> tuple[str, ...]:
    """Name the layers that the force law reads: those of the roles it needs that are nearest to the interface."""
    found = (needed_layer(scenario.stack.roles, wanted) for wanted in scenario.force.needs)
    return tuple(name for name in found if name is not None)


def conducting(scenario: Scenario) -> tuple[str, ...]:
    """Name the layers that conduct, from the plate to the finger."""
    layers = scenario.stack.layers.items()
    return tuple(name for name, layer in layers if layer.material.conductivity or layer.leak is not None)


def listed(names: Iterable[str]) -> str:
    """Write names as people do: ``a``, ``a and b``, ``a, b and c``."""
    *first, last = names
    return f"{', '.join(first)} and {last}" if first else last


def knows_polarity(scenario: Scenario) -> bool:
    """Tell whether a layer answers to +V otherwise than to -V: it rectifies, or holds charge at the start."""
    layers = scenario.stack.layers.values()
    return any(layer.initial_charge or (layer.leak and not _odd(layer.leak)) for layer in layers)


def _odd(leak: Conduction) -> bool:
    fields = np.geomspace(1.0, 1e9, 19)
    return np.allclose(leak.current_density(fields), -leak.current_density(-fields), rtol=1e-12, atol=0.0)


def in_time(scenario: Scenario, *, early: float, late: float) -> str:
    """Say what becomes of the force while the voltage is held, and which layer does it.

    Parameters
    ----------
    scenario : Scenario
        Stack and law.
    early, late : float
        Just after a step and 50 ms later [N].

    Returns
    -------
    str
        Begins with a verb, without a full stop.
    """
    if early <= 0:
        return "starts from nothing"
    names, change = conducting(scenario), late / early
    if abs(change - 1) < 1e-2:
        though = f", although {_conduct(names)}" if names else ": nothing conducts"
        return f"keeps its force while the voltage is held{though}"
    size = f"rises by a factor {change:.3g}" if change > 1 else f"falls to {change:.2g} of itself"
    return f"{size} while the voltage is held: {_because(_place(scenario), names, rises=change > 1)}"


def _place(scenario: Scenario) -> str:
    """Name where the law cuts: a layer if it is in one, else as the law names it."""
    read = layers_read(scenario)
    if len(read) == 1:
        return read[0]
    gap = scenario.stack.gap_name
    return gap if gap and scenario.force.evaluation_surface == "gap" else scenario.force.evaluation_surface


def _because(plane: str, names: tuple[str, ...], *, rises: bool) -> str:
    others = [name for name in names if name != plane]
    if not names:
        return "layers go on polarising, or the return path charges"
    if rises and others:
        return f"{_conduct(others)}, so field goes from there to the plane of this law"
    if not rises and plane in names:
        return f"{_conduct([plane])}, so field goes from there to the other layers"
    if not rises and plane == "effective medium":
        return f"{_conduct(names)}, and charge that has crossed counts as lost in this law"
    return _conduct(names)


def _conduct(names: Iterable[str]) -> str:
    chosen = [f"the {name}" for name in names]
    return f"{listed(chosen)} {'conduct' if len(chosen) > 1 else 'conducts'}"
