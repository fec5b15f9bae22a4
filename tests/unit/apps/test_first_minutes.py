"""What a new user types in the first minutes, mistakes included, and what is printed then."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import time
import urllib.request
from pathlib import Path
from signal import SIGINT

import numpy as np
import pytest
import xarray

import electrovib as ev
from electrovib.apps.cli import main
from electrovib.apps.cli.run import _range

SCENARIO = """
schema = 1
drive = { model = "Sine", amplitude = "100 V", frequency = "120 Hz" }
force = { model = "MaxwellStressInGap" }
friction = { model = "Coulomb", coefficient = 0.5 }
contact = { model = "FixedArea", area = "1 cm2" }
[load]
normal_force = "0.5 N"
[circuit]
return_path = { model = "Grounded", resistance = "1 kohm" }
[stack.insulator]
thickness = "1 um"
material = { model = "Constant", permittivity = 3.9 }
[stack.stratum_corneum]
thickness = "200 um"
material = { model = "Constant", permittivity = 1560, conductivity = "1.79 uS/m" }
"""


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a working folder with one scenario."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "my.toml").write_text(SCENARIO)
    return tmp_path


@pytest.fixture
def cli(here, capsys, monkeypatch):
    """Return a function that runs a command in this process: exit code, output and error output."""

    def call(*arguments: str) -> tuple[int, str, str]:
        monkeypatch.setattr(sys, "argv", ["electrovib", *arguments])
        with pytest.raises(SystemExit) as stop:
            main()
        out, err = capsys.readouterr()
        return int(stop.value.code or 0), out, err

    return call


def refused(cli, *arguments: str) -> str:
    """Run a command that is refused, and return its message."""
    code, out, err = cli(*arguments)
    assert (code, out) == (2, "")
    assert "Traceback" not in err
    return err


def test_help_lists_every_command_in_a_whole_sentence_of_one_line(cli, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    _, out, _ = cli("--help")
    listed = out.partition("Predict:")[2].splitlines()
    commands = [line for line in listed if line.strip() and line not in {"Measure:", "Plan:", "See:"}]
    assert 15 <= len(commands) <= 16
    for line in commands:
        assert re.fullmatch(r"  [a-z-]+ +[A-Z].*[^.]\.", line), line
    _, out, _ = cli("bench", "--help")
    assert "Print a bench file to start from." in out
    assert "..." not in out.partition("Commands:")[2]
    assert [line.split()[0] for line in commands[:3]] == ["run", "compare", "study"]


def test_parameter_without_its_table_is_named_with_it(cli):
    err = refused(cli, "run", "my.toml", "--set", "thickness=50 um")
    assert "Did you mean 'stack.insulator.thickness' (thickness of the layer) or 'stack.strat" in err
    err = refused(cli, "design", "my.toml", "--want", "mean electrostatic_force = 1 mN", "--free", "voltage")
    assert "Did you mean 'drive.amplitude' (peak voltage" in err
    assert "limits" not in err


def test_parameter_of_another_drive_names_the_drives_that_have_it(cli):
    err = refused(cli, "run", "my.toml", "--over", "drive.rise=1ms:2ms:2")
    assert "Models with 'rise': Trapezium; to take one, set drive.model as well." in err


def test_file_that_is_not_there_is_answered_with_the_nearest_in_its_folder(cli):
    assert refused(cli, "run", "my.tml").endswith("Did you mean 'my.toml'?\n")
    assert refused(cli, "run", "mi.toml").endswith("Did you mean 'my.toml'?\n")
    assert "for instance vezzoli_2014/fig6" in refused(cli, "run", "quite_another.toml")


def test_value_with_a_unit_and_without_quotes_is_explained(cli, here):
    (here / "bare.toml").write_text(f"{SCENARIO}[limits]\nvoltage = 600 V\n")
    assert refused(cli, "run", "bare.toml").endswith(
        '; a value with a unit is a text in quotes: voltage = "600 V"\n'
    )
    (here / "twice.toml").write_text(f"{SCENARIO}[load]\n")
    assert "quotes" not in refused(cli, "run", "twice.toml")


def test_picture_of_a_result_is_found_in_its_report(cli):
    err = refused(cli, "run", "my.toml", "-o", "force.png")
    assert "Figures are in the report, --report report.html" in err


def test_columns_with_other_headings_are_named_by_their_parameter(cli, here):
    (here / "scope.csv").write_text("time [s],CH1 [V]\n0,0\n0.001,5\n0.002,0\n")
    err = refused(cli, "run", "my.toml", "--set", 'drive={ model = "Sampled", file = "scope.csv" }')
    assert 'Name another by voltage_column = "..."' in err
    assert "'electrovib import scope.csv' reads what an instrument writes above them." in err
    named = '{ model = "Sampled", file = "scope.csv", voltage_column = "CH1" }'
    assert cli("run", "my.toml", "--set", f"drive={named}")[0] == 0


def test_recording_of_a_force_sensor_is_imported_as_its_listing_proposes_and_fitted(cli, here):
    pytest.importorskip("lmfit")
    time_ = np.arange(0, 0.03, 2e-4)
    sliding = ev.simulate(ev.load("my.toml").replace({"friction.coefficient": 0.6}), time=time_)
    noise = 1e-3 * np.random.default_rng(1).standard_normal(time_.size)
    reading = sliding["lateral_force"].values / 1.5 + noise  # volts of a sensor of 1.5 N/V
    np.savetxt(
        here / "scope.csv",
        np.c_[time_, sliding["drive_voltage"].values, reading],
        delimiter=",",
        comments="",
        header="Time (s),CH1 (V),Load cell (V)",
    )
    _, out, _ = cli("import", "scope.csv")
    assert '--column lateral_force="Load cell" --set scale.lateral_force="1.5 N/V"' in out
    scaled = ("--set", "scale.lateral_force_measured=1.5 N/V", "-o", "measured.nc")
    assert cli("import", "scope.csv", "--column", "lateral_force_measured=Load cell", *scaled)[0] == 0
    err = refused(cli, "fit", "my.toml", "measured.nc", "--free", "friction.coefficient", "-o", "fit")
    assert err.endswith("declare [rig], or import the recording as 'lateral_force'\n")
    scaled = ("--set", "scale.lateral_force=1.5 N/V", "-o", "plain.nc")
    assert cli("import", "scope.csv", "--column", "lateral_force=Load cell", *scaled)[0] == 0
    assert cli("fit", "my.toml", "plain.nc", "--free", "friction.coefficient", "-o", "fit")[0] == 0
    fitted = ev.load("fit/parameters.toml")
    assert fitted.friction.coefficient == pytest.approx(0.6, rel=1e-4)


def test_quantity_by_the_end_of_its_name_is_answered_with_the_forces_first(cli):
    over = ("run", "my.toml", "--over", "stack.insulator.thickness=1um:2um:2", "--quantity")
    asked = "Did you mean 'mean electrostatic_force' or 'mean lateral_force' or 'mean normal_force'?"
    assert asked in refused(cli, *over, "mean_force")
    assert asked.replace("mean e", "peak e").replace("'mean ", "'peak ") in refused(cli, *over, "force")
    assert asked in refused(cli, *over, "mean force")
    assert "Did you mean 'mean lateral_force'?" in refused(cli, *over, "mean_lateral_force")


def test_several_traces_are_compared_by_a_report(cli):
    err = refused(cli, "compare", "a.nc", "b.nc")
    assert "'electrovib report a.nc b.nc -o overlay.html' overlays several Traces" in err


def test_equilibrium_names_both_parts_that_are_missing(cli):
    err = refused(cli, "run", "my.toml", "--states")
    assert "contact.surface is not given" in err
    assert "the stack has no gap either: add [stack.gap]" in err
    assert "no gap either" not in refused(
        cli, "run", "my.toml", "--states", "--set", "stack.gap.thickness=1 um"
    )


def test_picture_of_a_texture_is_answered_with_its_table(cli):
    limits = ("--set", "limits.voltage=1 kV", "--set", "limits.current=250 uA")
    Path("grey.png").write_bytes(b"")
    err = refused(cli, "design", "my.toml", "--texture", "grey.png", "--path", "30 mm/s", *limits)
    assert '{ model = "GreyscalePicture", file = "grey.png", pixels_per_millimetre = 5 }' in err


def test_numbers_of_a_force_are_those_that_a_person_can_use(cli):
    computed = xarray.Dataset({"electrostatic_force": ("time", [6e-36, 0.0052])})
    assert _range(computed, "electrostatic_force") == "0 N to 5.2 mN at the output times"
    assert _range(computed + 1e-9, "electrostatic_force") == "1 nN to 5.2 mN at the output times"
    _, out, _ = cli("run", "my.toml", "--set", "drive.amplitude=1 mV")
    assert re.search(r"^lateral force: 250 mN to 250 mN \(a change of \d[\d.]* nN\)$", out, re.MULTILINE)


def test_search_for_a_kind_begins_with_all_of_that_kind(cli):
    _, out, _ = cli("list", "drives")
    kinds = re.findall(r"^[A-Z]\w+  +([a-z]+(?: [a-z]+)*)  ", out, re.MULTILINE)
    count = kinds.count("drive")  # models that other tests declare are among them, or too long for the table
    assert count >= 12
    assert kinds[:count] == ["drive"] * count
    _, out, _ = cli("list", "Sine")
    words = " ".join(out.split())  # wrapped at the width of the terminal
    assert "own model a subclass of Drive: from electrovib.physics.drive.base import Drive" in words


@pytest.mark.slow
def test_page_ends_with_a_sentence_and_without_a_fault(here):
    pytest.importorskip("nicegui")
    command = [sys.executable, "-m", "electrovib", "explore", "my.toml", "--no-browser"]
    plain = {
        name: value
        for name, value in os.environ.items()
        if name not in {"PYTEST_CURRENT_TEST", "PYTHONUNBUFFERED"}
    }
    page = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=plain)
    assert page.stdout is not None
    address = re.search(r"http://\S+", page.stdout.readline())
    assert address is not None
    for _ in range(100):
        try:
            urllib.request.urlopen(address[0], timeout=20).read()
            break
        except OSError:
            time.sleep(0.2)
    page.send_signal(SIGINT)
    out, err = page.communicate(timeout=30)
    assert (page.returncode, out, err) == (0, "The page is closed.\n", "")
