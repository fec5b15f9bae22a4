"""A non-ohmic leak compared with the linear solver, closed forms and a stiff integrator."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scenario_parts import (
    AREA,
    EPS0,
    apart,
    constant,
    debye,
    floating,
    model,
    polarity,
    sine,
    square,
    step,
    trapezium,
)
from scipy.integrate import solve_ivp

from electrovib.scenario import load
from electrovib.solve.simulate import simulate

MARCH = 5
"""How often the stated error may be exceeded: an estimate by halving, of the leaking layer's field. Measured: up to
2.2 times in that field, 3.7 times in the displacement of the same layer, less in all other signals."""
POSITIVE, NEGATIVE = 2.5e-3, 7.7e-3
"""Time constants of the two polarities, as in the candidate explanation of the falling edge."""


def conductivity(tau):
    """Of Vezzoli et al. 2014's skin: tau = (C_i + C_s) R_s."""
    return (EPS0 * 3.35 / 90e-6 + EPS0 * 1560 / 200e-6) * 200e-6 / tau


def founding(leak, drive, *, skin_conductivity=0.0):
    changes = {
        "stack.stratum_corneum.material": constant(1560.0, skin_conductivity),
        "stack.stratum_corneum.leak": leak,
        "drive": drive,
        "circuit.return_path.resistance": 0.0,
    }
    return load("vezzoli_2014/fig6").replace(changes)


PULSE = trapezium(1000.0, 20e-3, 50e-3, 20e-3)
DRIVES = {
    "trapezium": PULSE,
    "square": square(100, 40, low=-30),
    "sine": sine(100, 60),
    "burst": model("Burst", amplitude=100, frequency=250, cycles=5),
    "sampled": model(
        "Sampled", time_samples=[0, 1e-3, 5e-3, 6e-3, 0.05], voltage_samples=[0, 100, 80, -50, 0]
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize("drive", DRIVES)
@pytest.mark.parametrize("layer", ["gap", "stratum_corneum"])
@pytest.mark.parametrize("body", ["grounded", "floating"])
def test_a_leak_in_proportion_is_a_conductivity(drive, layer, body):
    """Every signal of the march is that of the exact linear solver, within the error the march states."""
    changes = {"drive": DRIVES[drive], "time.duration": 0.05}
    changes |= {"stack.stratum_corneum.material": debye(50, 1500, 1e-3, 5e-7)}
    changes |= {"circuit.return_path": floating(leak=1e10)} if body == "floating" else {}
    base = load("vezzoli_2014/fig6_gap").replace(changes)
    known = base.stack.layers[layer].material.conductivity
    added = 2e-9 if layer == "gap" else 3e-6
    linear = simulate(base.replace({f"stack.{layer}.material.conductivity": known + added}))
    marched = simulate(base.replace({f"stack.{layer}.leak": polarity(added, added)}))
    assert (linear.solver, marched.solver) == ("transient", "nonlinear branch")
    bound = MARCH * marched.attrs["step_error"]
    assert bound < 5e-4
    for name in ("field", "displacement"):
        for which in marched.layer.values:
            exact, found = (trace[name].sel(layer=which).values for trace in (linear, marched))
            assert apart(found, exact) <= bound
    for name in ("electrostatic_force", "current", "stack_voltage"):
        assert apart(marched[name].values, linear[name].values) <= bound
    without = simulate(base).field.sel(layer=layer).values
    assert apart(without, linear.field.sel(layer=layer).values) > 100 * bound


def closed_form(time, *, high, ramp, hold, positive, negative):
    """Effective voltage of one mode with a time constant for each sign, under a rising trapezoidal pulse."""
    slope = high / ramp
    top = slope * positive * -np.expm1(-ramp / positive)
    left = top * np.exp(-hold / positive)
    crossing = positive * np.log1p(left / (slope * positive))
    end = -slope * negative * -np.expm1(-(ramp - crossing) / negative)
    since = [time, time - ramp, time - ramp - hold, time - ramp - hold - crossing, time - 2 * ramp - hold]
    rising = slope * positive * -np.expm1(-since[0] / positive)
    held = top * np.exp(-since[1] / positive)
    falling = left - (slope * positive + left) * -np.expm1(-since[2] / positive)
    below = -slope * negative * -np.expm1(-since[3] / negative)
    after = end * np.exp(-since[4] / negative)
    edges = [ramp, ramp + hold, ramp + hold + crossing, 2 * ramp + hold]
    return np.select([time < edge for edge in edges], [rising, held, falling, below], after)


@pytest.mark.parametrize("taus", [(POSITIVE, NEGATIVE), (NEGATIVE, POSITIVE)], ids=["weaker", "stronger"])
def test_two_time_constants_of_one_mode(taus):
    positive, negative = taus
    time = np.linspace(0, 0.12, 1201)
    trace = simulate(founding(polarity(*map(conductivity, taus)), PULSE), time=time)
    pulse = {"high": 1000.0, "ramp": 20e-3, "hold": 50e-3}
    expected = closed_form(time, **pulse, positive=positive, negative=negative)
    error = apart(trace.effective_voltage.values, expected)
    assert error < MARCH * trace.attrs["step_error"]
    assert trace.attrs["step_error"] < 1e-4
    wrong = closed_form(time, **pulse, positive=negative, negative=positive)
    assert np.max(np.abs(trace.effective_voltage.values - wrong)) > 100 * error * np.max(np.abs(expected))


def test_a_stiff_integrator_agrees():
    """dE/dt of the skin on the film without series resistance, by another method altogether."""
    scale, onset = conductivity(20e-3), 5e3
    scenario = founding(model("FieldConduction", conductivity=scale, onset_field=onset), PULSE)
    time = np.linspace(0, 0.12, 61)
    trace = simulate(scenario, time=time)
    (part,) = scenario.drive.parts()
    film, skin = EPS0 * 3.35 / 90e-6, EPS0 * 1560 / 200e-6

    def rate(now, voltage):
        across = voltage[0] / 200e-6
        leak = scale * across * (1 + (across / onset) ** 2)
        return [(film * float(part.slope(np.array(now))) - leak) / (film + skin)]

    corners, voltages = np.unique([*part.times, *time]), [0.0]
    for first, last in itertools.pairwise(corners):
        piece = solve_ivp(rate, (first, last), [voltages[-1]], method="Radau", rtol=1e-10, atol=1e-10)
        voltages.append(float(piece.y[0, -1]))
    expected = np.interp(time, corners, voltages) / 200e-6
    found = trace.field.sel(layer="stratum_corneum").values
    assert np.max(np.abs(expected)) > 1.2 * onset  # far from ohmic
    assert apart(found, expected) < MARCH * trace.attrs["step_error"] + 1e-8
    linear = simulate(founding(None, PULSE, skin_conductivity=scale), time=time)
    assert apart(linear.field.sel(layer="stratum_corneum").values, expected) > 0.1


def test_a_leak_under_a_prescribed_current():
    """eps0 eps dE/dt = I/A - J(E), the layer alone; at the end what goes in leaks out again."""
    command = trapezium(1.0, 1e-3, 1.0, 1e-3)
    drive = model("CurrentAmplifier", sense_resistance=1e5, command=command)
    time = np.linspace(0, 0.05, 5001)
    trace = simulate(founding(model("FieldConduction", conductivity=2e-6, onset_field=1e4), drive), time=time)
    field = trace.field.sel(layer="stratum_corneum").values
    flow = 2e-6 * field * (1 + (field / 1e4) ** 2)
    assert flow[-1] == pytest.approx(1e-5 / AREA, rel=1e-6)
    held = trace.field.sel(layer="insulator").values * EPS0 * 3.35
    charge = np.where(time < 1e-3, time**2 * 500, time - 0.5e-3) * 1e-5 / AREA
    assert apart(held, charge) < 1e-12  # a leak elsewhere takes nothing from it
    stored = EPS0 * 1560 * field
    lost = np.concatenate([[0.0], np.cumsum((flow[1:] + flow[:-1]) / 2 * np.diff(time))])
    # the trapezoidal rule over 10 us against time constants of 1 ms, and the march
    assert np.max(np.abs(stored + lost - charge)) < (1e-4 + MARCH * trace.attrs["step_error"]) * stored[-1]


def powers(low, high):
    return st.floats(low, high).map(lambda power: 10.0**power)


@pytest.mark.slow
@settings(max_examples=12)
@given(
    positive=powers(-8, -4), negative=powers(-8, -4), drive=st.sampled_from(["trapezium", "square", "sine"])
)
def test_turning_everything_round_turns_the_answer_round(positive, negative, drive):
    table = DRIVES[drive]
    turned = {key: -value if key in {"high", "low", "amplitude"} else value for key, value in table.items()}
    if drive == "sine":
        turned |= {"amplitude": table["amplitude"], "phase": -np.pi}
    time = np.linspace(0, 0.04, 101)
    one = simulate(founding(polarity(positive, negative), table), time=time)
    other = simulate(founding(polarity(negative, positive), turned), time=time)
    assert apart(-other.field.values, one.field.values) <= 1e-11
    assert apart(other.electrostatic_force.values, one.electrostatic_force.values) <= 1e-11
    if abs(positive / negative - 1) > 0.1 and drive == "trapezium":
        unturned = simulate(founding(polarity(positive, negative), turned), time=time)
        assert apart(unturned.electrostatic_force.values, one.electrostatic_force.values) > 1e-6


@pytest.mark.slow
@settings(max_examples=12)
@given(
    size=powers(-8, -4),
    onset=powers(2, 6),
    kind=st.sampled_from(["polarity", "field"]),
    layer=st.sampled_from(["gap", "stratum_corneum"]),
    high=st.sampled_from([-200.0, 200.0]),
)
def test_under_a_held_voltage_a_leaking_layer_only_loses(size, onset, kind, layer, high):
    """Passivity: its field falls towards 0 and never changes sign, and so does the force of a leaking gap."""
    leak = model("FieldConduction", conductivity=size, onset_field=onset)
    if kind == "polarity":
        leak = polarity(size, size / 7)
    changes = {
        "drive": step(high),
        "stack.stratum_corneum.material": constant(),
        "stack.gap.material.conductivity": 0.0,
        f"stack.{layer}.leak": leak,
        "circuit.return_path.resistance": 0.0,
    }
    base = load("vezzoli_2014/fig6_gap").replace(changes)
    trace = simulate(base, time=np.concatenate([[0.0], np.geomspace(1e-7, 10.0, 120)]))
    field = trace.field.sel(layer=layer).values * np.sign(high)
    slack = max(1e-12, MARCH * trace.attrs["step_error"]) * field[0]
    assert np.all(np.diff(field) <= slack)
    assert np.all(field >= -slack)
    assert field[-1] < field[0]
    if layer == "gap":
        force = trace.electrostatic_force.values
        assert np.all(np.diff(force) <= 2 * slack / field[0] * force[0])
