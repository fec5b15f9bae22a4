"""Streams of textures: the same samples as the drive of the path, whatever the blocks; every violation ends at 0 V."""

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
from electrovib.studies.check import sampled, with_drive
from electrovib.studies.texture.set_up import current_bound
from electrovib.studies.texture.stream import StreamClosedError

PLATE = "vezzoli_2014/fig6"
LIMITS = {"voltage": "1 kV", "current": "250 uA"}
RATE, BLOCK, RUNNING, COUNT = 10_000, 10, 25, 300
GRATING = {"model": "Grating", "period": "1 mm", "amplitude": "0.5 mN"}


def picture(values, width, pixels_per_millimetre):
    size = {"width": width, "pixels_per_millimetre": pixels_per_millimetre}
    return {"model": "GreyscalePicture", "value_samples": values} | size


def recorded(positions, forces):
    samples = {"position_samples": positions, "friction_force_samples": forces}
    return {"model": "RecordedFrictionForce"} | samples


WHITE = picture([255], 1, 0.01)
STEP = recorded([0, 0.05, 0.0501, 0.1], [0.2, 0.2005, 0.25, 0.25])
HEIGHTS = {"position_samples": [0, 1e-3, 2e-3, 3e-3], "height_samples": [0, 2e-6, 1e-6, 2e-6]}
TEXTURES = {
    "grating": GRATING,
    "height": {"model": "HeightProfile"} | HEIGHTS,
    "force": recorded([0, 1e-3, 3e-3], [0.2, 0.2005, 0.2002]),
    "picture": picture(np.random.default_rng(1).integers(0, 120, 400).tolist(), 20, 5),
}


def stream(texture=GRATING, **options):
    return ev.texture_stream(PLATE, texture=texture, **{"limits": LIMITS, "carrier": "1 kHz"} | options)


def rendered(found, count, place=lambda _: 0.05):
    return [found.render(place(number / 1000), number / 1000) for number in range(count)]


def running(texture=WHITE, **options):
    """A stream that has run at the largest amplitude for some blocks."""
    found = stream(texture, **options)
    before = np.concatenate(rendered(found, RUNNING))
    assert found.error is None
    return found, before


def drive_of_path(texture, carrier="1 kHz", **samples):
    path = read_part(FingerPath, {"model": "RecordedPath"} | samples)
    asked = {"carrier": carrier, "rate": RATE, "limits": LIMITS}
    return ev.texture_drive(PLATE, texture=texture, path=path, **asked).voltages


@functools.cache
def offline(name, carrier):
    """Positions at the samples of a path, at rest for the first block, and the drive of that path."""
    turn = np.pi * np.arange(COUNT) / (COUNT - 1)
    moving = np.stack([1.5e-3 + 1.2e-3 * np.sin(2 * turn), 1e-3 * np.cos(turn) + 1.5e-3], axis=-1)
    x, y = np.concatenate([np.repeat(moving[:1], BLOCK - 1, axis=0), moving]).T
    samples = {"time_samples": np.arange(len(x)) / RATE, "x_samples": x, "y_samples": y}
    return moving, drive_of_path(TEXTURES[name], carrier, **samples)


@settings(max_examples=15, deadline=None)
@given(
    case=st.sampled_from([("grating", "1 kHz"), ("height", None), ("picture", "777 Hz"), ("force", None)]),
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


def test_a_number_for_each_block_is_interpolated_and_the_carrier_continuous_between_them():
    """Positions at the ends of the blocks are those of a straight path; a constant force is one sine, whatever the times."""
    found = stream()
    samples = np.concatenate([*rendered(found, 40, lambda time: 0.05 * time), found.close()])
    straight = {"time_samples": [0, 0.9e-3, 39.9e-3], "x_samples": [0, 0, 0.05 * 0.039]}
    expected = drive_of_path(GRATING, **straight)
    np.testing.assert_allclose(samples, expected, rtol=0, atol=1e-9 * np.max(expected))
    found = stream(WHITE, carrier="777 Hz")
    times = np.cumsum(np.random.default_rng(3).uniform(0.3e-3, 1e-3, 200))
    samples = np.concatenate([found.render(0.05, time) for time in times])
    tone = np.sin(2 * math.pi * 777 * np.arange(len(samples)) / RATE)
    expected = found._synthesis.hardware.largest_amplitude * tone
    assert np.max(np.abs(samples - expected)[BLOCK:]) < 1e-7
    assert stream(block="2 ms").latency == 2e-3
    assert "played `latency` seconds after" in " ".join(type(found).__doc__.split())


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
    whole, hardware = np.concatenate([before, after]), found._synthesis.hardware
    assert np.max(np.abs(np.diff(whole))) * RATE <= hardware.largest_slope
    assert np.max(np.abs(whole)) <= hardware.largest_amplitude
    steps = round(hardware.ramp * RATE)
    assert not after[steps + BLOCK :].any(), "the ramp has its duration"
    for _ in range(2):
        with pytest.raises(StreamClosedError, match=words.split(",")[0]):
            found.render(0.05, (RUNNING + 1) / 1000)
    assert not len(found.close())


@pytest.mark.parametrize(("speed", "words"), [(0.01, "None"), (1.0, "the voltage changes at")])
def test_too_steep_an_edge_ends_the_stream(speed, words):
    """White to black within a tenth of a millimetre is too fast at 100 mm/s a millisecond, not at 10 mm/s."""
    found = stream(picture([255] * 50 + [0] * 50, 100, 10), carrier="3 kHz")
    rendered(found, 6, lambda _: 4e-3)
    for number in range(1, 1 + round(2 / speed)):
        found.render(4e-3 + speed * number / 1000, (number + 5) / 1000)
        if found.error:
            break
    assert words in str(found.error)


def test_the_longest_duration_and_a_force_that_slowly_exceeds_the_most_end_the_stream():
    found = stream(WHITE, longest="20 ms")
    samples = np.concatenate(rendered(found, 20))
    with pytest.raises(StreamClosedError, match="the declared longest duration is reached"):
        found.render(0.05, 0.02)
    assert 180 < np.flatnonzero(samples)[-1] < 200
    found, largest = stream(recorded([0, 0.1], [0.2, 0.25]), carrier=None), 0.0
    for number in range(2000):
        largest = max(largest, np.max(found.render(0.1 * number / 2000, number / 1000)))
        if found.error:
            break
    assert "the texture needs an attraction of 54.2" in str(found.error)
    assert 0.999 * found.largest_voltage < largest <= found.largest_voltage


def test_a_stream_that_is_closed_ends_by_its_ramp():
    """Without a carrier the samples are the ramp itself, which is linear and has its duration."""
    found, _ = running(ramp="3 ms")
    end = found.close()
    assert len(end) == 30
    assert end[-1] == 0
    assert np.max(np.abs(end[:3])) > 50
    assert not len(found.close())
    with pytest.raises(StreamClosedError, match="the stream was closed"):
        found.render(0.05, 1.0)
    found, before = running(STEP, carrier=None, ramp="3 ms")
    ramp = before[-1] * (1 - np.arange(1, 31) / 30)
    np.testing.assert_allclose(found.close(), ramp, rtol=1e-12, atol=1e-12)
    assert not stream().close().any(), "it never rendered"


def test_the_current_bound_holds_for_random_voltages_and_is_close_for_carriers_and_conduction():
    """The current of the full model stays below the bound of slope and charge; for a carrier and for a resistor it is near it."""
    scenario, times = ev.load(PLATE), np.arange(400) * 1e-4
    bound, random = current_bound(scenario), np.random.default_rng(5)

    def current(voltage):
        trace = ev.simulate(with_drive(scenario, sampled(times, voltage)), signals=["current"])
        return np.max(np.abs(trace.current.values))

    for smooth in (1, 20, 200):
        voltage = np.convolve(random.standard_normal(600), np.ones(smooth) / smooth)[:400]
        voltage[0] = 0.0
        slope, size = np.max(np.abs(np.diff(voltage))) / 1e-4, np.max(np.abs(voltage))
        assert current(voltage) <= bound.current(slope, size)
    assert current(np.sin(2 * np.pi * 50 * times)) > 0.97 * bound.current(2 * np.pi * 50, 1.0)
    own = {"stack.insulator.material.conductivity": 1e-9, "stack.stratum_corneum.material.conductivity": 1e-3}
    scenario = ev.load(PLATE, changes=own)
    resistance = 90e-6 / (1e-9 * scenario.contact_area)
    assert 1 < current_bound(scenario).current(1e-3, 100.0) / (100.0 / resistance) < 2.1


REFUSED = {
    "limits": ({"limits": {"voltage": "1 kV"}, "set": {"limits": {}}}, "not declared, and a stream of"),
    "charge": ({"limits": LIMITS | {"charge": "1 uC"}}, "limits.charge: a stream cannot be compared"),
    "energy": ({"limits": LIMITS | {"stored_energy": "1 mJ"}}, "limits.stored_energy: a stream cannot be"),
    "rms": ({"limits": LIMITS | {"rms_current": "100 uA"}}, "limits.rms_current: a stream cannot be"),
    "dimensions": ({"dimensions": 3}, "dimensions = 3: must be 1 or 2"),
    "carrier": ({"carrier": "5 kHz"}, "may have 0.4 of the rate"),
    "block": ({"block": "10 us"}, "block = 10 us: must lie between 0.0001 and 1 s"),
    "breakdown": ({"set": {"stack.insulator.breakdown_field": "1 MV/m"}}, "declare a lower limits.voltage"),
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
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", str(file)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=120)
    assert done.returncode == 0, done.stdout[-3000:]
