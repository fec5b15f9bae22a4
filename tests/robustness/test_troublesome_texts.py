"""Files as programs and instruments write them, of known arrays, that were once read wrongly: right now, or refused by name."""

import re

import numpy as np
import pytest

import electrovib as ev
from electrovib.core.errors import InputError

ROWS = np.arange(60)
TIME = np.round(ROWS * 0.005, 6)
FORCE = np.round(0.3 + 0.1 * np.sin(ROWS / 7.3) + 0.01 * np.cos(ROWS * 2.1), 5)
VOLTAGE = np.round(90 * np.sin(ROWS / 5.1), 3)
MILLISECONDS = np.round(1e3 * TIME).astype(int)


def lines(*columns, separator=",", begin=""):
    """Rows of text of some columns."""
    return "".join(
        begin + separator.join(str(cell) for cell in row) + "\n" for row in zip(*columns, strict=True)
    )


def marked(mark, rows):
    """The forces as text, with a mark in some rows."""
    return [mark if row in rows else force for row, force in enumerate(FORCE)]


def listed(path):
    """What a user sees of a file."""
    from electrovib.recordings.importing.import_file import list_columns

    return "\n".join(list_columns(path))


WITHOUT_ITS_HEADINGS = {
    "two headings over three columns": "Time (ms),Force (N)\n" + lines(MILLISECONDS, FORCE, VOLTAGE),
    "a row of comments below the units": "Time\tForce\nms\tN\n\tfinger 3\n"
    + lines(MILLISECONDS, FORCE, separator="\t"),
    "headings one below the other": "# Column 1: Time (ms)\n# Column 2: Force (N)\n"
    + lines(MILLISECONDS, FORCE, separator=" "),
    "a line break in a quoted heading": '"Time\n(ms)","Force\n(N)"\n' + lines(MILLISECONDS, FORCE),
    "names of rows without a heading": '"Time (ms)" "Force (N)"\n'
    + lines([f'"{row + 1}"' for row in ROWS], MILLISECONDS, FORCE, separator=" "),
    "units below a blank row, and a counter": "Data:\tPoint\tTime\tForce\n\t\t\t\n\t\t[ms]\t[N]\n"
    + lines(ROWS + 1, MILLISECONDS, FORCE, separator="\t", begin="\t"),
    "angle brackets": "Time <ms>,Force {N}\n" + lines(MILLISECONDS, FORCE),
}


@pytest.mark.parametrize("kind", WITHOUT_ITS_HEADINGS)
def test_a_unit_above_the_numbers_is_never_lost(tmp_path, kind):
    path = tmp_path / "table.txt"
    path.write_text(WITHOUT_ITS_HEADINGS[kind])
    read = 0
    for name in ("Force", "force", "Force {N}", *(f"column {number}" for number in range(4))):
        for stated in (name, f"{name} [N]"):
            try:
                trace = ev.import_file(path, {"lateral_force": stated})
            except InputError as error:
                assert re.search("time|heading|no such column|unit", str(error)), error
                continue
            if trace.lateral_force.size == 60 and np.allclose(trace.lateral_force, FORCE):
                read += 1
                np.testing.assert_allclose(trace.time, TIME, atol=1e-9)
    assert read or re.search("time: not stated|step", listed(path))


@pytest.mark.parametrize("mark", ["\\N", "?", "Over Range", "1.0E+30", "9.96920996838687e+36"])
def test_a_mark_of_no_reading_costs_no_row(tmp_path, mark):
    path = tmp_path / "table.csv"
    where = (3, 31, 59)
    path.write_text("Time (s),Force (N),Voltage (V)\n" + lines(TIME, marked(mark, where), VOLTAGE))
    trace = ev.import_file(path, {"drive_voltage": "Voltage"})
    np.testing.assert_allclose(trace.drive_voltage, VOLTAGE)
    try:
        force = ev.import_file(path, {"lateral_force": "Force"}).lateral_force
    except InputError as error:
        assert mark in str(error)
    else:
        np.testing.assert_allclose(force, np.where(np.isin(ROWS, where), np.nan, FORCE))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (
            "Time (s);Force (N)\n"
            + lines(TIME[:30], FORCE[:30], separator=";")
            + lines(TIME[30:], FORCE[30:], separator=";").replace(".", ","),
            "the rows up to line 31 are numbers with a decimal point, those below with a decimal comma",
        ),
        (
            "Time (s),Channel,Value\n"
            + "".join(
                f"{t},force,{f}\n{t},voltage,{v}\n" for t, f, v in zip(TIME, FORCE, VOLTAGE, strict=True)
            ),
            "the rows are those of 'force', 'voltage' in turn, as column 'Channel' tells",
        ),
    ],
)
def test_rows_of_two_kinds_are_refused(tmp_path, text, words):
    path = tmp_path / "table.txt"
    path.write_text(text)
    with pytest.raises(InputError, match=words):
        ev.import_file(path, {"lateral_force": "column 1 [N]"})


def test_a_row_of_steps_below_a_word_is_no_sample(tmp_path):
    path = tmp_path / "table.txt"
    path.write_text(
        "channel names:\nForce (N)\tVoltage (V)\ndt:\n0.005\t0.005\ndata:\n"
        + lines(FORCE, VOLTAGE, separator="\t")
    )
    trace = ev.import_file(path, {"lateral_force": "column 0 [N]"})
    np.testing.assert_allclose(trace.lateral_force, FORCE)
    np.testing.assert_allclose(trace.time, TIME, atol=1e-9)


def test_a_heading_may_hold_the_delimiter(tmp_path):
    path = tmp_path / "table.txt"
    path.write_text("% Time (s), Force, z component (N), Voltage (V)\n" + lines(TIME, FORCE, VOLTAGE))
    trace = ev.import_file(path, {"normal_force": "Force, z component", "drive_voltage": "Voltage"})
    np.testing.assert_allclose(trace.normal_force, FORCE)
    np.testing.assert_allclose(trace.drive_voltage, VOLTAGE)


@pytest.mark.parametrize(
    "above",
    ["Time\tForce\n----\t----\n", "Time (ms)\tForce (N)\n==== ====\n", "ms\tN\nTime\tForce\n"],
    ids=["no unit", "a rule", "units first"],
)
def test_headings_are_found_behind_a_rule_and_below_their_units(tmp_path, above):
    path = tmp_path / "table.txt"
    path.write_text(above + lines(MILLISECONDS, FORCE, separator="\t"))
    trace = ev.import_file(path, {"lateral_force": "Force [N]" if "N" not in above else "Force"})
    np.testing.assert_allclose(trace.time, TIME if "ms" in above else 1e3 * TIME, atol=1e-9)
    np.testing.assert_allclose(trace.lateral_force, FORCE)


def test_a_table_whose_headings_leave_out_its_names_of_rows(tmp_path):
    path = tmp_path / "table.txt"
    rows = lines([f'"{row + 1}"' for row in ROWS], MILLISECONDS, FORCE, separator=" ")
    path.write_text('"Time (ms)" "Force (N)"\n' + rows)
    trace = ev.import_file(path, {"lateral_force": "Force"})
    np.testing.assert_allclose(trace.time, TIME, atol=1e-9)
    np.testing.assert_allclose(trace.lateral_force, FORCE)


def test_statistics_above_the_samples_are_named(tmp_path):
    path = tmp_path / "table.csv"
    path.write_text("Time (s),Force (N)\nMin,0.1\nMax,0.5\nMean,0.3\n" + lines(TIME, FORCE))
    np.testing.assert_allclose(ev.import_file(path, {"lateral_force": "Force"}).lateral_force, FORCE)
    assert "'Mean,0.3': a row of statistics above the samples" in listed(path)


def test_settings_beside_the_first_rows_are_no_column(tmp_path):
    path = tmp_path / "scope.csv"
    beside = ['"Record Length",60,"Points"', '"Sample Interval",5e-3,"s"', '"Trigger Point",30,"Samples"']
    begins = beside + [",,"] * (len(ROWS) - len(beside))
    path.write_text(lines(begins, TIME - 0.15, VOLTAGE))
    trace = ev.import_file(path, {"drive_voltage": "column 4 [V]"})
    np.testing.assert_allclose(trace.time, TIME - 0.15, atol=1e-9)
    np.testing.assert_allclose(trace.drive_voltage, VOLTAGE)


def test_a_unit_of_time_in_words_above_is_asked_for(tmp_path):
    path = tmp_path / "table.txt"
    path.write_text('<header><col unit="ms">t</col></header>\n' + lines(MILLISECONDS, FORCE, separator="\t"))
    with pytest.raises(InputError, match="neither times nor a time step"):
        ev.import_file(path, {"lateral_force": "column 1 [N]"})


def test_the_largest_float_is_no_reading(tmp_path):
    path = tmp_path / "table.csv"
    path.write_text("Time (s),Force (N)\n" + lines(TIME, marked("-1.7976931348623157e308", (2, 7))))
    force = ev.import_file(path, {"lateral_force": "Force"}).lateral_force
    np.testing.assert_allclose(force, np.where(np.isin(ROWS, (2, 7)), np.nan, FORCE))


def test_a_heading_without_a_column_is_named(tmp_path):
    path = tmp_path / "table.csv"
    path.write_text("Time (s),Force (N),Comment\n" + lines(TIME, FORCE))
    assert "Comment" in listed(path)
    assert "Comment" in ev.import_file(path, {"lateral_force": "Force"}).attrs["columns_of_file"]


def test_stamps_are_no_settings_of_the_instrument(tmp_path):
    path = tmp_path / "table.csv"
    stamps = [f"01/11/2026 {row // 60:02d}:{row % 60:02d}" for row in ROWS]
    path.write_text("Date;Force (N)\n" + lines(stamps, FORCE, separator=";"))
    trace = ev.import_file(path, {"lateral_force": "Force"})
    np.testing.assert_allclose(trace.time, 60.0 * ROWS)
    assert "01/11/2026 00:30" not in str(trace.attrs.get("file_preamble", "")).replace('": "', ":")


def test_headings_that_are_one_less_than_the_columns_are_not_moved(tmp_path):
    """The first of two readings: names of rows have no heading; the second: the last column has none."""
    path = tmp_path / "table.txt"
    path.write_text("Time Force\n" + lines(ROWS + 1, MILLISECONDS, FORCE, separator=" "))
    with pytest.raises(InputError, match="neither times nor a time step"):
        ev.import_file(path, {"lateral_force": "column 2 [N]"})
    path.write_text("Time (s),Force (N)\n" + lines(ROWS + 1, FORCE, VOLTAGE))
    trace = ev.import_file(path, {"lateral_force": "Force"})
    np.testing.assert_allclose(trace.lateral_force, FORCE)
    np.testing.assert_allclose(trace.time, ROWS + 1.0)


def test_a_pause_of_any_length_misses_samples(tmp_path):
    path = tmp_path / "table.csv"
    path.write_text("Time (s),Force (N)\n" + lines(np.round(TIME + 0.052 * (ROWS > 30), 6), FORCE))
    assert "about 10 samples are missing in 1 intervals" in listed(path)


UNEVEN = {
    "times of whole milliseconds": np.round(ROWS / 700, 3),
    "both corners of each edge": np.cumsum(np.where(ROWS % 2, 1e-7, 0.1 + 0.02 * ROWS)),
    "steps of a simulator": np.cumsum(np.random.default_rng(3).uniform(1e-6, 1e-3, 60)),
}


@pytest.mark.parametrize("kind", UNEVEN)
def test_uneven_steps_miss_no_samples(tmp_path, kind):
    path = tmp_path / "table.csv"
    path.write_text("Time (s),Force (N)\n" + lines([f"{time:.9g}" for time in UNEVEN[kind]], FORCE))
    assert "missing" not in listed(path)
