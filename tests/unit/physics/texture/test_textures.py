"""Added friction of textures and the paths over them, against closed forms; tests/contract hold the waveforms."""

import math

import numpy as np
import pytest

from electrovib.core.errors import InputError
from electrovib.core.samples import Samples
from electrovib.physics.texture.base import RenderingPlate, Texture
from electrovib.physics.texture.path import FingerPath
from electrovib.scenario import read_part

PLATE = RenderingPlate(normal_force=0.4, largest_added_friction=3e-3)
MM = 1e-3


def texture(model, **table):
    return read_part(Texture, {"model": model, **table})


def added(found, x, y=0.0, speed=0.03):
    x = np.asarray(x, dtype=float)
    position = np.stack([x, np.full(x.shape, y)], axis=-1)
    return found.added_friction(position, np.broadcast_to([speed, 0.0], position.shape), PLATE)


def test_a_grating_varies_along_its_angle_and_a_duty_is_the_width_of_its_ridges():
    across = texture("Grating", period="2 mm", amplitude="1 mN", angle=math.pi / 2)
    np.testing.assert_allclose(added(across, [0, 5e-4, 1.0], y=0.5e-3), 2e-3, atol=1e-15)
    waveform = {"model": "RectangularWaveform", "duty": 0.2, "edge": 1e-6}
    grating = texture("Grating", period=1.0, amplitude=0.5, waveform=waveform)
    assert np.mean(added(grating, np.linspace(0, 1, 10_000, endpoint=False))) == pytest.approx(0.2, abs=1e-4)


def test_the_slope_of_a_sinusoidal_profile_is_its_closed_form():
    """Central differences of a sine are its derivative times sin(k d)/(k d)."""
    height, step, k = 20e-6, 25e-6, 2 * math.pi / 2e-3
    x = np.arange(401) * step
    profile = texture("HeightProfile", position_samples=x, height_samples=height * np.sin(k * x), gain=2.0)
    slope = height * k * np.cos(k * x) * math.sin(k * step) / (k * step)
    for sign in (1, -1):
        expected = 2.0 * 0.4 * np.maximum(sign * slope, 0.0)[1:-1]
        found = added(profile, x, speed=0.03 * sign)[1:-1]
        np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-15)


def test_a_profile_counts_in_part_when_slow_and_fades_within_one_step_beyond_its_ends():
    rising = [0, 1e-5, 2e-5]
    profile = texture(
        "HeightProfile", position_samples=[5e-3, 6e-3, 7e-3], height_samples=rising, slow="2 mm/s"
    )
    at = [added(profile, [MM], speed=speed)[0] for speed in (0.0, 0.5e-3, 2e-3, 1.0, -1.0)]
    np.testing.assert_allclose(at, 0.4 * 0.01 * np.array([0, 0.25, 1, 1, 0]), rtol=1e-12)
    share = added(profile, [-1e-3, -0.5e-3, 0, 2e-3, 2.25e-3, 3e-3, 1.0]) / (0.4 * 0.01)
    np.testing.assert_allclose(share, [0, 0.5, 1, 1, 0.75, 0, 0], atol=1e-12)


def test_recorded_friction_is_replayed_above_its_lowest_value():
    record = {"position_samples": [0, MM, 2e-3], "friction_force_samples": [0.25, 0.27, 0.26]}
    lowest = added(texture("RecordedFrictionForce", **record, scale=3.0), [0, 0.5e-3, MM, 2e-3])
    np.testing.assert_allclose(lowest, 3 * np.array([0, 0.01, 0.02, 0.01]), atol=1e-15)
    given = added(texture("RecordedFrictionForce", **record, baseline="240 mN"), [0, MM])
    np.testing.assert_allclose(given, [0.01, 0.03], atol=1e-15)


def test_a_picture_maps_0_and_255_to_nothing_and_to_the_most_and_ends_at_its_edges():
    values = [0, 255, 51, 255, 0, 102]
    picture = texture("GreyscalePicture", width=3, value_samples=values, pixels_per_millimetre=2)
    assert (picture.length, picture.height) == (1.5e-3, 1e-3)
    centres = (np.arange(3) + 0.5) / 2e3
    places = [
        (centres, 0.25, [0, 1, 0.2]),
        (centres, 0.75, [1, 0, 0.4]),
        ([0.5e-3, 0.625e-3], 0.25, [0.5, 0.75]),
        ([0.5e-3], 0.5, [0.5]),
    ]
    for x, y, shares in places:
        np.testing.assert_allclose(
            added(picture, x, y=y * MM), 3e-3 * np.array(shares), rtol=1e-12, atol=1e-15
        )
    picture = texture("GreyscalePicture", width=1, value_samples=[255], pixels_per_millimetre=1)
    share = added(picture, [-1.0, -0.5e-3, 0.0, 0.5e-3, 1.25e-3, 1.5e-3, 1.0], y=0.5e-3) / 3e-3
    np.testing.assert_allclose(share, [0, 0, 0.5, 1, 0.25, 0, 0], atol=1e-12)
    assert added(picture, [0.5e-3], y=9.0) == 0


def test_paths_and_their_ends():
    content = {
        "model": "ConstantSpeed",
        "speed": "30 mm/s",
        "stroke": "6 mm",
        "begin": "1 mm",
        "across": "2 mm",
    }
    stroke = read_part(FingerPath, content)
    assert stroke.duration == pytest.approx(0.2)
    found = stroke.positions(np.array([-1.0, 0.1, 9.0]))
    np.testing.assert_allclose(found, MM * np.array([[1, 2], [4, 2], [7, 2]]))
    columns = {"time_samples": [5, 6, 8], "x_samples": [0, MM, 0], "y_samples": [0, 0, 4e-3]}
    record = read_part(FingerPath, {"model": "RecordedPath"} | columns)
    assert (record.duration, record.steady_speed) == (3, None)
    found = record.positions(np.array([0.5, 2.0, 7.0]))
    np.testing.assert_allclose(found, MM * np.array([[0.5, 0], [0.5, 2], [0, 4]]), atol=1e-15)


NARROW = {"waveform": {"model": "RectangularWaveform", "duty": 0.1, "edge": 0.2}}
TOO_MANY = {"width": 2001, "value_samples": Samples(np.zeros(2001 * 2000))}


def profile(positions, heights):
    return {"position_samples": positions, "height_samples": heights}


def path(time, x):
    return {"time_samples": time, "x_samples": x}


WRONG = [
    ("Grating", {"period": MM, "amplitude": MM} | NARROW, "edge must not be longer"),
    ("HeightProfile", {}, "holds no samples: name the record"),
    ("HeightProfile", profile([0, 1], [0]), "2 positions but 1 values of the height"),
    ("HeightProfile", profile([0], [0]), "at least 2 samples, not 1"),
    ("HeightProfile", profile([0, MM, MM], [0, 0, 1]), "increase by at least 1 nm, but sample 2"),
    ("HeightProfile", profile([0, 20], [0, 1]), "is 20 m long, and 10 m are allowed"),
    ("HeightProfile", profile([0, 1], [0, math.nan]), "the height of sample 1 is not a finite number"),
    ("GreyscalePicture", {}, "holds no pixels"),
    ("GreyscalePicture", {"width": 2, "value_samples": [0, 1, 2]}, "3 pixels are no rows of 2"),
    ("GreyscalePicture", {"width": 1, "value_samples": [256]}, "lie between 0 and 255"),
    ("GreyscalePicture", TOO_MANY, "4000000 are allowed"),
    ("RecordedPath", {}, "holds no samples"),
    ("RecordedPath", path([0, 1], [0]), "different numbers of samples: 2 of time, 1 of x"),
    ("RecordedPath", path([0, 1], [0, math.inf]), "the x of sample 1 is not a finite number"),
    ("RecordedPath", path([0, 1, 1], [0, 0, 0]), "time must increase, but sample 2"),
    ("RecordedPath", path([0, 1e4], [0, 0]), "an hour is allowed"),
    ("RecordedPath", path([0, 1], [0, 30]), "between -10 m and 10 m"),
]


@pytest.mark.parametrize(("model", "table", "words"), WRONG)
def test_a_wrong_texture_or_path_is_refused_in_a_sentence(model, table, words):
    if model == "GreyscalePicture":
        table = {"pixels_per_millimetre": 1} | table
    with pytest.raises(InputError, match=words):
        read_part(FingerPath if model == "RecordedPath" else Texture, {"model": model} | table)
