"""The law of Vezzoli et al. 2014 after a step, compared with its closed form."""

from __future__ import annotations

import numpy as np
import xarray as xr

import electrovib as ev


def solutions() -> tuple[xr.Dataset, xr.DataArray]:
    """Return the Trace, and the effective voltage v exp(-t/tau) [V] at its times."""
    scenario = ev.load("vezzoli_2014/fig6").replace(
        {"drive": {"model": "Step", "level": "1 kV"}, "circuit.return_path.resistance": 0}
    )
    trace = ev.simulate(scenario)
    film, skin = scenario.stack.layers["insulator"], scenario.stack.layers["stratum_corneum"]
    ratio = film.material.permittivity / film.thickness * skin.thickness / skin.material.permittivity
    tau = 8.8541878128e-12 * skin.material.permittivity / skin.material.conductivity * (1 + ratio)
    return trace, 1000 * np.exp(-trace.time / tau)


def main() -> float:
    """Return the largest difference between the simulated effective voltage and the closed form [V]."""
    trace, closed_form = solutions()
    return float(abs(trace.effective_voltage - closed_form).max())


if __name__ == "__main__":
    print(f"largest difference from the closed form: {main():.2g} V of 1000 V")
    ev.plot.effective_voltage(solutions()[0]).figure.savefig("step_by_hand.png")
