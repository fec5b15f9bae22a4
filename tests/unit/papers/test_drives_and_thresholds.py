"""Squares of drives with an offset (Kang 2017), and the weight and frequency of equal thresholds (Vardar 2017)."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from electrovib.core.budget import items_heard
from electrovib.core.discovery import papers
from electrovib.core.errors import InputError
from electrovib.papers import kang_2017, vardar_2017
from electrovib.solve.electrics.attraction import mean_force
from electrovib.solve.simulate import simulate
from electrovib.solve.stack.expand import phasors

ROUNDING = 1e-12  # of the mean, a discrete Fourier transform of 4096 samples


@given(level=st.floats(-500, 500), amplitude=st.floats(0, 500))
def test_harmonics_of_the_square_of_an_offset_sine(level, amplitude):
    found = kang_2017.square_harmonics(kang_2017.offset(kang_2017.sine(amplitude=amplitude), level=level))
    expected = [level**2 + amplitude**2 / 2, abs(2 * level * amplitude), amplitude**2 / 2, 0.0]
    assert found[:4] == pytest.approx(expected, abs=ROUNDING * (1 + expected[0]))


@given(level=st.floats(-500, 500), amplitude=st.floats(0, 500), depth=st.floats(0, 1))
def test_harmonics_of_the_square_of_a_modulated_carrier_with_an_offset(level, amplitude, depth):
    """Offset and carrier meet only at the carrier: below it the offset adds to the mean and to nothing else."""
    carrier = kang_2017.modulated(amplitude=amplitude, depth=depth)
    expected = np.array([(1 + depth**2 / 2) / 2, depth, depth**2 / 4, 0.0]) * amplitude**2
    alone = kang_2017.square_harmonics(carrier)
    assert alone[:4] == pytest.approx(expected, abs=ROUNDING * (1 + amplitude**2))
    found = kang_2017.square_harmonics(kang_2017.offset(carrier, level=level))
    assert found[0] == pytest.approx(alone[0] + level**2, rel=1e-12)
    assert found[1:20] == pytest.approx(alone[1:20], abs=ROUNDING * (1 + found[0]))


def force_harmonics(scenario):
    """Return mean and harmonics of the attraction in the periodic state, over that of a constant 1 V."""
    time = np.arange(4096) / 4096 / kang_2017.MODULATION
    force = simulate(scenario, time=time).electrostatic_force.values
    held = scenario.replace({"drive": {"model": "Step", "level": 1.0}, "time.initial_state.model": "AtRest"})
    still = simulate(held, time=np.array([0.0, 1e-3])).electrostatic_force.values
    return kang_2017.harmonics(force / still[-1])


@pytest.mark.parametrize("name", ["sine", "modulated", "offset", "both"])
def test_force_on_the_film_is_the_square_of_the_drive(name):
    scenario = kang_2017.scenarios()[name]
    found = force_harmonics(scenario)
    expected = kang_2017.square_harmonics(scenario.drive.to_dict())
    # 1 kohm against 33 pF at 3 kHz: 1e-6 of the carrier's share
    assert found[:20] == pytest.approx(expected[:20], abs=1e-5 * expected[0])
    # abstract: the mean friction goes with the rms voltage
    square = np.mean(scenario.drive.voltage(np.arange(4096) / 4096 / kang_2017.MODULATION) ** 2)
    assert found[0] == pytest.approx(square, rel=1e-9 if name == "offset" else 1e-5)


@pytest.mark.parametrize(
    ("changes", "is_kept"),
    [
        ({}, True),
        # the film blocks: without a leak of the gap its voltage stays, whatever the skin conducts
        ({"stack.stratum_corneum.material.conductivity": 1e-5}, True),
        ({"stack.gap.material.conductivity": 1e-8}, False),
        (
            {
                "stack.stratum_corneum.material.conductivity": 1e-5,
                "force.model": "MaxwellStressInStratumCorneum",
            },
            False,
        ),
    ],
    ids=["as it is", "skin that conducts", "leaky gap", "plane of a skin that conducts"],
)
def test_an_offset_that_leaks_away_gives_nothing_at_the_frequency_of_the_drive(changes, is_kept):
    time = np.arange(4096) / 4096 / kang_2017.MODULATION
    trace = simulate(kang_2017.scenarios()["offset"].replace(changes), time=time)
    found = kang_2017.harmonics(trace.electrostatic_force.values)
    if is_kept:  # 4 level/amplitude
        assert found[1] == pytest.approx(8 * found[2], rel=1e-2 if changes else 1e-6)
    else:  # rounding against the part at twice the frequency
        assert found[1] < 1e-9 * found[2]


def test_the_weight_is_one_at_250_hz_and_falls_by_12_db_an_octave():
    found = vardar_2017.weight(np.array([0.0, 1.0, 2.0, 250.0, 1e5, 2e5]))
    assert found[0] == 0
    assert found[3] == pytest.approx(1.0, rel=1e-12)
    # a square of the ratio, to (f/250)^4 at 2 Hz and (250/f)^4 at 100 kHz
    assert (found[2] / found[1], found[4] / found[5]) == pytest.approx((4.0, 4.0), rel=1e-6)


def test_the_level_of_a_sine_is_one_harmonic_and_goes_as_the_square_of_the_voltage():
    """All of a sine's moving force is at twice its frequency: as large as its mean."""
    skin = {"model": "Constant", "permittivity": 1560.0}
    sine = vardar_2017.scenarios()["sine"].replace({"stack.stratum_corneum.material": skin})
    mean = float(mean_force(sine, phasors(sine, np.array([30.0])), amplitude=100.0)[0])
    expected = mean * float(vardar_2017.weight(np.array(60.0)))
    assert vardar_2017.felt_level(sine) / expected == pytest.approx(1.0, rel=1e-6)
    louder = sine.replace({"drive.amplitude": 200.0})
    assert vardar_2017.felt_level(louder) / expected == pytest.approx(4.0, rel=1e-6)


def test_scenarios_differ_in_the_drive_only():
    sine, square = vardar_2017.scenarios()["sine"], vardar_2017.scenarios()["square"]
    assert sine.replace({"drive": square.drive.to_dict()}) == square
    assert set(vardar_2017.FREQUENCIES) >= {sine.drive.frequency, square.drive.frequency}


def test_the_crossover_says_when_there_is_none():
    assert vardar_2017.crossover(vardar_2017.first_order_skin(time_constant=1e-5)) == math.inf
    assert vardar_2017.crossover(vardar_2017.first_order_skin(time_constant=10.0)) == 0.0
    moist = papers()["plutchik_1963"].skins()["skin"].material
    found = vardar_2017.crossover(moist)
    # the root is found to 1e-3 in the logarithm; the ratio falls by less than 5 dB an octave
    assert vardar_2017.sine_over_square(moist, frequency=found) == pytest.approx(0.0, abs=0.02)


@pytest.fixture(scope="module")
def reproduction():
    items = []
    with items_heard(lambda *item: items.append(item)):
        found = vardar_2017.reproduce()
    assert [(number, total) for _, number, total in items] == [(number, 6) for number in range(1, 7)]
    return found


@pytest.mark.slow  # the reproduction takes tens of seconds
def test_the_rows_of_the_abstract(reproduction):
    """Nothing is called reproduced that the abstract does not print."""
    rows = {row.id: row for row in reproduction.rows}
    assert {row.verdict for row in rows.values()} == {"consistent", "open", "ours"}
    assert rows["direction"].verdict == "consistent"
    assert rows["direction"].ours[0] > 1.0
    assert (rows["crossover_tau"].paper, rows["crossover_tau"].verdict) == (60.0, "open")
    assert reproduction.count() == "2 consistent, 3 open, 2 quantities of ours"
    assert {row.inputs for row in rows.values()} == {"published", "constructed"}
    assert len(reproduction.findings) == 3
    assert "from 48 to 630 Hz" in reproduction.findings[1]
    assert rows["crossover_tau"].ours == pytest.approx((48.0, 630.0), rel=0.01)  # closed form apart
    assert rows["crossover_weight"].ours == pytest.approx((85.3, 91.2), rel=0.01)
    assert rows["edges_480"].ours == pytest.approx((-7.6, -2.8), abs=0.1)
    # the high-pass of the skin moves it by a little
    assert rows["best_frequency"].ours == pytest.approx(125.0, rel=0.04)
    skin = vardar_2017.first_order_skin(time_constant=rows["tau_of_60"].ours * 1e-3)
    assert vardar_2017.sine_over_square(skin, frequency=60.0) == pytest.approx(0, abs=0.01)


@pytest.mark.slow
def test_the_panels_show_the_direction_and_the_crossing(reproduction):
    panels = {panel.id: panel for panel in reproduction.panels}
    curves = {curve.label: curve for curve in panels["thresholds"].curves}
    sine, square = curves["sine, 7.7 ms"], curves["square, 7.7 ms"]
    assert sine.y[0] > square.y[0] + 10
    assert sine.y[-1] < square.y[-1]
    assert np.all(np.diff(panels["crossover"].curves[0].y) < 0)
    band = panels["ratio"].curves[0]
    assert np.all(band.upper >= band.y)


def test_a_table_of_skin_is_refused():
    with pytest.raises(InputError, match="electrovib run"):
        vardar_2017.reproduce(skin="own.csv")
