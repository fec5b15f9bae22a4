"""Resonance, quality factor and drift of synthetic oscillations, and impacts in a long record of a load cell."""

import math

import numpy as np
import pytest
from scipy.signal import lfilter
from typer.testing import CliRunner

from electrovib.apps.cli import app
from electrovib.core.errors import InputError
from electrovib.core.signals import make_trace
from electrovib.physics.relaxation import release_seen_by_sensor
from electrovib.recordings.transitions.edges import find_impacts
from electrovib.recordings.transitions.ring import measure_ring, measure_rings
from electrovib.recordings.transitions.times import measure_times

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
    force = (("time",), values(time - AT) + white)
    return make_trace({"lateral_force_measured": force}, {"time": time}, {})


def ringing(time):
    return mode(time, frequency=380.0, quality=5.0)


def test_one_mode_after_an_impact():
    found = measure_ring(record(ringing))
    assert (found.form, found.level) == ("one mode", "constant")
    assert found.parameters["frequency"].value == pytest.approx(380.0, rel=0.01)
    assert found.parameters["quality"].value == pytest.approx(5.0, rel=0.05)
    assert found.drift.lower < 0 < found.drift.upper
    assert found.misfit < 1.3
    assert not any(text.startswith("Warning") for text in found.remarks)


def test_the_release_of_a_resonant_sensor_gives_its_natural_frequency():
    def release(time):
        return release_seen_by_sensor(time, start=0.0, fall_time=1e-8, frequency=380.0, quality=2.0)

    trace = record(release, noise=0.002)
    on = np.where(trace["time"] < AT, 100.0, 0.0)
    found = measure_ring(
        trace.assign(drive_voltage=("time", on)), quantity="lateral_force_measured", by="drive_voltage"
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
    assert "a higher one" in " ".join(found.remarks)
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
    trace = record(lambda t: ringing(t) + level(t), noise=0.003)
    found = measure_ring(trace, at=AT, start=0.0, window=25e-3)
    assert (found.form, found.level) == ("one mode", form)
    assert found.misfit < 1.3
    of = found.parameters
    assert of["frequency"].lower < 380 < of["frequency"].upper
    assert of["quality"].value == pytest.approx(5.0, rel=0.03)
    if form == "exponential":
        assert of["level_time_constant"].lower < 6e-3 < of["level_time_constant"].upper
    assert any(text.startswith("The level") and words in text for text in found.remarks)
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
    assert ("falls" if drift < 0 else "rises") in " ".join(found.remarks)


def test_an_oscillation_of_another_form_carries_a_warning():
    def beating(time):
        return mode(time, frequency=400.0, quality=8.0) * (1 + 0.8 * np.sign(np.sin(900 * time)))

    found = measure_ring(record(beating, noise=0.002), at=AT, start=0.0)
    assert found.misfit > 1.5
    assert found.remarks[0].startswith("Warning")


@pytest.mark.parametrize(
    ("values", "options", "words"),
    [
        (lambda t: np.where(t < 0, 1.0, 0.0), {"at": AT}, "does not"),
        (ringing, {"at": 3.0}, "at = 3"),
        (ringing, {"start": -1.0}, "start = -1"),
        (ringing, {"at": AT, "start": 0.0, "window": 1e-3}, "13 samples"),
    ],
)
def test_what_is_no_oscillation_is_refused(values, options, words):
    with pytest.raises(InputError, match=words):
        measure_ring(record(values, noise=0.01 if values is ringing else 0.0), **options)


def holds(parameters, frequency, quality):
    known = {"frequency": frequency, "quality": quality}
    return [parameters[name].lower < value < parameters[name].upper for name, value in known.items()]


@pytest.mark.slow
def test_intervals_of_a_ring_hold_its_frequency_and_quality():
    found = [measure_ring(record(ringing, seed=seed, noise=0.02), at=AT, start=0.0) for seed in range(25)]
    assert (np.sum([holds(each.parameters, 380, 5) for each in found], axis=0) >= 20).all()


def cell(rng, *, frequency, quality, rate=20e3, length=4.0, impacts=3, noise=0.01, drift=0.02):
    """Load cell that is struck several times, with a linear and a slow periodic drift."""
    time = np.arange(round(length * rate)) / rate
    values = noise * rng.standard_normal(time.size) + drift * time + 0.1 * np.sin(2 * np.pi * time / 37)
    struck = length / (impacts + 1) * (np.arange(1, impacts + 1) + rng.uniform(-0.2, 0.2, impacts))
    for at in struck:
        size, phase = rng.uniform(0.5, 2.0) * rng.choice([-1, 1]), rng.uniform(-0.6, 0.6)
        values += mode(time - at, frequency=frequency, quality=quality, amplitude=size, phase=phase)
    return recorded(time, values), struck


def recorded(time, values):
    return make_trace({"normal_force_measured": (("time",), values)}, {"time": time}, {})


@pytest.mark.parametrize(
    ("frequency", "quality"),
    [
        (200.0, 3.0),
        pytest.param(380.0, 8.0, marks=pytest.mark.slow),
        pytest.param(600.0, 30.0, marks=pytest.mark.slow),
    ],
)
def test_every_impact_is_found_and_measured(frequency, quality):
    trace, struck = cell(np.random.default_rng(1), frequency=frequency, quality=quality)
    found = measure_rings(trace)
    assert [each.reference for each in found.rings] == pytest.approx(struck, abs=0.6 / frequency)
    assert found.frequency.value == pytest.approx(frequency, rel=0.005)
    assert found.quality.value == pytest.approx(quality, rel=0.03)
    assert found.frequency.count == 3
    assert not any(text.startswith("Warning") for text in found.remarks)
    largest = max(found.rings, key=lambda each: np.abs(each.values).max())
    assert measure_ring(trace).parameters["frequency"] == largest.parameters["frequency"]


def test_a_ring_is_no_edge_and_a_release_that_rings_is_one():
    trace, _ = cell(np.random.default_rng(2), frequency=300.0, quality=10.0, drift=0.0)
    with pytest.raises(InputError, match=r"no clear edge.*after 3 impacts"):
        measure_times(trace)
    values = trace["normal_force_measured"].copy()
    values[:] = values + np.where(trace["time"] > 3.6, 2.0, 0.0)  # one load that stays
    stepped = trace.assign(normal_force_measured=values)
    found = measure_times(stepped)
    assert [each.record.reference for each in found.rising.edges] == pytest.approx([3.6], abs=1e-3)
    assert found.falling is None


def test_noise_and_a_drive_that_is_switched_often_are_no_impacts():
    time, rng = np.arange(40_000) / 20e3, np.random.default_rng(3)
    for duty in (0.3, 0.5, 0.7):
        values = ((time * 10) % 1 < duty) + 0.01 * rng.standard_normal(time.size)
        assert not any(each.returns for each in find_impacts(time, values))
    values = 0.01 * np.random.default_rng(4).standard_normal(time.size)
    assert find_impacts(time, values) == []
    for measure in (measure_rings, measure_ring):
        with pytest.raises(InputError, match="never leaves the noise"):
            measure(recorded(time, values))
    with pytest.raises(InputError, match="times its noise") as caught:
        measure_times(recorded(time, values))
    assert len(caught.value.problems) == 1


def faint(ratio, *, seed=0, frequency=640.0, quality=20.0, bursts=4):
    """Bursts of an oscillation whose amplitude is so many standard deviations of the noise."""
    rng, time = np.random.default_rng(seed), np.arange(25_000) / 12.5e3
    values = rng.standard_normal(time.size)
    for number in range(bursts):
        at, phase = (number + 0.5) * 2 / bursts + rng.uniform(0, 0.01), rng.uniform(-0.6, 0.6)
        values += mode(time - at, frequency=frequency, quality=quality, amplitude=ratio, phase=phase)
    return recorded(time, values)


@pytest.mark.parametrize(
    ("ratio", "options"),
    [
        (4.0, {}),
        pytest.param(6.0, {"seed": 1}, marks=pytest.mark.slow),
        pytest.param(3.0, {"frequency": 250.0}, marks=pytest.mark.slow),
        pytest.param(2.5, {"seed": 2, "bursts": 3}, marks=pytest.mark.slow),
    ],
)
def test_bursts_that_no_sample_shows_are_found_in_their_band(ratio, options):
    trace = faint(ratio, **options)
    found = measure_rings(trace)
    assert len(found.rings) == options.get("bursts", 4)
    assert found.frequency.lower < options.get("frequency", 640.0) < found.frequency.upper
    assert found.frequency.upper - found.frequency.lower < 0.1 * found.frequency.value
    assert found.quality.value == pytest.approx(20.0, rel=0.4)


@pytest.mark.slow
def test_noise_alone_has_no_bursts_in_200_records_nor_has_a_change_that_does_not_swing():
    time = np.arange(8000) / 10e3
    alarms = 0
    for seed in range(200):
        white = np.random.default_rng(seed).standard_normal(time.size)
        alarms += bool(find_impacts(time, lfilter([1], [1, -0.9 * (seed % 2)], white), faint=True))
    assert alarms == 0
    for change in (12.0 * (time > 0.4), 6 * np.exp(-np.maximum(time - 0.4, 0) / 0.02) * (time > 0.4)):
        with pytest.raises(InputError, match=r"never leaves the noise|is no oscillation|at rest"):
            measure_rings(recorded(time, white + change))


def test_the_next_impact_ends_an_oscillation():
    """Two impacts 30 ms apart: the second strikes before the first has come to rest."""
    time = np.arange(40_000) / 20e3
    values = 0.002 * np.random.default_rng(5).standard_normal(time.size)
    for at, size in ((0.8, 1.0), (0.83, 1.5)):
        values += mode(time - at, frequency=400.0, quality=12.0, amplitude=size)
    found = measure_rings(recorded(time, values))
    assert [each.reference for each in found.rings] == pytest.approx([0.8, 0.83], abs=1.5e-3)
    assert found.rings[0].time[-1] < 0.03
    for each in found.rings:
        assert each.parameters["frequency"].value == pytest.approx(400.0, rel=0.01)
        assert each.parameters["quality"].value == pytest.approx(12.0, rel=0.05)


@pytest.mark.usefixtures("blank_pictures")
def test_the_command_answers_for_a_record_without_edges(tmp_path):
    trace, struck = cell(np.random.default_rng(6), frequency=380.0, quality=8.0, impacts=2, length=2.0)
    trace.to_netcdf(tmp_path / "cell.nc")
    result = CliRunner().invoke(
        app, ["times", str(tmp_path / "cell.nc"), "--ring", "-o", str(tmp_path / "out")]
    )
    assert result.exit_code == 0, result.output
    assert "mean of 2 impacts" in result.output
    assert "No time between levels: the signal has no clear edge" in result.output
    assert "more mistakes" not in result.output
    assert f"impact at {struck[0]:.3f}" in result.output
    table = (tmp_path / "out" / "times.csv").read_text()
    assert table.count("impact at") >= 4
    assert "after 2 impacts" in (tmp_path / "out" / "report.html").read_text()
