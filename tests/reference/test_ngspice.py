"""Exported netlists run by ngspice against our own results: an independent simulator, given nothing but the file."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from electrovib.core.errors import InputError
from electrovib.export.spice.netlist import netlist
from electrovib.export.spice.timing import Timing
from electrovib.papers.palmar_1995 import skins
from electrovib.physics.drive.pieces import Linear
from electrovib.scenario import paper_scenario
from electrovib.solve.simulate import simulate
from electrovib.solve.stack.expand import modes, phasors

ELECTRICAL = 5e-4
"""Of the peak, two longest steps after a corner of the drive and later; 1.4e-4 was measured, 1e-3 is promised."""
FORCE = 1e-3
"""Twice the electrical one: a force is a square."""
OVER_FREQUENCY = 1e-7
"""Against the same Debye terms; rounding of ngspice, which solves for voltages of nodes."""
LOST_DIGITS = 3e-4
"""The same where the largest conductance is as large as is accepted."""
DECLARED = 5e-4
"""Against materials as declared: the reduction, 3.2e-4 for palmar skin."""


def require_ngspice(found, *, checked_by_machine):
    """Skip where a person has no ngspice; fail where it has to be there."""
    if found is None and checked_by_machine:
        pytest.fail("ngspice is not installed, and continuous integration has to compare with it")
    if found is None:
        pytest.skip("ngspice is not installed")


@pytest.fixture(scope="session")
def ngspice():
    found = shutil.which("ngspice")
    require_ngspice(found, checked_by_machine=bool(os.environ.get("CI")))
    return found


class Tables(NamedTuple):
    time: dict[str, np.ndarray]
    frequency: dict[str, np.ndarray]
    said: str


def run(ngspice, text, folder: Path) -> Tables:
    (folder / "circuit.cir").write_text(text)
    done = subprocess.run(
        [ngspice, "-b", "circuit.cir"], cwd=folder, capture_output=True, text=True, timeout=300, check=True
    )
    said = done.stdout + done.stderr
    for word in ("error", "singular", "aborted", "too small", "unrecognized", "no such"):
        assert word not in said.lower(), said
    real = np.loadtxt(folder / "circuit.time.txt", skiprows=1)
    names = (folder / "circuit.time.txt").read_text().split("\n", 1)[0].split()
    pairs = np.loadtxt(folder / "circuit.frequency.txt", skiprows=1)
    heads = (folder / "circuit.frequency.txt").read_text().split("\n", 1)[0].split()
    over_frequency = {"frequency": pairs[:, 0]}
    over_frequency |= {heads[k]: pairs[:, k] + 1j * pairs[:, k + 1] for k in range(1, len(heads), 2)}
    later = np.concatenate([[True], np.diff(real[:, 0]) > 0])
    return Tables(dict(zip(names, real[later].T, strict=True)), over_frequency, said)


SKIN = {"thickness": 200e-6, "material": skins()["medium_men"].material.to_dict()}
TRAPEZIUM = {"model": "Trapezium", "high": 1000, "rise": 36e-3, "hold": 0.1, "fall": 36e-3}
SQUARE = {"model": "Square", "high": 100, "low": -100, "frequency": 60}
MODULATED = {
    "model": "AmplitudeModulation",
    "amplitude": 100,
    "carrier": 1000,
    "modulation": 100,
    "depth": 0.8,
}
CHIRP = {"model": "Chirp", "amplitude": 100, "first": 10, "last": 500, "length": 0.05}
UNEVEN = {"model": "Sampled", "time_samples": [0, 1e-3, 3e-3, 3.5e-3], "voltage_samples": [5, 10, -4, 0]}
SUM = {
    "model": "Sum",
    "drives": [
        {"model": "Sine", "amplitude": 50, "frequency": 100, "phase": 0.7},
        {
            "model": "Offset",
            "drive": {"model": "PulseTrain", "high": 30, "width": 1e-3, "frequency": 250},
            "level": 10,
        },
    ],
}
CURRENT = {"model": "CurrentSine", "amplitude": 1e-5, "frequency": 500, "phase": 0.3}
BURST = {"model": "Burst", "amplitude": 100, "frequency": 250, "cycles": 3, "delay": 2e-3}
FLOATING = {"model": "Floating", "capacitance": 150e-12}
SHOES = FLOATING | {"leak": 1e9}
SECOND = {"model": "SecondElectrode", "area": 0.5e-4}
ONE_WAY = {"model": "PolarityConduction", "conductivity_positive": 5e-6, "conductivity_negative": 1e-6}

BRIDGED = {
    "thickness": 3e-6,
    "material": {"model": "BridgedAir", "bridged_share": 0.3, "spot_conductivity": 1e-8},
}


@pytest.fixture(scope="session")
def cases(finger):
    film, build = finger.film(), finger.build
    leaky, plain = finger.gap(1e-6, 1 / 8.7e8), finger.skin(1560, 1.79384e-6)
    bare, full = (
        {"insulator": film, "stratum_corneum": SKIN},
        {"insulator": film, "gap": leaky, "stratum_corneum": SKIN},
    )
    charged = full | {"insulator": film | {"initial_charge": 1e-5}, "gap": leaky | {"initial_charge": -3e-6}}
    rectifying = {"insulator": film, "stratum_corneum": finger.skin(1560) | {"leak": ONE_WAY}}
    founding, old = "Vezzoli2014Causal", {"insulator": film, "gap": leaky, "stratum_corneum": plain}
    return {
        "film of Vezzoli et al. 2014": paper_scenario("vezzoli_2014/fig6"),
        "film of Vezzoli et al. 2014, palmar skin": build(drive=TRAPEZIUM, stack=bare, force=founding, resistance=1e3),
        "static law": build(drive=SQUARE, stack=full, force="EffectiveMedium", settled=True),
        "leaky gap": build(drive=SQUARE, stack=full, resistance=1e3),
        "leaky gap, no resistance": build(drive=SQUARE, stack=old),
        "floating": build(drive=SQUARE, stack=full, return_path=FLOATING),
        "floating, leak": build(drive=SUM, stack=full, return_path=SHOES, settled=True, force="MaxwellStressInInsulator"),
        "second electrode": build(drive=SQUARE, stack=full, return_path=SECOND),
        "modulated": build(drive=MODULATED, stack=bare, force="MaxwellStressInStratumCorneum", resistance=1e3),
        "modulated, settled": build(drive=MODULATED, stack=full, force=founding, return_path=SECOND, settled=True),
        "step": build(drive={"model": "Step", "level": 100}, stack=full, force=founding, resistance=1e3),
        "burst": build(drive=BURST, stack=old),
        "chirp": build(drive=CHIRP, stack=old),
        "measured": build(drive=UNEVEN, stack=full),
        "initial charge": build(drive=TRAPEZIUM, stack=charged, force=founding, resistance=1e3),
        "initial charge, no resistance": build(drive=TRAPEZIUM, stack=charged, return_path=FLOATING | {"resistance": 0}),
        "current": build(drive=CURRENT, stack=full, return_path=FLOATING),
        "current, settled": build(drive=CURRENT, stack=full, return_path=FLOATING | {"leak": 1e7}, settled=True),
        "bridged gap": build(drive=SQUARE, stack=full | {"gap": BRIDGED}, resistance=1e3),
        "rectifying": build(drive=SQUARE, stack=rectifying, resistance=1e3),
    }  # fmt: skip


NAMES = (
    "film of Vezzoli et al. 2014", "film of Vezzoli et al. 2014, palmar skin", "static law", "leaky gap", "leaky gap,"
    " no resistance", "floating",
    "floating, leak", "second electrode", "modulated", "modulated, settled", "step", "burst", "chirp", "measured",
    "initial charge", "initial charge, no resistance", "current", "current, settled", "bridged gap", "rectifying",
)  # fmt: skip


def away_from_corners(scenario, time):
    """Times at least two longest steps after a corner or a switching of the drive."""
    timing = Timing.of(scenario.drive, scenario.time)
    corners = [0.0]
    for part in scenario.drive.parts():
        if isinstance(part, Linear):
            corners += part.until(timing.duration).times.tolist()
        else:
            corners += [part.start, part.stop]
    since = np.min([np.where(time < at - timing.edge, np.inf, time - at) for at in corners], axis=0)
    return since > 2 * timing.step


def largest_error(ours, theirs, where=slice(None)):
    """Largest difference over the largest value."""
    return float(np.max(np.abs(theirs - ours)[where]) / np.max(np.abs(ours)))


def errors_over_time(scenario, tables):
    time = tables.time["time"]
    trace, away = simulate(scenario, time=time), away_from_corners(scenario, time)
    assert np.count_nonzero(away) > 200
    plain = {"drive_voltage", "stack_voltage", "current", "effective_voltage", "electrostatic_force"}
    pairs = {name: trace[name].values for name in plain & set(trace.variables)}
    for layer in trace.layer.values:
        pairs |= {
            f"{kind}_{layer}": trace[kind].sel(layer=layer).values for kind in ("field", "displacement")
        }
    assert set(pairs) <= set(tables.time)
    return {name: largest_error(row, tables.time[name], away) for name, row in pairs.items()}


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_transient_agrees(name, cases, ngspice, tmp_path, record_property):
    scenario = cases[name]
    tables = run(ngspice, netlist(scenario, name="circuit"), tmp_path)
    assert tables.time["time"][-1] == pytest.approx(
        Timing.of(scenario.drive, scenario.time).duration, rel=1e-9
    )
    errors = errors_over_time(scenario, tables)
    for quantity, error in errors.items():
        record_property(quantity, error)
    force = errors.pop("electrostatic_force")
    assert max(errors.values()) < ELECTRICAL, errors
    assert force < FORCE


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_frequency_response_agrees(name, cases, ngspice, tmp_path):
    scenario = cases[name]
    found = run(ngspice, netlist(scenario, name="circuit"), tmp_path).frequency
    frequency = found["frequency"]
    grid = scenario.frequency.frequencies()
    np.testing.assert_allclose(frequency, grid, rtol=1e-9)
    exact = phasors(scenario, frequency)
    volts = 1.0 if scenario.drive.quantity == "voltage" else found["impedance"]
    area = scenario.contact.gross_area()
    if scenario.drive.quantity == "voltage":
        assert largest_error(1 / (exact.current_density * area * found["impedance"]), 1.0) < DECLARED
    for layer in exact.names:
        declared = exact[layer].field * exact[layer].thickness / volts
        assert largest_error(declared, found[f"field_gain_{layer}"]) < DECLARED
    law = scenario.force.amplitudes(exact)
    for name_, phasor in law.items():
        assert largest_error(phasor / volts, found[f"force_amplitude_{name_.lower()}_gain"]) < DECLARED


def errors_over_frequency(scenario, found):
    """Against the same Debye terms."""
    section, frequency, errors = modes(scenario)[0], found["frequency"], {}
    for layer in section.names:
        ours = section[layer].field.at(frequency) * section[layer].thickness
        errors[layer] = largest_error(ours, found[f"field_gain_{layer}"])
    for quantity, transfer in scenario.force.amplitudes(section).items():
        gain = found[f"force_amplitude_{quantity.lower()}_gain"]
        errors[quantity] = largest_error(transfer.at(frequency), gain)
    return errors


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in NAMES if "current" not in name and name != "rectifying"])
def test_frequency_response_of_the_same_debye_terms_agrees(name, cases, ngspice, tmp_path):
    """With the reduction on both sides nothing but rounding is left."""
    found = run(ngspice, netlist(cases[name], name="circuit"), tmp_path).frequency
    errors = errors_over_frequency(cases[name], found)
    assert max(errors.values()) < OVER_FREQUENCY, errors


def random_scenario(finger, seed):
    """Layers over many decades under a random drive, return path and start."""
    random = np.random.default_rng(seed)
    stack = {}
    for name, slab in zip(
        ("insulator", "gap", "stratum_corneum", "sweat", "cream"), finger.random_stack(random), strict=False
    ):
        terms = zip(slab.debye.strengths, slab.debye.relaxation_times, strict=True)
        material = {
            "model": "Prony",
            "permittivity_high": slab.debye.high,
            "conductivity": slab.conductivity,
            "terms": [{"strength": strength, "relaxation_time": time} for strength, time in terms],
        }
        stack[name] = {"thickness": slab.thickness, "material": material}
        if name in ("sweat", "cream"):
            stack[name]["role"] = "finger"
    resistance = float(random.choice([0, 10 ** random.uniform(1, 7)]))
    paths = [{"model": "Grounded"}, FLOATING, SHOES, SECOND]
    drives = [
        {
            "model": "Sine",
            "amplitude": 100,
            "frequency": float(10 ** random.uniform(0, 5)),
            "phase": float(random.uniform(-3, 3)),
        },
        {"model": "Square", "high": 100, "low": -30, "frequency": float(10 ** random.uniform(0, 4))},
        {
            "model": "Trapezium",
            "low": -3,
            "high": 100,
            "rise": 1e-3,
            "hold": 2e-3,
            "fall": 2e-3,
            "repeat": 0.01,
        },
    ]
    return finger.build(
        drive=drives[random.integers(3)],
        stack=stack,
        force="MaxwellStressInInsulator",
        return_path=paths[random.integers(4)] | {"resistance": resistance},
        settled=bool(random.random() < 0.5),
    )


@pytest.mark.slow
def test_random_stacks_agree_or_are_refused(finger, ngspice, tmp_path):
    """What the digits of ngspice cannot hold is refused; all the rest comes out right."""
    accepted = 0
    for seed in range(40):
        scenario = random_scenario(finger, seed)
        try:
            text = netlist(scenario, name="circuit")
        except InputError as error:
            if "16 digits" not in str(error):
                raise
            continue
        tables = run(ngspice, text, tmp_path)
        errors = errors_over_time(scenario, tables)
        errors.pop("current")  # with no resistance at all it jumps, and its decay begins inside an edge
        assert max(errors.values()) < 1e-3, (seed, errors)
        over_frequency = errors_over_frequency(scenario, tables.frequency)
        assert max(over_frequency.values()) < LOST_DIGITS, (seed, over_frequency)
        accepted += 1
    assert accepted >= 15


ELEMENTS = (
    "C_insulator_high",
    "R_gap_conduction",
    "C_stratum_corneum_8",
    "R_stratum_corneum_9",
    "R_return",
    "B_force",
)


@pytest.mark.slow
@pytest.mark.parametrize("element", ELEMENTS)
def test_a_wrong_element_is_noticed(element, cases, ngspice, tmp_path):
    """One value 2 % off, in a layer, in the body or in the force."""

    def off(match):
        return f"{match[1]}{1.02 * float(match[2]):.15g}"

    pattern = rf"^({element} \S+ \S+ (?:V = )?)([0-9.e+-]+)"
    wrong, count = re.subn(pattern, off, netlist(cases["leaky gap"], name="circuit"), flags=re.MULTILINE)
    assert count == 1
    tables = run(ngspice, wrong, tmp_path)
    force = errors_over_time(cases["leaky gap"], tables)["electrostatic_force"]
    linear = max(errors_over_frequency(cases["leaky gap"], tables.frequency).values())
    assert (force > FORCE) if element == "B_force" else (linear > OVER_FREQUENCY)


def test_half_the_step_is_nearer(finger, ngspice, tmp_path):
    """What remains is the error of the stated step, of second order: at least 3 times less with half of it."""
    drive = {"model": "Sine", "amplitude": 100, "frequency": 2}
    stack = {"insulator": finger.film(), "stratum_corneum": finger.skin(1560, 1.79384e-6)}
    found = []
    for samples in (2001, 4001, 8001):
        grid = {"duration": 0.5, "samples": samples}
        scenario = finger.build(drive=drive, stack=stack, force="Vezzoli2014Causal", time=grid)
        even = netlist(scenario, name="circuit").replace("trtol=1 ", "trtol=1e6 ")  # steps as long as allowed
        found.append(errors_over_time(scenario, run(ngspice, even, tmp_path))["effective_voltage"])
    assert found[0] > 3 * found[1] > 9 * found[2]


@pytest.mark.parametrize(("ci", "outcome"), [(True, pytest.fail.Exception), (False, pytest.skip.Exception)])
def test_a_missing_ngspice_is_never_passed_over_by_the_machine(ci, outcome):
    with pytest.raises(outcome, match="ngspice is not installed"):
        require_ngspice(None, checked_by_machine=ci)
    require_ngspice("/usr/bin/ngspice", checked_by_machine=ci)
