"""Constant force for 1 s on the plate of Vezzoli et al. 2014: a slow voltage inside 1 kV, a carrier inside 250 uA.

The skin conducts the charge past the film, so a slow voltage has to rise as V0 (1 + t/tau) and holds micronewtons. A carrier is
faster than the leak, and holds millinewtons; at 3 kHz the current of the film alone allows 404 V, and less with the stray
capacitance of plate and cable, which is not printed in the paper.

    python constant_force.py figure.png
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import electrovib as ev

LIMITS = {"voltage": "1 kV", "current": "250 uA"}
STRAY = (0.0, 100e-12, 300e-12)
CARRIERS = np.geomspace(100.0, 100e3, 13)
SMALL = 1e-9
"""Constant force that is designed [N]; the force that is held is the largest multiple of it within the limits."""


def held(duration: float, stray: float = 0.0, **options: object) -> float:
    """Return the largest constant force that a drive of a method holds within the limits [N]."""
    target = ([0.0, duration], [SMALL, SMALL])
    changes = {"circuit.amplifier": {"stray_capacitance": stray}} if stray else {}
    found = ev.drive_for_force("vezzoli_2014/fig6", target=target, limits=LIMITS, set=changes, **options)
    return SMALL * found.scale


def main() -> tuple[float, dict[float, list[float]], list[float]]:
    """Return the force of a slow voltage, those of carriers by stray capacitance, and of 3 kHz by the full model [N]."""
    carriers = {
        stray: [held(10 / carrier, stray, method="carrier", carrier=carrier) for carrier in CARRIERS]
        for stray in STRAY
    }
    predicted = []
    for stray in STRAY:
        designed = ev.drive_for_force(
            "vezzoli_2014/fig6",
            target="constant 5 mN for 0.1 s",
            method="carrier",
            carrier="3 kHz",
            limits=LIMITS,
            set={"circuit.amplifier": {"stray_capacitance": stray}},
        )
        predicted.append(float(designed.predicted.mean()))
    return held(1.0, method="dc"), carriers, predicted


def draw(direct: float, carriers: dict[float, list[float]], file: str | Path) -> None:
    """Draw the forces over the frequency of the carrier."""
    figure, axes = plt.subplots()
    for stray, forces in carriers.items():
        axes.loglog(CARRIERS, forces, label=f"carrier, {1e12 * stray:.0f} pF stray")
    axes.axhline(direct, color="#222222", linestyle="--", label="slow voltage, held for 1 s")
    axes.set_title("Largest constant force within 1 kV and 250 µA")
    axes.set_xlabel("frequency of the carrier [Hz]")
    axes.set_ylabel("mean electrostatic force [N]")
    axes.legend()
    figure.savefig(file, dpi=150)


if __name__ == "__main__":
    direct, carriers, predicted = main()
    print(f"slow voltage: {1e6 * direct:.2f} uN for 1 s")
    for stray, force in zip(STRAY, predicted, strict=True):
        print(f"carrier of 3 kHz, {1e12 * stray:.0f} pF stray: {1e3 * force:.2f} mN")
    if len(sys.argv) > 1:
        draw(direct, carriers, sys.argv[1])
