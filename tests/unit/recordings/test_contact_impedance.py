"""Impedances of a known gap give its capacitance back, and those of a rough contact at several loads its roughness."""

import numpy as np
import pytest

import electrovib as ev
from electrovib.core.constants import eps0
from electrovib.core.errors import InputError

SINE = "bau_2010/sine"
FREQUENCY = np.geomspace(1e3, 1e5, 21)
GAPS = np.array([0.5e-6, 3e-6, 8e-6])
FILM = {"model": "ColeCole", "permittivity_high": 3.0, "conductivity": 0.0}
FILM["terms"] = [{"strength": 2.0, "relaxation_time": "10 us", "broadening": 0.3}]
STACKS = {
    "film and skin": {},
    "amplifier and body": {"circuit.source_resistance": "10 kohm"},
    "a film with a loss": {"stack.insulator.material": FILM},
    "a liquid in the gap": {"stack.gap.material.permittivity": 3.0},
}


def impedances(pad, gaps, frequency=FREQUENCY):
    """Of plates with each gap, by the general computation of a stack."""
    found = []
    for gap in gaps:
        grid = {"frequency.low": frequency[0], "frequency.high": frequency[-1], "frequency.samples": 21}
        trace = ev.simulate(pad.replace({"stack.gap.thickness": gap, **grid}), signals=["impedance"])
        np.testing.assert_allclose(trace.frequency, frequency)
        found.append(trace.impedance.values)
    return np.array(found)


@pytest.mark.parametrize("changes", STACKS.values(), ids=STACKS)
def test_the_gap_of_plates_gives_its_capacitance(changes):
    pad = ev.load(SINE, changes=changes | {"frequency.low": FREQUENCY[0]})
    found = ev.contact_capacitance(pad, frequency=FREQUENCY, impedance=impedances(pad, GAPS))
    film = pad.stack.layers["insulator"]
    between = pad.stack.layers["gap"].material.permittivity
    thickness = film.thickness / film.material.bound_permittivity(FREQUENCY[0]).real
    expected = eps0 * pad.contact_area / (GAPS / between + thickness)
    np.testing.assert_allclose(found, expected, rtol=1e-9)
    one = ev.contact_capacitance(pad, frequency=FREQUENCY, impedance=impedances(pad, GAPS[:1])[0])
    assert one.shape == ()
    assert one == pytest.approx(expected[0])


def test_noise_of_an_analyser_averages_out():
    """1 % of each part of 21 impedances of which the gap is nearly all: the gap is known to 1 %/sqrt(21)."""
    pad, rng = ev.load(SINE), np.random.default_rng(5)
    exact = impedances(pad, [8e-6])
    noise = rng.normal(size=(400, 21)) + 1j * rng.normal(size=(400, 21))
    found = ev.contact_capacitance(pad, frequency=FREQUENCY, impedance=exact * (1 + 0.01 * noise))
    true = ev.contact_capacitance(pad, frequency=FREQUENCY, impedance=exact)[0]
    assert np.std(found / true) == pytest.approx(0.01 / np.sqrt(21), rel=0.15)
    assert np.mean(found / true) == pytest.approx(1, abs=5e-4)


def test_impedances_of_a_rough_contact_at_several_loads_give_its_roughness_and_modulus():
    rough = ev.SelfAffine(rms=2e-6, hurst=0.8, longest=1e-3, roll_off=2.5e-4, shortest=2.5e-4)
    body, loads, pad = ev.Elastic(modulus=1e6), np.array([0.05, 0.1, 0.2, 0.4, 1.0, 2.0]), ev.load(SINE)
    gaps = []
    for load in loads:
        there = pad.replace({"load.normal_force": load})
        found = ev.rough_contact(there, roughness=rough, body=body, voltage=0.0)
        gaps.append(eps0 * pad.contact_area / found.capacitance[0] - found.stack.electrical_thickness)
    noise = np.random.default_rng(2).normal(size=(2, 6, 21)) * 0.02
    measured = impedances(pad, gaps) * (1 + noise[0] + 1j * noise[1])
    capacitance = ev.contact_capacitance(pad, frequency=FREQUENCY, impedance=measured)
    found = ev.fit_contact(pad, load=loads, capacitance=capacitance, roughness=rough, body=body, draws=1)
    assert found.rms.lower <= 2e-6 <= found.rms.upper
    assert found.modulus.lower <= 1e6 <= found.modulus.upper
    assert found.rms.upper / found.rms.lower < 1.2
    assert found.modulus.upper / found.modulus.lower < 1.3


SMALL = [-1e6j, -1e5j]


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"impedance": [1.0]}, r"not of the shapes \(2,\) and \(1,\)"),
        ({"impedance": 1.0}, "expected a row of frequencies"),
        ({"frequency": [0.0, 1.0]}, "frequency: expected finite numbers above 0 Hz"),
        ({"impedance": [0.0, 1.0]}, "impedance: expected finite numbers other than 0 ohm"),
        ({"impedance": [np.nan, 1.0]}, "impedance: expected finite numbers other than 0 ohm"),
        ({"impedance": [SMALL, [1e6, 1e5]]}, r"impedance\[1\]: layers and a gap miss it by 1e\+02 %"),
        ({"impedance": [-3.6e4j, -3.6e3j]}, r"impedance\[0\]: its gap would be -.*: the layers alone"),
    ],
)
def test_what_is_no_impedance_of_the_stack_is_refused(given, said):
    pad = ev.load(SINE, changes={"circuit.return_path.resistance": 0.0})
    asked = {"frequency": [1e3, 1e4], "impedance": SMALL} | given
    with pytest.raises(InputError, match=said):
        ev.contact_capacitance(pad, **asked)
