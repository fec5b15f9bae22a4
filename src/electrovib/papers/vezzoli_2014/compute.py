"""The paper's quantities for a skin and a law: figures 6 and 7 for every skin, and its 7.7 ms beside its 6 ms."""

from __future__ import annotations

import functools
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from electrovib.core.answer import Table
from electrovib.core.arrays import Real
from electrovib.core.constants import VACUUM_PERMITTIVITY as eps0
from electrovib.papers.vezzoli_2014 import values
from electrovib.papers.vezzoli_2014.laws import literal_response
from electrovib.papers.vezzoli_2014.values import scenarios
from electrovib.physics.drive.edges import Trapezium
from electrovib.physics.skin import Skin, time_constant
from electrovib.scenario import Scenario, skins
from electrovib.solve.simulate import simulate
from electrovib.studies.reproduction import Words

if TYPE_CHECKING:
    from electrovib.physics.material import Material
    from electrovib.physics.material.tabulated import Tabulated


_WORDS: Final = Words(
    Path(__file__).with_name("words.toml"),
    {name: each.value for name, each in values.PAPER.stated.values.items()},
)
row, panel, table = _WORDS.row, _WORDS.panel, _WORDS.table
"""Rows, figures and tables of the report, whose words are data into which numbers are put."""
POINT_BY_FORCE = "paper point, 15.4 ms"
"""The paper's skin if its 7.7 ms is the decay of the force."""
LEAKY_GAPS = {
    "Maxwell stress in the gap, leaky gap 1 um": 1e-6,
    "Maxwell stress in the gap, leaky gap 5 um": 5e-6,
}


def all_skins() -> dict[str, Skin]:
    """Collect every published skin, the paper's own point first."""
    own = {f"vezzoli_2014/{key}": skin for key, skin in values.skins().items()}
    return own | skins()


def force_skins() -> dict[str, Skin]:
    """Collect the skins that may predict a force, under their short names."""
    return {skin.name: skin for skin in all_skins().values() if skin.reproduces_force}


def with_skin(scenario: Scenario, material: Material) -> Scenario:
    """Put another skin into a scenario."""
    return scenario.replace({"stack.stratum_corneum.material": material})


def point(tau: float) -> Scenario:
    """Figure 6 on the paper's skin with this time constant of the voltage, eps0 eps rho [s]."""
    conductivity = eps0 * values.SKIN_PERMITTIVITY / tau
    return scenarios()["fig6"].replace({"stack.stratum_corneum.material.conductivity": conductivity})


def leaky_gap(thickness: float) -> Scenario:
    """Return figure 6 with a gap that leaks with 7.7 ms, tau = eps0 rho (1 + C_i/C_g), and the Maxwell stress in the gap."""
    ratio = values.FILM_PERMITTIVITY * thickness / values.FILM_THICKNESS  # C_i/C_g
    conductivity = eps0 * (1 + ratio) / values.TAU_MODEL
    changes = {"stack.gap.thickness": thickness, "stack.gap.material.conductivity": conductivity}
    return scenarios()["fig6_gap"].replace(changes)


def figure_6_cases() -> dict[str, Scenario]:
    """Return figure 6 for every skin under the causal law, and with the Maxwell stress in leaky gaps.

    The paper's point occurs twice: with 7.7 ms as the time constant of the voltage, and as the decay of the force.
    """
    causal = scenarios()["fig6"]
    found = {name: with_skin(causal, skin.material) for name, skin in force_skins().items()}
    found[POINT_BY_FORCE] = point(values.voltage_decay(decay=values.TAU_MODEL))
    return found | {name: leaky_gap(gap) for name, gap in LEAKY_GAPS.items()}


def peak_force(scenario: Scenario, *, ramp: float) -> float:
    """Attraction at the end of the rising ramp, where it is largest for a skin that conducts [N]."""
    changed = scenario.replace({"drive.rise": ramp, "drive.fall": ramp})
    return float(simulate(changed, time=np.array([0.0, ramp])).electrostatic_force[-1])


def ramp_for(scenario: Scenario, *, force: float) -> float:
    """Ramp time that gives this peak force [s]."""
    from scipy.optimize import brentq

    return float(
        np.exp(
            brentq(
                lambda x: np.log(peak_force(scenario, ramp=np.exp(x)) / force),
                np.log(1e-6),
                np.log(30.0),
                xtol=1e-4,
            )
        )
    )


def lateral_decay(scenario: Scenario) -> float:
    """Time [s] in which the lateral force above that of the load falls to 1/e after a step of the voltage, simulated."""
    step = {"drive": {"model": "Step", "level": values.VOLTAGE}}
    time = np.array([0.0, 5e-3, 10e-3])
    trace = simulate(scenario.replace(step), time=time)
    friction = scenario.to_dict()["friction"]["coefficient"] * scenario.load.normal_force
    excess = trace.lateral_force.values - friction
    return float((time[2] - time[1]) / np.log(excess[1] / excess[2]))


def edge_ratio(scenario: Scenario) -> float:
    """Peak attraction after the falling edge over that after the rising edge."""
    drive = scenario.drive
    assert isinstance(drive, Trapezium)
    ends = np.array([0.0, drive.rise, drive.rise + drive.hold + drive.fall])
    force = simulate(scenario, time=ends).electrostatic_force.values
    return float(force[2] / force[1])


def frequency_force(
    material: Material, *, samples: int, thickness: float = values.SKIN_THICKNESS
) -> tuple[Real, Real]:
    """Mean attraction on the thin coating of figure 7 under a 100 V sine [N], by the law as printed, after the frequencies [Hz].

    Without the body's resistance, as in the paper: above 10 kHz a body would take part of the voltage.
    """
    changes: dict[str, Any] = {
        "frequency": {"low": 100.0, "high": 1e4, "samples": samples},
        "stack.stratum_corneum.material": material,
        "stack.stratum_corneum.thickness": thickness,
        "circuit.return_path.resistance": 0.0,
    }
    found = simulate(scenarios()["fig7"].replace(changes), signals=["mean_force"])
    return found.frequency.values, found.mean_force.values


def rise_and_saturation(material: Material) -> tuple[float, float, float]:
    """Compute for figure 7 F(10 kHz)/F(100 Hz), F(10 kHz)/largest F and F(5 kHz)/F(10 kHz) [1]."""
    frequency, force = frequency_force(material, samples=161)
    half = float(np.interp(np.log(5e3), np.log(frequency), force))
    return float(force[-1] / force[0]), float(force[-1] / force.max()), half / float(force[-1])


def floating_factor(scenario: Scenario, *, capacitance: float) -> float:
    """Compute the static attraction with a floating body over that with a grounded one [1]."""
    static = scenario.replace(
        {"drive": {"model": "Step", "level": 1.0}, "force.model": "EffectiveMedium"}
    ).replace(
        {"stack.stratum_corneum.material": {"model": "Constant", "permittivity": values.SKIN_PERMITTIVITY}}
    )
    time = np.array([0.0, 1e-3])
    afloat = static.replace({"circuit.return_path": {"model": "Floating", "capacitance": capacitance}})
    forces = [float(simulate(case, time=time).electrostatic_force[-1]) for case in (afloat, static)]
    return forces[0] / forces[1]


def causality_residual(material: Material, *, ramp: float = 20e-3, before: float = 1e-3) -> float:
    """Compute the response of the law as printed before a ramp begins, as a share of its peak; 0 for a causal law.

    It is |v_e(-before)|/max |v_e| with times [s], by a discrete Fourier transform over a period long against
    skin and ramp, 0.2 s after 4 s at 0 V.
    """
    period, count = 8.0, 1 << 20
    time = np.arange(count) * period / count - period / 2
    drive = Trapezium(high=1.0, rise=ramp, hold=0.2, fall=ramp)
    spectrum = np.fft.rfft(drive.voltage(time))
    frequency = np.asarray(np.fft.rfftfreq(count, period / count)[1:], dtype=np.float64)
    film = eps0 * values.FILM_PERMITTIVITY / values.FILM_THICKNESS
    skin = eps0 * material.complex_permittivity(frequency) / values.SKIN_THICKNESS
    spectrum[0] = 0.0  # the response of the law at zero frequency
    spectrum[1:] *= literal_response(frequency, insulator=film, skin=skin)
    response = np.fft.irfft(spectrum, count)
    early: NDArray[np.float64] = np.interp([-before], time, response)
    return float(abs(early[0]) / np.max(np.abs(response)))


def static_force(law: str, *, gap: float | None = None, skin: float = values.SKIN_THICKNESS) -> float:
    """Compute the attraction [N] at 1000 V on the paper's film without conduction; by default in a vanishing gap."""
    base = scenarios()["fig6_static" if gap is None else "fig6_gap"]
    changes: dict[str, Any] = {
        "force.model": law,
        "drive": {"model": "Step", "level": values.VOLTAGE},
        "stack.stratum_corneum.material.conductivity": 0.0,
        "stack.stratum_corneum.thickness": skin,
    }
    if gap is not None:
        changes |= {"stack.gap.thickness": gap, "stack.gap.material.conductivity": 0.0}
    return float(simulate(base.replace(changes), time=np.array([0.0, 1e-3])).electrostatic_force[-1])


def leaky_air(resistivity: float) -> dict[str, Any]:
    """Return the change that lets the gap leak, with a resistivity [ohm m]."""
    return {"stack.gap.material": {"model": "Constant", "permittivity": 1.0, "conductivity": 1 / resistivity}}


def over_hold(scenario: Scenario) -> float:
    """Compute the attraction at the end of the hold of a trapezoidal pulse over that at its beginning [1]."""
    drive = scenario.drive
    assert isinstance(drive, Trapezium)
    ends = np.array([0.0, drive.rise, drive.rise + drive.hold])
    force = simulate(scenario, time=ends).electrostatic_force.values
    return float(force[2] / force[1])


def oscillation() -> float:
    """Compute for figure 2 the largest over the smallest attraction in the hold, the hand trembling [1]."""
    scenario = scenarios()["fig2_tremor"]
    drive = scenario.drive
    assert isinstance(drive, Trapezium)
    time = np.concatenate([[0.0], drive.rise + np.linspace(0.0, drive.hold, 801)])
    force = simulate(scenario, time=time).electrostatic_force.values[1:]
    return float(force.max() / force.min())


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
        return ramp_for(point(self.tau), force=force)

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


def published_skins() -> dict[str, Skin]:
    """Collect the skins of other publications."""
    return {key: skin for key, skin in all_skins().items() if not key.startswith("vezzoli_2014/")}


def time_constants(frequency: float, skins: Iterable[Skin] = ()) -> tuple[float, float]:
    """Shortest and longest time constant of the voltage [s] among skins, the published ones if none, at a frequency [Hz]."""
    among = list(skins) or published_skins().values()
    found = [float(time_constant(skin.material, frequency)) for skin in among]
    return min(found), max(found)


SLOWEST, USUAL = 1.0, 100.0
"""Frequencies between which the time constants of skins are given, as the paper prints none [Hz]."""


@functools.cache
def decay_table() -> Table:
    """Return what follows from either reading of the paper's time, and from the measurement."""
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
    return table("decay_readings", lines)


@dataclass(frozen=True)
class TrapeziumForce:
    """Figure 6 with one skin, or with the Maxwell stress in a leaky gap.

    `force` is the peak attraction with the ramp taken here [N], `ramp` the one that would give the paper's
    2.5 mN of attraction [s], `edges` the attraction after the falling edge over that after the rising edge.
    """

    name: str
    force: float
    ramp: float
    edges: float


@dataclass(frozen=True)
class Shape:
    """Figure 7 with one skin: F(10 kHz)/F(100 Hz), F(10 kHz)/largest F and F(5 kHz)/F(10 kHz)."""

    rise: float
    saturation: float
    before: float

    @property
    def words(self) -> str:
        """Verdict on this skin: begins with ``consistent`` or ``open``."""
        if self.rise < 1:
            return "open, falls"
        if self.rise < 1.2:
            return "open, flat"
        if self.saturation < 0.9:
            return "open, peaks and falls again"
        if self.before < 0.95:
            return "open, still rising at 10 kHz"
        return "consistent, rises and saturates"


def shape_of(material: Material) -> Shape:
    """Compute rise and saturation of figure 7 for a skin."""
    return Shape(*rise_and_saturation(material))


@functools.cache
def figure_6() -> tuple[TrapeziumForce, ...]:
    """Compute figure 6 for every skin under the causal law, and for the Maxwell stress in leaky gaps."""
    return tuple(
        TrapeziumForce(
            name,
            peak_force(case, ramp=values.RAMP),
            ramp_for(case, force=values.FORCE_MODEL),
            edge_ratio(case),
        )
        for name, case in figure_6_cases().items()
    )


@functools.cache
def figure_7() -> dict[str, Shape]:
    """Compute figure 7 for every skin that may predict a force."""
    return {name: shape_of(skin.material) for name, skin in force_skins().items()}


def skin_tables(own: Tabulated | None) -> tuple[Table, ...]:
    """Return the results for every skin, and the source status of every skin."""
    return _results(own), _skins(own)


def _results(own: Tabulated | None) -> Table:
    shapes: Mapping[str, Shape] = figure_7()
    skins, lines = force_skins(), []
    for case in figure_6():
        numbers = (f"{case.force / 1e-3:.3g}", f"{case.ramp / 1e-3:.3g}", f"{case.edges:.3g}")
        skin = skins.get(case.name)
        lines.append((case.name, skin.status if skin else "", *numbers, *_shown(shapes.get(case.name))))
    if own is not None:
        lines.append(("your table", "your own", "", "", "", *_shown(shape_of(own))))
    return table("by_skin", lines)


def _shown(shape: Shape | None) -> tuple[str, str, str]:
    return ("", "", "") if shape is None else (f"{shape.rise:.3g}", f"{shape.saturation:.2f}", shape.words)


def _skins(own: Tabulated | None) -> Table:
    lines = [
        (skin.name, key, *_taus(skin.material), skin.status, skin.note) for key, skin in all_skins().items()
    ]
    if own is not None:
        lines.append(("your table", own.file, *_taus(own), "your own", ""))
    return table("skins", lines)


def _taus(material: Material) -> list[str]:
    return [f"{float(time_constant(material, frequency)) / 1e-3:.3g}" for frequency in (100.0, 1e3, 1e4)]
