"""The steady state through harmonics equals the one through modes that begin in their periodic state."""

import numpy as np
import pytest
import scenario_parts as parts
from harmonic_response import periodic

from electrovib.core.model import read_model
from electrovib.papers.vezzoli_2014 import Vezzoli2014Causal
from electrovib.physics.drive.base import Drive
from electrovib.physics.force import EffectiveMedium
from electrovib.solve.electrics.transient import transient
from electrovib.solve.simulate import simulate
from electrovib.solve.stack.expand import modes, phasors
from electrovib.solve.stack.keys import DisplacementOf, FieldOf

MODULATED = {"amplitude": 100, "modulation": 100, "depth": 0.8, "carrier": 3000}
TONES = {
    "sine": parts.sine(100, 125, phase=0.4),
    "offset": parts.model("Offset", level=60, drive=parts.sine(50, 40)),
    "amplitude modulation": parts.model("AmplitudeModulation", **MODULATED),
    "overmodulation": parts.model("AmplitudeModulation", amplitude=100, carrier=100, modulation=250, depth=1),
    "square root modulation": parts.model("SquareRootModulation", **MODULATED),
    "sum": parts.model("Sum", drives=[parts.sine(50, 100), parts.sine(20, 250), parts.step(30)]),
}
SLOW, FAST = parts.square(100, 60, edge=1e-3), parts.trapezium(10, 1e-3, 1e-3, 2e-3, repeat=1 / 120)
EDGES = {
    "square": parts.square(100, 60, low=-40),
    "square with edges": parts.square(100, 60, edge=2e-3),
    "pulses": parts.model("PulseTrain", high=100, low=-10, width=1e-3, frequency=60),
    "pulses with edges": parts.model("PulseTrain", high=100, width=3e-3, frequency=60, edge=1e-3),
    "trapezium": parts.trapezium(100, 2e-3, 4e-3, 1e-3, low=20, delay=1e-3, repeat=1 / 60),
    "trapezium and square": parts.model("Sum", drives=[SLOW, FAST]),
}
SURROUNDINGS = {
    "nothing": {"return_path": parts.grounded()},
    "grounded": {"return_path": parts.grounded(1000)},
    "floating": {"return_path": parts.floating()},
    "leaking": {"return_path": parts.floating(leak=1e8)},
    "source": {"return_path": parts.grounded(1000), "source_resistance": 1e6},
    "second": {"return_path": parts.model("SecondElectrode", area=0.5e-4)},
}
PRECISION = 1e-9  # demanded of drives with a closed form; measured 2e-11 for fields that nearly cancel
TIME = np.concatenate([np.linspace(0, 0.05, 211), [0.0501, 0.11, 0.7, 3.0]])


def film_on(finger, material, surroundings, drive=None):
    layers = {
        "insulator": finger.film(),
        "gap": finger.gap(1e-6, 1e-9),
        "stratum_corneum": parts.layer(200e-6, material),
    }
    return finger.build(
        drive=drive or parts.step(1), stack=layers, settled=True, circuit=SURROUNDINGS[surroundings]
    )


def quantities(section):
    """Give every linear quantity: fields, displacements, current, and what the laws make of them."""
    found = {"voltage": section.voltage, "current": section.current_density}
    for name in section.names:
        found |= {FieldOf(name): section[name].field, DisplacementOf(name): section[name].displacement}
    for law in (EffectiveMedium(), Vezzoli2014Causal()):
        found[type(law).__name__] = law.amplitudes(section)["E"]
    return found


def check_steady_state(section, drive, time, exact=None):
    """Compare every quantity; `exact` gives phasors at frequencies instead of the modes' own."""
    drive = read_model(Drive, drive)
    transfers = quantities(section)
    marched = transient(transfers, drive, time, settled=True)
    for name, transfer in transfers.items():

        def response(frequency, name=name, transfer=transfer):
            return transfer.at(frequency) if exact is None else quantities(exact(frequency))[name]

        static = float(transfer.at(0.0).real)
        steady = periodic(response, drive, time, static=static)
        assert parts.apart(marched[name], steady) < PRECISION, name


@pytest.mark.parametrize("drive", TONES.values(), ids=TONES)
def test_drives_with_a_closed_form(finger, shipped_material, drive):
    section, _ = modes(film_on(finger, shipped_material, "grounded"))
    check_steady_state(section, drive, TIME)


@pytest.mark.parametrize("surroundings", SURROUNDINGS)
def test_every_way_back(finger, shipped_material, surroundings):
    """Debye sums are not reduced, so phasors of the material itself must give the same steady state."""
    scenario = film_on(finger, shipped_material, surroundings)
    section, error = modes(scenario)
    for drive in ("offset", "amplitude modulation"):
        check_steady_state(section, TONES[drive], TIME)
    declared = shipped_material.debye() is not None
    assert error == 0 or not declared
    exact = (lambda frequency: phasors(scenario, frequency)) if declared else None
    check_steady_state(section, TONES["sum"], TIME, exact=exact)


def truncation(drive, harmonics, time):
    """Bound what the harmonics left out can add to a response that no frequency amplifies.

    |sum over n > N of exp(j n x)/n^k| <= 1/((N + 1)^k |sin(x/2)|), k = 1 for a jump and 2 for a bend, where it
    is also below 1/N; twice that, because the response weighs the harmonics with a gain that varies.
    """
    next_one = harmonics + 1
    bound = np.zeros(len(time))
    for part in read_model(Drive, drive).parts():
        first, last, starts = part.after[:-1], part.before[1:], part.times[:-1]
        slopes = (last - first) / np.diff(part.times)
        for jump, bend, start in zip(
            first - np.roll(last, 1), slopes - np.roll(slopes, 1), starts, strict=True
        ):
            half = np.abs(np.sin(np.pi * (time - start) / part.period))
            with np.errstate(divide="ignore", invalid="ignore"):  # at the jump itself nothing is promised
                bound += np.where(jump == 0, 0.0, np.abs(jump) / (np.pi * next_one * half))
                tail = np.minimum(1 / harmonics, 1 / (next_one**2 * half))
            bound += np.abs(bend) * part.period / (2 * np.pi**2) * tail
    return 2 * bound


@pytest.mark.parametrize("drive", EDGES.values(), ids=EDGES)
@pytest.mark.parametrize("harmonics", [pytest.param(256, marks=pytest.mark.slow), 4096])
def test_edges_to_the_stated_truncation(finger, shipped_material, drive, harmonics):
    section, _ = modes(film_on(finger, shipped_material, "grounded"))
    time = np.linspace(0, 2 / 60, 139)  # none on an edge but the ends
    bound = truncation(drive, harmonics, time)
    drive = read_model(Drive, drive)
    transfers = {"gap": section["gap"].field, "voltage": section.voltage}
    marched = transient(transfers, drive, time, settled=True)
    for name, transfer in transfers.items():
        static = float(transfer.at(0.0).real)
        steady = periodic(transfer.at, drive, time, static=static, harmonics=harmonics)
        size = np.max(np.abs(transfer.at(np.geomspace(1, 1e9, 91))))
        error = np.abs(marched[name] - steady) / size
        assert np.all(error < bound + PRECISION * np.max(np.abs(steady)) / size)
        # refused even where little is left between the edges
        wrong = np.abs(1.01 * marched[name] - steady) / size
        assert harmonics < 4096 or np.any(wrong > bound)


def test_simulate_takes_the_periodic_state(finger):
    """A whole Trace, laws included, from the harmonics of the declared material alone."""
    scenario = film_on(finger, parts.debye(60, 4e3, 2e-3, 1e-6), "floating", drive=TONES["offset"])
    trace = simulate(scenario, time=TIME)

    def gap_field(frequency):
        return phasors(scenario, frequency)["gap"].field

    steady = periodic(gap_field, scenario.drive, TIME, static=0.0)  # the film blocks, and the gap leaks
    force = parts.EPS0 * finger.AREA * steady**2 / 2
    assert parts.apart(trace["electrostatic_force"].values, force) < PRECISION
    assert trace.attrs["solver"] == "periodic"
