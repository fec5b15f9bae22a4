"""The signals that a listing proposes for columns, typed back as they are printed."""

import shlex

import numpy as np
import pytest
from typer.testing import CliRunner

import electrovib as ev
from electrovib.apps.cli import app
from electrovib.core.errors import InputError
from electrovib.data.registry import read_recorded
from electrovib.recordings.importing.choice import proposed_columns
from electrovib.recordings.importing.import_file import list_columns

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
    "Time (s),DAQ.Fz (N),DAQ.Fx (N)": {"normal_force": 1, "lateral_force": 2},
    "Time (s),Load cell Fx (N),Load cell Fz (N)": {"lateral_force": 1, "normal_force": 2},
    "Time (s),Fz_1 (N),Fy (N),Fx (N)": {"normal_force": 1, "lateral_force": 3},
    "Time (s),NormalForce (N),LateralForce (N)": {"normal_force": 1, "lateral_force": 2},
    "Time (s),Force X (N),Force_Z (N)": {"lateral_force": 1, "normal_force": 2},
    "Time (s),Y force (N),cellFz (N),ForceX (N)": {"normal_force": 2, "lateral_force": 3},
    "time (s),force_N": {"lateral_force": 1},
    "Time (s),Fn1 (N),Ft (N)": {"normal_force": 1, "lateral_force": 2},
    "Time (s),COF,Friction coefficient,Fx (N)": {"lateral_force": 3},
    "time [s],electrostatic_force [N],lateral_force [N]": {"electrostatic_force": 1, "lateral_force": 2},
    "Timestamp,Fnormal (N),Fx (N)": {"normal_force": 1, "lateral_force": 2},
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
    if not HEADINGS[heading]:
        assert "no heading and no unit tells a signal" in listed
        return
    (line,) = [line for line in listed.splitlines() if line.startswith("to import it: ")]
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


@pytest.mark.parametrize(
    ("heading", "is_sure"), [("Fy (N)", False), ("DAQ.Fy", False), ("Fx (N)", True), ("Fr", True)]
)
def test_a_force_along_y_is_not_sure(tmp_path, heading, is_sure):
    (tmp_path / "a.csv").write_text(f"time (s),{heading}\n0,1\n1,2\n2,1\n")
    (proposed,) = proposed_columns(read_recorded(tmp_path / "a.csv"))
    assert (proposed.signal, proposed.is_sure) == ("lateral_force", is_sure)
    said = [line for line in list_columns(tmp_path / "a.csv") if line.startswith("not sure: ")]
    assert len(said) == (not is_sure)


@pytest.mark.parametrize(
    ("headings", "option"),
    [
        ("Step,Timestamp,DAQ.Fz (N)", '--set time="Timestamp [s]"'),
        ("Step,elapsed,DAQ.Fz (N)", '--set time="elapsed [s]"'),
        ("Step,elapsed (min),DAQ.Fz (N)", '--set time="elapsed"'),
        ("Step,U,DAQ.Fz (N)", '--set step="10 us"'),
    ],
)
def test_a_column_that_rises_is_asked_for_as_the_time_and_no_voltage(tmp_path, headings, option):
    rows = "".join(f"4,{0.05 * at:.3f},{3 + at % 2}\n" for at in range(20))
    (tmp_path / "a.csv").write_text(f"{headings}\n{rows}")
    (line,) = [line for line in list_columns(tmp_path / "a.csv") if line.startswith("to import it: ")]
    assert option in line
    assert ("drive_voltage" in line) is (",U," in headings)
    with pytest.raises(
        InputError,
        match=f"time = '{headings.split(',')[1].partition(' ')[0]}" if ",U," not in headings else "step",
    ):
        ev.import_file(tmp_path / "a.csv", {"normal_force": "DAQ.Fz"})


def test_without_a_heading_only_what_does_not_rise_is_an_example_of_a_voltage(tmp_path):
    for second, words in ((1, "no heading and no unit tells a signal"), (-1, 'drive_voltage="b [V]"')):
        rows = "".join(f"{at},{second * at}\n" for at in range(20))
        (tmp_path / "a.csv").write_text(f"t (s),b\n{rows}")
        assert any(words in line for line in list_columns(tmp_path / "a.csv"))


def test_what_was_typed_to_read_the_file_is_in_the_proposed_line(tmp_path, monkeypatch):
    """Without it the line imports another sheet, or splits the rows in another way."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.csv").write_text("t (s);U $1 (V)\n" + "".join(f"{at};{at % 3}\n" for at in range(9)))
    for options in (["--set", "delimiter=;"], ["--set", "reader=text", "--set", "decimal_comma=true"]):
        listed = CliRunner().invoke(app, ["import", "a.csv", *options]).output
        (line,) = [line for line in listed.splitlines() if line.startswith("to import it: ")]
        typed = shlex.split(line.removeprefix("to import it: "))
        assert set(options) - {"decimal_comma=true"} <= set(typed)
        done = CliRunner().invoke(app, ["import", "a.csv", *typed, "--force"])
        assert done.exit_code == 0, done.output
        assert "column 'U $1' [V]" in done.output
