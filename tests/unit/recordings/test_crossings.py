"""Passages of single edges through levels: their intervals hold the true time."""

import math

import numpy as np
import pytest
from scipy.signal import lfilter
from scipy.stats import t

from electrovib.recordings.correlated import autocovariance
from electrovib.recordings.transitions import crossings
from electrovib.recordings.transitions.crossings import EdgeLevels, levels_of
from electrovib.recordings.transitions.edges import edge_record, reference_times

TAU, AT, RATE = 6e-3, 0.12, 5000.0
BETWEEN = TAU * math.log(9)


def noise_of(seed, *, size, correlated):
    """Noise of unit variance, an autoregression of first order."""
    white = np.random.default_rng(seed).standard_normal(size + 200)
    return lfilter([math.sqrt(1 - correlated**2)], [1, -correlated], white)[200:]


def rise(seed, *, noise, correlated):
    """Times and values of a signal that rises by 1 as an exponential."""
    time = np.arange(0, 0.3, 1 / RATE)
    at = AT + np.random.default_rng(seed + 10**6).uniform(0, 1 / RATE)
    force = 1 - np.exp(-np.maximum(time - at, 0) / TAU)
    return time, force + noise * noise_of(seed, size=time.size, correlated=correlated)


def passages_of(seed, **options):
    time, force = rise(seed, **options)
    (at,) = reference_times(time, force, None)
    return edge_record(
        time, force, [at], 0, levels=(0.1, 0.9), driven=False, window=None, before=None
    ).passages


@pytest.mark.slow
@pytest.mark.parametrize("noise", [0.01, 0.03])
@pytest.mark.parametrize("correlated", [0.0, 0.6])
def test_intervals_of_1000_edges_hold_the_true_time(noise, correlated):
    found = [passages_of(seed, noise=noise, correlated=correlated) for seed in range(1000)]
    inside = [abs(each.time - BETWEEN) < t.ppf(0.975, each.freedom) * each.standard_error for each in found]
    assert 0.93 <= np.mean(inside) <= 0.97


def test_a_noisy_slope_lengthens_the_section():
    # a section that follows the noise gives 0.86 ms, and its standard error 0.71 ms
    times = [passages_of(seed, noise=0.03, correlated=0.6).time for seed in range(40)]
    assert np.std(times) < 0.75e-3
    assert np.mean(times) == pytest.approx(BETWEEN, abs=0.2e-3)


@pytest.mark.parametrize("correlated", [0.0, 0.6])
def test_degrees_of_freedom_of_a_mean_are_those_of_its_estimated_variance(correlated):
    size = 400
    time = np.arange(2 * size, dtype=float)
    variances, freedoms = [], []
    for seed in range(300):
        noise = noise_of(seed, size=size, correlated=correlated)
        alike = autocovariance(noise - noise.mean(), fitted=1)
        variances.append(alike[0] + 2 * alike[1:60].sum())
        if seed % 10:
            continue
        levels = levels_of(time, np.append(noise, noise + 100), edge=size - 0.5, settled=size - 0.5)
        freedoms.append(levels.freedom)
    spread = np.var(variances) / np.mean(variances) ** 2
    assert np.median(freedoms) == pytest.approx(2 / spread, rel=0.3)


def test_a_reversal_of_polarity_is_no_edge_of_the_drive():
    time = np.arange(1000) * 1e-4
    on = (time > 0.02) & (time < 0.08)
    drive = np.where(on, 300.0 * np.sign(np.sin(2 * np.pi * 50 * time + 0.1)), 0.0)
    turns = np.flatnonzero(drive[1:] * drive[:-1] < 0)
    assert turns.size > 3
    for offset in (0, 1):
        drive[turns + offset] = 10.0  # two samples fall within the reversal
    found = reference_times(time, np.zeros_like(time), drive)
    assert found == pytest.approx([0.02, 0.08], abs=2e-4)


EDGES = {
    # signal over time, and the derivatives of the time between 10 and 90 % by both levels over the change
    "exponential": (
        lambda time: 1 - np.exp(-np.maximum(time - AT, 0) / TAU),
        0.0,
        TAU * (0.9 / 0.1 - 0.1 / 0.9),
    ),
    "straight": (lambda time: np.clip((time - AT) / TAU, 0, 1), -0.8 * TAU, 0.8 * TAU),
}


@pytest.mark.parametrize("name", EDGES)
@pytest.mark.parametrize("height", [3.0, -2.0])
def test_an_error_of_a_level_counts_as_the_closed_form_of_the_edge_says(name, height):
    """Where an exponential begins does not change its time constant; both levels stretch a straight edge alike."""
    shape, of_before, of_after = EDGES[name]
    time = np.arange(0, 0.3, 2e-5)

    def found(*, before=0.0, after=0.0):
        levels = EdgeLevels(
            before=1.0, after=1.0 + height, before_error=before, after_error=after, noise=0.0,
            alike=np.zeros(20), freedom=100.0, drift=0.0,
        )  # fmt: skip
        return crossings.passages(
            time, 1 + height * shape(time), levels, fractions=(0.1, 0.9), edge=AT - 0.01
        )

    error, scale = 0.01 * abs(height), 0.02 * TAU
    assert found().standard_error == 0
    assert found(before=error).standard_error == pytest.approx(0.01 * abs(of_before), abs=0.01 * scale)
    assert found(after=error).standard_error == pytest.approx(0.01 * of_after, rel=0.02)


def test_the_weights_of_a_passage_reproduce_every_parabola(monkeypatch):
    """The value of a fitted parabola at the passage is exact for any parabola: moments of the weights of 1, 0 and 0."""
    kept, original = [], crossings._passage

    def keep(time, *arguments, **named):
        kept.append((time, original(time, *arguments, **named)))
        return kept[-1][1]

    monkeypatch.setattr(crossings, "_passage", keep)
    for seed in range(3):
        passages_of(seed, noise=0.03, correlated=0.0)
    assert kept
    for time, passage in kept:
        offsets, weights = (time - passage.time) * RATE, passage.weights
        sections = np.lib.stride_tricks.sliding_window_view(offsets, len(weights))
        first = sections @ weights
        moments = [weights.sum() - 1, np.abs(first).min(), sections[np.abs(first).argmin()] ** 2 @ weights]
        np.testing.assert_allclose(moments, 0, atol=1e-9)
