"""Hysteresis of a surface on a linear spring: pull-in at one voltage, release at a lower one."""

import math

import numpy as np
from matplotlib.figure import Figure

import electrovib as ev
from electrovib.core.constants import eps0
from electrovib.physics.contact import LinearSpring
from electrovib.solve.equilibrium import Hysteresis

SPRING = LinearSpring(stiffness=1e8, free_gap=20e-6)
FILM = 15e-6 / 3.0  # electrical thickness of 15 um of 3


def main() -> tuple[Hysteresis, float]:
    """Return the gap over rising and falling voltage, and the pull-in voltage [V]."""
    voltages = np.linspace(1, 250, 500)
    loop = ev.hysteresis(voltages, surface=SPRING, pressure=200.0, electrical_thickness=FILM)
    left = SPRING.free_gap - 200.0 / SPRING.stiffness  # under the load
    snap = math.sqrt(8 * SPRING.stiffness * (FILM + left) ** 3 / (27 * eps0))  # at the gap (2 left - FILM)/3
    return loop, snap


def draw(loop: Hysteresis, snap: float) -> Figure:
    """Draw gap against voltage."""
    import matplotlib.pyplot as plt

    figure, ax = plt.subplots(figsize=(6, 4), layout="constrained")
    ax.plot(loop.up.voltage, loop.up.gap / 1e-6, label="rising")
    ax.plot(loop.down.voltage, loop.down.gap / 1e-6, "--", label="falling")
    ax.axvline(snap, color="0.6", lw=1, label=f"pull-in voltage, {snap:.1f} V")
    ax.set(xlabel="voltage [V]", ylabel="gap [µm]", title="Pull-in and release of a spring over a film")
    ax.legend(loc=(0.42, 0.15))
    return figure


if __name__ == "__main__":
    loop, snap = main()
    print(f"pull-in at {snap:.2f} V, release at {loop.down.voltage[loop.down.jump][0]:.2f} V")
    draw(loop, snap).savefig("pull_in.png")
