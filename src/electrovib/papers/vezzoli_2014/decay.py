"""The paper's 7.7 ms beside its 6 ms: one is calculated, for a voltage or a force; the other is measured in a force."""

from __future__ import annotations

import functools
from dataclasses import dataclass

from electrovib.core.answer import Table
from electrovib.core.constants import VACUUM_PERMITTIVITY as eps0
from electrovib.papers.vezzoli_2014 import compute, values
from electrovib.physics.skin import time_constant
from electrovib.studies.reproduction import Row, verdict_over


@dataclass(frozen=True)
class DecayReading:
    """One reading, as a sentence, of a time that is printed, with the time constant of the effective voltage [s]."""

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
    """Return the time constants of the paper under both readings, and the check that they rest on."""
    skins = {key: skin for key, skin in compute.all_skins().items() if key != "vezzoli_2014/point"}
    taus = sorted((float(time_constant(skin.material, 100.0)), skin.name) for skin in skins.values())
    (least, fastest), (most, slowest) = taus[0], taus[-1]
    voltage = (least / 1e-3, most / 1e-3)
    force = (values.force_decay(tau=least) / 1e-3, values.force_decay(tau=most) / 1e-3)
    short, long = BY_VOLTAGE.decay / MEASURED.decay, BY_FORCE.decay / MEASURED.decay
    simulated = compute.lateral_decay(compute.point(values.TAU_MODEL))
    film = 1 + values.insulator_capacitance() / values.skin_capacitance()
    return (
        Row("tau_giraud", "time constant of the voltage, cited skins at 100 Hz", values.TAU_MODEL / 1e-3, voltage, "ms",
            verdict_over(values.TAU_MODEL / 1e-3, voltage),
            "The 7.7 ms calculated for Giraud's conditions, taken as the time constant of the voltage. The cited skins reach from"
            f" {fastest} to {slowest}. The paper prints neither the frequency of its eps 1560 nor a resistivity: 5.57e5 ohm m is"
            " computed from these 7.7 ms and is no independent value.", brief="frequency and resistivity not printed"),
        Row("tau_giraud_force", "decay of the force, cited skins at 100 Hz", values.TAU_MODEL / 1e-3, force, "ms",
            verdict_over(values.TAU_MODEL / 1e-3, force),
            "The same 7.7 ms, taken as the decay of the force. A force is proportional to the square of the voltage and decays in"
            f" half its time constant, which is then {BY_FORCE.tau / 1e-3:.3g} ms; the paper does not state which of the two its"
            " 7.7 ms is.", brief="if 7.7 ms is of the force"),
        Row("tau_giraud_measured", "decay of the lateral force, cited skins at 100 Hz",
            values.DECAY_MEASURED / 1e-3, force, "ms", verdict_over(values.DECAY_MEASURED / 1e-3, force),
            f"Measured by Giraud. These 6 ms correspond to {MEASURED.tau / 1e-3:.3g} ms of the voltage. A decay of the finger"
            " pulp of 4 ms (Pawluk and Howe 1999) may be part of them.", brief="skin of the subject not printed"),
        Row("tau_giraud_decay", "decay of the lateral force, the paper's model",
            values.DECAY_MEASURED / 1e-3, (BY_VOLTAGE.decay / 1e-3, BY_FORCE.decay / 1e-3), "ms", "open",
            "The paper compares 7.7 ms with 6 ms. If 7.7 ms belongs to the voltage, the force of the model decays in"
            f" {short:.2f} of the measured time; if it belongs to the force, in {long:.2f} of it. The paper does not state"
            " which.", brief="7.7 ms of the voltage, or of the force"),
        Row("force_decay_over_tau", "decay of the simulated lateral force over the time constant of the voltage",
            None, simulated / (values.TAU_MODEL * film), "1", "check",
            "After a step. One half, because the force is proportional to the square of the voltage.",
            brief="force ~ voltage squared"),
    )  # fmt: skip


@functools.cache
def table() -> Table:
    """Return what follows from either reading of the paper's time, and from the measurement."""
    headings = (
        "reading",
        "voltage decays with [ms]",
        "force decays with [ms]",
        "skin that would need it, at eps 1560 [Ω m]",
        "leaky gap that would need it [Ω m]",
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
    return Table(
        "Voltage or force: what the paper's 7.7 ms may mean",
        headings,
        tuple(lines),
        caption="The force decays twice as fast as the voltage.",
        id="decay_readings",
        shown=(0, 1, 2, 4, 5),
    )
