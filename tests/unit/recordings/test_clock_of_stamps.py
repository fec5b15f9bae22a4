"""Even times from stamps that are cut off: the times they were made from come back."""

import numpy as np
import pytest

import electrovib as ev
from electrovib.core.errors import InputError
from electrovib.recordings.importing.clock import even_times


def cut_off(times, at=1.0):
    return np.floor(times / at + 1e-9) * at


@pytest.mark.parametrize(
    ("times", "at", "exact", "doubts"),
    [
        (0.05 * np.arange(200), 1.0, True, 0),
        (0.05 * np.arange(187) + 0.65, 1.0, True, 0),
        (1.3e-3 * np.arange(5000), 4e-3, False, 1),
        (0.3 * np.arange(200) + 0.1, 1.0, False, 1),
        (0.05 * np.arange(100_000), 1.0, True, 0),
    ],
    ids=["20 a second", "first and last second partly", "4 ms", "3 or 4 a second", "long"],
)
def test_times_that_were_cut_off_come_back(times, at, exact, doubts):
    found, _, why = even_times(cut_off(times, at))
    step = times[1] - times[0]
    assert np.diff(found) == pytest.approx(step, rel=1e-9 if exact else 1e-3)
    assert found == pytest.approx(times, abs=1e-9 if exact else step)
    assert len(why) == doubts


def test_ticks_of_a_clock_that_are_rounded_come_back():
    """A clock with ticks of 15.625 ms, stated in whole milliseconds, so that stamps are 15 or 16 ms apart."""
    ticks = cut_off(cut_off(1e-3 * np.arange(3000), 0.015625), 1e-3)
    assert np.diff(even_times(ticks)[0]) == pytest.approx(1e-3, rel=1e-3)


@pytest.mark.parametrize(
    ("stamps", "words"),
    [
        (np.concatenate([cut_off(0.05 * np.arange(100)), 20 + cut_off(0.05 * np.arange(100))]), "no even step explains them"),
        (np.repeat([0.0, 1.0, 2.0, 3.0, 4.0], [20, 20, 5, 20, 20]), "with 5 to 20 rows each"),
        (np.repeat([0.0, 1.0], 20), "too few for a time step"),
    ],
    ids=["a pause", "a second with few rows", "two stamps"],
)  # fmt: skip
def test_stamps_that_no_even_step_explains_are_refused(stamps, words):
    with pytest.raises(InputError, match=words):
        even_times(stamps)


def rows(tmp_path, heading, *columns):
    lines = (",".join(str(cell) for cell in row) for row in zip(*columns, strict=True))
    (tmp_path / "a.csv").write_text("\n".join([heading, *lines]) + "\n")
    return tmp_path / "a.csv"


def test_clocks_are_imported_or_refused(tmp_path):
    n = np.arange(200)
    path = rows(tmp_path, "Time,F (N)", [f"10:00:{at // 20:02d}" for at in n], n)
    found = ev.import_file(path, {"lateral_force": "F"})
    np.testing.assert_allclose(found["time"], 0.05 * n, atol=1e-12)
    assert "20 times each" in found.attrs["history"]
    path = rows(tmp_path, "Time,F (N)", [f"10:{at // 100:02d}:{at // 20:02d}" for at in n], n)
    with pytest.raises(InputError, match="no even step explains them"):
        ev.import_file(path, {"lateral_force": "F"})
    found = ev.import_file(path, {"lateral_force": "F"}, stamps="keep_increasing")
    assert found["time"].size == 10
    path = rows(tmp_path, "Sample Interval,5e-5\nX [ms],U [V]", 2e-4 * n - 92, n)
    with pytest.raises(InputError, match=r"200 ns.*50 us.*time=.X \[ms\]"):
        ev.import_file(path, {"drive_voltage": "U"})
    found = ev.import_file(path, {"drive_voltage": "U"}, time="X [ms]")
    assert np.diff(found["time"]) == pytest.approx(2e-7, rel=1e-6)
    path = rows(tmp_path, "position,U [V]", np.tile(n[:100], 2), n)
    with pytest.raises(InputError, match=r"turn back .* 1 times, first at sample 100") as refused:
        ev.import_file(path, {"drive_voltage": "U"}, time="position [s]")
    assert "keep_increasing" not in str(refused.value)
