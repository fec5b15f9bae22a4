"""Standard errors against many records of noise whose correlation is known."""

import numpy as np
import pytest
from scipy.signal import lfilter

from electrovib.recordings.correlated import autocovariance, covariance, line


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
    for seed in range(400):
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
