"""The signals that a listing proposes for columns, typed back as they are printed."""

import shlex

import numpy as np
import pytest
from typer.testing import CliRunner

import electrovib as ev
from electrovib.apps.cli import app
from electrovib.data.registry import read_recorded
from electrovib.recordings.importing.choice import proposed_columns

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


def written(tmp_path, heading):
    sign = ";" if ";" in heading else ","
    columns = [TIMES, A, B, C][: heading.count(sign) + 1]
    rows = (sign.join(f"{value:.6f}" for value in row) for row in zip(*columns, strict=True))
    text = "\n".join([heading, *rows]) + "\n"
    (tmp_path / "a.csv").write_text(text.replace(".", ",") if sign == ";" else text)
    return read_recorded(tmp_path / "a.csv")


@pytest.mark.parametrize("heading", HEADINGS)
def test_what_is_proposed_is_imported_as_printed(tmp_path, monkeypatch, heading):
    monkeypatch.chdir(tmp_path)
    recorded = written(tmp_path, heading)
    assert {each.signal: each.column for each in proposed_columns(recorded)} == {
        signal: recorded.channels[place].name for signal, place in HEADINGS[heading].items()
    }
    listed = CliRunner().invoke(app, ["import", "a.csv"]).output
    assert ("states no unit: s are assumed" in listed) == heading.startswith(("time,", "t;"))
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


@pytest.mark.parametrize("heading", ["C", "Cp [nF]", "Capacitance (pF)", "Kapazität [pF]", "LCR.CH1 (pF)"])
def test_a_capacitance_is_recognised_by_unit_or_name(tmp_path, heading):
    (tmp_path / "a.csv").write_text(f"time (s),{heading},T (C),Fz (N)\n0,1,20,0.5\n1,2,20,0.5\n2,3,21,0.5\n")
    found = {each.signal: each.column for each in proposed_columns(read_recorded(tmp_path / "a.csv"))}
    assert found == {"capacitance": heading.partition(" ")[0], "normal_force": "Fz"}


def test_a_load_that_is_negative_is_turned(tmp_path):
    (tmp_path / "a.csv").write_text("T (sec),Fz (N)\n" + "".join(f"{t:.3f},{-1 - t:.3f}\n" for t in TIMES))
    (proposed,) = proposed_columns(read_recorded(tmp_path / "a.csv"))
    assert (proposed.signal, proposed.scale) == ("normal_force", "-1")
    found = ev.import_file(tmp_path / "a.csv", {"normal_force": "Fz"}, scale={"normal_force": "-1"})
    np.testing.assert_allclose(found.normal_force, 1 + TIMES, atol=1e-9)


@pytest.mark.parametrize(("heading", "unit"), [("t_ms", "ms"), ("Time_s", "s"), ("Zeit_us", "us")])
def test_a_time_has_the_unit_at_the_end_of_its_heading(tmp_path, heading, unit):
    recorded = written(tmp_path, f"{heading};F_N")
    assert recorded.time == heading
    assert [each.unit for each in recorded.channels] == [unit, ""]  # N of F_N may mean normal
