"""Values over frequency: behind an amplifier, of two contacts, beside a leak; what they leave out is stated."""

import numpy as np
import pytest

import electrovib as ev
from electrovib.core.diagnostics import read_diagnostics
from electrovib.solve.electrics.attraction import total_pull
from electrovib.solve.electrics.over_frequency import over_frequency
from electrovib.solve.stack.expand import phasors

GAP = ev.load("vezzoli_2014/fig6_gap")
FREQUENCY = np.geomspace(1.0, 1e5, 11)


def test_an_amplifier_multiplies_the_force_and_leaves_the_impedance():
    """A force of second degree rises with the square of the gain; the impedance is that seen by the plate."""
    gain, bandwidth = 3.0, 2e3
    loud = GAP.replace({"circuit.amplifier": {"gain": gain, "bandwidth": bandwidth}})
    one, two = (over_frequency(each, phasors(each, FREQUENCY), amplitude=10.0) for each in (GAP, loud))
    factor = gain / (1 + 1j * FREQUENCY / bandwidth)
    assert np.allclose(two["mean_force"][1], np.abs(factor) ** 2 * one["mean_force"][1], rtol=1e-12, atol=0)
    assert np.allclose(two["field_gain"][1], factor * one["field_gain"][1], rtol=1e-12, atol=0)
    assert np.array_equal(two["impedance"][1], one["impedance"][1])


@pytest.mark.parametrize("ratio", [0.5, 2.0])
def test_a_second_contact_pulls_with_its_own_area(ratio):
    """Its field is larger by the ratio of the areas, its force smaller by it than the square: per first area 1 + ratio."""
    contact = {"model": "SecondElectrode", "area": GAP.contact_area / ratio}
    both, given = GAP.replace({"circuit.return_path": contact}), {"E": np.array([1e6, -2e6])}
    assert np.allclose(total_pull(both, given), (1 + ratio) * total_pull(GAP, given), rtol=1e-13, atol=0)


def test_a_leak_counts_over_frequency_as_a_vanishing_sine_sees_it():
    leak = {"model": "PolarityConduction", "conductivity_positive": 5e-6, "conductivity_negative": 2e-6}
    skin = "stack.stratum_corneum"
    leaky = GAP.replace({f"{skin}.leak": leak, f"{skin}.material.conductivity": 0.0})
    found, without = (phasors(leaky, FREQUENCY, leaks=leaks) for leaks in (True, False))
    plain = phasors(GAP.replace({f"{skin}.material.conductivity": 3.5e-6}), FREQUENCY)
    np.testing.assert_allclose(found["gap"].field, plain["gap"].field, rtol=1e-14)
    assert np.max(np.abs(without["stratum_corneum"].field / found["stratum_corneum"].field - 1)) > 0.1


def of_film_and_gap(changes):
    film = {"thickness": 1e-5, "material": {"model": "Constant", "permittivity": 3.0}}
    gap = {"thickness": 2e-6, "material": {"model": "Constant", "permittivity": 1.0}}
    skin = ev.load("vezzoli_2014/fig6").stack.to_dict()["stratum_corneum"]
    given = {
        "force.model": "MaxwellStressInGap",
        "stack": {"insulator": film, "gap": gap, "stratum_corneum": skin},
        "drive": {"model": "Sine", "amplitude": 1.0, "frequency": 30.0},
        "frequency": {"low": 30.0, "high": 3e3, "samples": 3},
    }
    return ev.load("vezzoli_2014/fig6").replace(given | changes)


def said(trace):
    found = read_diagnostics(trace.attrs["validity"])
    return {each.name: each.text for each in found if each.name.startswith("over frequency")}


RECTIFIES = {"model": "PolarityConduction", "conductivity_positive": 6e-9, "conductivity_negative": 2e-9}
EVEN = {"model": "FieldConduction", "conductivity": 4e-9, "onset_field": 1e12}


@pytest.mark.parametrize(("leak", "ratio"), [(RECTIFIES, 1.62), (EVEN, 1.0)], ids=["rectifies", "even"])
def test_mean_force_of_a_leak_in_time_and_over_frequency(leak, ratio):
    """A rectifying gap behind a film charges: the mean of the late periods, by harmonic collocation 1.62 times as large."""
    trace = ev.simulate(of_film_and_gap({"stack.gap.leak": leak}), time=np.linspace(0, 3 / 30, 301))
    late = np.trapezoid(trace.electrostatic_force.values[-101:], dx=0.01)
    assert late / trace.mean_force.values[0] == pytest.approx(ratio, rel=0.02)
    assert ("over frequency, gap" in said(trace)) == (leak is RECTIFIES)


@pytest.mark.parametrize(
    ("amplifier", "words"),
    [
        ({"gain": 3.0, "saturation": 2.5}, "reaches 3 V, above the saturation of 2.5 V"),
        ({"source_current": 1e-8, "stray_capacitance": 1e-10}, "above 10 nA, from 30 Hz on"),
        ({"saturation": 1.5, "source_current": 1.0}, None),
        ({"gain": 3.0, "bandwidth": 100.0}, None),
    ],
    ids=["saturates", "current", "within", "unlimited"],
)
def test_limits_of_an_amplifier_that_the_mean_force_leaves_out(amplifier, words):
    trace = ev.simulate(of_film_and_gap({"circuit.amplifier": amplifier}), time=np.array([1e-3]))
    found = said(trace).get("over frequency, amplifier")
    assert found is None if words is None else words in found
