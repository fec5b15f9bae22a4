"""The law of Vezzoli et al. 2014 of lost charge: closed forms in time, and the shape of its causal reading."""

import numpy as np
import pytest
import scenario_parts as parts
from hypothesis import given, settings
from hypothesis import strategies as st

from electrovib.core.errors import NotCausalError
from electrovib.core.model import read_model
from electrovib.papers import gabriel_1996
from electrovib.papers.vezzoli_2014 import Vezzoli2014Causal, Vezzoli2014PerFrequency
from electrovib.physics.circuit import SeriesElement
from electrovib.physics.debye_sum import DebyeSum
from electrovib.physics.stack import Layer
from electrovib.solve.simulate import simulate
from electrovib.solve.stack.expand import modes, phasors, reduce_material
from electrovib.solve.stack.section import modal_section, phasor_section

VOLTAGE = 1000.0
CONDUCTIVITY = parts.EPS0 * 1560 / 7.7e-3
PRECISION = 1e-12  # of the peak: exp and the modes lose a few roundings, sums over breaks a few more
FREQUENCY = np.geomspace(1e-2, 1e9, 45)


def founding(finger, drive, *, conductivity=CONDUCTIVITY, settled=False, law="Vezzoli2014Causal"):
    layers = {"insulator": finger.film(), "stratum_corneum": finger.skin(conductivity=conductivity)}
    return finger.build(drive=drive, stack=layers, force=law, settled=settled)


def time_constant(conductivity=CONDUCTIVITY):
    """Give (C_i + C_s) R_s."""
    film, skin = parts.EPS0 * 3.35 / 90e-6, parts.EPS0 * 1560 / 200e-6
    return (film + skin) * 200e-6 / conductivity


def ramp(time, tau):
    """Response of tau s/(1 + tau s) to a ramp of 1 V/s from time 0."""
    return -tau * np.expm1(-np.maximum(time, 0) / tau)


def effective(scenario, time):
    """Voltage over time, of which the force is the static law."""
    trace = simulate(scenario, time=time)
    electrical = (90e-6 / 3.35 + 200e-6 / 1560) * 290e-6
    voltage = trace["effective_voltage"].values
    force = parts.EPS0 * scenario.contact.gross_area() * voltage**2 / (2 * electrical)
    assert parts.apart(trace["electrostatic_force"].values, force) < PRECISION
    return voltage


def on_film(finger, skin, drive, **more):
    layers = {"insulator": finger.film(), "stratum_corneum": parts.layer(200e-6, skin)}
    return finger.build(drive=drive, stack=layers, **more)


@pytest.fixture(params=[2001, 30_001], ids=["segments", "block scan"])
def time(request):
    return np.linspace(0, 0.3, request.param)


def test_step(finger, time):
    voltage = effective(founding(finger, parts.step(VOLTAGE)), time)
    expected = VOLTAGE * np.exp(-time / time_constant())
    assert parts.apart(voltage, expected) < PRECISION
    assert parts.apart(voltage, VOLTAGE * np.exp(-time / (time_constant() * (1 + 1e-11)))) > PRECISION


@pytest.mark.parametrize("conductivity", [CONDUCTIVITY, 100 * CONDUCTIVITY, 0.01 * CONDUCTIVITY])
@pytest.mark.parametrize(
    ("rise", "hold", "fall"), [(36e-3, 0.1, 25e-3), (0.3, 0, 0)], ids=["trapezium", "ramp"]
)
def test_straight_pieces(finger, time, rise, hold, fall, conductivity):
    drive = parts.trapezium(VOLTAGE, rise, hold, fall)
    voltage = effective(founding(finger, drive, conductivity=conductivity), time)
    tau = time_constant(conductivity)
    expected = VOLTAGE * (ramp(time, tau) - ramp(time - rise, tau)) / rise
    if fall:
        down = ramp(time - rise - hold, tau) - ramp(time - rise - hold - fall, tau)
        expected -= VOLTAGE * down / fall
    else:
        expected[-1] -= VOLTAGE  # the jump back, at the last sample
    assert parts.apart(voltage, expected) < PRECISION


def test_readings_agree_without_dispersion(finger):
    section = phasors(founding(finger, parts.step(1)), FREQUENCY)
    causal = Vezzoli2014Causal().effective_voltage(section)
    literal = Vezzoli2014PerFrequency().effective_voltage(section)
    assert np.max(np.abs(causal - literal)) < PRECISION
    s = 2j * np.pi * FREQUENCY
    law = time_constant() * s / (1 + time_constant() * s)
    assert np.max(np.abs(causal - law)) < PRECISION
    assert np.max(np.abs(causal / law - 1)) < 1e-9  # relative, where the voltage is 5e-4 of the drive
    modal = Vezzoli2014Causal().effective_voltage(modes(founding(finger, parts.step(1)))[0])
    assert np.max(np.abs(modal.at(FREQUENCY) - law)) < PRECISION


def test_readings_of_the_shipped_skins_differ_by_less_than_a_tenth_up_to_10_kilohertz(
    finger, conducting_paper_skin
):
    """Of these skins, and no further: see below for what a Trace says of others."""
    section = phasors(on_film(finger, conducting_paper_skin, parts.step(1)), np.geomspace(10, 1e4, 61))
    causal = abs(Vezzoli2014Causal().effective_voltage(section))
    literal = abs(Vezzoli2014PerFrequency().effective_voltage(section))
    assert np.max(np.abs(literal / causal - 1)) < 0.1


@pytest.mark.parametrize(
    ("drive", "settled"),
    [
        (parts.trapezium(1, 1, 1, 1), False),
        (parts.sine(1, 50), False),
        (parts.square(1, 50), True),
        (parts.model("Offset", level=1, drive=parts.sine(1, 50)), True),
    ],
)
def test_the_literal_reading_answers_one_sine_only(finger, drive, settled):
    scenario = founding(finger, drive, settled=settled, law="Vezzoli2014PerFrequency")
    with pytest.raises(NotCausalError, match="Use Vezzoli2014Causal"):
        simulate(scenario)


def causal_voltage(thickness, permittivity, debye_sum, conductivity):
    """Give the effective voltage on an insulator and a skin of Debye terms, nothing in series."""
    layers = {
        "insulator": read_model(Layer, parts.layer(thickness, parts.constant(permittivity))),
        "stratum_corneum": read_model(Layer, parts.layer(200e-6, parts.prony(debye_sum, conductivity))),
    }
    sums = {name: given.material.debye() for name, given in layers.items()}
    around = {"area": 1e-4, "element": SeriesElement(), "second": 0.0}
    section, exact = (
        modal_section(layers, sums, **around),
        phasor_section(layers, **around, frequency=FREQUENCY),
    )
    law = Vezzoli2014Causal()
    return law.effective_voltage(section), law.effective_voltage(exact)


def check_stieltjes(voltage, exact, conductivity):
    """1 - H has weights of one sign, so the step response falls from 1 to 0 without turning."""
    assert np.max(np.abs(voltage.at(FREQUENCY) - exact)) < PRECISION
    assert voltage.slope == 0
    assert voltage.direct == pytest.approx(1, abs=PRECISION)
    assert np.all(voltage.gains <= 1e-14)
    assert voltage.direct + voltage.gains.sum() == pytest.approx(0 if conductivity else 1, abs=PRECISION)
    time = np.concatenate([[0.0], np.geomspace(1e-12, 1e6, 400)])
    step = voltage.direct - np.expm1(-np.outer(time, voltage.rates)) @ voltage.gains
    assert np.max(step) <= 1 + PRECISION
    assert np.max(np.diff(step)) <= 1e-14


@pytest.mark.parametrize(("thickness", "permittivity"), [(90e-6, 3.35), (1e-6, 3.9)], ids=["film", "coating"])
def test_step_response_falls_for_every_skin(paper_skin, thickness, permittivity):
    terms = reduce_material(paper_skin).debye
    voltage, exact = causal_voltage(thickness, permittivity, terms, paper_skin.conductivity)
    check_stieltjes(voltage, exact, paper_skin.conductivity)


@settings(max_examples=60, deadline=None)
@given(
    thickness=parts.powers(-7, -3),
    permittivity=parts.powers(0, 2),
    high=parts.powers(0, 3),
    terms=st.lists(st.tuples(parts.powers(-2, 6), parts.powers(-12, 1)), max_size=6),
    conductivity=st.one_of(st.just(0.0), parts.powers(-12, 0)),
)
def test_step_response_falls_for_random_skins(thickness, permittivity, high, terms, conductivity):
    skin = DebyeSum(high, tuple(s for s, _ in terms), tuple(t for _, t in terms))
    check_stieltjes(*causal_voltage(thickness, permittivity, skin, conductivity), conductivity)


def difference_of_readings(scenario):
    """Find the diagnostic that compares both readings of the law in a Trace, or None."""
    return parts.diagnostics(simulate(scenario, time=np.array([0.0, 1e-3]))).get("readings of the law")


def peak_loss(*, high, strength):
    """Printed over causal effective voltage of a Debye skin without conduction where they differ most.

    The causal one is then the voltage itself; the printed one is the cosine of the loss angle of skin and film side by
    side, least at w tau = sqrt((high + strength)/high): 2 sqrt(high (high + strength))/(2 high + strength).
    """
    high = high + 3.35 / 90e-6 * 200e-6  # the film beside the skin
    return 2 * np.sqrt(high * (high + strength)) / (2 * high + strength)


@pytest.mark.parametrize(
    ("strength", "state"), [(1300.0, "warning"), (180.0, "warning"), (150.0, "ok"), (20.0, "ok")]
)
def test_a_trace_says_by_how_much_both_readings_differ(finger, strength, state):
    skin = parts.debye(100.0, strength, 3e-4, 1e-14)
    changes = {"stack.stratum_corneum.material": skin, "frequency.samples": 4001}
    scenario = founding(finger, parts.step(100.0)).replace(changes)
    found = difference_of_readings(scenario)
    ratio = peak_loss(high=100.0, strength=strength)
    assert found["value"] == pytest.approx(1 - ratio, rel=1e-3)
    assert (found["state"], found["limit"], found["unit"]) == (state, 0.1, "1")
    assert f"{-100 * (1 - ratio):.3g} %" in found["text"]
    assert f"{ratio**2:.3g} times the force" in found["text"]
    if strength == 1300.0:  # the force of the causal reading is 3.8 times that of the printed one
        assert "-48.7 % at 1.9" in found["text"]
        assert 1 / ratio**2 == pytest.approx(3.8, abs=0.05)


def test_both_readings_of_the_shipped_wet_skin_and_over_a_band_of_ones_own(finger):
    """-58 % at 1 MHz, 3.2 % below 10 kHz: what is said follows the frequencies of the scenario."""
    wet = founding(finger, parts.step(100.0)).replace(
        {"stack.stratum_corneum.material": gabriel_1996.skins()["wet"].material}
    )
    found = difference_of_readings(wet)
    assert (found["state"], found["value"]) == ("warning", pytest.approx(0.58, abs=5e-3))
    assert "-58 % at 1 MHz" in found["text"]
    narrow = difference_of_readings(wet.replace({"frequency.low": 100.0, "frequency.high": 1e4}))
    assert (narrow["state"], narrow["value"]) == ("ok", pytest.approx(0.031, abs=1e-3))
    assert "from 100 Hz to 10 kHz" in narrow["text"]
    # without dispersion there is one reading, and no promise stands in its docstring
    assert difference_of_readings(founding(finger, parts.step(100.0))) is None
    assert "%" not in (Vezzoli2014Causal.__doc__ or "")
