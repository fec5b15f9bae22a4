"""The law of Vezzoli et al. 2014 after a step, compared with its closed form."""

from __future__ import annotations

import numpy as np

import electrovib as ev


def main() -> float:
    """Return the largest difference between the simulated effective voltage and v exp(-t/tau) [V]."""
    scenario = ev.load("vezzoli_2014/fig6").replace(
        {"drive": {"model": "Step", "level": "1 kV"}, "circuit.return_path.resistance": 0}
    )
    trace = ev.simulate(scenario)
    film, skin = scenario.stack.layers["insulator"], scenario.stack.layers["stratum_corneum"]
    ratio = film.material.permittivity / film.thickness * skin.thickness / skin.material.permittivity
    tau = 8.8541878128e-12 * skin.material.permittivity / skin.material.conductivity * (1 + ratio)
    closed_form = 1000 * np.exp(-trace.time / tau)
    return float(abs(trace.effective_voltage - closed_form).max())


if __name__ == "__main__":
    print(f"largest difference: {main():.2g} V of 1000 V")
