"""``electrovib design --texture``: what is printed, written and refused."""

from __future__ import annotations

import numpy as np
import pytest
from typer.testing import CliRunner

import electrovib as ev
from electrovib.apps.cli import app
from electrovib.core.errors import InputError

GRATING = '{ model = "Grating", period = "1 mm", amplitude = "0.5 mN" }'
COMMON = [
    "design",
    "vezzoli_2014/fig6",
    "--texture",
    GRATING,
    "--path",
    "100 mm/s",
    "--carrier",
    "3 kHz",
    "--rate",
    "96 kHz",
]
HELD = ["--set", "limits.voltage=1 kV"]
LINES = ["--edge", "line"]


def run(*arguments):
    found = CliRunner().invoke(app, [*COMMON, *arguments])
    if found.exception is not None and not isinstance(found.exception, SystemExit):
        raise found.exception
    return found.output


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_the_command_prints_and_writes_what_the_function_returns(folder):
    output = run(*HELD, *LINES, "-o", "drive.csv")
    drive = ev.texture_drive(
        "vezzoli_2014/fig6",
        texture=GRATING,
        path="100 mm/s",
        carrier="3 kHz",
        rate="96 kHz",
        set={"limits.voltage": "1 kV"},
    )
    written = np.loadtxt(
        folder / "drive.csv", delimiter=",", skiprows=1 + (folder / "drive.csv").read_text().count("#")
    )
    np.testing.assert_array_equal(written, np.stack([drive.times, drive.voltages], axis=-1))
    assert "carrier of 3 kHz" in output
    assert drive.misfit_in_words in output
    assert "largest attraction 4.6" in output
    assert "peak current" in output
    assert output.splitlines()[-1] == "written: drive.csv"


def test_nothing_is_written_without_limits_or_over_an_input(folder):
    with pytest.raises(InputError, match=r"limits.voltage .* is not declared"):
        run(*LINES, "-o", "drive.csv")
    (folder / "path.csv").write_text("time,x\n0,0\n0.02,0.002\n", encoding="utf-8")
    for where in ("path.csv", "drive.txt"):
        with pytest.raises(InputError, match=where.replace(".", r"\.")):
            run(*HELD, *LINES, "--path", "path.csv", "-o", where, "--force")
    assert [each.name for each in folder.iterdir()] == ["path.csv"]
    assert (folder / "path.csv").read_text(encoding="utf-8").startswith("time,x")


def test_options_of_a_file_need_one():
    with pytest.raises(InputError, match=r"--as: belongs to a file; name one with -o drive\.csv"):
        run(*HELD, "--as", "hp_33120a")
    with pytest.raises(InputError, match="--edge: belongs to a file"):
        run(*HELD, *LINES)
    with pytest.raises(InputError, match="how the samples follow each other where a CSV is played"):
        run(*HELD, "-o", "drive.csv")
