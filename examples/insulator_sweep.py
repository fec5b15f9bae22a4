"""Force by the Maxwell stress in a gap of 5 um over the thickness of the insulator."""

from __future__ import annotations

import numpy as np
import xarray as xr

import electrovib as ev

QUANTITY = "peak electrostatic_force"


def sweep() -> xr.Dataset:
    """Return the sweep over five insulators from 1 to 90 um."""
    scenario = ev.load("vezzoli_2014/fig2").replace({"stack.gap.thickness": "5 um", "drive.high": "100 V"})
    thicknesses = np.geomspace(1e-6, 90e-6, 5)
    return ev.sweep(scenario, {"stack.insulator.thickness": thicknesses}, quantity=[QUANTITY])


def main() -> np.ndarray:
    """Return the peak force [N] for the five insulators."""
    return sweep()[QUANTITY].values


if __name__ == "__main__":
    found = sweep()
    for force in found[QUANTITY]:
        thickness = 1e6 * float(force["stack.insulator.thickness"])
        print(f"insulator of {thickness:.3g} um: {1e3 * float(force):.3f} mN")
    ev.plot.quantity(found, QUANTITY).figure.savefig("insulator_sweep.png")
