"""Streams of textures: the same samples as the drive of the path, whatever the blocks; every violation ends at 0 V."""

from __future__ import annotations

import functools
import math
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import electrovib as ev
from electrovib.core.errors import InputError
from electrovib.physics.texture.path import FingerPath
from electrovib.scenario import read_part
from electrovib.study.check import sampled, with_drive
from electrovib.study.texture import StreamClosedError
from electrovib.study.texture.hardware import current_bound

PLATE = "vezzoli_2014/fig6"
LIMITS = {"voltage": "1 kV", "current": "250 uA"}
RATE, BLOCK = 10_000, 10
GRATING = {"model": "Grating", "period": "1 mm", "amplitude": "0.5 mN"}
WHITE = {"model": "GreyscalePicture", "width": 1, "value_samples": [255], "pixels_per_millimetre": 0.01}
NOISE = np.random.default_rng(1).integers(0, 120, 400).tolist()
TEXTURES = {
    "grating": GRATING,
    "height": {
        "model": "HeightProfile",
        "position_samples": [0, 1e-3, 2e-3, 3e-3],
        "height_samples": [0, 2e-6, 1e-6, 2e-6],
    },
    "force": {
        "model": "RecordedFrictionForce",
        "position_samples": [0, 1e-3, 3e-3],
        "friction_force_samples": [0.2, 0.2005, 0.2002],
    },
    "picture": {"model": "GreyscalePicture", "width": 20, "value_samples": NOISE, "pixels_per_millimetre": 5},
}


def stream(texture=GRATING, **options):
    return ev.texture_stream(PLATE, texture=texture, **{"limits": LIMITS, "carrier": "1 kHz"} | options)


CASES = [("grating", "1 kHz"), ("height", None), ("picture", "777 Hz"), ("force", None)]
COUNT = 300


@functools.cache
def offline(name, carrier):
    """Positions at the samples of a path, at rest for the first block, and the drive of that path."""
    turn = np.pi * np.arange(COUNT) / (COUNT - 1)
    moving = np.stack([1.5e-3 + 1.2e-3 * np.sin(2 * turn), 1e-3 * np.cos(turn) + 1.5e-3], axis=-1)
    positions = np.concatenate([np.repeat(moving[:1], BLOCK - 1, axis=0), moving])
    table = {
        "time_samples": np.arange(len(positions)) / RATE,
        "x_samples": positions[:, 0],
        "y_samples": positions[:, 1],
    }
    path = read_part(FingerPath, {"model": "RecordedPath", **table})
    drive = ev.texture_drive(
        PLATE, texture=TEXTURES[name], path=path, carrier=carrier, rate=RATE, limits=LIMITS
    )
    return moving, drive.voltages


@settings(max_examples=15, deadline=None)
@given(
    case=st.sampled_from(CASES),
    sizes=st.lists(st.integers(1, BLOCK), min_size=1, max_size=40),
    late=st.floats(0, 1e6),
)
def test_a_stream_is_the_drive_of_the_path_whatever_the_blocks(case, sizes, late):
    name, carrier = case
    positions, expected = offline(name, carrier)
    found = stream(TEXTURES[name], carrier=carrier, dimensions=2)
    origin = math.floor(late)
    parts, place, number = [found.render(positions[0], origin)], 1, 0
    while place < COUNT:
        block = positions[place : place + sizes[number % len(sizes)]]
        place, number = place + len(block), number + 1
        parts.append(found.render(block, origin + (place - 1) / RATE))
        assert len(parts[-1]) == len(block)
    assert found.error is None
    samples = np.concatenate([*parts, found.close()])
    # the time stamps of a clock that began long ago are rounded, and with them the positions between the calls
    rounded = 1e-9 + 1e-15 * origin * RATE
    np.testing.assert_allclose(samples, expected, rtol=0, atol=rounded * np.max(np.abs(expected)))
    assert samples[0] == samples[-1] == 0
    assert found.samples == len(samples)


def test_a_number_for_each_block_is_interpolated():
    """Positions at the ends of the blocks are those of a straight path."""
    found = stream()
    parts = [found.render(0.05 * number / 1000, number / 1000) for number in range(40)]
    path = read_part(
        FingerPath,
        {"model": "RecordedPath", "time_samples": [0, 0.9e-3, 39.9e-3], "x_samples": [0, 0, 0.05 * 0.039]},
    )
    drive = ev.texture_drive(PLATE, texture=GRATING, path=path, carrier="1 kHz", rate=RATE, limits=LIMITS)
    found_all = np.concatenate([*parts, found.close()])
    np.testing.assert_allclose(found_all, drive.voltages, rtol=0, atol=1e-9 * np.max(drive.voltages))


def test_phase_and_amplitude_are_continuous_between_blocks():
    """Of a texture of constant force the samples are one sine, whatever the times of the calls."""
    found = stream(WHITE, carrier="777 Hz")
    times = np.cumsum(np.random.default_rng(3).uniform(0.3e-3, 1e-3, 200))
    samples = np.concatenate([found.render(0.05, time) for time in times])
    tone = 2 * math.pi * 777 * np.arange(len(samples)) / RATE
    assert np.max(np.abs(samples - found_amplitude(found) * np.sin(tone))[BLOCK:]) < 1e-7


def found_amplitude(found):
    return found._synthesis.hardware.largest_amplitude


def test_the_latency_is_one_block_and_stated():
    assert stream(block="2 ms").latency == 2e-3
    assert "played `latency` seconds after" in " ".join(type(stream()).__doc__.split())


def ended(found, position, time):
    """Render blocks after a violation until 0 V; return all samples."""
    parts = [found.render(position, time)]
    for _ in range(50):
        try:
            parts.append(found.render(position, time))
        except StreamClosedError:
            return np.concatenate(parts)
    pytest.fail("the stream does not end")
    return None


RUNNING = 25


def running(texture=WHITE, **options):
    """A stream that has run at the largest amplitude for some blocks."""
    found = stream(texture, **options)
    before = np.concatenate([found.render(0.05, number / 1000) for number in range(RUNNING)])
    assert found.error is None
    return found, before


STEP = {
    "model": "RecordedFrictionForce",
    "position_samples": [0, 0.05, 0.0501, 0.1],
    "friction_force_samples": [0.2, 0.2005, 0.25, 0.25],
}
VIOLATIONS = {
    "too large a force": (0.0601, RUNNING / 1000, "the texture needs an attraction of"),
    "NaN": (math.nan, RUNNING / 1000, "have to be finite numbers"),
    "no time": (0.05, math.inf, "have to be finite numbers"),
    "back in time": (0.05, 0.001, "is not after that of the call before"),
    "too late": (0.05, 1.0, "have passed since the call before, and a block has 0.001 s"),
    "no number": ("here", RUNNING / 1000, "could not convert"),
    "wrong shape": ([[0.05, 0.05]], RUNNING / 1000, "has the shape"),
}


@pytest.mark.parametrize("carrier", [None, "1 kHz"])
@pytest.mark.parametrize("case", VIOLATIONS)
def test_every_violation_ends_at_0_volts_within_the_limits_and_stays_closed(case, carrier):
    position, time, words = VIOLATIONS[case]
    found, before = running(STEP, carrier=carrier)
    assert np.max(np.abs(before)) > 10
    after = ended(found, position, time)
    assert words in str(found.error)
    assert after[-1] == 0
    whole = np.concatenate([before, after])
    hardware = found._synthesis.hardware
    assert np.max(np.abs(np.diff(whole))) * RATE <= hardware.largest_slope
    assert np.max(np.abs(whole)) <= hardware.largest_amplitude
    steps = round(hardware.ramp * RATE)
    assert not after[steps + BLOCK :].any(), "the ramp has its duration"
    for _ in range(2):
        with pytest.raises(StreamClosedError, match=words.split(",")[0]):
            found.render(0.05, (RUNNING + 1) / 1000)
    assert not len(found.close())


def test_too_steep_an_edge_ends_the_stream():
    """White to black within a tenth of a millimetre is too fast at 100 mm/s a millisecond, not at 10 mm/s."""
    edge = {
        "model": "GreyscalePicture",
        "width": 100,
        "value_samples": [255] * 50 + [0] * 50,
        "pixels_per_millimetre": 10,
    }
    for speed, held in ((0.01, True), (1.0, False)):
        found = stream(edge, carrier="3 kHz")
        found.render(4e-3, 0.0)
        for number in range(1, 6):
            found.render(4e-3, number / 1000)
        for number in range(6, 6 + round(2e-3 / speed * 1000)):
            found.render(4e-3 + speed * (number - 5) / 1000, number / 1000)
            if found.error:
                break
        assert (found.error is None) == held, found.error
        assert held or "the voltage changes at" in str(found.error)


def test_the_end_of_the_longest_duration_is_at_0_volts():
    found = stream(WHITE, longest="20 ms")
    samples = np.concatenate([found.render(0.05, number / 1000) for number in range(20)])
    with pytest.raises(StreamClosedError, match="the declared longest duration is reached"):
        found.render(0.05, 0.02)
    last = np.flatnonzero(samples)[-1]
    assert 180 < last < 200


def test_a_stream_that_is_closed_ends_by_its_ramp():
    found, _ = running(ramp="3 ms")
    end = found.close()
    assert len(end) == 30
    assert end[-1] == 0
    assert np.max(np.abs(end[:3])) > 50
    assert not len(found.close())
    with pytest.raises(StreamClosedError, match="the stream was closed"):
        found.render(0.05, 1.0)


def test_the_ramp_is_linear_and_has_its_duration():
    """Without a carrier the samples are the ramp itself."""
    found, before = running(STEP, carrier=None, ramp="3 ms")
    np.testing.assert_allclose(
        found.close(), before[-1] * (1 - np.arange(1, 31) / 30), rtol=1e-12, atol=1e-12
    )


def test_a_force_that_slowly_exceeds_the_most_ends_the_stream():
    rising = {
        "model": "RecordedFrictionForce",
        "position_samples": [0, 0.1],
        "friction_force_samples": [0.2, 0.25],
    }
    found = stream(rising, carrier=None)
    largest = []
    for number in range(2000):
        largest.append(np.max(found.render(0.1 * number / 2000, number / 1000)))
        if found.error:
            break
    assert "the texture needs an attraction of 54.2" in str(found.error)
    assert 0.999 * found.largest_voltage < max(largest) <= found.largest_voltage


def test_a_stream_that_never_rendered_closes_at_0_volts():
    assert not stream().close().any()


def test_the_current_bound_holds_for_random_voltages_and_is_close_for_carriers():
    """The current of the full model stays below the bound of slope and charge; for a carrier it is near it."""
    scenario = ev.load(PLATE)
    bound = current_bound(scenario)
    random, times = np.random.default_rng(5), np.arange(400) * 1e-4
    for smooth in (1, 20, 200):
        voltage = np.convolve(random.standard_normal(600), np.ones(smooth) / smooth)[:400]
        voltage[0] = 0.0
        trace = ev.simulate(with_drive(scenario, sampled(times, voltage)), signals=["current"])
        slope, size = np.max(np.abs(np.diff(voltage))) / 1e-4, np.max(np.abs(voltage))
        assert np.max(np.abs(trace.current.values)) <= bound.current(slope, size)
    tone = np.sin(2 * np.pi * 50 * times)
    trace = ev.simulate(with_drive(scenario, sampled(times, tone)), signals=["current"])
    assert np.max(np.abs(trace.current.values)) > 0.97 * bound.current(2 * np.pi * 50, 1.0)


def test_conduction_contributes_its_current_and_not_the_charge_of_the_whole_run():
    """A plate that conducts as a resistor: the bound of a slow voltage is near V/R, with a factor of 2 for what came before."""
    conducting = {
        "stack.insulator.material.conductivity": 1e-9,
        "stack.stratum_corneum.material.conductivity": 1e-3,
    }
    scenario = ev.load(PLATE, changes=conducting)
    resistance = 90e-6 / (1e-9 * scenario.contact_area)
    assert 1 < current_bound(scenario).current(1e-3, 100.0) / (100.0 / resistance) < 2.1


REFUSED = {
    "limits": (
        {"limits": {"voltage": "1 kV"}, "set": {"limits": {}}},
        "not declared, and a stream of a texture needs",
    ),
    "charge": (
        {"limits": LIMITS | {"charge": "1 uC"}},
        "limits.charge: a stream cannot be compared with this limit",
    ),
    "energy": ({"limits": LIMITS | {"stored_energy": "1 mJ"}}, "limits.stored_energy: a stream cannot be"),
    "root mean square": (
        {"limits": LIMITS | {"rms_current": "100 uA"}},
        "limits.rms_current: a stream cannot be",
    ),
    "dimensions": ({"dimensions": 3}, "dimensions = 3: must be 1 or 2"),
    "carrier": ({"carrier": "5 kHz"}, "may have 0.4 of the rate"),
    "block": ({"block": "10 us"}, "block = 10 us: must lie between 0.0001 and 1 s"),
    "breakdown": (
        {"set": {"stack.insulator.breakdown_field": "1 MV/m"}},
        "No stream was made; declare a lower limits.voltage",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_a_stream_that_could_not_be_held_is_not_made(case):
    options, words = REFUSED[case]
    with pytest.raises(InputError, match=words):
        stream(**options)


@pytest.mark.slow
def test_textures_of_users_pass_their_tests():
    """In a process of its own: a model that is defined in a test is known to every test after it."""
    file = Path(__file__).with_name("textures_of_users.py")
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", str(file)],
        capture_output=True,
        text=True,
        check=False,
        timeout=120,
    )
    assert done.returncode == 0, done.stdout[-3000:]
