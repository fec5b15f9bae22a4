"""simulate chooses by what the models declare: amplifier, moving gap, yielding gap, several leaks; each against a closed form."""

from __future__ import annotations

import json

import numpy as np
import pytest

from electrovib.core.constants import VACUUM_PERMITTIVITY as eps0
from electrovib.core.errors import InputError
from electrovib.data.traces import open_trace
from electrovib.scenario import load
from electrovib.solve.equilibrium import equilibrium
from electrovib.solve.simulate import simulate

FILM = 90e-6 / 3.35
TREMOR = {"model": "TremblingDistance", "mean": 100e-6, "amplitude": 20e-6, "frequency": 8.0}
TOUCH = {"model": "TouchAndLift", "far": 1e-3, "near": 1e-6, "approach": 0.2, "touch": 0.2, "lift": 0.2}
LEAK = {"model": "PolarityConduction", "conductivity_positive": 1e-9, "conductivity_negative": 1e-9}
DRY = {"stack.stratum_corneum.material": {"model": "Constant", "permittivity": 1560.0}}


@pytest.fixture(scope="module")
def suspended():
    return load("vezzoli_2014/fig2")


@pytest.fixture(scope="module")
def founding():
    return load("vezzoli_2014/fig6")


@pytest.mark.parametrize("distance", [TREMOR, TOUCH])
def test_a_moved_gap_that_nothing_leaks_through(suspended, distance):
    """E = V/(K + g(t)) with K = T_i/eps_i + T_s/eps_s; the body's 1 kohm takes less than 1e-6 of it."""
    scenario = suspended.replace(
        DRY | {"motion.distance": distance, "drive": {"model": "Step", "level": 500.0}}
    )
    trace = simulate(scenario, time=np.linspace(0, 0.7, 701))
    gap = scenario.motion.distance.gap(trace.time.values)
    expected = eps0 * 1e-4 / 2 * (500.0 / (FILM + 200e-6 / 1560 + gap)) ** 2
    assert trace.attrs["solver"] == "moving gap"
    np.testing.assert_allclose(trace.gap.values, gap, rtol=1e-12)
    np.testing.assert_allclose(trace.electrostatic_force.values[1:], expected[1:], rtol=1e-5)


def test_general_solver_and_moving_gap_agree(suspended):
    """An ohmic leak, once declared as material and once as a law of conduction."""
    moved = suspended.replace({"motion.distance": TREMOR})
    linear = {"stack.gap.material": {"model": "Constant", "permittivity": 1.0, "conductivity": 1e-9}}
    time = np.linspace(0, 0.5, 251)
    fast = simulate(moved.replace(linear), time=time)
    general = simulate(moved.replace({"stack.gap.leak": LEAK}), time=time)
    assert fast.attrs["solver"] == "moving gap"
    assert general.attrs["solver"] == "nonlinear"
    assert np.max(
        np.abs(fast.electrostatic_force.values - general.electrostatic_force.values)
    ) < 1e-7 * float(fast.electrostatic_force.max())


def test_two_leaks_go_to_the_general_solver(founding):
    """Two ohmic leaks are two conductivities."""
    base = load("vezzoli_2014/fig6_gap").replace(
        DRY | {"stack.gap.material": {"model": "Constant", "permittivity": 1.0}}
    )
    leaking = {"stack.gap.leak": LEAK, "stack.stratum_corneum.leak": LEAK}
    material = {"stack.gap.material.conductivity": 1e-9, "stack.stratum_corneum.material.conductivity": 1e-9}
    time = np.linspace(0, 0.2, 201)
    general, linear = (simulate(base.replace(changes), time=time) for changes in (leaking, material))
    assert (general.attrs["solver"], linear.attrs["solver"]) == ("nonlinear", "transient")
    assert np.max(
        np.abs(general.electrostatic_force.values - linear.electrostatic_force.values)
    ) < 1e-7 * float(linear.electrostatic_force.max())


def test_a_gap_that_yields_ends_where_the_forces_balance(suspended):
    topography = {"contact.surface": {"model": "LinearSpring", "stiffness": 1e9, "free_gap": "10 um"}}
    held = {"drive": {"model": "Trapezium", "high": 600.0, "rise": 0.01, "hold": 0.2, "fall": 0.01}}
    pressed = {"motion.distance": None, "load.normal_force": 0.5}
    scenario = suspended.replace(DRY | topography | held | pressed | {"contact.closing": {"damping": 1e6}})
    trace = simulate(scenario, time=np.linspace(0, 0.2, 201))
    state = equilibrium(scenario, voltage=600.0).stable[0]
    # without a voltage at 5 um; the skin's own thickness counts in the stack, and not in the balance if it conducts
    assert trace.gap.values[0] == pytest.approx(5e-6, rel=1e-9)
    assert trace.gap.values[-1] == pytest.approx(state.gap, rel=1e-5)
    assert trace.attrs["solver"] == "nonlinear"
    with pytest.raises(InputError, match=r"contact\.surface"):
        simulate(suspended.replace(pressed | {"contact.closing": {"damping": 1e6}}))
    with pytest.raises(InputError, match="one of them"):
        simulate(scenario.replace({"motion.distance": TREMOR}))


@pytest.mark.parametrize("law", ["Vezzoli2014Causal", "MaxwellStressInInsulator"])
def test_a_gap_yields_to_the_stress_of_its_own_plane_only(suspended, law):
    """It followed eps0 E^2/2 of the gap whatever attraction the Trace reported."""
    topography = {"model": "LinearSpring", "stiffness": 1e9, "free_gap": "10 um"}
    yields = {"contact.surface": topography, "contact.closing": {"damping": 1e6}, "motion.distance": None}
    with pytest.raises(InputError, match=rf"contact\.closing.*force = {law}.*MaxwellStressInGap"):
        simulate(suspended.replace(yields | {"force": {"model": law}}))


def test_a_gap_with_bridges_yields_to_the_share_that_pulls(suspended):
    """At the end the surface topography bears the load and the attraction that the Trace reports."""
    topography = {"model": "LinearSpring", "stiffness": 1e9, "free_gap": "10 um"}
    bridged = {"model": "BridgedAir", "bridged_share": 0.3, "spot_conductivity": 0.0}
    yields = {
        "contact.surface": topography,
        "contact.closing": {"damping": 1e6},
        "stack.gap.material": bridged,
    }
    held = {"motion.distance": None, "load.normal_force": 0.3, "drive": {"model": "Step", "level": 300.0}}
    trace = simulate(suspended.replace(yields | held | DRY), time=np.linspace(0, 0.1, 11))
    borne = 1e9 * (10e-6 - float(trace.gap[-1])) * 1e-4
    assert borne == pytest.approx(0.3 + float(trace.electrostatic_force[-1]), rel=1e-5)
    assert float(trace.electrostatic_force[-1]) > 0.01


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
    sine = {
        "drive": {"model": "Sine", "amplitude": 10.0, "frequency": 1e3},
        "time.initial_state": {"model": "PeriodicState"},
    }
    scenario = founding.replace(sine | {"circuit.amplifier": amplifier})
    time = np.linspace(0, 1e-3, 401)[:-1]
    trace = simulate(scenario, time=time)
    plain = simulate(founding.replace(sine | {"drive.amplitude": 200 / np.sqrt(1.25)}), time=time)
    assert float(trace.electrostatic_force.mean()) == pytest.approx(
        float(plain.electrostatic_force.mean()), rel=1e-9
    )
    over = np.interp(1e3, trace.frequency.values, trace.mean_force.values)
    assert over == pytest.approx(float(trace.electrostatic_force.mean()), rel=2e-3)  # between two frequencies
    assert np.max(np.abs(trace.plate_voltage.values)) == pytest.approx(200 / np.sqrt(1.25), rel=1e-4)


def test_an_amplifier_at_its_limit_slews_as_its_load_lets_it(founding):
    """i/(C_stray + C) through the ramp; the stack of film and skin is C_e = 32.8 pF until the skin conducts."""
    amplifier = {"source_current": 10e-6, "stray_capacitance": "1 nF"}
    step = {"drive": {"model": "Trapezium", "high": 1000.0, "rise": 1e-6, "hold": 0.2, "fall": 1e-6}}
    no_leak = founding.replace(
        DRY | step | {"circuit.amplifier": amplifier, "force": {"model": "MaxwellStressInGap"}}
    )
    time = np.linspace(0, 0.4, 401)
    trace = simulate(no_leak.replace({"circuit.return_path.resistance": 0.0}), time=time)
    film, skin = eps0 * 3.35 * 1e-4 / 90e-6, eps0 * 1560 * 1e-4 / 200e-6
    slew = 10e-6 / (1e-9 + film * skin / (film + skin))
    rising = (time > 0.001) & (time < 0.1)
    np.testing.assert_allclose(trace.plate_voltage.values[rising], slew * time[rising], rtol=1e-6)
    np.testing.assert_allclose(trace.amplifier_current.values[rising], 10e-6, rtol=1e-9)
    assert trace.attrs["solver"] == "amplifier"
    diagnostics = {diagnostic["name"]: diagnostic for diagnostic in json.loads(trace.attrs["validity"])}
    assert diagnostics["current"]["state"] == "ok"
    assert "amplifier" not in diagnostics["current"]["text"]


def test_what_an_amplifier_does_not_go_with(founding):
    limited = {"circuit.amplifier": {"source_current": 1e-3}}
    settled = {
        "drive": {"model": "Sine", "amplitude": 10.0, "frequency": 1e3},
        "time.initial_state": {"model": "PeriodicState"},
    }
    with pytest.raises(InputError, match="PeriodicState"):
        simulate(founding.replace(limited | settled))
    current = {"drive": {"model": "CurrentSine", "amplitude": 1e-6, "frequency": 1e3}}
    with pytest.raises(InputError, match="amplifier"):
        simulate(founding.replace(limited | current))
    with pytest.raises(InputError, match="amplifier"):
        simulate(founding.replace(limited | {"motion.speed": 0.03, "motion.renews_film": True}))


def test_a_hand_that_holds_the_finger_off_reads_as_pull_and_rubs_nothing():
    trace = simulate(load("vezzoli_2014/fig2_tremor"))
    assert np.all(trace.lateral_force.values == 0)
    said = {diagnostic["name"]: diagnostic["text"] for diagnostic in json.loads(trace.attrs["validity"])}
    assert said["moving gap"].startswith("the gap varies from 90 um to 110 um in time")
    early = (trace.time.values > 0.05) & (trace.time.values < 0.3)
    read, pull = trace.normal_force_measured.values[early], trace.electrostatic_force.values[early]
    np.testing.assert_allclose(read, -pull, rtol=0.05)  # the charge amplifier forgets with 10 s


def test_a_trace_gives_back_every_new_part(tmp_path):
    from electrovib.export.save import save
    from electrovib.scenario import scenario_of

    scenario = load("vezzoli_2014/fig2_tremor").replace(
        {
            "circuit.amplifier": {"bandwidth": 1e4},
            "finger": {"model": "MassSpringDamper", "mass": 1.5e-4, "stiffness": 1e3, "damping": 1.0},
            "perception": {},
        }
    )
    trace = simulate(scenario, time=np.linspace(0, 0.1, 51))
    for suffix in (".nc", ".csv", ".mat"):
        save(trace, tmp_path / f"trace{suffix}")
        again = open_trace(tmp_path / f"trace{suffix}")
        assert scenario_of(again) == scenario
        for name in trace:
            np.testing.assert_array_equal(
                again[name].values, trace[name].values, err_msg=f"{name} in {suffix}"
            )
