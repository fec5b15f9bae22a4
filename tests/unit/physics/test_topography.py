"""Heights drawn from a self-affine spectrum have its statistics, on any grid."""

import numpy as np
import pytest

from electrovib.core.errors import InputError
from electrovib.physics.topography import MeasuredHeights, SelfAffine

PERIODS = (1e-3, 5e-4)
GIVEN = {"rms": 5e-6, "hurst": 0.7, "longest": 1e-3, "roll_off": 2.5e-4, "shortest": 2e-5}
SPECTRUM = SelfAffine(**GIVEN)


def power(heights):
    """Return the power of each wave, and its wave number."""
    q = [2 * np.pi * np.fft.fftfreq(n, period / n) for n, period in zip(heights.shape, PERIODS, strict=True)]
    return np.abs(np.fft.fft2(heights) / heights.size) ** 2, np.hypot(q[0][:, None], q[1][None, :])


@pytest.mark.parametrize("seed", range(3))
def test_rms_height_and_slope_are_those_of_the_spectrum(seed):
    heights = SPECTRUM.heights((128, 64), PERIODS, seed=seed)
    found, q = power(heights)
    assert heights.std() == pytest.approx(5e-6, rel=1e-12)
    assert abs(heights.mean()) < 1e-18
    assert np.sqrt(np.sum(q**2 * found)) == pytest.approx(SPECTRUM.rms_slope(PERIODS), rel=1e-12)


def test_the_power_is_level_up_to_the_roll_off_and_then_falls():
    found, q = power(SPECTRUM.heights((128, 64), PERIODS, seed=0))
    wavelength = 2 * np.pi / np.where(q == 0, 1e-9, q)
    there = (wavelength <= 1e-3 * (1 + 1e-9)) & (wavelength >= 2e-5 * (1 - 1e-9))
    level = found[there & (wavelength > 2.5e-4)]
    assert level == pytest.approx(level[0], rel=1e-9)
    assert found[~there].max() < 1e-20 * level[0]
    falls = there & (wavelength < 2.5e-4)
    assert found[falls] == pytest.approx(level[0] * (wavelength[falls] / 2.5e-4) ** 3.4, rel=1e-9)


def test_heights_are_nearly_gaussian_and_phases_are_independent():
    heights = SPECTRUM.heights((128, 64), PERIODS, seed=4) / 5e-6
    assert abs(np.mean(heights**3)) < 0.3
    assert np.mean(heights**4) == pytest.approx(3, abs=0.5)
    other = SPECTRUM.heights((128, 64), PERIODS, seed=5) / 5e-6
    assert abs(np.mean(heights * other)) < 0.2


def test_a_finer_grid_shows_the_same_surface_and_a_finer_spectrum_adds_to_it():
    coarse = SPECTRUM.heights((128, 64), PERIODS, seed=1)
    fine = SPECTRUM.heights((256, 128), PERIODS, seed=1)
    assert fine[::2, ::2] == pytest.approx(coarse, abs=1e-18)
    finer = SelfAffine(**GIVEN | {"shortest": 1e-5}).heights((256, 128), PERIODS, seed=1)
    waves, added = np.fft.fft2(fine), np.fft.fft2(finer)
    own = np.abs(waves) > 1e-9 * np.abs(waves).max()
    ratio = added[own] / waves[own]
    assert ratio == pytest.approx(np.full(ratio.shape, ratio[0].real), rel=1e-7)
    assert 0.9 < ratio[0].real < 1


@pytest.mark.parametrize(
    ("other", "said"),
    [
        ({"rms": 0.0}, r"rms\n.*between 1 fm and 1 m"),
        ({"rms": None}, r"rms\n.*expected a length"),
        ({"hurst": 1.2}, r"hurst\n.*between 0 and 1"),
        ({"roll_off": 1e-6}, "wavelengths fall in this order"),
        ({"longest": np.inf}, r"longest\n.*a finite number"),
    ],
)
def test_what_is_no_spectrum_is_refused(other, said):
    with pytest.raises(ValueError, match=said):
        SelfAffine(**GIVEN | other)


def test_a_grid_that_is_too_coarse_and_a_range_without_waves_are_refused():
    with pytest.raises(InputError, match=r"at least \(101, 51\) points"):
        SPECTRUM.heights((100, 64), PERIODS, seed=0)
    assert SPECTRUM.heights((101, 51), PERIODS, seed=0).shape == (101, 51)
    narrow = SelfAffine(rms=1e-6, hurst=0.5, longest=9.5e-4, roll_off=9e-4, shortest=9e-4)
    with pytest.raises(InputError, match="no wave of this range"):
        narrow.heights((64, 64), (1e-3, 1e-3), seed=0)


def test_without_the_shortest_octave_the_longer_waves_stay_as_they_are():
    given = SelfAffine(**GIVEN)
    smooth = given.without_shortest_octave()
    sides = (given.longest,) * 2
    whole, even = (np.fft.fft2(each.heights((128, 128), sides, seed=2)) for each in (given, smooth))
    count = np.fft.fftfreq(128, 1 / 128)
    kept = np.hypot(count[:, None], count[None, :]) <= given.longest / smooth.shortest * (1 + 1e-9)
    assert smooth.shortest == 2 * given.shortest
    assert even[kept] == pytest.approx(whole[kept], abs=1e-9 * np.abs(whole).max())
    assert np.abs(even[~kept]).max() < 1e-12 * np.abs(even).max()
    assert smooth.rms == pytest.approx(np.sqrt(np.sum(np.abs(whole[kept]) ** 2)) / 128**2, rel=1e-12)
    assert smooth.rms < given.rms
    with pytest.raises(InputError, match="at most half the longest"):
        SelfAffine(**GIVEN | {"roll_off": 1e-3, "shortest": 6e-4}).without_shortest_octave()


def test_waves_that_no_grid_resolves_are_refused_before_memory_is_asked_for():
    rough = SelfAffine(rms=1e-6, hurst=0.8, longest=1e-3, roll_off=1e-3, shortest=1e-9)
    for use in (lambda: rough.rms_slope((1e-3, 1e-3)), lambda: rough.heights((64, 64), (1e-3, 1e-3), seed=0)):
        with pytest.raises(InputError, match=r"1e-09: 1e\+06 waves stand in 0.001 m, .* at most 2048"):
            use()


SPACING = 2e-6


def waves(rows=24, columns=32, along=4, across=6, amplitude=1e-6):
    """Return a product of cosines whose mirror images continue it, with neither mean nor tilt."""
    y, x = ((np.arange(count) + 0.5) / count for count in (rows, columns))
    return amplitude * np.cos(np.pi * across * y)[:, None] * np.cos(np.pi * along * x)[None, :]


def test_a_measured_map_continues_in_its_mirror_images_without_its_tilt():
    rows, columns = np.indices((25, 33))
    tilted = 3e-4 + 2e-7 * rows - 5e-7 * columns
    tilted[:24, :32] += waves()
    found = MeasuredHeights(values=tilted, spacing=SPACING)
    assert found.shape() == (48, 64)
    assert found.periods == pytest.approx((48 * SPACING, 64 * SPACING))
    assert found.shortest == 2 * SPACING
    expected = waves(48, 64, 8, 12)
    heights = found.heights(found.shape(), found.periods, seed=5)
    assert heights == pytest.approx(expected, abs=1e-12)
    assert heights[::-1, ::-1] == pytest.approx(heights, abs=1e-18)
    slope = 1e-6 / 2 * np.pi * np.hypot(4 / (32 * SPACING), 6 / (24 * SPACING))
    assert found.rms_slope(found.periods) == pytest.approx(slope, rel=1e-9)


@pytest.mark.parametrize(("across", "left"), [(10, True), (12, True), (14, False)])
def test_a_measured_map_loses_the_waves_of_its_shortest_octave(across, left):
    """Of 24 points with a wave of 2 points at least, those below 4 points: more than 12 half waves."""
    values = waves(along=0, across=across)
    even = MeasuredHeights(values=values, spacing=SPACING).without_shortest_octave()
    assert even.level() == pytest.approx(values if left else 0 * values, abs=1e-12)


def test_the_slope_of_a_measured_map_is_that_of_all_its_waves():
    values = 1e-6 * np.random.default_rng(0).normal(size=(8, 8))
    found = MeasuredHeights(values=values, spacing=SPACING)
    heights = found.heights(found.shape(), found.periods, seed=0)
    q = 2 * np.pi * np.fft.fftfreq(16, SPACING)
    power = np.abs(np.fft.fft2(heights) / heights.size) ** 2
    expected = np.sqrt(np.sum((q[:, None] ** 2 + q[None, :] ** 2) * power))
    assert found.rms_slope(found.periods) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"values": np.zeros(9)}, "9 heights: give columns"),
        ({"values": np.zeros((3, 9))}, "4 to 1024 whole rows"),
        ({"values": np.zeros((1025, 4))}, "4 to 1024 whole rows"),
        ({"values": np.zeros((4, 1025))}, "1024"),
        ({"values": [[0.0, 1.0, np.nan, 0.0]] * 4}, "4 of 16 heights are missing"),
        ({"spacing": 0.0}, r"spacing\n.*between 1 pm and 1 m"),
        ({"spacing": np.nan}, r"spacing\n.*a finite number"),
    ],
)
def test_what_is_no_map_is_refused(given, said):
    with pytest.raises(ValueError, match=said):
        MeasuredHeights(**{"values": np.eye(4), "spacing": SPACING} | given)
