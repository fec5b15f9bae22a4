"""From the attraction to friction, skin and readings, through simulate: closed forms and a second route."""

from __future__ import annotations

import json

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.signal import lsim

from electrovib.core.errors import InputError
from electrovib.scenario import load
from electrovib.solve.simulate import simulate

FINGER = {"model": "MassSpringDamper", "mass": "0.15 g", "stiffness": "1 kN/m", "damping": "1 N s/m"}
RIG = {
    "model": "Tribometer",
    "normal": {"natural_frequency": 2e3, "damping_ratio": 0.02, "time_constant": 10.0},
    "lateral": {"natural_frequency": 500.0, "damping_ratio": 0.05, "bandwidth": 1e3},
}
COULOMB = {"model": "Coulomb", "coefficient": 0.5}
SINE = {"model": "Sine", "amplitude": 1000.0, "frequency": 100.0}
SETTLED = {"drive": SINE, "time.initial_state": {"model": "PeriodicState"}}


@pytest.fixture(scope="module")
def vezzoli():
    return load("vezzoli_2014/fig6")


def test_the_skin_follows_the_friction_as_its_equation_says(vezzoli):
    """Against scipy's Radau on m x'' + c x' + k x = F - F(0); the load's friction has always been there."""
    scenario = vezzoli.replace({"finger": FINGER})
    trace = simulate(scenario)
    time, force = trace.time.values, trace.lateral_force.values
    mass, stiffness, damping = 1.5e-4, 1e3, 1.0
    fine = np.linspace(0, time[-1], 20 * (len(time) - 1) + 1)
    smooth = simulate(vezzoli, time=fine).lateral_force.values

    def rate(t, state):
        return [state[1], (np.interp(t, fine, smooth) - damping * state[1] - stiffness * state[0]) / mass]

    solved = solve_ivp(
        rate, (0, time[-1]), [force[0] / stiffness, 0.0], method="Radau", t_eval=time, rtol=1e-9, atol=1e-12
    )
    moved = trace.skin_displacement.values
    assert np.max(np.abs(moved - solved.y[0])) < 1e-6 * np.max(np.abs(moved))
    assert np.max(np.abs(trace.skin_speed.values - solved.y[1])) < 1e-3 * np.max(np.abs(solved.y[1]))
    assert trace.attrs["mechanics_error"] <= 1e-6


def test_creep_against_its_equations(vezzoli):
    """F = (1 - w) F_s + w F_1, tau F_1' = F_s - F_1, marched apart."""
    share, tau = 0.3, 20e-3
    creep = {"model": "Creep", "steady": COULOMB, "relaxations": [{"share": share, "time": tau}]}
    time = np.linspace(0, 0.2, 40001)
    steady = simulate(vezzoli, time=time).lateral_force.values
    slow, step = np.empty_like(steady), time[1]
    slow[0] = steady[0]
    decay = np.exp(-step / tau)
    for index in range(1, len(time)):
        slow[index] = decay * slow[index - 1] + (1 - decay) * (steady[index] + steady[index - 1]) / 2
    expected = (1 - share) * steady + share * slow
    found = simulate(vezzoli.replace({"friction": creep}), time=time[::200]).lateral_force.values
    assert np.max(np.abs(found - expected[::200])) < 1e-8 * np.max(expected)
    assert np.max(np.abs(found - steady[::200])) > 1e-4 * np.max(expected)


def test_a_lag_in_the_periodic_state(vezzoli):
    """The two lines of the force of a sine, mean and twice its frequency, each through one corner."""
    lag = {"model": "FirstOrderLag", "steady": COULOMB, "cut_off": "150 Hz"}
    scenario = vezzoli.replace(SETTLED)
    time = np.linspace(0, 0.01, 201)[:-1]
    steady = simulate(scenario, time=time).lateral_force.values
    lines = np.fft.rfft(steady)
    frequency = np.fft.rfftfreq(len(time), time[1])
    expected = np.fft.irfft(lines / (1 + 1j * frequency / 150.0), len(time))
    found = simulate(scenario.replace({"friction": lag}), time=time).lateral_force.values
    assert np.max(np.abs(found - expected)) < 1e-6 * np.max(expected)


def test_a_corner_that_rises_with_the_speed(vezzoli):
    lag = {"model": "FirstOrderLag", "steady": COULOMB, "cut_off": "100 Hz", "at_speed": "20 mm/s"}
    growing = {"friction": lag | {"renewal_length": 1 / 13.8e3}, "motion.speed": "40 mm/s"}
    fixed = {"friction": lag | {"cut_off": 100 + 13.8 * 20, "at_speed": 0.0}}
    first, second = (simulate(vezzoli.replace(changes)).lateral_force.values for changes in (growing, fixed))
    np.testing.assert_allclose(first, second, rtol=1e-12)
    with pytest.raises(InputError, match=r"motion\.speed"):
        simulate(vezzoli.replace({"friction": lag | {"renewal_length": 1e-4}}))
    with pytest.raises(InputError, match="cut_off"):
        simulate(vezzoli.replace({"friction": lag | {"renewal_length": 1e-5}, "motion.speed": "1 mm/s"}))


def test_the_rig_reads_the_load_but_not_the_attraction_in_touch(vezzoli):
    """Piezo: nothing of a load held for ever; the attraction is balanced inside the contact."""
    trace = simulate(vezzoli.replace({"rig": RIG}))
    assert np.max(np.abs(trace.normal_force_measured.values)) < 1e-12
    time = trace.time.values
    fine = np.linspace(0, time[-1], 20 * (len(time) - 1) + 1)
    true = simulate(vezzoli, time=fine).lateral_force.values
    turn, corner = 2 * np.pi * 500.0, 2 * np.pi * 1e3
    poles = np.polymul([1 / turn**2, 0.1 / turn, 1], [1 / corner, 1])
    _, change, _ = lsim(([1.0], poles), true - true[0], fine)
    read = trace.lateral_force_measured.values - true[0]
    # lsim is exact for straight pieces, 5 us long; the stated error is a share of the largest reading, load included
    assert np.max(np.abs(read - change[::20])) < trace.attrs["mechanics_error"] * true.max()
    assert np.max(np.abs(read - (true - true[0])[::20])) > 0.05 * np.max(change)


def test_a_press_is_read_by_a_piezo_sensor(vezzoli):
    """After a slow press the reading decays with the charge amplifier's time constant."""
    press = {
        "load.time_profile": {"model": "Press", "rise": 0.1},
        "rig": RIG | {"normal": RIG["normal"] | {"time_constant": 0.5}},
    }
    time = np.linspace(0, 2.0, 401)
    trace = simulate(vezzoli.replace(press), time=time)
    late = time > 0.3
    expected = 0.5 * 0.5 / 0.1 * (np.exp(-(time - 0.1) / 0.5) - np.exp(-time / 0.5))
    np.testing.assert_allclose(trace.normal_force_measured.values[late], expected[late], rtol=2e-3)
    np.testing.assert_allclose(trace.normal_force.values, 0.5 * np.clip(time / 0.1, 0, 1), rtol=1e-12)


def test_a_digitiser_that_is_driven_beyond_its_range_says_so(vezzoli):
    small = {"sampling_rate": 1e4, "bits": 12, "normal_range": 1.0, "lateral_range": 0.1, "seed": 3}
    trace = simulate(vezzoli.replace({"rig": RIG | {"digitiser": small}}))
    assert np.max(trace.lateral_force_measured.values) <= 0.1
    diagnostics = {diagnostic["name"]: diagnostic for diagnostic in json.loads(trace.attrs["validity"])}
    assert diagnostics["lateral range"]["state"] == "warning"


def test_the_attraction_grows_with_the_area_that_load_and_attraction_make(vezzoli):
    """Exponent 1/2: W = load + c sqrt(W), a square in sqrt(W)."""
    growing = {"model": "GrowingArea", "area": 1e-4, "at_force": 0.5, "exponent": 0.5}
    changes = {"contact": growing, "load.time_profile": {"model": "Press", "rise": 0.1}}
    time = np.linspace(0, 0.2, 101)
    trace, whole = simulate(vezzoli.replace(changes), time=time), simulate(vezzoli, time=time)
    load, slope = 0.5 * np.clip(time / 0.1, 0, 1), whole.electrostatic_force.values / np.sqrt(0.5)
    root = np.where(load > 0, slope / 2 + np.sqrt(slope**2 / 4 + load), 0.0)
    np.testing.assert_allclose(trace.gross_contact_area.values, 1e-4 * root / np.sqrt(0.5), rtol=1e-12)
    np.testing.assert_allclose(trace.electrostatic_force.values, slope * root, rtol=1e-12)


def test_adhesive_shear_needs_the_surface_topography(vezzoli):
    with pytest.raises(InputError, match=r"contact\.surface"):
        simulate(vezzoli.replace({"friction": {"model": "AdhesiveShear", "shear_strength": "1 MPa"}}))


def test_attraction_adds_real_contact(vezzoli):
    topography = {
        "model": "PerssonSurface",
        "modulus": 1e6,
        "rms_slope": 0.3,
        "rms_gap": 5e-6,
        "pressure_factor": 1.0,
        "decay_factor": 1.0,
    }
    shear = {"contact.surface": topography, "friction": {"model": "AdhesiveShear", "shear_strength": "1 MPa"}}
    trace = simulate(vezzoli.replace(shear))
    np.testing.assert_allclose(trace.lateral_force.values, 1e6 * trace.real_contact_area.values, rtol=1e-12)
    peak = int(trace.electrostatic_force.values.argmax())
    assert trace.real_contact_area.values[peak] > trace.real_contact_area.values[0] * (1 + 1e-3)


def test_moisture_moves_skin_gap_and_friction_together():
    moist = {
        "level": 0.0,
        "dry_gap_resistivity": 1e10,
        "wet_gap_resistivity": 1e7,
        "dry_coefficient": 0.4,
        "wet_coefficient": 0.8,
    }
    dry = load("vezzoli_2014/fig6_gap").replace({"moisture": moist})
    wet = dry.replace({"moisture.level": 1.0})
    assert dry.stack.layers["gap"].material.conductivity == pytest.approx(1e-10)
    assert wet.stack.layers["gap"].material.conductivity == pytest.approx(1e-7)
    assert wet.friction.coefficient == pytest.approx(0.8)
    ratio = (
        wet.stack.layers["stratum_corneum"].material.conductivity
        / dry.stack.layers["stratum_corneum"].material.conductivity
    )
    assert ratio == pytest.approx(10)
    ends = [simulate(case, time=np.array([0.0, 0.1])).electrostatic_force.values[-1] for case in (dry, wet)]
    assert ends[1] < 1e-3 * ends[0]
    again = type(wet).model_validate(wet.to_dict())
    assert again == wet


def test_without_a_load_there_is_no_growing_area(vezzoli):
    growing = {"model": "GrowingArea", "area": 1e-4, "at_force": 0.5, "exponent": 0.5}
    with pytest.raises(InputError, match="contact area"):
        vezzoli.replace({"contact": growing, "load.normal_force": 0.0})


def test_a_lag_whose_corner_follows_the_speed_against_its_equation(vezzoli):
    """Against scipy's Radau on F' = 2 pi f_c(u(t)) (F_s - F) while the finger sets out."""
    length = 1 / 13.8e3
    lag = {"model": "FirstOrderLag", "steady": COULOMB, "cut_off": "20 Hz", "renewal_length": length}
    moving = {"speed": "40 mm/s", "time_profile": {"model": "Press", "rise": 0.06}}
    square = {"model": "Square", "high": 1000.0, "frequency": 20.0, "edge": 5e-3}
    scenario = vezzoli.replace({"friction": lag, "motion": moving, "drive": square, "time.duration": 0.1})
    trace = simulate(scenario)
    time = trace.time.values
    fine = np.linspace(0, 0.1, 40001)
    steady = simulate(scenario.replace({"friction": COULOMB}), time=fine).lateral_force.values

    def rate(t, state):
        corner = 20.0 + np.interp(t, [0, 0.06], [0, 0.04]) / length
        return 2 * np.pi * corner * (np.interp(t, fine, steady) - state)

    solved = solve_ivp(
        rate, (0, 0.1), [steady[0]], method="Radau", t_eval=time, rtol=1e-9, atol=1e-12, max_step=1e-4
    )
    lateral = trace.lateral_force.values
    # the finger rests before: until exp(-theta) is a millionth, nobody knows what the lag remembers of that
    theta = 2 * np.pi * (20 * time + 0.02 / 0.06 / length * time**2)
    assert np.all(np.isnan(lateral) == (theta < np.log(1e6)))
    found, expected = lateral[theta >= np.log(1e6)], solved.y[0][theta >= np.log(1e6)]
    assert np.max(np.abs(found - expected)) < 2e-6 * np.max(found)
    assert trace.attrs["mechanics_error"] < 1e-6
    still = simulate(scenario.replace({"motion.time_profile": {"model": "Steady"}})).lateral_force.values
    assert np.max(np.abs(still[theta >= np.log(1e6)] - found)) > 1e-4 * np.max(found)
    with pytest.raises(InputError, match="slowest speed"):
        simulate(scenario.replace({"friction.at_speed": "40 mm/s"}))


LUGRE = {
    "model": "LuGre",
    "steady": COULOMB,
    "stiffness": 5e3,
    "static_ratio": 1.5,
    "stribeck_speed": "5 mm/s",
}


def test_bristles_that_slide_follow_the_steady_friction(vezzoli):
    """A rigid finger at 0.5 m/s and stiff bristles: Coulomb but for the 0.05 mm of their deflection."""
    fast = {"friction": LUGRE | {"stiffness": 1e6, "static_ratio": 1.0}, "motion.speed": 0.5}
    trace = simulate(vezzoli.replace(fast))
    steady = simulate(vezzoli).lateral_force.values
    assert np.max(np.abs(trace.lateral_force.values - steady)) < 2e-3 * np.ptp(steady)
    assert trace.attrs["energy_residual"] < 1e-6


def test_bristles_need_a_speed_and_no_periodic_state(vezzoli):
    with pytest.raises(InputError, match=r"motion\.speed"):
        simulate(vezzoli.replace({"friction": LUGRE}))
    with pytest.raises(InputError, match="PeriodicState"):
        simulate(vezzoli.replace(SETTLED | {"friction": LUGRE, "motion.speed": "30 mm/s"}))


def test_a_finger_that_sets_out_sticks_before_it_slips(vezzoli):
    """Below the Stribeck speed it ends at the friction of its curve; before, the skin is left behind."""
    moving = {"speed": "2 mm/s", "time_profile": {"model": "Press", "rise": 0.01}}
    scenario = vezzoli.replace({"friction": LUGRE, "motion": moving, "finger": FINGER})
    trace = simulate(scenario, time=np.linspace(0, 1.0, 2001))
    lateral, skin = trace.lateral_force.values, trace.skin_displacement.values
    assert lateral[0] == 0
    early = trace.time.values < 0.05
    distance = np.where(
        trace.time.values < 0.01, 0.1 * trace.time.values**2, 2e-3 * (trace.time.values - 0.005)
    )
    bent = skin + trace.bristle_deflection.values
    np.testing.assert_allclose(bent[early], distance[early], atol=0.02 * distance[early].max())
    assert lateral[-1] == pytest.approx(0.25 * (1 + 0.5 * np.exp(-((2 / 5) ** 2))), rel=1e-3)
    assert trace.attrs["energy_residual"] < 1e-6


def test_a_reading_in_the_periodic_state_is_periodic(vezzoli):
    """The lines of the friction of a sine, each through lag and sensor: by hand from their transfer functions."""
    lag = {"model": "FirstOrderLag", "steady": COULOMB, "cut_off": "150 Hz"}
    scenario = vezzoli.replace(SETTLED | {"friction": lag, "rig": RIG})
    time = np.linspace(0, 0.01, 201)[:-1]
    steady = simulate(vezzoli.replace(SETTLED), time=time).lateral_force.values
    frequency = np.fft.rfftfreq(len(time), time[1])
    share = frequency / 500.0
    sensor = 1 / (1 - share**2 + 0.1j * share) / (1 + 1j * frequency / 1e3)
    expected = np.fft.irfft(np.fft.rfft(steady) * sensor / (1 + 1j * frequency / 150.0), len(time))
    found = simulate(scenario, time=time)
    assert np.max(np.abs(found.lateral_force_measured.values - expected)) < 2e-6 * np.max(expected)
    assert np.max(np.abs(found.normal_force_measured.values)) < 1e-12


@pytest.mark.slow
def test_a_coarse_output_grid_reads_the_same(vezzoli):
    """What is between the output times counts too: creep and stick-slip are read as on a fine grid."""
    creep = {"model": "Creep", "steady": COULOMB, "relaxations": [{"share": 0.3, "time": 20e-3}]}
    slip = {"friction": LUGRE, "motion.speed": "20 mm/s", "finger": FINGER}
    square = {"model": "Square", "high": 1000.0, "frequency": 20.0, "edge": 2e-3}
    for changes in ({"friction": creep}, slip):
        scenario = vezzoli.replace(changes | {"rig": RIG, "drive": square})
        fine = simulate(scenario, time=np.linspace(0, 0.1, 2001)).lateral_force_measured.values
        coarse = simulate(scenario, time=np.linspace(0, 0.1, 41)).lateral_force_measured.values
        assert np.max(np.abs(coarse - fine[::50])) < 2e-5 * np.ptp(fine) + 1e-6 * np.max(fine)


@pytest.mark.parametrize("digitised", [False, True])
def test_readings_in_the_periodic_state_are_those_of_a_late_period(digitised):
    """The sensor creeps with 50 ms, half a period: begun at the first time it would be off by 3 % of the swing."""
    rig = {
        "model": "Tribometer",
        "normal": {"natural_frequency": 2e3, "damping_ratio": 0.02, "time_constant": 10.0},
        "lateral": {
            "natural_frequency": 500.0,
            "damping_ratio": 0.5,
            "creep": {"share": 0.25, "time": 50e-3},
        },
    }
    if digitised:  # steps of 120 nN
        levels = {"sampling_rate": 10e3, "bits": 24, "normal_range": 1.0, "lateral_range": 1.0, "seed": 1}
        rig["digitiser"] = levels
    drive = {"model": "Trapezium", "high": 1000.0, "rise": 0.01, "hold": 0.04, "fall": 0.01, "repeat": 0.1}
    scenario = load("vezzoli_2014/fig6").replace({"drive": drive, "rig": rig})
    time = np.linspace(0, 0.1, 1001)
    settled = scenario.replace({"time.initial_state": {"model": "PeriodicState"}})
    found = simulate(settled, time=time).lateral_force_measured.values
    late = simulate(scenario, time=np.concatenate([[0.0], time + 2.0])).lateral_force_measured.values[1:]
    close = 1e-3 if digitised else 3e-5  # of a swing of 1.5 mN: 1e-6 of the largest reading, and the levels
    assert np.max(np.abs(found - late)) < close * np.ptp(late)
