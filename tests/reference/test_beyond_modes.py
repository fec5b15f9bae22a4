"""simulate chooses by what the models declare, here beyond modes; tests/reference/test_product compares with plain equations."""

from __future__ import annotations

import numpy as np
import pytest
from scenario_parts import (
    AREA,
    FINGER,
    SETTLED,
    constant,
    diagnostics,
    model,
    polarity,
    sine,
    step,
    trapezium,
)

from electrovib.core.constants import VACUUM_PERMITTIVITY as eps0
from electrovib.core.errors import InputError
from electrovib.data.traces import open_trace
from electrovib.export.save import save
from electrovib.scenario import load, scenario_of
from electrovib.solve.equilibrium import equilibrium
from electrovib.solve.simulate import simulate

FILM = 90e-6 / 3.35
TREMOR = model("TremblingDistance", mean=100e-6, amplitude=20e-6, frequency=8.0)
TOUCH = model("TouchAndLift", far=1e-3, near=1e-6, approach=0.2, touch=0.2, lift=0.2)
LEAK = polarity(1e-9, 1e-9)
DRY = {"stack.stratum_corneum.material": constant()}
YIELDS = {
    "contact.surface": model("LinearSpring", stiffness=1e9, free_gap="10 um"),
    "contact.closing": {"damping": 1e6},
    "motion.distance": None,
}


@pytest.fixture(scope="module")
def suspended():
    return load("vezzoli_2014/fig2")


@pytest.fixture(scope="module")
def founding():
    return load("vezzoli_2014/fig6")


@pytest.mark.parametrize("distance", [TREMOR, TOUCH])
def test_a_moved_gap_that_nothing_leaks_through(suspended, distance):
    """E = V/(K + g(t)) with K = T_i/eps_i + T_s/eps_s; the body's 1 kohm takes less than 1e-6 of it."""
    scenario = suspended.replace(DRY | {"motion.distance": distance, "drive": step(500.0)})
    trace = simulate(scenario, time=np.linspace(0, 0.7, 701))
    gap = scenario.motion.distance.gap(trace.time.values)
    expected = eps0 * AREA / 2 * (500.0 / (FILM + 200e-6 / 1560 + gap)) ** 2
    assert trace.attrs["solver"] == "moving gap"
    np.testing.assert_allclose(trace.gap.values, gap, rtol=1e-12)
    np.testing.assert_allclose(trace.electrostatic_force.values[1:], expected[1:], rtol=1e-5)


MOVED = {"motion.distance": TREMOR}
TWO = {"stack.gap.material": constant(1.0)} | DRY
CONDUCTS, LEAKS = "stack.{}.material.conductivity", "stack.{}.leak"


@pytest.mark.parametrize(
    ("preset", "changes", "layers", "solver"),
    [("fig2", MOVED, ("gap",), "moving gap"), ("fig6_gap", TWO, ("gap", "stratum_corneum"), "transient")],
)
def test_the_general_solver_takes_an_ohmic_leak_as_a_conductivity(preset, changes, layers, solver):
    base = load(f"vezzoli_2014/{preset}").replace(changes)
    time = np.linspace(0, 0.5, 251)
    fast, general = (
        simulate(base.replace({path.format(name): value for name in layers}), time=time)
        for path, value in ((CONDUCTS, 1e-9), (LEAKS, LEAK))
    )
    assert (fast.attrs["solver"], general.attrs["solver"]) == (solver, "nonlinear")
    difference = np.max(np.abs(fast.electrostatic_force.values - general.electrostatic_force.values))
    assert difference < 1e-7 * float(fast.electrostatic_force.max())


def test_a_gap_that_yields_ends_where_the_forces_balance(suspended):
    held = {"drive": trapezium(600.0, 0.01, 0.2, 0.01), "load.normal_force": 0.5}
    scenario = suspended.replace(DRY | held | YIELDS)
    trace = simulate(scenario, time=np.linspace(0, 0.2, 201))
    # without a voltage at 5 um; the skin's own thickness counts in the stack, and not in the balance if it conducts
    assert trace.gap.values[0] == pytest.approx(5e-6, rel=1e-9)
    assert trace.gap.values[-1] == pytest.approx(equilibrium(scenario, voltage=600.0).stable[0].gap, rel=1e-5)
    assert trace.attrs["solver"] == "nonlinear"
    with pytest.raises(InputError, match=r"contact\.surface"):
        simulate(scenario.replace({"contact.surface": None}))
    with pytest.raises(InputError, match="one of them"):
        simulate(scenario.replace({"motion.distance": TREMOR}))
    for law in (
        "Vezzoli2014Causal",
        "MaxwellStressInInsulator",
    ):  # it followed eps0 E^2/2 of the gap whatever was reported
        with pytest.raises(InputError, match=rf"contact\.closing.*force = {law}.*MaxwellStressInGap"):
            simulate(scenario.replace({"force": {"model": law}}))


def test_a_dispersive_law_without_modes_is_refused_with_what_to_use(founding):
    skin = load("vezzoli_2014/fig7").stack.layers["stratum_corneum"].material
    double = {
        "stack.insulator.leak": LEAK,
        "stack.stratum_corneum.leak": LEAK,
        "stack.stratum_corneum.material": skin,
    }
    with pytest.raises(InputError, match="MaxwellStressInGap"):
        simulate(founding.replace(double))


def test_an_amplifier_with_gain_and_pole_is_a_filter(founding):
    """One sine: the force over frequency and the force over time see the same gain/(1 + j f/bandwidth)."""
    amplifier = {"gain": 20.0, "bandwidth": "2 kHz", "stray_capacitance": "100 pF"}
    driven = founding.replace({"drive": sine(10.0, 1e3), "circuit.amplifier": amplifier} | SETTLED)
    time = np.linspace(0, 1e-3, 401)[:-1]
    trace = simulate(driven, time=time)
    plain = simulate(founding.replace({"drive": sine(200 / np.sqrt(1.25), 1e3)} | SETTLED), time=time)
    mean = float(trace.electrostatic_force.mean())
    assert mean == pytest.approx(float(plain.electrostatic_force.mean()), rel=1e-9)
    over = np.interp(1e3, trace.frequency.values, trace.mean_force.values)
    assert over == pytest.approx(mean, rel=2e-3)  # between two frequencies
    assert np.max(np.abs(trace.plate_voltage.values)) == pytest.approx(200 / np.sqrt(1.25), rel=1e-4)


def test_an_amplifier_at_its_limit_slews_as_its_load_lets_it(founding):
    """i/(C_stray + C) through the ramp; the stack of film and skin is C_e = 32.8 pF until the skin conducts."""
    changes = {"circuit.amplifier": {"source_current": 10e-6, "stray_capacitance": "1 nF"}}
    changes |= {"drive": trapezium(1000.0, 1e-6, 0.2, 1e-6), "circuit.return_path.resistance": 0.0}
    time = np.linspace(0, 0.4, 401)
    trace = simulate(founding.replace(DRY | changes | {"force": {"model": "MaxwellStressInGap"}}), time=time)
    slew = 10e-6 / (1e-9 + eps0 * AREA / (FILM + 200e-6 / 1560))
    rising = (time > 0.001) & (time < 0.1)
    np.testing.assert_allclose(trace.plate_voltage.values[rising], slew * time[rising], rtol=1e-6)
    np.testing.assert_allclose(trace.amplifier_current.values[rising], 10e-6, rtol=1e-9)
    assert trace.attrs["solver"] == "amplifier"
    said = diagnostics(trace)["current"]
    assert said["state"] == "ok"
    assert "amplifier" not in said["text"]


def test_a_hand_that_holds_the_finger_off_reads_as_pull_and_rubs_nothing():
    trace = simulate(load("vezzoli_2014/fig2_tremor"))
    assert np.all(trace.lateral_force.values == 0)
    said = diagnostics(trace)["moving gap"]["text"]
    assert said.startswith("the gap varies from 90 um to 110 um in time")
    early = (trace.time.values > 0.05) & (trace.time.values < 0.3)
    read, pull = trace.normal_force_measured.values[early], trace.electrostatic_force.values[early]
    np.testing.assert_allclose(read, -pull, rtol=0.05)  # the charge amplifier forgets with 10 s


def test_a_trace_gives_back_every_new_part(tmp_path):
    changes = {"circuit.amplifier": {"bandwidth": 1e4}, "finger": FINGER, "perception": {}}
    scenario = load("vezzoli_2014/fig2_tremor").replace(changes)
    trace = simulate(scenario, time=np.linspace(0, 0.1, 51))
    for name in ("trace.nc", "trace.csv", "trace.mat"):
        save(trace, tmp_path / name)
        again = open_trace(tmp_path / name)
        assert scenario_of(again) == scenario
        for signal in trace:
            np.testing.assert_array_equal(
                again[signal].values, trace[signal].values, err_msg=f"{signal}, {name}"
            )
