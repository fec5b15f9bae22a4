"""Signals over frequency behind an amplifier, and the pull of two contacts in series."""

from __future__ import annotations

import numpy as np
import pytest

from electrovib import load
from electrovib.solve.electrics.attraction import total_pull
from electrovib.solve.electrics.over_frequency import over_frequency
from electrovib.solve.stack.expand import phasors

GAP = "vezzoli_2014/fig6_gap"
FREQUENCY = np.geomspace(1.0, 1e5, 11)


def test_an_amplifier_multiplies_the_force_and_leaves_the_impedance():
    """A force of second degree rises with the square of the gain; the impedance is that seen by the plate."""
    gain, bandwidth = 3.0, 2e3
    quiet = load(GAP)
    loud = quiet.replace({"circuit.amplifier": {"gain": gain, "bandwidth": bandwidth}})
    one, two = (over_frequency(each, phasors(each, FREQUENCY), amplitude=10.0) for each in (quiet, loud))
    factor = gain / (1 + 1j * FREQUENCY / bandwidth)
    assert np.allclose(two["mean_force"][1], np.abs(factor) ** 2 * one["mean_force"][1], rtol=1e-12, atol=0)
    assert np.allclose(two["field_gain"][1], factor * one["field_gain"][1], rtol=1e-12, atol=0)
    assert np.array_equal(two["impedance"][1], one["impedance"][1])


@pytest.mark.parametrize("ratio", [0.5, 2.0])
def test_a_second_contact_pulls_with_its_own_area(ratio):
    """Its field is larger by the ratio of the areas, its force smaller by it than the square: per first area 1 + ratio."""
    scenario = load(GAP)
    area = scenario.contact_area / ratio
    both = scenario.replace({"circuit.return_path": {"model": "SecondElectrode", "area": area}})
    given = {"E": np.array([1e6, -2e6])}
    assert np.allclose(total_pull(both, given), (1 + ratio) * total_pull(scenario, given), rtol=1e-13, atol=0)
