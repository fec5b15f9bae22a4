"""Force by the Maxwell stress in a gap of 5 um over the thickness of the insulator."""

from __future__ import annotations

import numpy as np

import electrovib as ev


def main() -> np.ndarray:
    """Return the peak force [N] for five insulators from 1 to 90 um."""
    scenario = ev.load("vezzoli_2014/fig2").replace({"stack.gap.thickness": "5 um", "drive.high": "100 V"})
    thicknesses = np.geomspace(1e-6, 90e-6, 5)
    found = ev.sweep(
        scenario, {"stack.insulator.thickness": thicknesses}, quantities=["peak electrostatic_force"]
    )
    return found["peak electrostatic_force"].values


if __name__ == "__main__":
    for force in main():
        print(f"{1e3 * force:.3f} mN")
