"""Constant force for 1 s on the plate of Vezzoli et al. 2014: a slow voltage inside 1 kV, a carrier inside 250 uA.

The skin conducts the charge past the film, so a slow voltage has to rise as V0 (1 + t/tau) and holds micronewtons. A carrier is
faster than the leak, and holds millinewtons; at 3 kHz the current of the film alone allows 404 V, and less with the stray
capacitance of plate and cable, which is not printed in the paper.

    python constant_force.py figure.png
"""

from __future__ import annotations

import sys
from pathlib import Path

import electrovib as ev
from electrovib.studies.design.drive import HeldForce, held_force

LIMITS = {"voltage": "1 kV", "current": "250 uA"}
STRAY = (0.0, 100e-12, 300e-12)


def main() -> tuple[HeldForce, list[float]]:
    """Return the largest constant forces, and those of a carrier of 3 kHz as the full model predicts them [N]."""
    found = held_force("vezzoli_2014/fig6", duration=1.0, stray=STRAY, limits=LIMITS)
    predicted = []
    for stray in STRAY:
        designed = ev.design(
            "vezzoli_2014/fig6",
            target="constant 5 mN for 0.1 s",
            method="carrier",
            carrier="3 kHz",
            limits=LIMITS,
            set={"circuit.amplifier": {"stray_capacitance": stray}},
        )
        predicted.append(float(designed.predicted.mean()))
    return found, predicted


def draw(found: HeldForce, file: str | Path) -> None:
    """Draw the forces over the frequency of the carrier."""
    ev.plot.held_force(found).figure.savefig(file, dpi=150)


if __name__ == "__main__":
    found, predicted = main()
    print(f"slow voltage: {1e6 * found.direct:.2f} uN for {found.duration:g} s")
    for stray, force in zip(STRAY, predicted, strict=True):
        print(f"carrier of 3 kHz, {1e12 * stray:.0f} pF stray: {1e3 * force:.2f} mN")
    if len(sys.argv) > 1:
        draw(found, sys.argv[1])
