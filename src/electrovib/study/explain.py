"""Why a law's static force differs from that of the gap plane, in words made from numbers."""

from __future__ import annotations

from electrovib.solve.scenario import Scenario

AGREES = 0.01
"""Relative difference up to which an explanation is said to account for a ratio."""


def static_permittivity(scenario: Scenario, name: str) -> float:
    """Real relative permittivity of a layer at 1 Hz, conduction apart."""
    return float(scenario.stack.layers[name].material.polarisation(1.0).real)


def explain(scenario: Scenario, ratio: float) -> str:
    """Account for a static force by plane, permittivity and gap.

    Parameters
    ----------
    scenario : Scenario
        Stack and law.
    ratio : float
        Static force of the law over that of the gap plane.

    Returns
    -------
    str
        One sentence; says so when the known reasons do not give the ratio.
    """
    expected, words = _reason(scenario)
    if expected is None:
        return f"{words}; {ratio:.4g} of the gap plane here"
    if abs(ratio / expected - 1) <= AGREES:
        return f"{words}: {expected:.4g} of the gap plane"
    return (
        f"{words} would give {expected:.4g} of the gap plane, but it is {ratio:.4g}: the law has more in it"
    )


def _reason(scenario: Scenario) -> tuple[float | None, str]:
    plane, layers = scenario.force.plane, scenario.stack.layers
    permittivity = {name: static_permittivity(scenario, name) for name in layers}
    electrical = sum(layer.thickness / permittivity[name] for name, layer in layers.items())
    if plane == "gap":
        if "gap" not in layers:
            return 1.0, "the field of a vanishing gap, D/eps0"
        solid = electrical - layers["gap"].thickness / permittivity["gap"]
        return 1.0, f"the field in the gap, {(solid / electrical) ** 2:.3g} of a vanishing one"
    if plane in layers:
        value = permittivity[plane]
        return permittivity.get(
            "gap", 1.0
        ) / value, f"the same displacement in the {plane}, permittivity {value:.4g}"
    if plane == "effective medium":
        pair = [layers[name] for name in ("insulator", "stratum_corneum")]
        length = sum(layer.thickness for layer in pair)
        solid = sum(layers[n].thickness / permittivity[n] for n in ("insulator", "stratum_corneum"))
        # V^2/(K L) against V^2/(K + g)^2, the voltage being the same
        expected = electrical**2 / (solid * length)
        medium = length / solid
        gap = "" if "gap" not in layers else ", and it takes no account of the gap"
        return expected, f"energy over geometric thickness, effective permittivity {medium:.4g}{gap}"
    return None, f"cut free at: {plane}"


def in_time(early: float, late: float) -> str:
    """Say what becomes of the force while the voltage is held.

    Parameters
    ----------
    early, late : float
        Just after a step and 50 ms later [N].

    Returns
    -------
    str
        Begins with a verb.
    """
    if early <= 0:
        return "starts from nothing"
    change = late / early
    if abs(change - 1) < 1e-2:
        return "keeps its force while the voltage is held"
    if change > 1:
        return f"rises by a factor {change:.3g} while the voltage is held: its plane gains field as others conduct"
    return f"falls to {change:.2g} of itself while the voltage is held: charge or field leaves its plane"
