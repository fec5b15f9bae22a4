"""simulate chooses by what the models declare, here beyond modes; tests/reference/test_product compares with plain equations."""

from __future__ import annotations

import numpy as np
import pytest
import scenario_parts as parts

from electrovib.core.errors import InputError
from electrovib.data.traces import open_trace
from electrovib.export.save import save
from electrovib.scenario import load, scenario_of
from electrovib.solve.equilibrium import equilibrium
from electrovib.solve.simulate import simulate

TREMOR = parts.model("TremblingDistance", mean=100e-6, amplitude=20e-6, frequency=8.0)
LEAK = parts.polarity(1e-9, 1e-9)
DRY = {"stack.stratum_corneum.material": parts.constant()}
YIELDS = {
    "contact.surface": parts.model("LinearSpring", stiffness=1e9, free_gap="10 um"),
    "contact.closing": {"damping": 1e6},
    "motion.distance": None,
}


@pytest.fixture(scope="module")
def suspended():
    return load("vezzoli_2014/fig2")


@pytest.fixture(scope="module")
def founding():
    return load("vezzoli_2014/fig6")


def test_a_gap_that_yields_ends_where_the_forces_balance(suspended):
    held = {"drive": parts.trapezium(600.0, 0.01, 0.2, 0.01), "load.normal_force": 0.5}
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
    # it followed eps0 E^2/2 of the gap whatever was reported
    for law in ("Vezzoli2014Causal", "MaxwellStressInInsulator"):
        with pytest.raises(InputError, match=rf"contact\.closing.*force = {law}.*MaxwellStressInGap"):
            simulate(scenario.replace({"force": {"model": law}}))


def test_an_amplifier_with_gain_and_pole_is_a_filter(founding):
    """One sine: the force over frequency and the force over time see the same gain/(1 + j f/bandwidth)."""
    amplifier = {"gain": 20.0, "bandwidth": "2 kHz", "stray_capacitance": "100 pF"}
    driven = founding.replace(
        {"drive": parts.sine(10.0, 1e3), "circuit.amplifier": amplifier} | parts.SETTLED
    )
    time = np.linspace(0, 1e-3, 401)[:-1]
    trace = simulate(driven, time=time)
    plain = simulate(
        founding.replace({"drive": parts.sine(200 / np.sqrt(1.25), 1e3)} | parts.SETTLED), time=time
    )
    mean = float(trace.electrostatic_force.mean())
    assert mean == pytest.approx(float(plain.electrostatic_force.mean()), rel=1e-9)
    over = np.interp(1e3, trace.frequency.values, trace.mean_force.values)
    assert over == pytest.approx(mean, rel=2e-3)  # between two frequencies
    assert np.max(np.abs(trace.plate_voltage.values)) == pytest.approx(200 / np.sqrt(1.25), rel=1e-4)


def test_a_dispersive_law_without_modes_is_refused_with_what_to_use(founding):
    skin = load("vezzoli_2014/fig7").stack.layers["stratum_corneum"].material
    double = {
        "stack.insulator.leak": LEAK,
        "stack.stratum_corneum.leak": LEAK,
        "stack.stratum_corneum.material": skin,
    }
    with pytest.raises(InputError, match="MaxwellStressInGap"):
        simulate(founding.replace(double))


def test_a_hand_that_holds_the_finger_off_reads_as_pull_and_rubs_nothing():
    trace = simulate(load("vezzoli_2014/fig2_tremor"))
    assert np.all(trace.lateral_force.values == 0)
    said = parts.diagnostics(trace)["moving gap"]["text"]
    assert said.startswith("the gap varies from 90 um to 110 um in time")
    early = (trace.time.values > 0.05) & (trace.time.values < 0.3)
    read, pull = trace.normal_force_measured.values[early], trace.electrostatic_force.values[early]
    np.testing.assert_allclose(read, -pull, rtol=0.05)  # the charge amplifier forgets with 10 s


def test_a_trace_gives_back_every_new_part(tmp_path):
    changes = {"circuit.amplifier": {"bandwidth": 1e4}, "finger": parts.FINGER, "perception": {}}
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
