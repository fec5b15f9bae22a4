"""The paper's quantities for a skin and a law."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from electrovib.core.arrays import Real
from electrovib.core.constants import VACUUM_PERMITTIVITY as eps0
from electrovib.papers.vezzoli_2014 import values
from electrovib.papers.vezzoli_2014.laws import literal_response
from electrovib.papers.vezzoli_2014.scenarios import scenarios
from electrovib.physics.drive.edges import Trapezium
from electrovib.physics.material import Material
from electrovib.physics.skin import Skin
from electrovib.scenario import Scenario, skins
from electrovib.solve.electrics.attraction import mean_force
from electrovib.solve.simulate import simulate
from electrovib.solve.stack.expand import phasors

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


def frequency_force(material: Material, frequency: Real, *, thickness: float = values.SKIN_THICKNESS) -> Real:
    """Mean attraction on the thin coating of figure 7 under a 100 V sine [N], by the law as printed.

    Without the body's resistance, as in the paper: above 10 kHz a body would take part of the voltage.
    """
    changes: dict[str, Any] = {
        "stack.stratum_corneum.material": material,
        "stack.stratum_corneum.thickness": thickness,
        "circuit.return_path.resistance": 0.0,
    }
    scenario = scenarios()["fig7"].replace(changes)
    return mean_force(scenario, phasors(scenario, frequency), amplitude=100.0)


def rise_and_saturation(material: Material) -> tuple[float, float, float]:
    """Compute for figure 7 F(10 kHz)/F(100 Hz), F(10 kHz)/largest F and F(5 kHz)/F(10 kHz) [1]."""
    frequency = np.geomspace(100.0, 1e4, 161)
    force = frequency_force(material, frequency)
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


def suspended_constancy(*, conductivity: float) -> float:
    """Compute for figure 2 the attraction at the end of the hold over that at its beginning [1]."""
    scenario = scenarios()["fig2"]
    if conductivity:
        leaky = {"model": "Constant", "permittivity": 1.0, "conductivity": conductivity}
        scenario = scenario.replace({"stack.gap.material": leaky})
    drive = scenario.drive
    assert isinstance(drive, Trapezium)
    ends = np.array([0.0, drive.rise, drive.rise + drive.hold])
    force = simulate(scenario, time=ends).electrostatic_force.values
    return float(force[2] / force[1])
