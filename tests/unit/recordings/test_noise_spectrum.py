"""The spectrum of residuals: white noise is white, and a correlated part is found with its size, by itself and by a sensor."""

import numpy as np
import pytest
from scipy.fft import dct
from twins import correlated

from electrovib.recordings.fit.components import spectrum_of

COUNT = 2000


def found(noise, sensor=None):
    return spectrum_of(dct(noise, norm="ortho") ** 2, np.ones(noise.size), sensor)


def test_white_noise_is_white():
    spectra = [found(2 * np.random.default_rng([51, seed]).normal(size=COUNT)) for seed in range(200)]
    assert sum(each.is_correlated for each in spectra) <= 2  # 1 of 1000 expected
    assert np.mean([each.power.mean() for each in spectra]) == pytest.approx(4, rel=0.01)


@pytest.mark.parametrize("memory", [0.3, 0.8, 0.95])
def test_noise_with_a_memory_has_the_spectrum_of_its_autoregression(memory):
    """(1 - m^2)/(1 - 2 m cos w + m^2) at w = pi k/n, which for slow components tends to (1 + m)/(1 - m)."""
    drawn = [correlated(np.random.default_rng([52, seed]), COUNT, memory) for seed in range(30)]
    spectra = [found(each) for each in drawn]
    assert all(each.is_correlated and each.is_unexplained for each in spectra)
    angle = np.pi * np.arange(COUNT) / COUNT
    exact = (1 - memory**2) / (1 - 2 * memory * np.cos(angle) + memory**2)
    for part in (slice(0, 10), slice(100, 110), slice(500, 510)):
        power = np.mean([each.power[part] for each in spectra])
        assert power == pytest.approx(exact[part].mean(), rel=0.3)


def test_noise_of_the_declared_sensor_is_explained_and_other_noise_is_not():
    rng, share = np.random.default_rng(53), 1 / (1 + (np.arange(COUNT) / 150) ** 2) ** 2
    drawn = dct(rng.normal(size=COUNT) * np.sqrt(0.1 + 5 * share), norm="ortho", type=3)
    alone, declared = found(drawn), found(drawn, share)
    assert (alone.is_correlated, alone.is_unexplained) == (True, True)
    assert (declared.is_correlated, declared.is_unexplained) == (True, False)
    assert declared.power[0] == pytest.approx(5.1, rel=0.2)
    assert declared.share[0] == pytest.approx(5 / 5.1, abs=0.02)
    slower = found(correlated(rng, COUNT, 0.98), share)
    assert slower.is_unexplained


def test_residuals_without_any_part_have_a_finite_spectrum():
    assert np.isfinite(found(np.zeros(40)).power).all()
    assert not found(np.zeros(40)).is_correlated
