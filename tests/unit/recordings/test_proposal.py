"""The signals that a listing proposes for columns, typed back as they are printed."""

import shlex

import numpy as np
import pytest
from typer.testing import CliRunner

import electrovib as ev
from electrovib.apps.cli import app
from electrovib.data.registry import read_recorded
from electrovib.recordings.importing.proposal import proposed_columns

TIMES = np.arange(50) * 1e-3
A, B, C = 0.4 + TIMES, 0.2 - TIMES, 100 * np.sin(90 * TIMES)

HEADINGS = {
    "time,force,voltage": {"lateral_force": 1, "drive_voltage": 2},
    "t;F_N;F_T;U": {"normal_force": 1, "lateral_force": 2, "drive_voltage": 3},
    "t (s),Fz (mN),Fx (mN)": {"normal_force": 1, "lateral_force": 2},
    "Zeit [s];Spannung [V];Reibkraft [N];Normalkraft [N]": {
        "drive_voltage": 1, "lateral_force": 2, "normal_force": 3,
    },
    "Time (s),CH1 (V),Current monitor (mA)": {"drive_voltage": 1, "current": 2},
    "Time (s),load cell (V),drive (V)": {"lateral_force": 1, "drive_voltage": 2},
    "T (sec),COF,Fy (N),Velocity (mm/sec)": {"lateral_force": 2, "sliding_speed": 3},
    "Time (s),Voltage (N)": {"lateral_force": 1},
    "Time (s),Temperature (K)": {},
}  # fmt: skip


def table(heading):
    sign = ";" if ";" in heading else ","
    columns = [TIMES, A, B, C][: heading.count(sign) + 1]
    rows = (sign.join(f"{value:.6f}" for value in row) for row in zip(*columns, strict=True))
    text = "\n".join([heading, *rows]) + "\n"
    return text.replace(".", ",") if sign == ";" else text


@pytest.mark.parametrize("heading", HEADINGS)
def test_what_is_proposed_is_imported_as_printed(tmp_path, monkeypatch, heading):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.csv").write_text(table(heading))
    recorded = read_recorded(tmp_path / "a.csv")
    assert {each.signal: each.column for each in proposed_columns(recorded)} == {
        signal: recorded.channels[place].name for signal, place in HEADINGS[heading].items()
    }
    listed = CliRunner().invoke(app, ["import", "a.csv"]).output
    (line,) = [line for line in listed.splitlines() if line.startswith("to import it: ")]
    if not HEADINGS[heading]:
        assert 'drive_voltage="Temperature"' in line  # an example
        return
    done = CliRunner().invoke(app, ["import", "a.csv", *shlex.split(line.removeprefix("to import it: "))])
    assert done.exit_code == 0, done.output
    found = ev.open_trace("trace.nc")
    for signal, place in HEADINGS[heading].items():
        unit = recorded.channels[place].unit
        factor = {"mN": 1e-3, "mA": 1e-3, "mm/s": 1e-3}.get(unit, 1)
        factor *= 1.5 if unit == "V" and signal != "drive_voltage" else 1  # the example of a sensitivity
        np.testing.assert_allclose(found[signal], [TIMES, A, B, C][place] * factor, atol=1e-6)
    np.testing.assert_allclose(found.time, TIMES, atol=1e-9)


def test_a_load_that_is_negative_is_turned(tmp_path):
    (tmp_path / "a.csv").write_text("T (sec),Fz (N)\n" + "".join(f"{t:.3f},{-1 - t:.3f}\n" for t in TIMES))
    (proposed,) = proposed_columns(read_recorded(tmp_path / "a.csv"))
    assert (proposed.signal, proposed.scale) == ("normal_force", "-1")
    found = ev.import_file(tmp_path / "a.csv", {"normal_force": "Fz"}, scale={"normal_force": "-1"})
    np.testing.assert_allclose(found.normal_force, 1 + TIMES, atol=1e-9)


def test_a_time_without_a_unit_is_said_in_the_listing(tmp_path):
    (tmp_path / "a.csv").write_text(table("time,force,voltage"))
    lines = "\n".join(ev.recordings.importing.list_columns(tmp_path / "a.csv"))
    assert "states no unit: s are assumed" in lines
    (tmp_path / "a.csv").write_text(table("time (ms),force,voltage"))
    assert "assumed" not in "\n".join(ev.recordings.importing.list_columns(tmp_path / "a.csv"))


@pytest.mark.parametrize(("heading", "unit"), [("t_ms", "ms"), ("Time_s", "s"), ("Zeit_us", "us")])
def test_a_time_has_the_unit_at_the_end_of_its_heading(tmp_path, heading, unit):
    (tmp_path / "a.csv").write_text(table(f"{heading};F_N"))
    recorded = read_recorded(tmp_path / "a.csv")
    assert recorded.time == heading
    assert [each.unit for each in recorded.channels] == [unit, ""]  # N of F_N may mean normal
