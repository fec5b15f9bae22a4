"""Exported netlists run by ngspice against our own results: an independent simulator, given nothing but the file."""

import re
import shutil
import subprocess
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from scenario_parts import constant, floating, layer, model, polarity, prony, sine, square, trapezium

from electrovib.core.errors import InputError
from electrovib.exports.spice.circuit import Timing
from electrovib.exports.spice.netlist import netlist
from electrovib.papers.palmar_1995 import skins
from electrovib.physics.drive.parts import Linear
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


@pytest.fixture(scope="session")
def ngspice():
    """Where it is missing these tests are skipped, which fails on the machine that checks every change."""
    found = shutil.which("ngspice")
    if found is None:
        pytest.skip("ngspice is not installed")
    return found


class Tables(NamedTuple):
    time: dict[str, np.ndarray]
    frequency: dict[str, np.ndarray]


def table(path):
    """Names in the first row, and the columns below."""
    return path.read_text().split("\n", 1)[0].split(), np.loadtxt(path, skiprows=1)


def run(ngspice, text, folder: Path) -> Tables:
    (folder / "circuit.cir").write_text(text)
    how = {"cwd": folder, "capture_output": True, "text": True, "timeout": 300}
    done = subprocess.run([ngspice, "-b", "circuit.cir"], check=True, **how)
    said = done.stdout + done.stderr
    for word in ("error", "singular", "aborted", "too small", "unrecognized", "no such"):
        assert word not in said.lower(), said
    names, real = table(folder / "circuit.time.txt")
    later = np.concatenate([[True], np.diff(real[:, 0]) > 0])
    heads, pairs = table(folder / "circuit.frequency.txt")
    over_frequency = {"frequency": pairs[:, 0]}
    over_frequency |= {heads[k]: pairs[:, k] + 1j * pairs[:, k + 1] for k in range(1, len(heads), 2)}
    return Tables(dict(zip(names, real[later].T, strict=True)), over_frequency)


SKIN = layer(200e-6, skins()["medium_men"].material.to_dict())
TRAPEZIUM = trapezium(1000, 36e-3, 0.1, 36e-3)
SQUARE = square(100, 60, low=-100)
MODULATED = model("AmplitudeModulation", amplitude=100, carrier=1000, modulation=100, depth=0.8)
CHIRP = model("Chirp", amplitude=100, first=10, last=500, length=0.05)
UNEVEN = model("Sampled", time_samples=[0, 1e-3, 3e-3, 3.5e-3], voltage_samples=[5, 10, -4, 0])
PULSES = model("PulseTrain", high=30, width=1e-3, frequency=250)
SUM = model("Sum", drives=[sine(50, 100, phase=0.7), model("Offset", drive=PULSES, level=10)])
CURRENT = model("CurrentSine", amplitude=1e-5, frequency=500, phase=0.3)
BURST = model("Burst", amplitude=100, frequency=250, cycles=3, delay=2e-3)
FLOATING, SHOES = floating(), floating(leak=1e9)
SECOND = model("SecondElectrode", area=0.5e-4)
BRIDGED = layer(3e-6, model("BridgedAir", bridged_share=0.3, spot_conductivity=1e-8))
FILM = layer(90e-6, constant(3.35))
LEAKY_GAP = layer(1e-6, constant(1.0, 1 / 8.7e8))
PLAIN_SKIN = layer(200e-6, constant(1560, 1.79384e-6))
BARE = {"insulator": FILM, "stratum_corneum": SKIN}
FULL = {"insulator": FILM, "gap": LEAKY_GAP, "stratum_corneum": SKIN}
OLD = FULL | {"stratum_corneum": PLAIN_SKIN}
CHARGED = FULL | {"insulator": FILM | {"initial_charge": 1e-5}, "gap": LEAKY_GAP | {"initial_charge": -3e-6}}
RECTIFYING = BARE | {"stratum_corneum": layer(200e-6, constant(1560), leak=polarity(5e-6, 1e-6))}
CAUSAL = {"force": "Vezzoli2014Causal"}
STRAP, SETTLED = {"resistance": 1e3}, {"settled": True}
IN_SKIN, IN_FILM = {"force": "MaxwellStressInStratumCorneum"}, {"force": "MaxwellStressInInsulator"}
BODY, BACK = {"return_path": FLOATING}, {"return_path": SECOND}
CASES = {
    "film of Vezzoli et al. 2014": None,
    "film of Vezzoli et al. 2014, palmar skin": (TRAPEZIUM, BARE, CAUSAL | STRAP),
    "static law": (SQUARE, FULL, {"force": "EffectiveMedium"} | SETTLED),
    "leaky gap": (SQUARE, FULL, STRAP),
    "leaky gap, no resistance": (SQUARE, OLD, {}),
    "floating": (SQUARE, FULL, BODY),
    "floating, leak": (SUM, FULL, {"return_path": SHOES} | SETTLED | IN_FILM),
    "second electrode": (SQUARE, FULL, BACK),
    "modulated": (MODULATED, BARE, IN_SKIN | STRAP),
    "modulated, settled": (MODULATED, FULL, CAUSAL | BACK | SETTLED),
    "step": (model("Step", level=100), FULL, CAUSAL | STRAP),
    "burst": (BURST, OLD, {}),
    "chirp": (CHIRP, OLD, {}),
    "measured": (UNEVEN, FULL, {}),
    "initial charge": (TRAPEZIUM, CHARGED, CAUSAL | STRAP),
    "initial charge, no resistance": (TRAPEZIUM, CHARGED, {"return_path": FLOATING | {"resistance": 0}}),
    "current": (CURRENT, FULL, BODY),
    "current, settled": (CURRENT, FULL, {"return_path": floating(leak=1e7)} | SETTLED),
    "bridged gap": (SQUARE, FULL | {"gap": BRIDGED}, STRAP),
    "rectifying": (SQUARE, RECTIFYING, STRAP),
}


def scenario_of(finger, name):
    if CASES[name] is None:
        return paper_scenario("vezzoli_2014/fig6")
    drive, stack, more = CASES[name]
    return finger.build(drive=drive, stack=stack, **more)


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
    for name in trace.layer.values:
        pairs |= {f"{kind}_{name}": trace[kind].sel(layer=name).values for kind in ("field", "displacement")}
    assert set(pairs) <= set(tables.time)
    return {name: largest_error(row, tables.time[name], away) for name, row in pairs.items()}


def errors_over_frequency(scenario, found):
    """Against the same Debye terms."""
    section, frequency, errors = modes(scenario)[0], found["frequency"], {}
    for name in section.names:
        ours = section[name].field.at(frequency) * section[name].thickness
        errors[name] = largest_error(ours, found[f"field_gain_{name}"])
    for quantity, transfer in scenario.force.amplitudes(section).items():
        gain = found[f"force_amplitude_{quantity.lower()}_gain"]
        errors[quantity] = largest_error(transfer.at(frequency), gain)
    return errors


def errors_of_declared(scenario, found):
    """Against the materials as declared."""
    frequency = found["frequency"]
    exact, errors = phasors(scenario, frequency), {}
    volts = 1.0 if scenario.drive.quantity == "voltage" else found["impedance"]
    if scenario.drive.quantity == "voltage":
        flow = exact.current_density * scenario.contact.gross_area() * found["impedance"]
        errors["impedance"] = largest_error(1 / flow, 1.0)
    for name in exact.names:
        declared = exact[name].field * exact[name].thickness / volts
        errors[name] = largest_error(declared, found[f"field_gain_{name}"])
    for quantity, phasor in scenario.force.amplitudes(exact).items():
        errors[quantity] = largest_error(phasor / volts, found[f"force_amplitude_{quantity.lower()}_gain"])
    return errors


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_transient_and_frequency_response_agree(name, finger, ngspice, tmp_path, record_property):
    scenario = scenario_of(finger, name)
    tables = run(ngspice, netlist(scenario, name="circuit"), tmp_path)
    duration = Timing.of(scenario.drive, scenario.time).duration
    assert tables.time["time"][-1] == pytest.approx(duration, rel=1e-9)
    errors = errors_over_time(scenario, tables)
    for quantity, error in errors.items():
        record_property(quantity, error)
    assert errors.pop("electrostatic_force") < FORCE
    assert max(errors.values()) < ELECTRICAL, errors
    grid = scenario.frequency.frequencies()
    np.testing.assert_allclose(tables.frequency["frequency"], grid, rtol=1e-9)
    errors = errors_of_declared(scenario, tables.frequency)
    assert max(errors.values()) < DECLARED, errors
    if "current" not in name and name != "rectifying":  # nothing but rounding is left
        errors = errors_over_frequency(scenario, tables.frequency)
        assert max(errors.values()) < OVER_FREQUENCY, errors


def random_scenario(finger, seed):
    """Layers over many decades under a random drive, return path and start."""
    random = np.random.default_rng(seed)
    stack, names = {}, ("insulator", "gap", "stratum_corneum", "sweat", "cream")
    for name, slab in zip(names, finger.random_stack(random), strict=False):
        role = {"role": "finger"} if name in ("sweat", "cream") else {}
        stack[name] = layer(slab.thickness, prony(slab.debye, slab.conductivity), **role)
    resistance = float(random.choice([0, 10 ** random.uniform(1, 7)]))
    paths = [model("Grounded"), FLOATING, SHOES, SECOND]
    drives = [
        sine(100, float(10 ** random.uniform(0, 5)), phase=float(random.uniform(-3, 3))),
        square(100, float(10 ** random.uniform(0, 4)), low=-30),
        trapezium(100, 1e-3, 2e-3, 2e-3, low=-3, repeat=0.01),
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


ELEMENTS = [
    "C_insulator_high",
    "R_gap_conduction",
    "C_stratum_corneum_8",
    "R_stratum_corneum_9",
    "R_return",
    "B_force",
]


@pytest.mark.slow
@pytest.mark.parametrize("element", ELEMENTS)
def test_a_wrong_element_is_noticed(element, finger, ngspice, tmp_path):
    """One value 2 % off, in a layer, in the body or in the force."""
    scenario = scenario_of(finger, "leaky gap")

    def off(match):
        return f"{match[1]}{1.02 * float(match[2]):.15g}"

    pattern = rf"^({element} \S+ \S+ (?:V = )?)([0-9.e+-]+)"
    wrong, count = re.subn(pattern, off, netlist(scenario, name="circuit"), flags=re.MULTILINE)
    assert count == 1
    tables = run(ngspice, wrong, tmp_path)
    force = errors_over_time(scenario, tables)["electrostatic_force"]
    linear = max(errors_over_frequency(scenario, tables.frequency).values())
    assert (force > FORCE) if element == "B_force" else (linear > OVER_FREQUENCY)


def test_half_the_step_is_nearer(finger, ngspice, tmp_path):
    """What remains is the error of the stated step, of second order: at least 3 times less with half of it."""
    stack = {"insulator": FILM, "stratum_corneum": PLAIN_SKIN}
    found = []
    for samples in (2001, 4001, 8001):
        grid = {"duration": 0.5, "samples": samples}
        scenario = finger.build(drive=sine(100, 2), stack=stack, **CAUSAL, time=grid)
        even = netlist(scenario, name="circuit").replace("trtol=1 ", "trtol=1e6 ")  # steps as long as allowed
        found.append(errors_over_time(scenario, run(ngspice, even, tmp_path))["effective_voltage"])
    assert found[0] > 3 * found[1] > 9 * found[2]
