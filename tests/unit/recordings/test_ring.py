"""Resonance, quality factor and drift of synthetic oscillations."""

import math

import numpy as np
import pytest
import xarray

from electrovib.core.errors import InputError
from electrovib.physics.resonance import release_seen_by_sensor
from electrovib.recordings.transitions import measure_ring

AT, LENGTH, RATE = 0.1, 0.5, 12_800.0


def mode(time, *, frequency, quality, amplitude=1.0, drift=0.0, phase=0.0):
    """Damped oscillation of a natural frequency and quality factor, from time 0 on."""
    rate = math.pi * frequency / quality
    damped = frequency * math.sqrt(1 - 1 / (4 * quality**2))
    late = np.maximum(time, 0.0)
    wave = (
        amplitude * np.exp(-rate * late) * np.cos(2 * np.pi * (damped * late + drift * late**2 / 2) + phase)
    )
    return np.where(time >= 0, wave, 0.0)


def record(values, *, noise=0.01, seed=0):
    time = np.arange(0, LENGTH, 1 / RATE)
    white = noise * np.random.default_rng(seed).standard_normal(time.size)
    return xarray.Dataset(
        {"lateral_force_measured": ("time", values(time - AT) + white)}, coords={"time": time}
    )


def test_one_mode_after_an_impact():
    found = measure_ring(record(lambda t: mode(t, frequency=380.0, quality=5.0)))
    assert (found.form, found.level) == ("one mode", "constant")
    assert found.parameters["frequency"].value == pytest.approx(380.0, rel=0.01)
    assert found.parameters["quality"].value == pytest.approx(5.0, rel=0.05)
    assert found.drift.lower < 0 < found.drift.upper
    assert found.misfit < 1.3
    assert not any(text.startswith("Warning") for text in found.words)


def test_the_release_of_a_resonant_sensor_gives_its_natural_frequency():
    def release(time):
        return release_seen_by_sensor(time, start=0.0, fall_time=1e-8, frequency=380.0, quality=2.0)

    trace = record(release, noise=0.002)
    on = np.where(trace["time"] < AT, 100.0, 0.0)
    found = measure_ring(
        trace.assign(drive_voltage=("time", on)), signal="lateral_force_measured", by="drive_voltage"
    )
    assert found.reference == pytest.approx(AT, abs=1 / RATE)
    assert found.parameters["frequency"].lower < 380 < found.parameters["frequency"].upper
    assert found.parameters["quality"].lower < 2.0 < found.parameters["quality"].upper
    # the first turning point is half of a damped period after the release
    assert found.time[0] == pytest.approx(0.5 / (380 * math.sqrt(1 - 1 / 16)), abs=2 / RATE)


def test_a_higher_mode_that_decays_sooner_is_separated():
    def both(time):
        return mode(time, frequency=310.0, quality=9.0, amplitude=0.4) + mode(
            time, frequency=450.0, quality=2.0, amplitude=1.0
        )

    found = measure_ring(record(both, noise=0.004), at=AT, start=0.0)
    assert found.form == "two modes"
    of = found.parameters
    assert of["frequency"].value == pytest.approx(310.0, rel=0.01)
    assert of["quality"].value == pytest.approx(9.0, rel=0.1)
    assert of["early_frequency"].value == pytest.approx(450.0, rel=0.03)
    assert of["early_quality"].value == pytest.approx(2.0, rel=0.1)
    assert "a higher one" in " ".join(found.words)
    # one mode alone approaches the one that remains
    first, last = found.sections[0].frequency.value, found.sections[-1].frequency.value
    assert abs(last - 310) < abs(first - 310)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("level", "form", "words"),
    [
        (lambda t: -0.5 * np.exp(-np.maximum(t, 0) / 6e-3), "exponential", "relaxes exponentially by 0.5"),
        (lambda t: 3.0 * np.minimum(np.maximum(t, 0), 0.03), "linear", "changes linearly"),
    ],
)
def test_the_level_may_change_while_the_signal_oscillates(level, form, words):
    found = measure_ring(
        record(lambda t: mode(t, frequency=380.0, quality=5.0) + level(t), noise=0.003),
        at=AT, start=0.0, window=25e-3,
    )  # fmt: skip
    assert (found.form, found.level) == ("one mode", form)
    assert found.misfit < 1.3
    of = found.parameters
    assert of["frequency"].lower < 380 < of["frequency"].upper
    assert of["quality"].value == pytest.approx(5.0, rel=0.03)
    if form == "exponential":
        assert of["level_time_constant"].lower < 6e-3 < of["level_time_constant"].upper
    assert any(text.startswith("The level") and words in text for text in found.words)
    # one mode about this level is one mode from every start
    assert len(found.sections) > 2
    assert found.sections[-1].frequency.value == pytest.approx(380.0, rel=0.02)


@pytest.mark.parametrize("drift", [-6000.0, pytest.param(4000.0, marks=pytest.mark.slow)])
def test_a_frequency_that_drifts_is_found(drift):
    found = measure_ring(
        record(lambda t: mode(t, frequency=400.0, quality=10.0, drift=drift), noise=0.005), at=AT, start=0.0
    )
    assert found.form == "one drifting mode"
    assert found.parameters["frequency"].value == pytest.approx(400.0, rel=0.01)
    assert found.parameters["drift"].lower < drift < found.parameters["drift"].upper
    assert ("falls" if drift < 0 else "rises") in " ".join(found.words)


def test_an_oscillation_of_another_form_carries_a_warning():
    def beating(time):
        return mode(time, frequency=400.0, quality=8.0) * (1 + 0.8 * np.sign(np.sin(900 * time)))

    found = measure_ring(record(beating, noise=0.002), at=AT, start=0.0)
    assert found.misfit > 1.5
    assert found.words[0].startswith("Warning")


@pytest.mark.parametrize(
    ("values", "options", "words"),
    [
        (lambda t: np.where(t < 0, 1.0, 0.0), {"at": AT}, "does not"),
        (lambda t: mode(t, frequency=380.0, quality=5.0), {"at": 3.0}, "at = 3"),
        (lambda t: mode(t, frequency=380.0, quality=5.0), {"start": -1.0}, "start = -1"),
        (
            lambda t: mode(t, frequency=380.0, quality=5.0),
            {"at": AT, "start": 0.0, "window": 1e-3},
            "13 samples",
        ),
    ],
)
def test_what_is_no_oscillation_is_refused(values, options, words):
    noise = 0.0 if words == "does not" else 0.01
    with pytest.raises(InputError, match=words):
        measure_ring(record(values, noise=noise), **options)


@pytest.mark.slow
def test_intervals_of_a_ring_hold_its_frequency_and_quality():
    inside = np.zeros(2)
    for seed in range(25):
        of = measure_ring(
            record(lambda t: mode(t, frequency=380.0, quality=5.0), seed=seed, noise=0.02), at=AT, start=0.0
        ).parameters
        inside += [
            of["frequency"].lower < 380 < of["frequency"].upper, of["quality"].lower < 5 < of["quality"].upper
        ]  # fmt: skip
    assert (inside >= 20).all()
