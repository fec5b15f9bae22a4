"""What moisture changes in a scenario."""

from __future__ import annotations

from electrovib.physics.moisture import Moisture
from electrovib.solve.scenario import Scenario


def moistened(scenario: Scenario, moisture: Moisture) -> dict[str, float]:
    """Changes that bring a scenario to a moisture, for `Scenario.replace`.

    Parameters
    ----------
    scenario : Scenario
        Whose layers, materials and friction say what there is to change.
    moisture : Moisture
        How moist.

    Returns
    -------
    dict of str to float
        Dotted path to value in SI: conductivity of the stratum corneum, of the gap or of the bridges in it, and
        the coefficient of friction; only what the scenario has.
    """
    layers, found = scenario.stack.layers, {}
    known = {path for path, _, _ in scenario.parameters()}
    if "stratum_corneum" in layers:
        thickness = layers["stratum_corneum"].thickness
        found["stack.stratum_corneum.material.conductivity"] = moisture.skin_conductivity(thickness)
    for name in ("conductivity", "spot_conductivity"):
        found[f"stack.gap.material.{name}"] = 1 / moisture.gap_resistivity()
    for where in ("friction", "friction.steady"):
        found[f"{where}.coefficient"] = moisture.coefficient()
    return {path: value for path, value in found.items() if path in known}
