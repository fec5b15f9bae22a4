"""Releases of known resonance and delay; and records in which nothing lets go."""

import json

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from electrovib.core.errors import InputError
from electrovib.physics.drive.sampled import KeepIncreasing
from electrovib.physics.resonance import release_seen_by_sensor
from electrovib.study.ringing import ringing
from electrovib.study.ringing_parts import damped_sine, drive_end, longest_pause


def made(
    *,
    frequency=350.0,
    quality=3.0,
    delay=0.4e-3,
    fall_time=0.1e-3,
    held=0.7,
    after=0.05,
    noise=5e-3,
    rate=12_800.0,
    drive=1000.0,
    seed=0,
    size=300.0,
):
    """Make time, force and voltage of a clutch that is pulled from 0.1 to 0.3 s."""
    random = np.random.default_rng(seed)
    step = 1 / rate
    time = 7.0 + np.cumsum(step * random.uniform(0.99, 1.01, round(0.4 * rate)))
    since = time - 7.0
    on = (since > 0.1) & (since < 0.3) & ((since * drive) % 1 < 0.5 if drive else True)
    voltage = np.where(on, size, 0.005 * size)
    end = time[np.flatnonzero(on)[-1]]
    shape = release_seen_by_sensor(
        time, start=end + delay, fall_time=fall_time, frequency=frequency, quality=quality
    )
    force = after + (held - after) * shape * np.clip((since - 0.1) / 0.05, 0, 1)
    return time, force + noise * random.standard_normal(len(time)), voltage


@given(
    frequency=st.floats(200, 1200),
    quality=st.floats(1.5, 12),
    delay=st.floats(0.1e-3, 1.5e-3),
    held=st.sampled_from([0.7, -0.7, 20.0]),
    rate=st.sampled_from([10_000.0, 12_800.0, 50_000.0]),
    drive=st.sampled_from([0.0, 200.0, 1000.0, 10_300.0]),
    seed=st.integers(0, 2**32 - 1),
)
@settings(deadline=None, max_examples=15, phases=[Phase.explicit, Phase.generate])
def test_a_known_resonance_is_found(frequency, quality, delay, held, **other):
    found = ringing(
        *made(frequency=frequency, quality=quality, delay=delay, held=held, noise=abs(held) * 5e-3, **other)
    )
    # noise is 0.5 % of the force; over a few oscillations that is a percent of the frequency at quality 1.5
    assert found.frequency == pytest.approx(frequency, rel=2e-2)
    assert found.quality == pytest.approx(quality, rel=0.15)
    assert found.held == pytest.approx(held, rel=1e-2)
    assert found.misfit < 0.05
    assert found.misfit_without > 4 * found.misfit


def test_without_noise_the_fit_is_exact():
    found = ringing(*made(noise=0.0))
    assert found.frequency == pytest.approx(350, rel=1e-5)
    assert found.quality == pytest.approx(3, rel=1e-4)
    assert found.delay == pytest.approx(0.4e-3, rel=1e-3)
    assert found.fall_time == pytest.approx(0.1e-3, rel=1e-2)
    assert (found.held, found.after) == pytest.approx((0.7, 0.05), rel=1e-4)
    assert found.misfit < 1e-5


def test_turning_points_and_decays_of_one_resonance_agree():
    found = ringing(*made(noise=1e-4, quality=6.0, rate=50_000.0))
    damped = 350 * np.sqrt(1 - 1 / (4 * 36))
    assert len(found.half_periods) > 6
    # a parabola through an eighth of a period on either side of a damped top leans by less than 1 %
    assert found.half_periods == pytest.approx([damped] * len(found.half_periods), rel=1e-2)
    for decay in (found.early, found.late):
        assert decay.frequency == pytest.approx(damped, rel=1e-3)
        # the rate is w/2Q, told as pi f/rate with the damped frequency
        assert decay.quality == pytest.approx(6 * damped / 350, rel=5e-3)
    assert not any("no single linear resonance" in word for word in found.words)


def test_a_falling_frequency_is_shown_and_named():
    """A chirp from 450 to 300 Hz: no single resonance fits, and the words say so."""
    time, force, voltage = made(noise=2e-3)
    start = drive_end(time, voltage) + 0.4e-3
    late = np.maximum(time - start, 0)
    phase = 2 * np.pi * (300 * late + 150 * 4e-3 * (1 - np.exp(-late / 4e-3)))
    force = np.where(late > 0, 0.05 + 0.65 * np.exp(-late / 3e-3) * np.cos(phase), 0.7)
    found = ringing(time, force, voltage)
    assert found.half_periods[0] > 1.1 * found.half_periods[3]
    assert found.early.frequency > 1.05 * found.late.frequency
    assert any("falls while the ringing dies away: no single linear" in word for word in found.words)
    assert 0.03 < found.misfit < found.misfit_without / 2


def test_pauses_of_the_drive_that_are_held_through():
    found = ringing(*made(drive=500.0, delay=0.3e-3))
    # half of 2 ms, known to one sample at either end
    assert found.longest_pause == pytest.approx(1e-3, abs=0.16e-3)
    assert any("holds through pauses of" in word for word in found.words)
    assert not any("holds through pauses" in word for word in ringing(*made(drive=0.0)).words)
    time, _, voltage = made(drive=0.0)
    assert longest_pause(time, voltage, since=0.0) == 0


def test_result_is_plain_json():
    found = ringing(*made())
    again = json.loads(json.dumps(found.to_dict()))
    assert again["frequency"] == found.frequency
    assert again["early"]["frequency"] == found.early.frequency
    assert len(found.time) == len(found.force) == len(found.model) == len(found.model_without)


def test_too_few_samples_for_a_damped_sine():
    time = np.linspace(0, 1e-3, 8)
    assert damped_sine(time, time, start=0.0, end=1e-3) is None


def test_repeated_stamps_are_refused_or_dropped():
    columns = [np.insert(values, 3850, values[3850]) for values in made()]
    with pytest.raises(InputError, match=r"1 of 5121 stamps do not: sample 3851.*repeats"):
        ringing(*columns)
    found, whole = ringing(*columns, stamps=KeepIncreasing()), ringing(*made())
    assert found.frequency == whole.frequency


def changed(place, change):
    columns = list(made())
    columns[place] = change(columns[place].copy())
    return columns


def spoiled(values):
    values[7] = np.nan
    return values


@pytest.mark.parametrize(
    ("columns", "words"),
    [
        (
            changed(1, lambda v: v * 0 + 0.7 + 1e-3 * np.sin(np.arange(len(v)))),
            "does not let go when the drive ends",
        ),
        (changed(2, lambda v: v * 0), "voltage: lies between 0 and 0 V and never goes on and off"),
        (changed(2, lambda v: v * 0 + 300), "never goes on and off"),
        (changed(2, lambda v: v[::-1] * 0 + np.linspace(0, 300, len(v))), "still on at the last sample"),
        (changed(1, spoiled), "force: sample 7 is nan"),
        (
            changed(0, lambda v: v[::-1]),
            r"time: time must increase, but 5119 of 5120 stamps do not: sample 1 .*KeepIncreasing",
        ),
        (changed(0, lambda v: v[:-1]), r"expected one row each, of one length; they have time \(5119,\)"),
        (
            [values[:3850] for values in made()],
            "there are only .* samples from 0.01 s before to 0.02 s after",
        ),
        ([values[::40] for values in made()], "samples from 0.01 s before"),
    ],
)
def test_what_is_no_release_is_refused(columns, words):
    with pytest.raises(InputError, match=words):
        ringing(*columns)


def test_a_duration_is_a_time():
    with pytest.raises(InputError, match="duration = -1: expected a time"):
        ringing(*made(), duration=-1)
