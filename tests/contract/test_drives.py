"""A drive is the sum of its parts, repeats with its period, and a finite one begins and ends at its low level."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from electrovib.physics.drive.edges import Trapezium
from electrovib.physics.drive.pieces import Linear
from electrovib.physics.drive.sines import Burst


def somewhere(drive, count=400, *, first=0.0, last=1.0):
    """Times that fall on no break: irrational shares of the duration."""
    share = (np.arange(count) + 1 / np.sqrt(2)) / count
    return (first + (last - first) * share) * drive.duration


def height(drive):
    return max(float(np.max(np.abs(drive.voltage(somewhere(drive))))), 1e-12)


def breaks(drive, end):
    """Where a drive bends or jumps up to a time."""
    found = [part.until(end).times for part in drive.parts() if isinstance(part, Linear)]
    gates = [np.array([part.start, part.stop]) for part in drive.parts() if not isinstance(part, Linear)]
    return np.concatenate([*found, *gates, np.zeros(1)])


def away_from_breaks(drive, times, distance):
    near = np.min(np.abs(times[:, None] - breaks(drive, times[-1] + distance)), axis=1)
    return times[near > distance]


def test_a_drive_is_the_sum_of_its_parts_and_its_slope_is_the_derivative(drive_class, build):
    drive = build(drive_class)
    times = somewhere(drive, first=-0.5, last=1.5)
    for whole, name in ((drive.voltage, "value"), (drive.slope, "slope")):
        total = sum(getattr(part, name)(times) for part in drive.parts())
        np.testing.assert_array_equal(whole(times), total)
        assert np.max(np.abs(total)) > 0 or name == "slope"
    step = 1e-6 * drive.duration
    times = away_from_breaks(drive, somewhere(drive), 2 * step)
    numeric = (drive.voltage(times + step) - drive.voltage(times - step)) / (2 * step)
    steepest = max(float(np.max(np.abs(numeric))), height(drive) / drive.duration)
    # central difference: third derivative times step^2, below 1e-6 of the steepest slope here
    np.testing.assert_allclose(drive.slope(times), numeric, rtol=0, atol=1e-5 * steepest)


def test_the_period_is_the_period(drive_class, build):
    drive = build(drive_class)
    if drive.period is None:
        return
    times = somewhere(drive)

    def off(after):
        return np.max(np.abs(drive.voltage(times + after) - drive.voltage(times))) / height(drive)

    assert off(drive.period) < 1e-9
    for share in (2, 3, 5, 7):
        assert off(drive.period / share) > 1e-3, f"repeats after {share} times less already"


@given(data=st.data())
def test_drawn_voltages_are_finite_and_periods_are_periods(drive_class, drawn, data):
    drive = data.draw(drawn(drive_class))
    assert drive.duration > 0
    voltage = drive.voltage(somewhere(drive, 50))
    assert np.all(np.isfinite(voltage))
    assert voltage.shape == (50,)
    if drive.period is None:
        return
    for part in drive.parts():
        if isinstance(part, Linear) and part.period:
            assert part.times[0] == 0
            assert abs(part.times[-1] / part.period - 1) < 1e-12
            assert np.all(np.diff(part.times) > 0)
    times = away_from_breaks(drive, np.linspace(0, 1, 101)[1:-1] * drive.period, 1e-6 * drive.period)
    later = times + drive.period
    # the rounding of a time is a phase, or a height on an edge
    slack = 8 * np.spacing(later[-1]) * np.max(np.abs(drive.slope(times)), initial=0.0)
    atol = 1e-9 * height(drive) + slack
    np.testing.assert_allclose(drive.voltage(later), drive.voltage(times), rtol=0, atol=atol)


@given(data=st.data())
def test_a_trapezium_begins_and_ends_at_low(drawn, data):
    drive = data.draw(drawn(Trapezium)).replace({"repeat": None})
    if drive.delay + drive.rise > 0:
        assert drive.voltage(0.0) == drive.low
    end = drive.delay + drive.rise + drive.hold + drive.fall
    after = np.array([end * (1 + 1e-12) + 1e-30, 2 * end + 1, 1e6 * end + 1])
    np.testing.assert_array_equal(drive.voltage(after), drive.low)
    voltage = drive.voltage(np.linspace(0, drive.duration, 101))
    lowest, highest = sorted((drive.low, drive.high))
    slack = 1e-12 * (abs(lowest) + abs(highest))
    assert np.all((voltage >= lowest - slack) & (voltage <= highest + slack))
    assert drive.voltage(-1.0) == 0


@given(data=st.data())
def test_a_burst_begins_and_ends_at_zero(drawn, data):
    drive = data.draw(drawn(Burst)).replace({"offset": 0})
    end = drive.delay + drive.cycles / drive.frequency
    # what sin of a rounded phase leaves, at the first and after the last sample
    rounding = 2 * np.pi * drive.frequency * np.spacing(end) * drive.amplitude * 4
    assert abs(float(drive.voltage(drive.delay))) <= rounding + 1e-12 * drive.amplitude
    after = np.array([end * (1 + 1e-12), 2 * end, 10 * end])
    np.testing.assert_array_equal(drive.voltage(after), np.zeros(3))
    before = np.array([-1.0, -1e-9])
    np.testing.assert_array_equal(drive.voltage(before), np.zeros(2))


def test_a_sum_of_nothing_is_refused(discovered):
    with pytest.raises(ValueError):
        discovered["drive_class"]["Sum"].model_validate({"drives": []})
