"""Times of the samples: clocks of their own, steps that contradict, units of time, and rows that are changes alone."""

import json
import re
import shlex
import sys

import numpy as np
import pytest

import electrovib as ev
from electrovib.core.errors import InputError
from electrovib.core.samples import Samples
from electrovib.data.recorded import ChannelClock, DataColumn, NotRead, Recorded, recorded_of
from electrovib.data.registry import read_recorded
from electrovib.physics.drive.sampled import Sampled
from electrovib.recordings.importing.clock import sample_times
from electrovib.recordings.importing.import_file import list_columns

N = 200
A, B = 0.05 * np.arange(N), 25.0 * np.arange(N)


def column(name, unit, values):
    return DataColumn(name=name, unit=unit, values=np.asarray(values, dtype=float))


def two_clocks(second=B, **changes):
    """Two records beside each other: a force over 'Time A' [s] and a voltage over 'Time B' [ms]."""
    columns = {
        "Time A [s]": A,
        "Force [N]": np.sin(A),
        "Time B [ms]": second,
        "Voltage [V]": np.cos(second / 1e3),
    }
    channels = [
        column(name[:-1].split(" [")[0], name[:-1].split(" [")[1], each) for name, each in columns.items()
    ]
    return Recorded(
        **{"channels": tuple(channels), "time": "Time A", "clocks": {"Voltage": ChannelClock(time="Time B")}}
        | changes
    )


def test_a_column_takes_its_own_clock():
    recorded = two_clocks()
    np.testing.assert_allclose(sample_times(recorded, ["Force"]).time, A)
    np.testing.assert_allclose(sample_times(recorded, ["Voltage"]).time, 1e-3 * B)
    even = two_clocks(time="", step=2.0, clocks={"Voltage": ChannelClock(step=0.5, start=3.0)})
    np.testing.assert_allclose(sample_times(even, ["Force"]).time, 2.0 * np.arange(N))
    np.testing.assert_allclose(sample_times(even, ["Voltage"]).time, 3 + 0.5 * np.arange(N))
    with pytest.raises(InputError, match="neither times nor a time step"):
        sample_times(two_clocks(clocks={"Voltage": ChannelClock()}), ["Voltage"])


def test_columns_of_two_clocks_are_refused_with_both():
    said = (
        r"2 clocks \('Force': column 'Time A' from 0 s to 9.95 s in steps of 50 ms; 'Voltage': column 'Time B' from 0 s"
        " to 4.975 s in steps of 25 ms.*clock_shift='0 s'"
    )
    with pytest.raises(InputError, match=said):
        sample_times(two_clocks(), ["Force", "Voltage"])
    with pytest.raises(InputError, match="do not overlap"):
        sample_times(two_clocks(second=B + 9951), ["Force", "Voltage"])
    stated = sample_times(two_clocks(), ["Force", "Voltage"], time="Time A")
    np.testing.assert_allclose(stated.time, A)
    (said,) = [each.text for each in stated.diagnostics if each.name == "clock"]
    assert "the times 'Time A' were stated; in the file 'Voltage' have another clock" in said
    assert not [
        each
        for each in sample_times(two_clocks(), ["Voltage"], time="Time B").diagnostics
        if each.name == "clock"
    ]


def test_two_columns_of_the_same_times_are_one_clock():
    same = [*two_clocks().channels]
    same[2] = column("Time B", "s", A)
    found = sample_times(two_clocks(channels=tuple(same)), ["Force", "Voltage"])
    np.testing.assert_allclose(found.time, A)
    assert not [each for each in found.diagnostics if each.name == "clock"]


def test_a_step_that_contradicts_the_times_is_refused_with_both():
    with pytest.raises(InputError, match=r"'Time A \[s\]' has steps of 50 ms.* states .* 51 ms"):
        sample_times(two_clocks(step=0.051), ["Force"])
    np.testing.assert_allclose(sample_times(two_clocks(step=0.0502), ["Force"]).time, A)
    np.testing.assert_allclose(sample_times(two_clocks(step=0.051), ["Force"], time="Time A").time, A)
    np.testing.assert_allclose(
        sample_times(two_clocks(step=0.051), ["Force"], step="51 ms").time[-1], 0.051 * 199
    )


@pytest.fixture
def waveforms(tmp_path, monkeypatch):
    """Write channels with the properties of their waveforms as TDMS."""
    nptdms = pytest.importorskip("nptdms", reason="needs the extra 'formats'")
    monkeypatch.chdir(tmp_path)

    def write(**channels):
        with nptdms.TdmsWriter("a.tdms") as file:
            file.write_segment(
                [nptdms.ChannelObject("G", name, values, about) for name, (values, about) in channels.items()]
            )
        return tmp_path / "a.tdms"

    return write


def waveform(delay, step, unit, offset=0.0):
    start = np.datetime64("2026-11-28T10:00:00.000000") + np.timedelta64(round(1e6 * delay), "us")
    return {"wf_start_time": start, "wf_start_offset": offset, "wf_increment": step, "unit_string": unit}


def test_waveforms_begin_when_they_state_it(waveforms):
    values = np.arange(1000.0)
    path = waveforms(
        A=(values, waveform(2, 1e-3, "V")),
        B=(values, waveform(1.5, 1e-3, "N", offset=0.25)),
        C=(values, waveform(2, 2e-3, "A")),
        word=(["a", "b"], {}),
    )
    recorded = read_recorded(path)
    assert [each.name for each in recorded.not_read] == ["G/word"]
    assert recorded.attributes["first_time"].startswith("2026-11-28T10:00:01.5")
    for name, start, step in (
        ("drive_voltage=G/A", 0.5, 1e-3),
        ("lateral_force=G/B", 0.25, 1e-3),
        ("current=G/C", 0.5, 2e-3),
    ):
        signal, _, channel = name.partition("=")
        np.testing.assert_allclose(
            ev.import_file(path, {signal: channel}).time, start + step * values, atol=1e-12
        )
    with pytest.raises(InputError, match=r"'G/A': from 500 ms.*'G/B': from 250 ms to 1.249 s in .*1 ms"):
        ev.import_file(path, {"drive_voltage": "G/A", "lateral_force": "G/B"})


def run(said_by, line):
    """Type a line of a listing as it is printed."""
    from typer.testing import CliRunner

    from electrovib.apps.cli import app

    done = CliRunner().invoke(app, ["import", said_by, *shlex.split(re.search(r"--column.*", line)[0])])
    assert done.exit_code == 0, done.output


def test_what_is_proposed_for_two_clocks_works_and_is_right(waveforms):
    time = 1e-3 * np.arange(1000)
    path = waveforms(
        A=(np.sin(time), waveform(0, 1e-3, "V")),
        B=(np.cos(time + 0.3), waveform(0.3, 1e-3, "N")),
        C=(time, waveform(100, 1e-3, "A")),
    )
    first, second, third = [line for line in list_columns(path) if "--column" in line]
    assert "'G/B': another clock, from 300 ms to 1.299 s in steps of 1 ms; to put it onto" in second
    assert "to import it by itself" in third
    for line in (first, second, third):
        run("a.tdms", line)
    both = ev.open_trace("trace_2.nc")
    np.testing.assert_allclose(both.time, time[300:], atol=1e-9)
    np.testing.assert_allclose(both.drive_voltage, np.sin(both.time), atol=1e-12)
    np.testing.assert_allclose(both.lateral_force, np.cos(both.time), atol=1e-9)
    accounts = [json.loads(both.attrs[name]) for name in ("columns_of_file", "second_columns_of_file")]
    assert accounts[0] == accounts[1]
    np.testing.assert_allclose(ev.open_trace("trace_3.nc").time, 100 + time, atol=1e-9)


def test_a_channel_of_times_beside_waveforms(waveforms):
    values = np.arange(50.0)
    times = {"unit_string": "s"}
    path = waveforms(Time=(0.01 * values, times), F=(values, waveform(0, 0.01, "N")))
    np.testing.assert_allclose(ev.import_file(path, {"lateral_force": "G/F"}).time, 0.01 * values)
    assert not any("state which one is right" in line for line in list_columns(path))
    path = waveforms(Time=(0.01 * values, times), F=(values, waveform(0, 1.0, "N")))
    assert any(
        "the file also states a step of 1 s: state which one is right" in line for line in list_columns(path)
    )
    with pytest.raises(InputError, match=r"'G/Time \[s\]' has steps of 10 ms.* states .* 1 s"):
        ev.import_file(path, {"lateral_force": "G/F"})


@pytest.mark.parametrize(
    ("unit", "factor"),
    [
        ("milliseconds since 2026-11-28 10:00:00", 1e-3),
        ("microseconds", 1e-6),
        ("ns", 1e-9),
        ("min", 60.0),
        ("h", 3600.0),
    ],
)
def test_units_of_time_of_other_programs(tmp_path, unit, factor):
    values = np.arange(5.0)
    recorded = recorded_of([("clock", unit, values), ("force", "N", values)])
    assert recorded.time == "clock"
    np.testing.assert_allclose(sample_times(recorded, ["force"]).time, factor * values)


EDGES = np.array([0, 1.0, 1.25, 3.0, 3.5, 6.0])
LEVELS = np.array([0.0, 1, 0, 1, 0, 0])
OTHER = np.array([0.0, 0, 0, 1, 1, 0])


def test_a_record_of_changes_is_held_between_its_rows(table):
    path = table("Time [s],CH_A,CH_B", EDGES, LEVELS, OTHER)
    assert any("a row only where a value changes" in line for line in list_columns(path))
    found = ev.import_file(path, {"drive_voltage": "CH_A [V]"})
    assert "each value is held until just before the next row" in found.attrs["history"]
    said = json.loads(found.attrs["validity"])
    assert [(each["name"], each["state"]) for each in said] == [("dropped samples", "ok")]
    grid = np.arange(0, 6, 0.01) + 0.005
    exact = LEVELS[np.searchsorted(EDGES, grid, side="right") - 1]
    np.testing.assert_array_equal(np.interp(grid, found.time, found.drive_voltage), exact)
    drive = Sampled(
        time_samples=Samples(found.time.values), voltage_samples=Samples(found.drive_voltage.values)
    )
    np.testing.assert_array_equal(drive.voltage(grid), exact)


@pytest.mark.parametrize(
    ("time", "values", "is_held"),
    [
        (EDGES, [0.0, 80, 120, 80, 0, 120], True),
        (np.arange(6.0), [0.0, 1, 0, 1, 0, 1], True),
        (np.arange(6.0), [0.0, 80, 120, 80, 0, 120], False),
        (np.delete(np.arange(40.0), [7, 21]), np.delete(np.tile([0.0, 80, 120, 80], 10), [7, 21]), False),
        (EDGES, [0.0, 80, 0, 120, 0, 150], True),
        (EDGES, [0.0, 80, 0, 120, 0, 0], True),
        (EDGES, [0.0, 0, 120, 80, 0, 120], False),
        (EDGES, [0.1, 0.2, 0.35, 0.3, 0.4, 0.45], False),
        (EDGES[:3], [0.0, 1, 0], False),
    ],
    ids=[
        "event log", "even edges of one level", "even levels", "samples missing", "many levels", "an end", "repeats", "readings",
        "too few",
    ],
)  # fmt: skip
def test_only_changes_of_few_levels_are_held(table, time, values, is_held):
    found = ev.import_file(table("t [s],u [V]", time, np.asarray(values)), {"drive_voltage": "u"})
    assert ("only where a value changes" in found.attrs["history"]) is is_held
    assert found.time.size == (2 * len(values) - 1 if is_held else len(values))


def test_a_listing_of_constructed_clocks_does_not_mix_them(monkeypatch, tmp_path):
    (tmp_path / "a.csv").write_text("1,2\n3,4\n")
    monkeypatch.setattr(
        sys.modules[list_columns.__module__],
        "read_recorded",
        lambda *_, **__: two_clocks(not_read=(NotRead(name="x", why="y"),)),
    )
    lines = list_columns(tmp_path / "a.csv")
    assert "  not read: x: y" in lines
    first, second = [line for line in lines if "--column" in line]
    assert first == 'to import it: --column lateral_force="Force" -o trace.nc'
    assert "column 'Time B' from 0 s to 4.975 s in steps of 25 ms" in second
    assert 'drive_voltage="Voltage" --set with="trace.nc" --set clock_shift="0 s" -o trace_2.nc' in second
