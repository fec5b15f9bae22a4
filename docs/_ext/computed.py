"""Curves of the figures of the explanations, computed by the toolkit; tests compare the numbers of the text with them."""

from __future__ import annotations

from typing import Any, Final, NamedTuple

import numpy as np

import electrovib as ev
from electrovib.core.arrays import Real
from electrovib.core.constants import VACUUM_PERMITTIVITY
from electrovib.papers.vezzoli_2014 import values
from electrovib.papers.vezzoli_2014.laws import literal_response
from electrovib.physics.drive.edges import Trapezium
from electrovib.scenario import Scenario
from electrovib.studies.rough_contact import RestingContact
from electrovib.studies.surfaces import FILM, FORMS, SCREEN, PlateStack

STEP: Final = {"model": "Step", "level": "1 kV"}
SINE: Final = {"model": "Sine", "amplitude": "1 kV", "frequency": "100 Hz"}
INSULATING: Final = {"model": "Constant", "permittivity": 1.0}
CASES: Final[dict[str, tuple[str, dict[str, Any]]]] = {
    "law of Vezzoli et al. 2014, conducting skin": ("vezzoli_2014/fig6", {}),
    "Maxwell stress in a gap that leaks": ("vezzoli_2014/fig6_gap", {}),
    "the same gap without a leak, conducting skin": (
        "vezzoli_2014/fig6_gap",
        {"stack.gap.material": INSULATING},
    ),
}
"""Scenario and changes of each curve of the first figure."""


class Response(NamedTuple):
    """Attraction of one case after a step, and its mean under a sine."""

    time: Real
    """After the step [s]."""
    force: Real
    """Over that just after the step [1]."""
    frequency: Real
    """Of the sine [Hz]."""
    mean: Real
    """Over that at the highest frequency [1]."""


def time_constant() -> float:
    """Return (C_i + C_s) R_s of the stack of `vezzoli_2014/fig6` [s]."""
    layers = ev.load("vezzoli_2014/fig6").stack.layers
    film, skin = layers["insulator"], layers["stratum_corneum"]
    of_film, of_skin = (one.material.permittivity / one.thickness for one in (film, skin))
    return float(VACUUM_PERMITTIVITY * (of_film + of_skin) * skin.thickness / skin.material.conductivity)


def responses() -> dict[str, Response]:
    """Compute what fades after a step of 1 kV, and what grows with the frequency of a sine, for each case."""
    time = np.concatenate([[1e-9], np.linspace(0.1e-3, 30e-3, 300)])
    found = {}
    for label, (name, changes) in CASES.items():
        base = ev.load(name).replace(changes | {"circuit.return_path.resistance": 0.0})
        force = ev.simulate(base.replace({"drive": STEP}), time=time).electrostatic_force.values
        mean = ev.simulate(base.replace({"drive": SINE})).mean_force
        low = mean.sel(frequency=slice(None, 1.001e4))
        found[label] = Response(time, force / force[0], low.frequency.values, low.values / low.values[-1])
    return found


class Forces(NamedTuple):
    """Static attraction by each law on one stack."""

    stack: PlateStack
    gap: Real
    """Of the law with a gap [m]."""
    in_gap: Real
    """Maxwell stress in the gap [N]."""
    others: dict[str, float]
    """Force of each law, without a gap [N]."""


def static(scenario: Scenario) -> float:
    """Compute the attraction of layers that do not conduct, at a constant voltage [N]."""
    return float(ev.simulate(scenario, time=[0.0, 1e-3]).electrostatic_force[-1])


def forces() -> list[Forces]:
    """Compute the static attraction of each law on the film and on the coating, over the gap."""
    gap = np.geomspace(0.1e-6, 100e-6, 31)
    return [
        Forces(
            stack,
            gap,
            np.array([static(stack.scenario("MaxwellStressInGap", gap=float(one))) for one in gap]),
            {law: static(stack.scenario(law)) for law in FORMS},
        )
        for stack in (FILM, SCREEN)
    ]


class Readings(NamedTuple):
    """Effective voltage by two readings of one formula, around the beginning of a ramp."""

    time: Real
    """From the beginning of the ramp [s]."""
    as_printed: Real
    """Over its largest value [1]."""
    causal: Real
    """Over the largest value of the reading as printed [1]."""


SKIN: Final = "palmar_1995/dry_men"
RAMP: Final = 20e-3


def readings(skin: str = SKIN) -> Readings:
    """Compute both readings for a skin under a ramp of 20 ms, the one as printed by a discrete Fourier transform."""
    period, count = 8.0, 1 << 20
    time = np.arange(count) * period / count - period / 2
    scenario = ev.load("vezzoli_2014/fig6").replace(
        {"stack.stratum_corneum.material": skin, "circuit.return_path.resistance": 0.0}
    )
    material = scenario.stack.layers["stratum_corneum"].material
    drive = Trapezium(high=1.0, rise=RAMP, hold=0.2, fall=RAMP)
    spectrum = np.fft.rfft(drive.voltage(time))
    frequency = np.fft.rfftfreq(count, period / count)[1:]
    film = VACUUM_PERMITTIVITY * values.FILM_PERMITTIVITY / values.FILM_THICKNESS
    layer = VACUUM_PERMITTIVITY * material.complex_permittivity(frequency) / values.SKIN_THICKNESS
    spectrum[0] = 0.0
    spectrum[1:] *= literal_response(frequency, insulator=film, skin=layer)
    printed = np.fft.irfft(spectrum, count)
    near = (time > -20e-3) & (time < 40e-3)
    shown = time[near][::16]
    after = shown[shown > 0]
    table = {"model": "Trapezium", "high": "1 V", "rise": RAMP, "hold": 0.2, "fall": RAMP}
    causal = ev.simulate(scenario.replace({"drive": table}), time=after).effective_voltage.values
    largest = float(np.max(np.abs(printed)))
    full = np.concatenate([np.zeros(shown.size - after.size), causal])
    return Readings(shown, printed[near][::16] / largest, full / largest)


class Recording(NamedTuple):
    """Recording of the tutorial, and what the scenario gives before and after the fit."""

    time: Real
    """s."""
    recorded: Real
    """Attraction with noise [N]."""
    curves: dict[float, Real]
    """Thickness of the film [m] to the attraction [N]."""


FITTED: Final = 75.109e-6
"""Thickness that the fit of the tutorial finds [m]."""


def recording() -> Recording:
    """Compute the recording of the tutorial, and the attraction with the thickness of the scenario and of the fit."""
    time = np.arange(0, 0.3, 0.5e-3)
    base = ev.load("vezzoli_2014/fig6")
    forces = {
        thickness: ev.simulate(
            base.replace({"stack.insulator.thickness": thickness}), time=time
        ).electrostatic_force.values
        for thickness in (75e-6, 90e-6, FITTED)
    }
    noise = 0.05e-3 * np.random.default_rng(1).standard_normal(time.size)
    return Recording(time, forces[75e-6] + noise, {one: forces[one] for one in (90e-6, FITTED)})


class Gaps(NamedTuple):
    """A rough contact at one voltage, its gaps in order, and attraction over voltage."""

    found: RestingContact
    gap: Real
    """From the smallest on [m]."""
    area: Real
    """Share of the area with gaps up to that [1]."""
    attraction: Real
    """Share of the attraction there [1]."""


def gaps() -> Gaps:
    """Press a rough skin on the screen of Bau 2010, and raise the voltage."""
    rough = ev.SelfAffine(rms=2e-6, hurst=0.8, longest=1e-3, roll_off=2.5e-4, shortest=62.5e-6)
    found = ev.rough_contact(
        "bau_2010/sine",
        roughness=rough,
        body=ev.Elastic(modulus=1e7),
        voltage=np.linspace(0.0, 40.0, 41),
    )
    last = found.rests[-1]
    order = np.argsort(last.gap, axis=None)
    gap, pull = last.gap.ravel()[order], last.attraction.ravel()[order]
    shares = np.arange(1, gap.size + 1) / gap.size
    every = slice(None, None, 64)
    return Gaps(found, gap[every], shares[every], (np.cumsum(pull) / pull.sum())[every])
