"""Standard errors of correlated noise, and passages of single edges through levels, whose intervals hold the true time."""

import math

import numpy as np
import pytest
from scipy.signal import lfilter
from scipy.stats import t

from electrovib.recordings.interval import autocovariance, covariance, line
from electrovib.recordings.transitions import crossings
from electrovib.recordings.transitions.crossings import EdgeLevels, creeps, levels_of
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


def noise(recursion, seed, count=128):
    """Noise of variance 1 after 500 samples of run-in."""
    made = lfilter([1], recursion, np.random.default_rng(seed).standard_normal(count + 500))[500:]
    long = lfilter([1], recursion, np.eye(1, 4000)[0])
    return made / np.sqrt(long @ long)


@pytest.mark.parametrize("recursion", [[1.0], [1, -0.8], [1, 0.5], [1, -1.7, 0.81]])
def test_the_autocovariance_of_known_noise(recursion):
    found = np.mean([autocovariance(noise(recursion, seed, 2000)) for seed in range(20)], axis=0)
    kernel = lfilter([1], recursion, np.eye(1, 4000)[0])
    expected = np.correlate(kernel, kernel, "full")[3999:4040] / (kernel @ kernel)
    # 20 records of 2000 samples, alike over 10: 1 part in 30
    assert found[:41] == pytest.approx(expected, abs=0.1)
    assert found[0] == pytest.approx(1, abs=0.05)


def test_a_covariance_is_that_of_the_formula_and_infinite_where_samples_determine_nothing():
    random = np.random.default_rng(0)
    jacobian, lags = random.standard_normal((30, 3)) * [1, 1e-6, 1e6], 0.7 ** np.arange(30)
    whole = 0.7 ** np.abs(np.subtract.outer(np.arange(30), np.arange(30)))
    inverse = np.linalg.inv(jacobian.T @ jacobian) @ jacobian.T
    for alike, matrix in ((lags, whole), (lags[:1], np.eye(30))):
        found = covariance(jacobian=jacobian, autocovariance=alike)
        np.testing.assert_allclose(found, inverse @ matrix @ inverse.T, rtol=1e-6)
    for lost in (np.ones((10, 2)), np.zeros((10, 1))):
        assert np.all(np.isinf(covariance(jacobian=lost, autocovariance=np.ones(1))))


@pytest.mark.slow
@pytest.mark.parametrize("recursion", [[1.0], [1, -0.7], [1, -1.7, 0.81]])
def test_a_standard_error_holds_the_mean_and_the_slope_as_often_as_it_says(recursion):
    time, beyond = np.arange(128) * 1e-3, np.zeros(2)
    for seed in range(150):
        mean, _, slope, of_slope = line(time=time, values=noise(recursion, seed) + 3 + 5 * time)
        # a drift counts as scatter of the mean, so the mean is judged without it
        flat, of_flat, _, _ = line(time=time, values=noise(recursion, seed))
        assert mean - 3 - 5 * time.mean() == pytest.approx(flat, abs=1e-12)
        beyond += abs(flat) > 2 * of_flat, abs(slope - 5) > 2 * of_slope
    # 5 % are stated for independent samples; 400 records give 1.1 % more or less, correlation up to 11 %
    assert np.all(beyond / 400 < 0.13)
    assert np.all(beyond / 400 > 0.02)


def test_a_drift_counts_as_scatter_of_the_mean_and_without_scatter_there_is_no_error():
    time, white = np.arange(128) * 1e-3, noise([1.0], 0)
    assert line(time=time, values=white + 50 * time)[1] > 3 * line(time=time, values=white)[1]
    assert line(time=np.arange(10.0), values=np.full(10, 3.0)) == pytest.approx((3, 0, 0, 0), abs=1e-12)


@pytest.mark.slow
def test_a_passage_between_two_samples_has_the_error_of_the_noise_over_its_slope():
    """A ramp of five samples passes each level between two of them: too few for a parabola."""
    time, ramp = np.arange(400) / 1e3, np.clip((np.arange(400) - 200.3) / 5, 0, 1)
    found = []
    for seed in range(150):
        values = ramp + 0.01 * np.random.default_rng(seed).standard_normal(time.size)
        (at,) = reference_times(time, values, None)
        found.append(
            edge_record(
                time, values, [at], 0, levels=(0.4, 0.9), driven=False, window=None, before=None
            ).passages
        )
    assert all(each.interpolated for each in found)
    assert np.mean([each.time for each in found]) == pytest.approx(2.5e-3, rel=0.02)
    assert np.mean([each.standard_error for each in found]) == pytest.approx(
        np.std([each.time for each in found]), rel=0.25
    )


@pytest.mark.parametrize(
    ("form", "unsettled"),
    [
        (lambda t: 1 - np.exp(-2 * t), True),
        (lambda t: 1 - np.exp(-5 * t), False),
        (lambda t: 1 - np.exp(-30 * t), False),
        (lambda t: np.log1p(1e3 * t), True),
        (lambda t: t**0.3, True),
        (lambda t: 1 + 0.02 * np.log(t + 1e-9), False),  # an edge after which a small part creeps
    ],
)
def test_a_record_creeps_that_has_not_settled_at_its_end(form, unsettled):
    time = np.linspace(-0.3, 1, 800)
    progress = form(np.maximum(time, 0)) / form(np.array(1.0))
    noise = 0.005 * np.random.default_rng(1).standard_normal(time.size)
    assert creeps(time, progress + noise) is unsettled
