"""Times of a text: stamps, columns beside a stated step, several columns of times, segments and tables that are parts."""

import numpy as np
import pytest

from electrovib.core.errors import DataFileError
from electrovib.data.recorded import ChannelClock
from electrovib.data.registry import read_recorded
from electrovib.data.text.stamps import seconds_from_first

N = np.arange(60)
V = np.sin(N / 5)


@pytest.fixture
def read(tmp_path):
    def written(text, **options):
        (tmp_path / "a.csv").write_text(text, encoding="utf-8")
        return read_recorded(tmp_path / "a.csv", **options)

    return written


def table(heading, *columns, sign=","):
    lines = (sign.join(str(cell) for cell in row) for row in zip(*columns, strict=True))
    return "\n".join([heading, *lines]) + "\n"


def unread(found):
    return {each.name: each.why for each in found.not_read}


def clock(seconds, form="{:02d}:{:02d}:{:09.6f}"):
    return form.format(int(seconds // 3600), int(seconds // 60 % 60), seconds % 60)


@pytest.mark.parametrize(
    ("stamps", "seconds", "order"),
    [
        (["2026-10-25T02:59:59.9+02:00", "2026-10-25T02:00:00+01:00", "2026-10-25T01:00:00.2Z"], [0, 0.1, 0.3], ""),
        (["00:59.95", "01:00.00", "01:00.05"], [0, 0.05, 0.1], ""),
        (["59:59.9", "00:00.0", "59:59.9", "00:00.1"], [0, 0.1, 3600, 3600.2], ""),
        (["59:59", "1:00:00", "1:00:01"], [0, 1, 2], ""),
        (["00:01", "00:02", "1:00:03"], [0, 1, 3602], ""),
        (["99:58", "99:59", "100:01"], [0, 1, 3], ""),
        (["0 days 23:59:59.9", "1 day, 0:00:00", "1 days 00:00:00.100"], [86399.9, 86400, 86400.1], ""),
        (["11:59:59.5 p.m.", "12:00:00.25 a.m.", "1:00:00 a.m."], [0, 0.75, 3600.5], ""),
        (["28.11.26 10:00:00,5", "28.11.26 10:00:01,5", "28.11.26 10:00:02"], [0, 1, 1.5], ""),
        (["10:00:00:999", "10:00:01:000", "10:00:01:001"], [0, 0.001, 0.002], ""),
        (["28-Nov-2026 23:59:59", "29-Nov-2026 00:00:00.5", "Nov 29, 2026 00:00:01"], [0, 1.5, 2], ""),
        (["2024-02-28,10:00:00", "2024-02-29,10:00:00", "2024-03-01,10:00:00"], [0, 86400, 172800], ""),
        (["03/01/2024 23:59:59", "04/01/2024 00:00:00", "04/01/2024 00:00:01"], [0, 1, 2], "day.month"),
        (["03/01/2024 23:59:59", "03/02/2024 00:00:00", "03/02/2024 00:00:01"], [0, 1, 2], "month/day"),
        (["2024-01-01 00:00:00.000000001", "2024-01-01 00:00:00.000000002", "no stamp"], [0, 1e-9, np.nan], ""),
    ],
)  # fmt: skip
def test_stamps_of_every_form_become_seconds(stamps, seconds, order):
    found, assumed = seconds_from_first(stamps)
    np.testing.assert_allclose(found, seconds, rtol=1e-15)
    assert assumed == order


def test_stamps_at_100_khz_keep_their_resolution(read):
    """As floats of seconds since year 1 they were rounded to 7.63 us, and samples seemed to be missing."""
    stamps = [f"2026-11-28 {clock(36000 + at * 1e-5)}" for at in range(400)]
    found = read(table("Timestamp,F [N]", stamps, np.arange(400)))
    np.testing.assert_allclose(found.times(), 1e-5 * np.arange(400), atol=1e-15)


def test_whole_seconds_beside_a_column_of_milliseconds_are_one_time(read):
    seconds, parts = 36000 + N // 20, 50 * (N % 20)
    found = read(table("Time,ms,F [N]", [clock(each)[:8] for each in seconds], parts, V))
    np.testing.assert_allclose(found.times(), 0.05 * N, atol=1e-12)
    for other in (950 - parts, 50 * N, parts - 950):
        found = read(table("Time,ms,F [N]", [clock(each)[:8] for each in seconds], other, V))
        np.testing.assert_array_equal(found.times(), N // 20)


def test_an_open_order_of_the_date_is_said(read):
    found = read(table("At,F [N]", [f"0{1 + at}/02/2024 10:00:00" for at in range(9)], N[:9]))
    assert "read as day.month" in found.attributes["unsure"]
    np.testing.assert_allclose(found.times(), 86400 * N[:9])


@pytest.mark.parametrize(
    ("text", "name", "why"),
    [
        (table("Clock,F [N]", [f"10:{at:02d}" for at in N], V), "Clock", "hours and minutes or minutes and seconds"),
        (table("Date,t [s],F [N]", ["2026-11-28"] * 60, N, V), "Date", "'2026-11-28' in all rows"),
        (table("At,t [s],F [N]", map(clock, N), N, V), "At", "the times are those of column 't'"),
        ("Sample Rate: 1 Hz\n" + table("At;F [N]", map(clock, N), V, sign=";"), "At", "the step that the file states"),
        (table("At,F [N]", ["2500-01-01 10:00:00", "2500-01-01 10:00:01"] * 30, V), "At", "Out of bounds"),
    ],
    ids=["two ways", "one date", "beside a time", "beside a step", "beyond nanoseconds"],
)  # fmt: skip
def test_stamps_that_are_not_the_time_are_named(read, text, name, why):
    assert why in unread(read(text))[name]


def test_stamps_are_the_time_beside_a_rising_column_without_a_heading(read):
    found = read("\n".join(f"2026-11-28 {clock(at / 2)},{at},{v}" for at, v in zip(N, V, strict=True)))
    np.testing.assert_allclose(found.times(), N / 2)
    assert [each.name for each in found.channels] == ["time", "column 1", "column 2"]


@pytest.mark.parametrize(("unit", "step"), [("hh:mm", 60), ("mm:ss", 1)])
def test_the_heading_says_what_a_clock_of_two_numbers_is(read, unit, step):
    found = read(table(f"Clock [{unit}],F [N]", [f"10:{at:02d}" for at in N], V))
    np.testing.assert_allclose(found.times(), step * N)


@pytest.mark.parametrize(
    ("heading", "values", "unit", "seconds"),
    [
        ("Time (min)", N / 60, "min", N),
        ("t [h]", N / 3600, "h", N),
        ("time (milliseconds since 2026-11-28 10:00:00)", 2 * N, "milliseconds", 2e-3 * N),
        ("Time [microseconds]", 5 * N, "microseconds", 5e-6 * N),
    ],
)
def test_units_of_time(read, heading, values, unit, seconds):
    found = read(table(f"{heading},F [N]", values, V))
    assert (found.time, found.channels[0].unit) == (found.channels[0].name, unit)
    column = found.channels[0].in_si("a.csv", "s")
    np.testing.assert_allclose(column, seconds, rtol=1e-14)


@pytest.mark.parametrize(("heading", "time"), [("Timestamp", ""), ("Timestamp [ms]", "Timestamp")])
def test_a_time_stamp_is_the_time_if_its_unit_is_stated(read, heading, time):
    assert read(table(f"F [N],{heading}", V, 1e12 + N)).time == time
    assert read(table(f"{heading},F [N]", 1e12 + N, V)).time == time


STATED = "Sample Interval,{},s\n"


@pytest.mark.parametrize(
    ("step", "column", "time", "kept"),
    [
        ("1e-3", N, "t", None),  # ms
        ("1.001e-3", N, "t", None),
        ("1e-6", N, "t", 1e-6),
        ("1.02e-3", N, "t", 1.02e-3),
        ("1e-3", 10 * (N // 10), "", 1e-3),
    ],
    ids=["equal", "nearly", "a factor of 1000", "two percent", "rounded"],
)
def test_a_column_of_times_beside_a_stated_step(read, step, column, time, kept):
    """Where they contradict each other both are in the record, which an import refuses."""
    found = read(STATED.format(step) + table("t [ms],U [V]", column, V))
    assert (found.time, found.step) == (time, kept)
    assert ("t" in unread(found)) == (not time)


def test_stamps_that_contradict_a_stated_step_are_kept_beside_it(read):
    found = read("Sample Rate: 10 Hz\n" + table("At;F [N]", map(clock, N), V, sign=";"))
    assert (found.time, found.step) == ("time", 0.1)


def test_a_column_that_numbers_the_rows_is_named(read):
    found = read(STATED.format("1e-6") + table("Sample,U [V]", N, V))
    assert [each.name for each in found.channels] == ["U"]
    assert unread(found) == {"Sample": "it numbers the rows"}


def test_a_force_in_newton_beside_a_stated_step_is_read(read):
    """Its unit N was taken for the heading n of a number of samples, and the column dropped."""
    found = read(STATED.format("1e-6") + table("F (N),U (V)", V, V))
    assert [each.name for each in found.channels] == ["F", "U"]


def test_a_constant_time_is_no_clock(read):
    found = read(table("Time (s),Time increment (s),F (N)", N / 10, [0.1] * 60, V))
    assert (found.time, found.clocks) == ("Time", {})


def test_columns_behind_a_second_time_have_it_as_their_clock(read):
    shorter = [*map(str, 2.5 * N[:40]), *[""] * 20]
    found = read(table("Time_A (s),F (N),Time_B (ms),U (V),I (A)", 0.05 * N, V, shorter, V, V))
    assert found.time == "Time_A"
    assert found.clocks == {"U": ChannelClock(time="Time_B"), "I": ChannelClock(time="Time_B")}
    text = STATED.format(0.5) + table("Time A (s),F (N),Time B (s),U (V)", N // 2, V, N // 4, V)
    assert (read(text).step, read(text).clocks) == (0.5, {"U": ChannelClock(time="Time B")})
    for other in (1000 * N + 250, 1000 * N):  # since another beginning, or the same times
        found = read(table("Time A (s),F (N),Time B (ms),U (V)", N, V, other, V))
        assert (found.time, found.clocks) == ("Time A", {})


def test_each_signal_of_labview_may_have_its_own_times(read):
    header = "Channels\t2\nX_Dimension\tTime\tTime\nX0\t0\t0\nDelta_X\t1E-2\t5E-3\n***End_of_Header***\n"
    found = read(header + table("X_Value\tU\tX_Value\tF\tComment", N / 100, V, N / 200, V, sign="\t"))
    assert (found.time, found.step) == ("X_Value", None)
    assert found.clocks == {"F": ChannelClock(time="X_Value'")}


def test_minutes_that_begin_anew_do_not_pass_the_full_hour(read):
    clocks = [f"{at // 60:02d}:{at % 60:02d}.0" for at in (*range(0, 2700, 60), *range(0, 900, 60))]
    found = read(table("Time,F [N]", clocks, V))
    np.testing.assert_allclose(found.times(), 60 * np.arange(45))
    assert "15 rows" in unread(found)["segment 2"]


def test_pairs_without_headings(read):
    """As ngspice writes them with wrdata: the times again before each vector."""
    found = read(
        "\n".join(f" {t:.8e}  {u:.8e}  {t:.8e}  {u:.8e}" for t, u in zip(1e-3 * N, V, strict=True)) + "\n"
    )
    assert [each.name for each in found.channels] == ["column 0", "column 1", "column 3"]
    assert unread(found) == {"column 2": "it repeats the times of column 'column 0'"}
    warped = 0.059 * (N / 59) ** 2
    found = read(
        "\n".join(f"{t:.8e} {u:.8e} {w:.8e} {u:.8e}" for t, u, w in zip(1e-3 * N, V, warped, strict=True))
        + "\n"
    )
    assert found.clocks == {"column 3": ChannelClock(time="column 2")}
    ramp = read(
        "\n".join(f"{t:.8e} {u:.8e} {t * 7:.8e} {u:.8e}" for t, u in zip(1e-3 * N, V, strict=True)) + "\n"
    )
    assert (ramp.time, ramp.clocks) == ("column 0", {})


def test_times_that_turn_back_to_their_beginning_are_segments(read):
    times = np.concatenate([N[:40], N[:20]]) - 5.0
    text = "Segments,2,SegmentSize,40\n" + table("Time,Ampl", times, V)
    for part, rows in ((None, slice(0, 40)), ("segment 1", slice(0, 40)), ("segment 2", slice(40, 60))):
        found = read(text, part=part)
        np.testing.assert_array_equal(found.times(), times[rows])
        np.testing.assert_allclose(found.channels[1].values, V[rows])
        assert len(found.not_read) == 1
    assert "40 rows" in unread(found)["segment 1"]
    with pytest.raises(DataFileError, match=r"no such table.*segment 1, segment 2"):
        read(text, part="segment 3")
    glitch = np.where(N == 30, 20, N)
    assert read(table("Time,Ampl", glitch, V)).size == 60


HEADER = "Channels\t2\nSamples\t60\t60\nDate\t2026/11/28\t2026/11/28\nX0\t{}\t{}\nDelta_X\t1E-4\t1E-4\n***End_of_Header***\n"


def test_segments_with_their_own_headers_are_parts(read):
    text = "LabVIEW Measurement\nSeparator\tTab\n***End_of_Header***\n\n"
    for start in (0.0, 0.5):
        text += (
            HEADER.format(start, start)
            + table("X_Value\tU\tF\tComment", [""] * 60, V + start, V, sign="\t")
            + "\n"
        )
    for part, start in ((None, 0.0), ("table 1", 0.0), ("table 2", 0.5)):
        found = read(text, part=part)
        assert (found.size, found.step, found.start) == (60, 1e-4, start)
        np.testing.assert_allclose(found.channels[0].values, V + start)
    assert "60 rows" in unread(found)["table 1"]


@pytest.mark.parametrize("between", ["", "\n", "\n\nRun 2 of the day\n"])
def test_tables_with_other_headings_in_one_text_are_parts(read, between):
    text = table("t [s],F [N]", N, V) + between + table("t [s],F [N],U [V]", N[:30], V[:30], 2 * V[:30])
    found = read(text)
    assert [each.name for each in found.channels] == ["t", "F"]
    assert "30 rows" in unread(found)["table 2"]
    found = read(text, part="table 2")
    np.testing.assert_allclose(found.channels[2].values, 2 * V[:30])


@pytest.mark.parametrize("sign", ["-", "- ", "\u2212"])
def test_signs_and_readings_that_are_missing_do_not_divide_a_table(read, sign):
    half = [f"nan,{at}" if at % 7 == 6 else f"{sign}{at}.5,{at}" for at in range(20)] + ["nan,20"]
    found = read("\n".join(["u [V],n", *half]) + "\n")
    assert (found.size, "table" in found.attributes) == (21, False)
    found = read("\n".join(["u [V],n", *half, "u [V],n", *half[:9]]) + "\n")
    assert (found.size, found.attributes["table"]) == (21, "table 1")
    assert found.channels[1].values[-1] == 20


@pytest.mark.parametrize("line", ["Paused", "Paused at 12:00", "# a comment"])
def test_words_between_rows_are_no_other_table(read, line):
    found = read(
        table("t [s],F [N]", N[:30], V[:30])
        + line
        + "\n"
        + "\n".join(f"{t},{v}" for t, v in zip(N[30:], V[30:], strict=True))
    )
    assert "table" not in found.attributes


def test_a_clock_of_whole_seconds_has_its_decimals_in_the_column_of_milliseconds(read):
    stamps = [f"10:00:{at // 20:02d}" for at in N]
    found = read(table("Time,Millisecond,Force (N)", stamps, 50 * (N % 20), V))
    assert found.time == "time"
    assert found.times() == pytest.approx(0.05 * N)
    assert found.size == N.size


def test_a_rising_column_in_a_unit_of_time_is_that_of_the_columns_behind_it(read):
    found = read(table("t1 (ms),Force,t2 (s),Voltage", 10 * N, V, 0.005 * N, 2 * V))
    assert (found.time, found.clocks) == ("t1", {"Voltage": ChannelClock(time="t2")})


@pytest.mark.parametrize("heading", ["# U [mV],I [nA]", "Segment {}\nTime,U,I"])
def test_no_segment_is_joined_to_another_or_lost(read, heading):
    cells = (2.5 + V, V) if "#" in heading else ([f"{t} s" for t in N], *[[f"{each} mV" for each in V]] * 2)
    one = table("", *cells)
    found = read("".join(heading.format(part) + one for part in (1, 2)))
    assert found.size == N.size
    assert [why.partition(";")[0] for why in unread(found).values()] == ["another part of 60 rows"]


@pytest.mark.parametrize(
    "setting", ["Decimation = 10", "Decimation,10", "# Decimation factor: 10", "Downsampling,10"]
)
def test_a_step_beside_a_decimation_is_doubted_unless_times_tell(tmp_path, setting):
    """Whether the step is that before or behind it was not asked, and every time may have been ten times too short."""
    values = [f"{(37 * at % 101) / 10:.4f}" for at in range(40)]
    path, head = tmp_path / "a.csv", "Model,X\nSample interval,1e-06\n"
    path.write_text(f"{head}{setting}\nF [N]\n" + "\n".join(values) + "\n")
    found = read_recorded(path)
    assert found.step == 1e-6
    assert "whether 'Sample interval' is that before or behind 'De" in found.attributes["unsure"].replace(
        "Do", "De"
    )
    path.write_text(f"{head}{setting.replace('10', '1')}\nF [N]\n" + "\n".join(values) + "\n")
    assert "unsure" not in read_recorded(path).attributes
    for step in (1e-6, 1e-5):
        rows = "".join(f"{at * step:.7f},{value}\n" for at, value in enumerate(values))
        path.write_text(f"{head}{setting}\nTime [s],F [N]\n{rows}")
        found = read_recorded(path)
        assert (found.time, found.step) == ("Time", None)
        assert "unsure" not in found.attributes
    stamps = "".join(f"10:00:{at:02d}.5,{value}\n" for at, value in enumerate(values))
    path.write_text(f"Sample interval = 0.1 s\nDecimation = 10\nTime,F [N]\n{stamps}")
    assert read_recorded(path).time == "time"
    assert "unsure" not in read_recorded(path).attributes
