"""What every drive keeps: shapes, NaN, periods, slopes, and parts that add up to it."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from electrovib.core.discovery import find_members
from electrovib.core.model import read_model
from electrovib.physics.drive.base import Drive, common_period

DRIVES = {name: read_model(kind, kind.example) for name, kind in find_members(Drive).items()}
REPEATING = {name: one for name, one in DRIVES.items() if one.period is not None}


@pytest.fixture(params=DRIVES.values(), ids=DRIVES)
def drive(request):
    return request.param


def corners(drive):
    """Give the times at which something is switched, within two durations."""
    found = []
    for part in drive.parts():
        if hasattr(part, "until"):
            found.extend(part.until(2 * drive.duration).times)
        else:
            found.extend(each for each in (part.start, part.stop) if np.isfinite(each))
    return np.array(found)


def between_corners(drive, count=400):
    time = np.linspace(0, 2 * drive.duration, count) + 0.37 * drive.duration / count
    switches = corners(drive)
    if len(switches):
        time = time[np.min(np.abs(time[:, None] - switches), axis=1) > 1e-3 * drive.duration / count]
    return time


def test_shapes(drive):
    assert np.shape(drive.voltage(0.1)) == ()
    assert drive.voltage([[0.1, 0.2, 0.3]]).shape == (1, 3)
    assert drive.slope(np.zeros(0)).shape == (0,)
    one_by_one = [float(drive.voltage(each)) for each in (0.0, 0.01, 0.02)]
    assert np.array_equal(drive.voltage([0.0, 0.01, 0.02]), one_by_one)


def test_nan_passes(drive):
    found = drive.voltage([0.01, np.nan])
    assert np.isfinite(found[0])
    assert np.isnan(found[1])


def test_duration_is_worth_looking_at(drive):
    assert 0 < drive.duration < 1e3
    assert np.ptp(drive.voltage(np.linspace(-1e-9, drive.duration, 999))) > 0


def test_slope_is_the_derivative_of_the_voltage(drive):
    time = between_corners(drive)
    step = 1e-7 * drive.duration
    steepest = np.max(np.abs(drive.slope(time))) + 1e-300
    found = (drive.voltage(time + step) - drive.voltage(time - step)) / (2 * step)
    # central differences: (phase in a step)^2/6, and the rounding of the voltage over the step
    assert np.max(np.abs(found - drive.slope(time))) < 1e-5 * steepest + 1e-7 / step


def test_off_before_time_0_unless_it_repeats(drive):
    if drive.period is None:
        assert drive.voltage(-1e-3) == 0
        assert drive.slope(-1e-3) == 0


@pytest.mark.parametrize("one", REPEATING.values(), ids=REPEATING)
def test_repeats_with_its_period(one):
    time = between_corners(one)
    largest = np.max(np.abs(one.voltage(time)))
    for count in (1, 7):
        assert np.max(np.abs(one.voltage(time + count * one.period) - one.voltage(time))) < 1e-9 * largest
    third = np.max(np.abs(one.voltage(time + one.period / 3.1) - one.voltage(time)))
    assert third > 1e-2 * largest  # a shorter time is no period


def test_parts_add_up(drive):
    time = np.linspace(0, drive.duration, 57)
    total = sum(part.value(time) for part in drive.parts())
    assert np.array_equal(drive.voltage(time), total)


@pytest.mark.parametrize(
    ("periods", "expected"),
    [
        ([], None),
        ([0.02], 0.02),
        ([1 / 50, 1 / 60], 0.1),
        ([1 / 60, 1 / 50], 0.1),
        ([0.3, 0.2, 0.5], 3.0),
        ([1 / 3000, 1 / 100], 0.01),
        ([1 / 30_000, 1 / 7], 1.0),
        ([1 / 50, 1 / 49.99], 100.0),
        ([1.0, np.sqrt(2)], None),
    ],
)
def test_common_period(periods, expected):
    found = common_period(periods)
    assert found == (None if expected is None else pytest.approx(expected, rel=1e-9))


def test_the_default_duration_is_five_periods_and_a_drive_that_does_not_repeat_declares_its_own():
    assert Drive.duration.fget(SimpleNamespace(period=0.02)) == 0.1
    with pytest.raises(NotImplementedError, match="SimpleNamespace does not repeat"):
        Drive.duration.fget(SimpleNamespace(period=None))
