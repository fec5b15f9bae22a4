# ruff: noqa: ARG002
"""Textures of users that fail while they are rendered; `test_stream` runs this file in a process of its own."""

import math
import os
import signal
import threading
import warnings

import numpy as np
import pytest

import electrovib as ev
from electrovib.core.errors import InputError
from electrovib.physics.texture.base import Texture
from electrovib.studies.texture.stream import StreamClosedError

PLATE = "vezzoli_2014/fig6"
LIMITS = {"voltage": "1 kV", "current": "250 uA"}
RATE, BLOCK, RUNNING = 10_000, 10, 25
WHITE = {"model": "GreyscalePicture", "width": 1, "value_samples": [255], "pixels_per_millimetre": 0.01}
PAIR = (signal.SIGINT, KeyboardInterrupt), (signal.SIGTERM, SystemExit)
fault = {"is": None}
"""What the texture does beyond x = 0.5 m."""


class Failing(Texture):
    """A constant texture that fails beyond x = 0.5 m."""

    @property
    def length(self):
        return 1.0

    def added_friction(self, position, velocity, plate):
        found = np.full(len(position), 0.5 * plate.largest_added_friction)
        return fault["is"](position, found) if fault["is"] and position[-1, 0] > 0.5 else found


class Misplaced(Texture):
    """A texture whose place across the stroke cannot be computed."""

    @property
    def length(self):
        return 1.0

    @property
    def across(self):
        return 1 / 0

    def added_friction(self, position, velocity, plate):
        return np.zeros(len(position))


@pytest.fixture(autouse=True)
def no_fault():
    fault["is"] = None


def raising(error):
    def fails(position, found):
        raise error

    return fails


def changed(index, value):
    """Friction of which one sample has another value."""

    def fails(position, found):
        found[index] = value
        return found

    return fails


def changes_positions(position, found):
    position[:] = math.nan
    return found


FAULTS = {
    "an exception": (raising(ZeroDivisionError("none left")), "Failing.added_friction .*: ZeroDivisionError: none left"),
    "an exception without words": (raising(LookupError()), "Failing.added_friction .*: LookupError"),
    "a warning": (lambda *_: warnings.warn("near", UserWarning, stacklevel=1), "Failing.added_friction .*: UserWarning: near"),
    "no memory": (raising(MemoryError()), "Failing.added_friction .*: MemoryError"),
    "the end of an iterator": (raising(StopIteration()), "Failing.added_friction .*: StopIteration"),
    "an error of ours": (raising(InputError("too rough", path="ridges")), "added_friction .*: InputError: ridges: too rough"),
    "a closed stream": (raising(StreamClosedError("closed")), "Failing.added_friction .*: StreamClosedError: closed"),
    "NaN": (changed(4, math.nan), "'Failing' returned NaN or infinity, 1 of 10 values"),
    "infinity": (changed(4, math.inf), "'Failing' returned NaN or infinity, 1 of 10 values"),
    "minus infinity": (changed(4, -math.inf), "'Failing' returned NaN or infinity, 1 of 10 values"),
    "nothing": (lambda *_: None, "Failing.added_friction .*: returns None"),
    "words": (lambda *_: "rough", "Failing.added_friction .*: returns 'rough'"),
    "one number": (lambda _, found: found[0], r"an array of shape \(\)"),
    "too few": (lambda _, found: found[:-1], r"an array of shape \(9,\), and an array of real numbers, one force"),
    "too many": (lambda _, found: np.append(found, 0), r"an array of shape \(11,\)"),
    "a column": (lambda _, found: found[:, None], r"an array of shape \(10, 1\)"),
    "ragged": (lambda *_: [[1.0], [1.0, 2.0]], "Failing.added_friction .*: ValueError: setting an array element"),
    "complex": (lambda _, found: found * 1j, r"Failing.added_friction .*: returns array\(\["),
    "negative": (changed(4, -1e-3), "less friction than the plate itself"),
    "too much": (changed(4, 1e3), "the texture needs an attraction of"),
    "beyond all numbers": (changed(4, 1e308), "the texture needs"),
}  # fmt: skip
KEPT = {"NaN", "infinity", "minus infinity", "negative", "too much", "beyond all numbers"}
"""Faults of a single sample: those before it are rendered."""


def stream(texture=None, **options):
    given = {"carrier": None, "limits": LIMITS} | options
    return ev.texture_stream(PLATE, texture=texture or Failing(), **given)


def moves(count, first=0, place=0.1):
    return [(place, number / 1000) for number in range(first, first + count)]


def running(carrier=None, **options):
    """A stream that has run for some blocks, and its samples."""
    found = stream(carrier=carrier, **options)
    before = np.concatenate([found.render(*move) for move in moves(RUNNING)])
    assert found.error is None
    assert np.max(np.abs(before)) > 10
    return found, before


def ended(found, *, by=StreamClosedError):
    """Samples up to 0 V, from the first block at which the texture fails."""
    parts = []
    for move in moves(50, RUNNING, 0.6):
        try:
            parts.append(found.render(*move))
        except by:
            return np.concatenate(parts)
    pytest.fail("the stream does not end")
    return None


def is_within_limits(found, samples):
    hardware = found._synthesis.hardware
    assert np.isfinite(samples).all()
    assert samples[-1] == 0
    assert np.max(np.abs(np.diff(samples))) * RATE <= hardware.largest_slope
    assert np.max(np.abs(samples)) <= hardware.largest_amplitude


@pytest.mark.parametrize("carrier", [None, "1 kHz"])
@pytest.mark.parametrize("case", FAULTS)
def test_a_texture_that_fails_ends_at_0_volts_and_is_named(case, carrier):
    found, before = running(carrier)
    fault["is"], words = FAULTS[case]
    after = ended(found)
    with pytest.raises(InputError, match=words):
        raise found.error
    assert str(found.error).endswith("The stream ends at 0 V")
    is_within_limits(found, np.concatenate([before, after]))
    if carrier is None:
        kept = 4 if case in KEPT else 0
        ramp = found._synthesis.ramp_samples
        np.testing.assert_allclose(after[:kept], before[-1])
        np.testing.assert_allclose(
            after[kept : kept + ramp], before[-1] * (1 - np.arange(1, ramp + 1) / ramp), atol=1e-9
        )
        assert not after[kept + ramp :].any()
    with pytest.raises(StreamClosedError, match=words):
        found.render(0.1, 1.0)


def test_the_line_of_the_file_is_stated_and_the_error_kept_as_the_cause():
    found, _ = running()
    fault["is"] = raising(cause := ValueError("odd"))
    ended(found)
    assert "(textures_of_users.py, line " in str(found.error)
    with pytest.raises(StreamClosedError) as closed:
        found.render(0.1, 1.0)
    assert closed.value.__cause__ is found.error
    assert found.error.__cause__ is cause
    assert not ended(stream()).any(), "a texture that fails at once gives 0 V"
    with pytest.raises(InputError, match=r"Failing.added_friction \(.*, line .*\): ValueError: odd"):
        ev.texture_drive(PLATE, texture=Failing(), path="1 m/s", limits=LIMITS)
    with pytest.raises(InputError, match=r"Misplaced.across \(.*, line .*\): ZeroDivisionError"):
        stream(Misplaced())


def test_a_texture_may_overwrite_its_positions_and_one_that_cannot_be_read_ends_at_0_volts():
    found, before = running()
    fault["is"] = changes_positions
    after = np.concatenate([found.render(*move) for move in moves(3, RUNNING, 0.6)])
    assert found.error is None
    np.testing.assert_allclose(after, before[-1])
    np.testing.assert_allclose(found.state.sample_place[:, 0], 0.6)

    class Sensor:
        def __array__(self, dtype=None, copy=None):
            raise OSError("sensor unplugged")

    found, before = running()
    after = np.concatenate([found.render(Sensor(), RUNNING / 1000), found.close()])
    is_within_limits(found, np.concatenate([before, after]))
    assert "OSError: sensor unplugged" in str(found.error)


@pytest.mark.parametrize("kind", [KeyboardInterrupt, SystemExit])
def test_an_interrupt_waits_until_0_volts(kind):
    found, before = running("1 kHz", ramp="3 ms")
    fault["is"] = raising(kind())
    after = ended(found, by=kind)
    is_within_limits(found, np.concatenate([before, after]))
    assert len(after) >= 30
    assert f"interrupted by {kind.__name__}" in str(found.error)
    with pytest.raises(StreamClosedError, match="interrupted"):
        found.render(0.1, 1.0)


def test_a_block_that_an_interrupt_loses_is_not_part_of_the_samples(monkeypatch):
    """The interrupt comes after a block has been rendered and before it is returned."""
    found, before = running("777 Hz")
    rendered = found._rendered

    def interrupted(position, time):
        rendered(position, time)
        raise KeyboardInterrupt

    monkeypatch.setattr(found, "_rendered", interrupted)
    after = ended(found, by=KeyboardInterrupt)
    assert found.samples == len(before) + BLOCK * math.ceil(found._synthesis.ramp_samples / BLOCK)
    is_within_limits(found, np.concatenate([before, after]))


class Device:
    """An output that can refuse blocks, and that a signal may reach while it writes."""

    def __init__(self, *, refused=(), sends=None, at=RUNNING, again=None):
        self.samples, self.calls, self.refused = [], 0, refused
        self.sends, self.at, self.again = sends, at, again

    def __call__(self, block):
        number, self.calls = self.calls, self.calls + 1
        if self.sends is not None and number in (self.at, self.again):
            os.kill(os.getpid(), self.sends)
        if number in self.refused:
            raise OSError("no output")
        self.samples.extend(block)

    @property
    def played(self):
        return np.array(self.samples)


@pytest.mark.parametrize(("texture", "carrier"), [(None, None), (WHITE, "1 kHz")])
def test_playing_ends_by_the_ramp_and_returns_all_samples(texture, carrier):
    found, device = stream(texture, carrier=carrier), Device()
    samples = found.play(moves(RUNNING), device)
    is_within_limits(found, samples)
    np.testing.assert_array_equal(samples, device.played)
    np.testing.assert_array_equal(samples, found.played)
    assert "the stream was closed" in str(found.error)


def failing_moves(error):
    yield from moves(RUNNING)
    raise error


ENDS = {
    "texture": (lambda: [*moves(RUNNING), *moves(5, RUNNING, 0.6)], (), StreamClosedError),
    "positions": (lambda: failing_moves(OSError("no sensor")), (), OSError),
    "no pair": (lambda: [*moves(RUNNING), 0.1], (), TypeError),
    "output": (lambda: moves(RUNNING), (RUNNING - 5,), OSError),
}


@pytest.mark.parametrize("case", ENDS)
def test_whatever_raises_while_playing_the_ramp_is_written(case):
    given, refused, kind = ENDS[case]
    fault["is"] = raising(ValueError("odd")) if case == "texture" else None
    found, device = stream(carrier="1 kHz"), Device(refused=refused)
    with pytest.raises(kind):
        found.play(given(), device)
    is_within_limits(found, device.played)
    np.testing.assert_array_equal(device.played, found.played)
    assert np.max(np.abs(found.played)) > 10
    assert found.samples == len(found.played)


def test_positions_that_end_within_the_ramp_still_give_the_reason_and_so_does_an_output_that_refuses_it():
    fault["is"] = raising(ValueError("odd"))
    found, device = stream(ramp="5 ms"), Device()
    with pytest.raises(StreamClosedError, match=r"Failing.added_friction .*: ValueError: odd"):
        found.play([*moves(RUNNING), *moves(1, RUNNING, 0.6)], device)
    is_within_limits(found, device.played)
    assert len(device.played) == BLOCK * RUNNING + 50
    fault["is"] = None
    with pytest.raises(OSError, match="no output") as stopped:
        stream().play(moves(RUNNING), Device(refused=range(20, 100)))
    assert "not brought to 0 V by the ramp" in "".join(stopped.value.__notes__)


@pytest.mark.parametrize(("number", "kind"), PAIR)
@pytest.mark.parametrize("where", ["output", "positions", "texture"])
def test_a_signal_while_playing_ends_by_the_ramp(number, kind, where):
    def interrupted(position, found):
        if len(device.samples) == BLOCK * RUNNING:
            os.kill(os.getpid(), number)
        return found

    def waiting():
        yield from moves(RUNNING)
        os.kill(os.getpid(), number)
        pytest.fail("positions are awaited after the signal")

    fault["is"] = interrupted if where == "texture" else None
    found, device = stream(carrier="1 kHz"), Device(sends=number if where == "output" else None)
    before = {each: signal.getsignal(each) for each in (signal.SIGINT, signal.SIGTERM)}
    given = waiting() if where == "positions" else [*moves(RUNNING), *moves(500, RUNNING, 0.6)]
    with pytest.raises(kind) as stopped:
        found.play(given, device)
    is_within_limits(found, device.played)
    np.testing.assert_array_equal(device.played, found.played)
    assert BLOCK * RUNNING < len(device.played) < BLOCK * (RUNNING + 5)
    assert f"interrupted by {signal.Signals(number).name}" in str(found.error)
    assert kind is KeyboardInterrupt or stopped.value.code == 128 + number
    assert {each: signal.getsignal(each) for each in before} == before


def test_a_second_signal_does_not_stop_the_ramp_and_a_thread_leaves_signals_alone():
    found, device = stream(ramp="5 ms"), Device(sends=signal.SIGINT, again=RUNNING + 1)
    with pytest.raises(KeyboardInterrupt) as stopped:
        found.play(moves(500), device)
    is_within_limits(found, device.played)
    assert device.calls == RUNNING + 2
    assert not hasattr(stopped.value, "__notes__")
    found, device = stream(), Device()
    thread = threading.Thread(target=found.play, args=(moves(3), device))
    thread.start()
    thread.join()
    is_within_limits(found, device.played)
