"""Sine against square: thresholds of the skin's plane against numbers computed apart from this code."""

import itertools

import numpy as np
import pytest

from electrovib.core.discovery import papers
from electrovib.papers import vardar_2017
from electrovib.papers.vardar_2017.reproduction import conducting_skins
from electrovib.papers.vardar_2017.thresholds import BOTH_CHANNELS, ON_DISPLACEMENT, ON_FORCE
from electrovib.studies.felt_spectrum import crossover, threshold_ratio

FREQUENCIES = (15.0, 30.0, 60.0, 120.0, 240.0, 480.0)
TABLE = {
    1e-3: (33.1, 22.7, 12.8, 6.4, 3.8, 1.0),
    3e-3: (25.8, 16.1, 7.6, 2.4, -0.6, -3.5),
    7.7e-3: (19.5, 11.1, 3.6, -1.5, -4.6, -7.2),
}
"""dB at each frequency, one decimal."""
CROSSOVERS = {1e-3: 590.0, 3e-3: 207.0, 7.7e-3: 86.0, 15e-3: 61.0, 30e-3: 45.0}
"""Hz, with a weight of the same slopes whose rounding at 250 Hz is not stated."""
SKIN = vardar_2017.first_order_skin(time_constant=7.7e-3)


@pytest.mark.parametrize("time_constant", TABLE)
def test_threshold_ratios_of_a_first_order_skin(time_constant):
    skin = vardar_2017.first_order_skin(time_constant=time_constant)
    found = np.array([vardar_2017.sine_over_square(skin, frequency=frequency) for frequency in FREQUENCIES])
    misses = np.abs(found - TABLE[time_constant])
    # half a digit, doubled; the last of 7.7 ms is 0.4 dB away and hangs on the edge of the square, see below
    assert np.all(misses[:5] < 0.1)
    assert misses[5] < (0.41 if time_constant == 7.7e-3 else 0.15)


@pytest.mark.parametrize(("edge", "ratio"), [(20e-6, -7.5), (200e-6, -2.8)])
def test_edges_of_the_square_matter_at_480_hz(edge, ratio):
    assert vardar_2017.sine_over_square(SKIN, frequency=480.0, edge=edge) == pytest.approx(ratio, abs=0.05)


def test_level_against_a_closed_form():
    """Two exponentials a period and one phasor, without the stack and its solver."""
    time_constant, frequency, samples = 7.7e-3, 30.0, 1 << 13
    time = np.arange(samples) / samples / frequency
    turn = 2j * np.pi * frequency * time_constant
    sine = np.real(turn / (1 + turn) * np.exp(2j * np.pi * frequency * time))
    half = 0.5 / frequency
    square = 2 / (1 + np.exp(-half / time_constant)) * np.exp(-np.mod(time, half) / time_constant)
    levels = []
    for voltage in (sine, square):
        force = 2 * np.abs(np.fft.rfft(voltage**2))[1:] / samples
        weights = vardar_2017.weight(np.arange(1, len(force) + 1) * frequency)
        levels.append(np.sqrt(np.sum((force * weights) ** 2)))
    closed = 10 * np.log10(levels[1] / levels[0])
    # rounding, except at the samples on a jump, where the two may take the side before or after it
    assert vardar_2017.sine_over_square(SKIN, frequency=frequency) == pytest.approx(closed, abs=0.01)


WEIGHTS = {"force": ON_FORCE, "both": BOTH_CHANNELS, "displacement": ON_DISPLACEMENT}


@pytest.mark.parametrize("weight", WEIGHTS)
@pytest.mark.parametrize(
    "skin",
    [
        pytest.param(name, marks=pytest.mark.slow if at % 3 else ())
        for at, name in enumerate(conducting_skins())
    ],
)
def test_a_slow_square_is_felt_at_a_lower_voltage_on_every_skin_that_conducts(skin, weight):
    """Direction of the paper's abstract at 15 and 30 Hz, with a body of 1 kohm; the size is not asked for."""
    material, edges = conducting_skins()[skin], (0.0, 200e-6) if weight == "both" else (0.0,)
    for frequency, edge in itertools.product((15.0, 30.0), edges):
        given = {"resistance": 1000.0, "edge": edge, "person": WEIGHTS[weight]}
        ratio = vardar_2017.sine_over_square(material, frequency=frequency, **given)
        assert ratio > (3.0 if weight == "force" else 1.0)
        if weight == "both" and edge == 0:  # the law of Vezzoli et al. 2014, in place of this paper's plane
            causal = {"force": {"model": "Vezzoli2014Causal"}, "stack.stratum_corneum.material": material}
            changes = {**causal, "drive.frequency": frequency}
            pair = [vardar_2017.scenarios()[name].replace(changes) for name in ("sine", "square")]
            assert threshold_ratio(*pair, BOTH_CHANNELS) > 1.0


def test_without_conduction_the_direction_is_lost_below_60_hz():
    for skin in papers()["vezzoli_2014"].skins().values():
        if not skin.reproduces_force:
            assert vardar_2017.sine_over_square(skin.material, frequency=60.0) < -4.0


def test_crossover_follows_the_time_constant():
    """Nothing forces 60 Hz: the frequency of equal thresholds is a reading of the skin."""
    skins = {tau: vardar_2017.first_order_skin(time_constant=tau) for tau in CROSSOVERS}
    found = {tau: vardar_2017.crossover(skin) for tau, skin in skins.items()}
    assert np.all(np.diff([found[tau] for tau in sorted(found)]) < 0)
    for tau, expected in CROSSOVERS.items():
        # 8 %: the shapes of weight with these slopes differ so much where the curves cross at a flat angle
        assert found[tau] == pytest.approx(expected, rel=0.08)
        assert found[tau] != pytest.approx(2 * expected, rel=0.08)


def test_what_another_weight_makes_of_ratio_and_crossover():
    """Computed apart from this code: 2 dB less at 15 Hz with a channel for low frequencies; 86 to 81 Hz with displacement.

    The displacement has a corner of which only 'elastic, then viscous' is said. The frequencies themselves come out 5 to 6 %
    higher here, as those of the other time constants do.
    """
    both, alone = (
        vardar_2017.sine_over_square(SKIN, frequency=15.0, person=p) for p in (BOTH_CHANNELS, ON_FORCE)
    )
    assert both - alone == pytest.approx(-2.0, abs=0.1)
    both, alone, moved = (
        vardar_2017.crossover(SKIN, person=p) for p in (BOTH_CHANNELS, ON_FORCE, ON_DISPLACEMENT)
    )
    assert both == pytest.approx(alone, rel=1e-9)
    assert moved / alone == pytest.approx(81 / 86, abs=0.01)
    assert moved == pytest.approx(81.0, rel=0.08)


def test_the_lowest_crossing_is_given():
    """With edges there is a second crossing near 1 kHz, above which the square is felt better again."""
    assert 80 < vardar_2017.crossover(SKIN, edge=200e-6) < 100
    assert vardar_2017.sine_over_square(SKIN, frequency=1920.0, edge=200e-6) > 0
    sine, square = vardar_2017.scenarios()["sine"], vardar_2017.scenarios()["square"]
    ends = {"low": 15.0, "high": 1920.0, "person": ON_FORCE}
    assert crossover(lambda _: (sine, square), **ends) == np.inf
    assert crossover(lambda _: (square, sine), **ends) == 0.0


def test_size_belongs_to_the_plane():
    def ratio(law):
        changes = {"drive.frequency": 15.0, "force.model": law}
        levels = [vardar_2017.felt_level(each.replace(changes)) for each in vardar_2017.scenarios().values()]
        return abs(10 * np.log10(levels[0] / levels[1]))

    assert set(vardar_2017.scenarios()) == {"sine", "square"}
    assert ratio("MaxwellStressInStratumCorneum") == pytest.approx(28.9, abs=0.2)
    assert ratio("MaxwellStressInGap") == pytest.approx(8.1, abs=0.2)
