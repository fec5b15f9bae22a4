"""Added friction of textures against closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest

from electrovib.core.errors import InputError
from electrovib.core.model import read_model
from electrovib.core.samples import Samples
from electrovib.physics.texture.base import RenderingPlate, Texture
from electrovib.physics.texture.path import FingerPath
from electrovib.scenario import read_part

PLATE = RenderingPlate(normal_force=0.4, largest_added_friction=3e-3)


def places(x, y=0.0):
    x = np.asarray(x, dtype=float)
    return np.stack([x, np.full(x.shape, y)], axis=-1)


def texture(model, **table):
    return read_part(Texture, {"model": model, **table})


def added(found, x, y=0.0, speed=0.03):
    position = places(x, y)
    return found.added_friction(position, np.broadcast_to([speed, 0.0], position.shape), PLATE)


@pytest.mark.parametrize(
    ("waveform", "at", "expected"),
    [
        ("SinusoidalWaveform", [0, 0.25, 0.5, 0.75, 1.125], [0, 1, 0, -1, math.sqrt(0.5)]),
        ("TriangularWaveform", [0, 0.125, 0.25, 0.5, 0.75, 1.0], [0, 0.5, 1, 0, -1, 0]),
        ("RectangularWaveform", [-0.025, 0, 0.0125, 0.025, 0.3, 0.5, 0.6, 1.2], [-1, 0, 0.5, 1, 1, 0, -1, 1]),
        ("SawtoothWaveform", [0, 0.475, 0.95, 0.975, 1.0], [-1, 0, 1, 0, -1]),
    ],
)
def test_waveforms_of_a_grating(waveform, at, expected):
    grating = texture("Grating", period="2 mm", amplitude="1 mN", waveform={"model": waveform})
    np.testing.assert_allclose(
        added(grating, np.array(at) * 2e-3), 1e-3 * (1 + np.array(expected)), atol=1e-15
    )


def test_a_grating_varies_along_its_angle():
    grating = texture("Grating", period="2 mm", amplitude="1 mN", angle=math.pi / 2)
    np.testing.assert_allclose(added(grating, [0, 5e-4, 1.0], y=0.5e-3), 2e-3, atol=1e-15)


def test_a_duty_is_the_width_of_the_ridges():
    grating = texture(
        "Grating",
        period=1.0,
        amplitude=0.5,
        waveform={"model": "RectangularWaveform", "duty": 0.2, "edge": 1e-6},
    )
    assert np.mean(added(grating, np.linspace(0, 1, 10_000, endpoint=False))) == pytest.approx(0.2, abs=1e-4)


def test_the_slope_of_a_sinusoidal_profile_is_its_closed_form():
    """Central differences of a sine are its derivative times sin(k d)/(k d)."""
    period, height, step = 2e-3, 20e-6, 25e-6
    x = np.arange(401) * step
    k = 2 * math.pi / period
    profile = texture("HeightProfile", position_samples=x, height_samples=height * np.sin(k * x), gain=2.0)
    slope = height * k * np.cos(k * x) * math.sin(k * step) / (k * step)
    inner = slice(1, -1)
    np.testing.assert_allclose(
        added(profile, x)[inner], (2.0 * 0.4 * np.maximum(slope, 0.0))[inner], rtol=1e-12, atol=1e-15
    )
    backwards = added(profile, x, speed=-0.03)[inner]
    np.testing.assert_allclose(
        backwards, (2.0 * 0.4 * np.maximum(-slope, 0.0))[inner], rtol=1e-12, atol=1e-15
    )


def test_below_the_slow_speed_the_slope_counts_in_part():
    profile = texture(
        "HeightProfile", position_samples=[0, 1e-3, 2e-3], height_samples=[0, 1e-5, 2e-5], slow="2 mm/s"
    )
    at = [added(profile, [1e-3], speed=speed)[0] for speed in (0.0, 0.5e-3, 2e-3, 1.0, -1.0)]
    np.testing.assert_allclose(at, 0.4 * 0.01 * np.array([0, 0.25, 1, 1, 0]), rtol=1e-12)


def test_a_profile_fades_within_one_step_beyond_its_ends():
    profile = texture("HeightProfile", position_samples=[5e-3, 6e-3, 7e-3], height_samples=[0, 1e-5, 2e-5])
    share = added(profile, [-1e-3, -0.5e-3, 0, 2e-3, 2.25e-3, 3e-3, 1.0]) / (0.4 * 0.01)
    np.testing.assert_allclose(share, [0, 0.5, 1, 1, 0.75, 0, 0], atol=1e-12)


def test_recorded_friction_is_replayed_above_its_baseline():
    record = {"position_samples": [0, 1e-3, 2e-3], "friction_force_samples": [0.25, 0.27, 0.26]}
    lowest = texture("RecordedFrictionForce", **record, scale=3.0)
    np.testing.assert_allclose(
        added(lowest, [0, 0.5e-3, 1e-3, 2e-3]), 3 * np.array([0, 0.01, 0.02, 0.01]), atol=1e-15
    )
    given = texture("RecordedFrictionForce", **record, baseline="240 mN")
    np.testing.assert_allclose(added(given, [0, 1e-3]), [0.01, 0.03], atol=1e-15)
    coefficient = texture(
        "RecordedFrictionCoefficient",
        position_samples=[0, 1e-3],
        friction_coefficient_samples=[0.5, 0.6],
        baseline=0.45,
    )
    np.testing.assert_allclose(added(coefficient, [0, 1e-3]), 0.4 * np.array([0.05, 0.15]), rtol=1e-12)


def test_a_picture_maps_0_and_255_to_nothing_and_to_the_most():
    picture = texture(
        "GreyscalePicture", width=3, value_samples=[0, 255, 51, 255, 0, 102], pixels_per_millimetre=2
    )
    centres = (np.arange(3) + 0.5) / 2e3
    np.testing.assert_allclose(added(picture, centres, y=0.25e-3), 3e-3 * np.array([0, 1, 0.2]), atol=1e-15)
    np.testing.assert_allclose(added(picture, centres, y=0.75e-3), 3e-3 * np.array([1, 0, 0.4]), atol=1e-15)
    np.testing.assert_allclose(added(picture, [0.5e-3], y=0.25e-3), 1.5e-3, rtol=1e-12)
    np.testing.assert_allclose(added(picture, [0.5e-3], y=0.5e-3), 1.5e-3, rtol=1e-12)
    np.testing.assert_allclose(added(picture, [0.625e-3], y=0.25e-3), 3e-3 * 0.75, rtol=1e-12)
    assert (picture.length, picture.height) == (1.5e-3, 1e-3)


def test_a_picture_is_0_beyond_its_edges():
    picture = texture("GreyscalePicture", width=1, value_samples=[255], pixels_per_millimetre=1)
    share = added(picture, [-1.0, -0.5e-3, 0.0, 0.5e-3, 1.25e-3, 1.5e-3, 1.0], y=0.5e-3) / 3e-3
    np.testing.assert_allclose(share, [0, 0, 0.5, 1, 0.25, 0, 0], atol=1e-12)
    assert added(picture, [0.5e-3], y=9.0) == 0


WRONG = {
    "edge": (
        {
            "model": "Grating",
            "period": 1e-3,
            "amplitude": 1e-3,
            "waveform": {"model": "RectangularWaveform", "duty": 0.1, "edge": 0.2},
        },
        "edge must not be longer",
    ),
    "no samples": ({"model": "HeightProfile"}, "holds no samples: name the record"),
    "unlike columns": (
        {"model": "HeightProfile", "position_samples": [0, 1], "height_samples": [0]},
        "2 positions but 1 values of the height",
    ),
    "one sample": (
        {"model": "HeightProfile", "position_samples": [0], "height_samples": [0]},
        "at least 2 samples, not 1",
    ),
    "not increasing": (
        {"model": "HeightProfile", "position_samples": [0, 1e-3, 1e-3], "height_samples": [0, 0, 1]},
        "positions must increase by at least 1 nm, but sample 2",
    ),
    "too long": (
        {"model": "HeightProfile", "position_samples": [0, 20], "height_samples": [0, 1]},
        "is 20 m long, and 10 m are allowed",
    ),
    "not finite": (
        {"model": "HeightProfile", "position_samples": [0, 1], "height_samples": [0, math.nan]},
        "the height of sample 1 is not a finite number",
    ),
    "no pixels": ({"model": "GreyscalePicture", "pixels_per_millimetre": 1}, "holds no pixels"),
    "no rows": (
        {"model": "GreyscalePicture", "pixels_per_millimetre": 1, "width": 2, "value_samples": [0, 1, 2]},
        "3 pixels are no rows of 2",
    ),
    "beyond white": (
        {"model": "GreyscalePicture", "pixels_per_millimetre": 1, "width": 1, "value_samples": [256]},
        "lie between 0 and 255",
    ),
}


@pytest.mark.parametrize("case", WRONG)
def test_a_wrong_texture_is_refused_in_a_sentence(case):
    table, words = WRONG[case]
    with pytest.raises(InputError, match=words):
        read_part(Texture, table)


def test_a_picture_has_a_largest_number_of_pixels():
    with pytest.raises(InputError, match="4000000 are allowed"):
        read_model(
            Texture,
            {
                "model": "GreyscalePicture",
                "pixels_per_millimetre": 1,
                "width": 2001,
                "value_samples": Samples(np.zeros(2001 * 2000)),
            },
        )


def test_paths_and_their_ends():
    stroke = read_part(
        FingerPath,
        {"model": "ConstantSpeed", "speed": "30 mm/s", "stroke": "6 mm", "begin": "1 mm", "across": "2 mm"},
    )
    assert stroke.duration == pytest.approx(0.2)
    np.testing.assert_allclose(
        stroke.positions(np.array([-1.0, 0.1, 9.0])), [[1e-3, 2e-3], [4e-3, 2e-3], [7e-3, 2e-3]]
    )
    record = read_part(
        FingerPath,
        {
            "model": "RecordedPath",
            "time_samples": [5, 6, 8],
            "x_samples": [0, 1e-3, 0],
            "y_samples": [0, 0, 4e-3],
        },
    )
    assert (record.duration, record.steady_speed) == (3, None)
    np.testing.assert_allclose(
        record.positions(np.array([0.5, 2.0, 7.0])), [[0.5e-3, 0], [0.5e-3, 2e-3], [0, 4e-3]], atol=1e-15
    )


WRONG_PATHS = {
    "no samples": ({}, "holds no samples"),
    "unlike": ({"time_samples": [0, 1], "x_samples": [0]}, "different numbers of samples: 2 of time, 1 of x"),
    "one": ({"time_samples": [0], "x_samples": [0]}, "at least 2 samples"),
    "not finite": (
        {"time_samples": [0, 1], "x_samples": [0, math.inf]},
        "the x of sample 1 is not a finite number",
    ),
    "back": ({"time_samples": [0, 1, 1], "x_samples": [0, 0, 0]}, "time must increase, but sample 2"),
    "long": ({"time_samples": [0, 1e4], "x_samples": [0, 0]}, "an hour is allowed"),
    "far": ({"time_samples": [0, 1], "x_samples": [0, 30]}, "between -10 m and 10 m"),
}


@pytest.mark.parametrize("case", WRONG_PATHS)
def test_a_wrong_path_is_refused_in_a_sentence(case):
    table, words = WRONG_PATHS[case]
    with pytest.raises(InputError, match=words):
        read_part(FingerPath, {"model": "RecordedPath", **table})
