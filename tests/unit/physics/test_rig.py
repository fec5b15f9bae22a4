"""The tribometer: sensors over frequency, levels of the digitiser, what has no default."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from electrovib.core.errors import InputError
from electrovib.core.model import read_model
from electrovib.physics.rig import Digitiser, LateralSensor, PiezoSensor, Rig, SensorCreep, Tribometer

DIGITISER = {"sampling_rate": "10 kHz", "bits": 8, "normal_range": "2 N", "lateral_range": "1 N", "seed": 3}
TABLE = {
    "model": "Tribometer",
    "normal": {"natural_frequency": "2 kHz", "damping_ratio": 0.02, "time_constant": "10 s"},
    "lateral": {"natural_frequency": "500 Hz", "damping_ratio": 0.05},
}


def read(table):
    return read_model(Rig, table)


@pytest.mark.parametrize("kind", [LateralSensor, PiezoSensor, Digitiser, SensorCreep])
def test_no_value_is_assumed(kind):
    """The paper prints none; what may be left out is a part that is then not modelled."""
    optional = {name: field.default for name, field in kind.model_fields.items() if not field.is_required()}
    assert all(default in (None, 0.0) for default in optional.values()), optional


def test_lateral_sensor_over_frequency():
    sensor = LateralSensor(
        natural_frequency=500.0, damping_ratio=0.05, bandwidth=1e4, creep=SensorCreep(share=-0.02, time=5.0)
    )
    assert sensor.gain(0.0) == pytest.approx(0.98)
    assert abs(sensor.gain(1.0)) == pytest.approx(
        1.0, abs=1e-4
    )  # long before the creep, far below the resonance
    assert abs(sensor.gain(500.0)) == pytest.approx(10 / np.hypot(1, 0.05), rel=1e-6)
    plain = LateralSensor(natural_frequency=500.0, damping_ratio=0.05)
    assert abs(plain.gain(1e4)) == pytest.approx(1 / np.hypot(1 - 400, 2.0), rel=1e-12)


def test_piezo_is_blind_to_what_lasts():
    sensor = PiezoSensor(natural_frequency=2e3, damping_ratio=0.02, time_constant=10.0)
    assert sensor.gain(0.0) == 0
    assert abs(sensor.gain(1 / (20 * np.pi))) == pytest.approx(np.sqrt(0.5))
    assert abs(sensor.gain(50.0)) == pytest.approx(1.0, abs=1e-3)


def test_levels():
    """Eight bits over +-2 N: 256 levels of 15.625 mN from -2 N to 1.984375 N."""
    digitiser = read({**TABLE, "digitiser": DIGITISER}).digitiser
    force = np.array([0.0, 0.0079, -0.0079, 0.0077, 1.99, 1.9999, 7.0, -2.0, -2.0079, -7.0])
    step = 2 / 128
    expected = np.array([0, step, -step, 0, 127 * step, 127 * step, 127 * step, -2, -2, -2])
    assert digitiser.reading(force, full_scale=2.0).tolist() == expected.tolist()
    clipped = digitiser.levels(force, full_scale=2.0) * step != digitiser.reading(force, full_scale=2.0)
    assert clipped.tolist() == [False] * 5 + [True, True, False, True, True]


@given(st.floats(-3, 3), st.integers(1, 24))
def test_a_reading_is_half_a_level_off_unless_clipped(force, bits):
    digitiser = Digitiser(sampling_rate=1.0, bits=bits, normal_range=2.0, lateral_range=1.0, seed=0)
    level = 4.0 / 2**bits
    reading = digitiser.reading(force, full_scale=2.0)
    off = abs(reading - force)
    if reading == digitiser.levels(force, full_scale=2.0) * level:
        assert off <= level / 2 * (1 + 1e-9)
    else:
        assert off > level / 2 * (1 - 1e-9)
        assert abs(force) > 2.0 - level


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"lateral": {**TABLE["lateral"], "noise": "1 mN"}}, "needs a digitiser"),
        ({"lateral": {"natural_frequency": "500 Hz"}}, "missing"),
        ({"digitiser": {**DIGITISER, "bits": 40}}, "32"),
        ({"digitiser": {**DIGITISER, "bits": True}}, "whole number"),
        ({"digitiser": {**DIGITISER, "seed": -1}}, "0"),
        ({"normal": {**TABLE["normal"], "time_constant": "2 V"}}, "expected a time"),
    ],
)
def test_what_is_no_rig_is_refused(change, message):
    assert isinstance(read(TABLE), Tribometer)
    with pytest.raises(InputError, match=message):
        read({**TABLE, **change})


def test_noise_goes_with_a_digitiser():
    rig = read({**TABLE, "digitiser": DIGITISER, "lateral": {**TABLE["lateral"], "noise": "1 mN"}})
    assert rig.noises() == (0.0, 1e-3)
