"""Calibration of a tribometer: signs, offsets and encoders that wrap."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from electrovib.core.errors import InputError
from electrovib.core.model import read_model
from electrovib.physics.rig_channels import Encoder, ForceChannel, TribometerChannels


def test_a_voltage_that_falls_under_load():
    channel = ForceChannel(column=0, sensitivity=-0.31, offset=5.4)
    np.testing.assert_allclose(channel.force(np.array([5.4, 3.7])), [0, 0.527], atol=1e-15)


def test_a_column_that_is_a_force_needs_no_sensitivity():
    pressed = ForceChannel(column=0, unit="mN", sign=-1)
    assert pressed.read_as == "mN"
    np.testing.assert_array_equal(pressed.force(np.array([-0.5, 0.25])), [0.5, -0.25])
    assert ForceChannel(column=0, sensitivity=1).read_as == "V"


@given(
    st.sampled_from([0.0, 2.0**31, 2.0**32]),
    st.sampled_from([2.0**31, 2.0**32]),
    st.integers(0, 2**32),
    st.integers(-3000, 3000),
    st.sampled_from([0.5e-6, -1e-6]),
)
def test_wraps_are_undone(declared, modulus, start, stride, step):
    """Any register, declared or not, counting in either direction, from any count, gives back the position."""
    if declared:
        modulus = declared
    moved = np.arange(400) * stride
    counts = (start + moved) % modulus
    encoder = Encoder(column=0, step=step, wraps_at=declared)
    # counts below 2^33 are exact in doubles; the product has one rounding
    np.testing.assert_allclose(encoder.position(counts), step * moved, rtol=1e-15, atol=0)


def test_a_register_with_a_sign_bit():
    counts = np.array([2.0**31 - 2, 2.0**31 - 1, -(2.0**31), 1 - 2.0**31])
    np.testing.assert_allclose(Encoder(column=0, step=1e-6).position(counts), np.arange(4) * 1e-6, rtol=1e-15)


def test_a_small_register_has_to_be_declared():
    counts = np.arange(0, 200_000, 50) % 2**16
    known = Encoder(column=0, step=1e-6, wraps_at=2.0**16).position(counts)
    np.testing.assert_allclose(known, np.arange(0, 200_000, 50) * 1e-6, rtol=1e-15)
    assert np.ptp(Encoder(column=0, step=1e-6).position(counts)) < 0.066


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"normal": {"column": 0, "sensitivity": 0}}, r"normal = .*a sensitivity of 0 makes every force 0"),
        (
            {"normal": {"column": 0, "sensitivity": "3 V"}},
            r"expected a sensitivity, for instance '0\.31 N/V'",
        ),
        ({"encoder": {"column": 0, "step": "0 um"}}, "a step of 0 makes every position 0"),
        ({"encoder": {"column": 0, "step": "1 um", "wraps_at": -1}}, "wraps_at = -1: must lie between 0"),
        ({"clock": {"model": "EvenSample", "rate": 1}}, "Did you mean 'EvenSamples'"),
        (
            {"lateral": {"column": 0}},
            "a column of voltages needs a sensitivity, .* a unit, .* neither of the two given",
        ),
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
