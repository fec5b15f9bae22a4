"""The paper's 7.7 ms against its 6 ms: one is calculated for a voltage or for a force, the other measured in a force."""

from __future__ import annotations

import functools
from dataclasses import dataclass

from electrovib.core.constants import VACUUM_PERMITTIVITY as eps0
from electrovib.papers.vezzoli_2014 import compute, values
from electrovib.physics.skin import time_constant
from electrovib.study.reproduction import Row, Table


@dataclass(frozen=True)
class DecayReading:
    """One way to read a time that the paper prints.

    Parameters
    ----------
    name : str
        The reading, as a sentence.
    tau : float
        Time constant of the effective voltage under it [s].
    """

    name: str
    tau: float

    @property
    def decay(self) -> float:
        """Decay of the force, lateral or normal [s]."""
        return values.force_decay(tau=self.tau)

    def ramp(self, force: float) -> float:
        """Ramp of figure 6 that gives this attraction [N] with this time constant [s]."""
        return compute.ramp_for(compute.point(self.tau), force=force)

    def ramps(self, forces: tuple[float, float]) -> tuple[float, float]:
        """Shortest and longest ramp [s] for a range of attractions [N]: the larger force needs the shorter one."""
        return self.ramp(forces[1]), self.ramp(forces[0])


BY_VOLTAGE = DecayReading("7.7 ms is the time constant of the voltage", values.TAU_MODEL)
BY_FORCE = DecayReading(
    "7.7 ms is already the decay of the force", values.voltage_decay(decay=values.TAU_MODEL)
)
MEASURED = DecayReading(
    "6 ms measured in the lateral force", values.voltage_decay(decay=values.DECAY_MEASURED)
)


def rows() -> tuple[Row, ...]:
    """Give the time constants of the paper under both readings, and the check on which they stand."""
    skins = {key: skin for key, skin in compute.all_skins().items() if key != "vezzoli_2014/point"}
    taus = sorted((float(time_constant(skin.material, 100.0)), skin.name) for skin in skins.values())
    (least, fastest), (most, slowest) = taus[0], taus[-1]
    voltage = (least / 1e-3, most / 1e-3)
    force = (values.force_decay(tau=least) / 1e-3, values.force_decay(tau=most) / 1e-3)
    short, long = BY_VOLTAGE.decay / MEASURED.decay, BY_FORCE.decay / MEASURED.decay
    simulated = compute.lateral_decay(compute.point(values.TAU_MODEL))
    film = 1 + values.insulator_capacitance() / values.skin_capacitance()
    return (
        Row("tau_giraud", "7.7 ms calculated for Giraud's conditions, read as the time constant of the voltage, against"
            " that of the cited skins at 100 Hz", values.TAU_MODEL / 1e-3, voltage, "ms", "open",
            f"the cited skins reach from {fastest} to {slowest}. The paper prints neither the frequency of its eps 1560 nor a"
            " resistivity: 5.57e5 ohm m is only 7.7 ms written otherwise"),
        Row("tau_giraud_force", "the same 7.7 ms, read as the decay of the force, against that of the cited skins",
            values.TAU_MODEL / 1e-3, force, "ms", "open",
            "a force goes with the square of the voltage and decays in half its time constant, which is then"
            f" {BY_FORCE.tau / 1e-3:.3g}"
            " ms; the paper does not say which of the two its 7.7 ms is"),
        Row("tau_giraud_measured", "decay of the lateral force measured by Giraud, against that of the cited skins",
            values.DECAY_MEASURED / 1e-3, force, "ms", "open",
            f"as a voltage these 6 ms are {MEASURED.tau / 1e-3:.3g} ms. A decay of the finger pulp of 4 ms (Pawluk and Howe"
            " 1999) may be part of them"),
        Row("tau_giraud_decay", "the same, against the paper's own model under both readings of its 7.7 ms",
            values.DECAY_MEASURED / 1e-3, (BY_VOLTAGE.decay / 1e-3, BY_FORCE.decay / 1e-3), "ms", "open",
            "the paper sets 7.7 ms beside 6 ms. If 7.7 ms belongs to the voltage, the force of the model decays in"
            f" {short:.2f} of"
            f" the measured time; if it belongs to the force, in {long:.2f} of it. The paper does not say which"),
        Row("force_decay_over_tau", "decay of the simulated lateral force after a step over the time constant of the voltage",
            None, simulated / (values.TAU_MODEL * film), "1", "check",
            "one half, because the force goes with the square of the voltage"),
    )  # fmt: skip


@functools.cache
def table() -> Table:
    """Carry both readings, and the measurement, through everything that the paper's time stands behind."""
    headings = (
        "reading",
        "voltage decays with [ms]",
        "force decays with [ms]",
        "skin that would need it, at eps 1560 [ohm m]",
        "leaking gap that would need it [ohm m]",
        "ramp for 2.5 mN of attraction [ms]",
        "ramp for 2.5 mN of lateral force [ms]",
        "ramp for the measured 2 to 5 mN of lateral force [ms]",
    )
    printed = (values.FORCE_MODEL, values.FORCE_MODEL)
    lines = []
    for reading in (BY_VOLTAGE, BY_FORCE, MEASURED):
        ranges = [reading.ramps(values.attraction_of(forces)) for forces in (printed, values.FORCE_MEASURED)]
        lines.append(
            (
                reading.name,
                f"{reading.tau / 1e-3:.3g}",
                f"{reading.decay / 1e-3:.3g}",
                f"{reading.tau / (eps0 * values.SKIN_PERMITTIVITY):.3g}",
                f"{reading.tau / eps0:.3g}",
                f"{reading.ramp(values.FORCE_MODEL) / 1e-3:.3g}",
                *(f"{low / 1e-3:.3g} to {high / 1e-3:.3g}" for low, high in ranges),
            )
        )
    low, high = values.FRICTION
    return Table(
        "Voltage or force: what the paper's time constant means",
        headings,
        tuple(lines),
        caption="An exponential voltage has a force that decays twice as fast. The paper compares its 7.7 ms with a lateral force"
        " that decays in 6 ms: 3.85 against 6 ms as forces (7.7 against 12 ms as voltages) under the first reading, 7.7 against"
        f" 6 ms (15.4 against 12 ms) under the second. Lateral forces are divided by a coefficient of friction of {low:g} to"
        f" {high:g}, a choice of ours: the paper prints none. With one relaxation time every ramp, resistivity"
        " and leak grows in proportion to it; a dispersive skin has no single one.",
    )
