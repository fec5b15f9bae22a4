"""Drives where a formula is not enough: at jumps and ends, their periods, what their squares are for, what is refused.

Equations, slopes, shapes, NaN and sums of parts of every drive are held by tests/contract.
"""

from types import SimpleNamespace

import numpy as np
import pytest

from electrovib.core.discovery import find_members
from electrovib.core.errors import InputError
from electrovib.core.model import read_model
from electrovib.physics.drive.base import Drive, common_period
from electrovib.physics.drive.combined import Sum
from electrovib.physics.drive.current import CurrentAmplifier, CurrentSine
from electrovib.physics.drive.edges import PulseTrain, Square, Step, Trapezium
from electrovib.physics.drive.sines import AmplitudeModulation, Burst, Chirp, Sine, SquareRootModulation
from electrovib.scenario import read_part

MEMBERS = find_members(Drive)
TIME = np.linspace(0, 0.05, 2003)
ROUNDING = 1e-12
SINE = {"model": "Sine", "amplitude": 3, "frequency": 50}
CURRENT = {"model": "CurrentSine", "amplitude": 1e-3, "frequency": 1e3}
ONCE = {"high": 10, "rise": 1, "hold": 1, "fall": 1}
FULL = {"high": 10, "rise": 0.1, "hold": 0.2, "fall": 0, "repeat": 0.3}


def at(drive, *times):
    return drive.voltage(np.array(times))


# ------------------------------------------------------------------------------ straight pieces


def test_a_step_and_a_square_have_the_level_after_a_jump():
    assert np.array_equal(at(Step(level=-5), -1e-12, 0, 1e9), [0, -5, -5])
    square = Square(high=10, low=-4, frequency=0.5)
    assert np.array_equal(at(square, 0, 0.5, 1, 1.5, 2, 2.5, 3), [10, 10, -4, -4, 10, 10, -4])
    pulses = PulseTrain(high=10, width=0.25, frequency=1)
    assert np.array_equal(at(pulses, 0, 0.2, 0.25, 0.9, 1.1), [10, 10, 0, 0, 10])
    always = PulseTrain(high=10, width=1, frequency=1)
    assert np.array_equal(at(always, 0, 0.5, 1.0, 1.5), [10, 10, 10, 10])


def test_a_trapezium_once_and_repeated():
    drive, again = Trapezium(high=10, low=2, delay=1, rise=2, hold=3, fall=4), Trapezium(**ONCE, repeat=5)
    assert at(drive, -1, 0, 1, 2, 3, 6, 8, 99) == pytest.approx([0, 2, 2, 6, 10, 10, 6, 2], abs=1e-14)
    assert (drive.period, drive.duration) == (None, 13)
    assert again.period == again.duration == 5


@pytest.mark.parametrize("edges", [(0, 0.01), (0.01, 0), (0, 0)])
def test_a_trapezium_with_jumps(edges):
    drive = Trapezium(high=10, rise=edges[0], hold=1, fall=edges[1], delay=1)
    assert at(drive, 1 - 1e-9, 1 + edges[0], 1 + edges[0] + 1 - 1e-9, 2.02) == pytest.approx([0, 10, 10, 0])


def test_times_that_fill_the_period_but_for_rounding():
    """0.1 + 0.2 is above 0.3 by a rounding, and still fits."""
    drive = Trapezium(**FULL)
    (part,) = drive.parts()
    assert part.times[-1] == 0.3
    assert np.all(np.diff(part.times) > 1e-3)
    assert at(drive, 0.05, 0.1, 0.29999, 0.35) == pytest.approx([5, 10, 10, 5])
    third = 1 / 3
    pulses = PulseTrain(high=10, width=2 * third, frequency=1, edge=1 - 2 * third)
    assert pulses.parts()[0].times[-1] == 1
    triangle = Square(high=10, frequency=300, edge=1 / 600 * (1 + 1e-15))
    assert triangle.parts()[0].times == pytest.approx([0, 1 / 600, 1 / 300], rel=1e-15)


# ------------------------------------------------------------------------------ sines


@pytest.mark.parametrize("cycles", [1, 7])
def test_a_burst_begins_and_ends_at_0_volts(cycles):
    drive = Burst(amplitude=100, frequency=250, cycles=cycles, delay=3.3e-3)
    (part,) = drive.parts()
    assert part.stop - part.start == pytest.approx(cycles / 250, rel=1e-14)
    ends = np.array([part.start, np.nextafter(part.stop, 0), part.stop])
    assert np.max(np.abs(drive.voltage(ends))) < 1e-10 * 100  # phase of 3 ms and seven cycles, rounded
    assert np.all(drive.voltage([0, 3.2e-3, part.stop + 1e-9, 1.0]) == 0)
    assert drive.period is None


@pytest.mark.parametrize("depth", [0.1, 0.99, 1])
@pytest.mark.parametrize(("carrier", "modulation"), [(3000, 100), (100, 250), (250, 250)])
def test_the_square_of_a_root_modulation(carrier, modulation, depth):
    """It is (1 + m cos) times the square of the carrier, and the sum of tones has no negative frequency."""
    content = {"amplitude": 10, "carrier": carrier, "modulation": modulation, "depth": depth}
    root = SquareRootModulation(**content)
    envelope = 1 + depth * np.cos(2 * np.pi * modulation * TIME)
    square = envelope * (10 * np.cos(2 * np.pi * carrier * TIME)) ** 2
    assert np.max(np.abs(root.voltage(TIME) ** 2 - square)) < ROUNDING * 200
    parts = [*root.parts(), *AmplitudeModulation(**content).parts()]
    assert all(np.all(part.frequencies >= 0) for part in parts)


def test_a_chirp_knows_its_highest_frequency():
    for first, last in ((10, 1000), (1000, 10), (0, 300)):
        (part,) = Chirp(amplitude=5, first=first, last=last, length=0.04).parts()
        assert part.highest_frequency == max(first, last)


# ------------------------------------------------------------------------------ periods and durations


@pytest.mark.parametrize(
    ("periods", "expected"),
    [
        ([], None),
        ([1 / 60, 1 / 50], 0.1),
        ([0.3, 0.2, 0.5], 3.0),
        ([1 / 30_000, 1 / 7], 1.0),
        ([1 / 50, 1 / 49.99], 100.0),
        ([1.0, np.sqrt(2)], None),
    ],
)
def test_common_period(periods, expected):
    found = common_period(periods)
    assert found == (None if expected is None else pytest.approx(expected, rel=1e-9))


@pytest.mark.parametrize(
    ("others", "period"),
    [
        ([SINE | {"frequency": 75}], 0.04),
        ([{"model": "Square", "high": 1, "frequency": 20}], 0.1),
        ([{"model": "Step", "level": 5}, SINE | {"frequency": 25}], 0.04),
        ([{"model": "Burst", "amplitude": 1, "frequency": 25, "cycles": 1}], None),
        ([{"model": "Trapezium", **ONCE}], None),
        ([SINE | {"frequency": 50 * np.sqrt(3)}], None),
    ],
)
def test_the_period_of_a_sum(others, period):
    found = Sum(drives=[SINE, *others]).period
    assert found == (None if period is None else pytest.approx(period, rel=1e-12))


def test_a_sum_of_constants_has_no_period_and_one_of_sines_lasts_as_the_longest():
    constants = Sum(drives=[Step(level=5), Step(level=-2)])
    assert constants.period is None
    assert np.all(constants.voltage(TIME) == 3)
    assert Sum(drives=[SINE, Step(level=1), SINE | {"frequency": 10}]).duration == 0.5


def test_periods_of_modulations():
    content = {"amplitude": 1, "carrier": 3000, "modulation": 70, "depth": 0.5}
    assert AmplitudeModulation(**content).period == pytest.approx(0.1, rel=1e-12)
    assert SquareRootModulation(**content).period == pytest.approx(0.1, rel=1e-12)
    # the smooth branch of the root has half the frequency
    assert SquareRootModulation(**content | {"depth": 1}).period == pytest.approx(0.2, rel=1e-12)
    assert AmplitudeModulation(**content | {"carrier": 1000 * np.sqrt(2)}).period is None


def test_durations():
    assert Drive.duration.fget(SimpleNamespace(period=0.02)) == 0.1  # five periods
    with pytest.raises(NotImplementedError, match="SimpleNamespace does not repeat"):
        Drive.duration.fget(SimpleNamespace(period=None))
    for name, kind in MEMBERS.items():
        drive = read_model(kind, kind.example)
        assert 0 < drive.duration < 1e3, name
        assert np.ptp(drive.voltage(np.linspace(-1e-9, drive.duration, 999))) > 0, name
        if drive.period is None:  # off before time 0
            assert drive.voltage(-1e-3) == drive.slope(-1e-3) == 0, name


# ------------------------------------------------------------------------------ currents, held samples


def test_a_drive_is_of_voltages_or_of_currents_and_an_amplifier_keeps_the_time_of_its_command():
    sine, same = CurrentSine(amplitude=1e-3, frequency=2e3), Sine(amplitude=1e-3, frequency=2e3)
    assert (sine.quantity, same.quantity) == ("current", "voltage")
    assert (sine.period, sine.duration) == (same.period, same.duration)
    for kind in MEMBERS.values():
        if kind.quantity == "voltage":
            command = read_model(kind, dict(kind.example))
            drive = CurrentAmplifier(command=command, sense_resistance=2e4)
            assert (drive.period, drive.duration) == (command.period, command.duration)
            np.testing.assert_array_equal(drive.time_stamps, command.time_stamps)
    assert {kind.quantity for kind in MEMBERS.values()} == {"voltage", "current"}


def held(edge, times=(0, 1, 2, 5), volts=(1, 10, 4, 0)):
    samples = {"model": "Sampled", "time_samples": list(times), "voltage_samples": list(volts)}
    return read_part(Drive, {"model": "Held", "samples": samples, "edge": edge})


@pytest.mark.parametrize(
    ("edge", "ends", "volts"),
    [
        (0, 5, [1, 1, 1, 10, 10, 10, 4, 4, 4, 0]),
        (0.4, 5.4, [0, 0.5, 1, 1, 5.5, 10, 10, 4, 4, 2]),
        (1, 6, [0, 0.2, 0.9, 1, 2.8, 9.1, 10, 4, 4, 3.2]),
    ],
)
def test_held_samples_and_their_edges(edge, ends, volts):
    drive = held(edge)
    assert at(drive, 0, 0.2, 0.9, 1, 1.2, 1.9, 2, 3, 4.99, 5.2) == pytest.approx(volts, rel=1e-12)
    assert drive.duration == pytest.approx(ends)
    assert (drive.largest(), drive.voltage(6.0)) == (10, 0)


def test_an_edge_of_one_interval_is_a_line_one_interval_later():
    times = np.arange(1000) * 1.7e-5  # not representable: an edge ends where the next begins, to the rounding
    volts = np.sin(np.arange(1000))
    drive = held(float(np.min(np.diff(times))), times, volts)
    moments = np.linspace(1e-4, 0.0169, 5003)
    np.testing.assert_allclose(drive.voltage(moments), np.interp(moments - 1.7e-5, times, volts), atol=1e-8)
    assert len(drive.parts()[0].times) == 1001
    with pytest.raises(InputError, match=r"edge of 1\.1 s is longer than the shortest interval .*, 1 s"):
        held(1.1)


@pytest.mark.parametrize(
    ("kind", "content", "why"),
    [
        ("Trapezium", FULL | {"repeat": 0.3 * (1 - 1e-9)}, "repeat must be at least"),
        ("Trapezium", ONCE | {"repeat": 2}, "at least .* = 3 s"),
        ("Square", {"high": 1, "frequency": 50, "edge": 0.011}, "half a period, 0.01 s"),
        ("PulseTrain", {"high": 1, "width": 1e-3, "frequency": 50, "edge": 2e-3}, "edge <= width"),
        ("PulseTrain", {"high": 1, "width": 0.019, "frequency": 50, "edge": 2e-3}, "width . edge <= period"),
        ("Square", {"high": 1, "frequency": 0}, "frequency = 0: must lie between 1 mHz and 100 MHz"),
        ("Step", {"level": float("nan")}, "must be a finite number"),
        ("Burst", {"amplitude": 1, "frequency": 50, "cycles": 0}, "cycles must be a whole number"),
        ("Burst", {"amplitude": 1, "frequency": 50, "cycles": 2.5}, "cycles"),
        ("AmplitudeModulation", {"carrier": 50, "modulation": 5, "depth": 1.1}, "between 0 and 1"),
        ("Sine", {"amplitude": -1, "frequency": 50}, "amplitude = -1"),
        ("CurrentSine", {"amplitude": "1 V", "frequency": 50}, "expected a current"),
        ("Sum", {"drives": [SINE, CURRENT]}, "CurrentAmplifier"),
        ("Offset", {"level": 1, "drive": CURRENT}, "CurrentAmplifier"),
        ("CurrentAmplifier", {"sense_resistance": 1e3, "command": CURRENT}, "CurrentAmplifier"),
    ],
)
def test_what_is_no_drive_is_refused(kind, content, why):
    with pytest.raises(InputError, match=why):
        read_model(Drive, {"model": kind} | content)
