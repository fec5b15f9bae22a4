"""The tribometer: sensors over frequency, levels of the digitiser, calibration, encoders that wrap, what has no default."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from electrovib.core.errors import InputError
from electrovib.core.model import read_model
from electrovib.physics.rig import (
    Digitiser,
    Encoder,
    ForceChannel,
    LateralSensor,
    PiezoSensor,
    Rig,
    SensorCreep,
    TribometerChannels,
)

DIGITISER = {"sampling_rate": "10 kHz", "bits": 8, "normal_range": "2 N", "lateral_range": "1 N", "seed": 3}
NORMAL = {"natural_frequency": "2 kHz", "damping_ratio": 0.02, "time_constant": "10 s"}
LATERAL = {"natural_frequency": "500 Hz", "damping_ratio": 0.05}
TABLE = {"model": "Tribometer", "normal": NORMAL, "lateral": LATERAL}
NOISY = LATERAL | {"noise": "1 mN"}


@pytest.mark.parametrize("kind", [LateralSensor, PiezoSensor, Digitiser, SensorCreep])
def test_no_value_is_assumed(kind):
    """The paper prints none; what may be left out is a part that is then not modelled."""
    optional = {name: field.default for name, field in kind.model_fields.items() if not field.is_required()}
    assert all(default in (None, 0.0) for default in optional.values()), optional


def test_sensors_over_frequency():
    plain = LateralSensor(natural_frequency=500.0, damping_ratio=0.05)
    assert plain.replace({"creep": SensorCreep(share=-0.02, time=5.0)}).gain(0.0) == pytest.approx(0.98)
    assert abs(plain.gain(500.0)) == pytest.approx(10, rel=1e-6)
    piezo = PiezoSensor(natural_frequency=2e3, damping_ratio=0.02, time_constant=10.0)
    assert piezo.gain(0.0) == 0  # blind to what lasts
    assert abs(piezo.gain(1 / (20 * np.pi))) == pytest.approx(np.sqrt(0.5))


def test_levels():
    """Eight bits over +-2 N: 256 levels of 15.625 mN from -2 N to 1.984375 N."""
    rig = read_model(Rig, {**TABLE, "digitiser": DIGITISER, "lateral": NOISY})
    assert rig.noises() == (0.0, 1e-3)
    force = np.array([0.0, 0.0079, -0.0079, 0.0077, 1.99, 1.9999, 7.0, -2.0, -2.0079, -7.0])
    step = 2 / 128
    expected = np.array([0, step, -step, 0, 127 * step, 127 * step, 127 * step, -2, -2, -2])
    reading = rig.digitiser.reading(force, full_scale=2.0)
    assert reading.tolist() == expected.tolist()
    clipped = rig.digitiser.levels(force, full_scale=2.0) * step != reading
    assert clipped.tolist() == [False] * 5 + [True, True, False, True, True]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"lateral": NOISY}, "needs a digitiser"),
        ({"lateral": {"natural_frequency": "500 Hz"}}, "missing"),
        ({"digitiser": {**DIGITISER, "bits": 40}}, "32"),
        ({"digitiser": {**DIGITISER, "bits": True}}, "whole number"),
        ({"digitiser": {**DIGITISER, "seed": -1}}, "0"),
        ({"normal": {**NORMAL, "time_constant": "2 V"}}, "expected a time"),
    ],
)
def test_what_is_no_rig_is_refused(change, message):
    with pytest.raises(InputError, match=message):
        read_model(Rig, {**TABLE, **change})


def test_columns_that_are_voltages_or_forces():
    falling = ForceChannel(column=0, sensitivity=-0.31, offset=5.4)  # under load
    np.testing.assert_allclose(falling.force(np.array([5.4, 3.7])), [0, 0.527], atol=1e-15)
    pressed = ForceChannel(column=0, unit="mN", sign=-1)
    np.testing.assert_array_equal(pressed.force(np.array([-0.5, 0.25])), [0.5, -0.25])
    assert (falling.read_as, pressed.read_as) == ("V", "mN")


@given(
    st.sampled_from([0.0, 2.0**31, 2.0**32]),
    st.sampled_from([2.0**31, 2.0**32]),
    st.integers(0, 2**32),
    st.integers(-3000, 3000),
    st.sampled_from([0.5e-6, -1e-6]),
)
def test_wraps_are_undone(declared, modulus, start, stride, step):
    """Any register, declared or not, counting in either direction, from any count, gives back the position."""
    moved = np.arange(400) * stride
    counts = (start + moved) % (declared or modulus)
    encoder = Encoder(column=0, step=step, wraps_at=declared)
    # counts below 2^33 are exact in doubles; the product has one rounding
    np.testing.assert_allclose(encoder.position(counts), step * moved, rtol=1e-15, atol=0)


def test_a_register_with_a_sign_bit_and_a_small_one_that_has_to_be_declared():
    counts = np.array([2.0**31 - 2, 2.0**31 - 1, -(2.0**31), 1 - 2.0**31])
    unknown = Encoder(column=0, step=1e-6)
    np.testing.assert_allclose(unknown.position(counts), np.arange(4) * 1e-6, rtol=1e-15)
    moved = np.arange(0, 200_000, 50)
    known = Encoder(column=0, step=1e-6, wraps_at=2.0**16)
    np.testing.assert_allclose(known.position(moved % 2**16), moved * 1e-6, rtol=1e-15)
    assert np.ptp(unknown.position(moved % 2**16)) < 0.066


NEITHER = "a column of voltages needs a sensitivity, .* a unit, .* neither of the two given"


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"normal": {"column": 0, "sensitivity": 0}}, r"normal = .*a sensitivity of 0 makes every force 0"),
        ({"normal": {"column": 0, "sensitivity": "3 V"}}, r"a sensitivity, for instance '0\.31 N/V'"),
        ({"encoder": {"column": 0, "step": "0 um"}}, "a step of 0 makes every position 0"),
        ({"encoder": {"column": 0, "step": "1 um", "wraps_at": -1}}, "wraps_at = -1: must lie between 0"),
        ({"clock": {"model": "EvenSample", "rate": 1}}, "Did you mean 'EvenSamples'"),
        ({"lateral": {"column": 0}}, NEITHER),
        ({"lateral": {"column": 0, "sensitivity": 1, "unit": "N"}}, "both of the two given"),
        ({"lateral": {"column": 0, "unit": "V"}}, "expected a unit such as 'N'"),
        ({"lateral": {"column": 0, "unit": "N", "sign": 2}}, "sign is 1 or -1, not 2"),
        ({"lateral": {"column": 0, "unit": "N", "offset": "1 V"}}, "an offset is a voltage and needs a sens"),
        ({"lateral": {"column": 0, "sensitivity": 1, "sign": -1}}, "give a negative sensitivity"),
        ({"speed": "40 mm/s"}, "the speed follows from the encoder: omit speed, or the encoder"),
        ({"missing_rows": -1}, "missing_rows = -1: expected a number of rows"),
    ],
)
def test_wrong_calibrations_are_refused(change, words):
    with pytest.raises(InputError, match=words):
        read_model(TribometerChannels, dict(TribometerChannels.example) | change)
