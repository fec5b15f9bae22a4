"""The weight, the level and the frequency of equal thresholds."""

from __future__ import annotations

import math

import numpy as np
import pytest

from electrovib.core.discovery import papers
from electrovib.papers import vardar_2017


def test_weight_is_one_at_250_hz_and_falls_by_12_db_an_octave():
    found = vardar_2017.weight(np.array([0.0, 1.0, 2.0, 250.0, 1e5, 2e5]))
    assert found[0] == 0
    assert found[3] == pytest.approx(1.0, rel=1e-12)
    # a square of the ratio, to (f/250)^4 at 2 Hz and (250/f)^4 at 100 kHz
    assert found[2] / found[1] == pytest.approx(4.0, rel=1e-6)
    assert found[4] / found[5] == pytest.approx(4.0, rel=1e-6)


def test_level_goes_as_the_square_of_the_voltage():
    sine = vardar_2017.scenarios()["sine"]
    louder = sine.replace({"drive.amplitude": 200.0})
    assert vardar_2017.felt_level(louder) / vardar_2017.felt_level(sine) == pytest.approx(4.0, rel=1e-9)


def test_level_of_a_sine_is_one_harmonic():
    """All of a sine's moving force is at twice its frequency: as large as its mean."""
    sine = vardar_2017.scenarios()["sine"].replace(
        {"stack.stratum_corneum.material": {"model": "Constant", "permittivity": 1560.0}}
    )
    from electrovib.solve.electrics.attraction import mean_force
    from electrovib.solve.stack.expand import phasors

    mean = float(mean_force(sine, phasors(sine, np.array([30.0])), amplitude=100.0)[0])
    expected = mean * float(vardar_2017.weight(np.array(60.0)))
    assert vardar_2017.felt_level(sine) / expected == pytest.approx(1.0, rel=1e-6)


def test_crossover_says_when_there_is_none():
    always = papers()["gabriel_1996"].skins()["dry"].material
    assert vardar_2017.crossover(always) == math.inf
    slow = vardar_2017.first_order_skin(time_constant=10.0)
    assert vardar_2017.crossover(slow) == 0.0
    moist = papers()["plutchik_1963"].skins()["skin"].material
    found = vardar_2017.crossover(moist)
    # the root is found to 1e-3 in the logarithm; the ratio falls by less than 5 dB an octave
    assert vardar_2017.sine_over_square(moist, frequency=found) == pytest.approx(0.0, abs=0.02)


def test_scenarios_differ_in_the_drive_only():
    sine, square = vardar_2017.scenarios()["sine"], vardar_2017.scenarios()["square"]
    assert sine.stack == square.stack
    assert sine.replace({"drive": square.drive.to_dict()}) == square
    assert set(vardar_2017.FREQUENCIES) >= {sine.drive.frequency, square.drive.frequency}
