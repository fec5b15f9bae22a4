"""Squares of the three drives, on the film and where the offset does not reach the gap."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from electrovib.papers import kang_2017
from electrovib.solve.simulate import simulate

ROUNDING = 1e-12  # of the mean, a discrete Fourier transform of 4096 samples


@given(level=st.floats(-500, 500), amplitude=st.floats(0, 500))
def test_offset(level, amplitude):
    found = kang_2017.square_harmonics(kang_2017.offset(kang_2017.sine(amplitude=amplitude), level=level))
    expected = [level**2 + amplitude**2 / 2, abs(2 * level * amplitude), amplitude**2 / 2, 0.0]
    assert found[:4] == pytest.approx(expected, abs=ROUNDING * (1 + expected[0]))


@given(amplitude=st.floats(0, 500), depth=st.floats(0, 1))
def test_modulated_carrier(amplitude, depth):
    found = kang_2017.square_harmonics(kang_2017.modulated(amplitude=amplitude, depth=depth))
    expected = np.array([(1 + depth**2 / 2) / 2, depth, depth**2 / 4, 0.0]) * amplitude**2
    assert found[:4] == pytest.approx(expected, abs=ROUNDING * (1 + amplitude**2))


@given(level=st.floats(-500, 500), depth=st.floats(0, 1))
def test_both(level, depth):
    """Offset and carrier meet only at the carrier: below it the offset adds to the mean and to nothing else."""
    carrier = kang_2017.modulated(amplitude=100.0, depth=depth)
    alone = kang_2017.square_harmonics(carrier)
    found = kang_2017.square_harmonics(kang_2017.offset(carrier, level=level))
    assert found[0] == pytest.approx(alone[0] + level**2, rel=1e-12)
    assert found[1:20] == pytest.approx(alone[1:20], abs=ROUNDING * (1 + found[0]))


def test_mean_square_is_the_rms_voltage():
    """Abstract: the mean friction of the offset method goes with the rms voltage."""
    scenario = kang_2017.scenarios()["offset"]
    time = np.arange(4096) / 4096 / kang_2017.MODULATION
    square = float(np.mean(scenario.drive.voltage(time) ** 2))
    assert kang_2017.force_harmonics(scenario)[0] == pytest.approx(square, rel=1e-9)


@pytest.mark.parametrize("name", ["sine", "modulated", "offset", "both"])
def test_force_on_the_film_is_the_square_of_the_drive(name):
    scenario = kang_2017.scenarios()[name]
    found = kang_2017.force_harmonics(scenario)
    expected = kang_2017.square_harmonics(scenario.drive.to_dict())
    # 1 kohm against 33 pF at 3 kHz: 1e-6 of the carrier's share
    assert found[:20] == pytest.approx(expected[:20], abs=1e-5 * expected[0])
    assert found[0] != pytest.approx(expected[0] * 1.001, abs=1e-5 * expected[0])


def leaky_force(changes):
    time = np.arange(4096) / 4096 / kang_2017.MODULATION
    scenario = kang_2017.scenarios()["offset"].replace(changes)
    return kang_2017.harmonics(simulate(scenario, time=time).electrostatic_force.values)


@pytest.mark.parametrize(
    "changes",
    [
        {"stack.gap.material.conductivity": 1e-8},
        {"stack.stratum_corneum.material.conductivity": 1e-5, "force.model": "MaxwellStressInStratumCorneum"},
    ],
    ids=["leaky gap", "plane of a skin that conducts"],
)
def test_an_offset_that_leaks_away_gives_nothing_at_the_frequency_of_the_drive(changes):
    kept = leaky_force({})
    assert kept[1] == pytest.approx(8 * kept[2], rel=1e-6)  # 4 level/amplitude
    found = leaky_force(changes)
    # rounding against the part at twice the frequency
    assert found[1] < 1e-9 * found[2]


def test_skin_alone_does_not_take_the_offset_out_of_the_gap():
    """The film blocks: without a leak of the gap its voltage stays, whatever the skin conducts."""
    found = leaky_force({"stack.stratum_corneum.material.conductivity": 1e-5})
    assert found[1] == pytest.approx(8 * found[2], rel=1e-2)
