"""Commands in groups, examples that run, and mistakes named as what they are."""

from __future__ import annotations

import re
import shlex

import pytest
from typer.main import get_command

import electrovib as ev
from electrovib.apps.cli import app, main
from electrovib.core.errors import InputError


@pytest.fixture
def cli(tmp_path, capsys, monkeypatch):
    """Return a function that runs a command in this process: exit code, output and error output."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "my.toml").write_text(ev.init("vezzoli_2014/fig6"), encoding="utf-8")
    (tmp_path / "drive.csv").write_text("time,voltage\n0,0\n0.01,100\n0.02,0\n")

    def call(*arguments: str) -> tuple[int, str, str]:
        monkeypatch.setattr("sys.argv", ["electrovib", *arguments])
        with pytest.raises(SystemExit) as stop:
            main()
        out, err = capsys.readouterr()
        return int(stop.value.code or 0), out, err

    return call


def test_help_lists_the_commands_by_what_they_are_for(cli):
    _, out, _ = cli("--help")
    groups = dict(re.findall(r"^(\w+):\n((?:  [a-z].*\n?)+)", out, re.MULTILINE))
    assert list(groups)[-4:] == ["Predict", "Measure", "Plan", "See"]
    listed = {title: [line.split()[0] for line in rows.splitlines()] for title, rows in groups.items()}
    assert listed["Plan"] == ["design", "check", "export"]
    assert {name for title in list(listed)[-4:] for name in listed[title]} == set(get_command(app).commands)


@pytest.mark.parametrize("name", ["design", "check"])
def test_help_begins_with_an_example_that_runs(cli, name):
    _, out, _ = cli(name, "-h")
    usage, _, first, *_ = out.splitlines()
    assert f"electrovib {name} [OPTIONS]" in usage
    example = first.removeprefix("  Example: electrovib ")
    assert example != first
    assert out.count(example) == 1
    code, _, err = cli(*shlex.split(example))
    assert (code, err) == (0, "")


@pytest.mark.parametrize(
    ("arguments", "meant"),
    [
        ("check my.toml drive.csv", "check drive.csv my.toml"),
        ("fit drive.csv my.toml --free stack.insulator.thickness", "fit my.toml drive.csv"),
        ("export drive.csv my.toml -o w.csv", ""),
    ],
)
def test_arguments_in_another_order_are_named(cli, arguments, meant):
    code, out, err = cli(*arguments.split())
    assert (code, out) == (2, "")
    if meant:
        assert err.endswith(f"the order is: electrovib {meant}\n")


def test_arguments_in_the_right_order_pass(cli):
    assert cli("run", "my.toml", "-o", "a.nc")[0] == 0
    assert cli("report", "my.toml", "a.nc", "-o", "r.html")[0] == 0
    assert cli("check", "drive.csv", "my.toml", "--set", "limits.voltage=1 kV")[0] == 0


@pytest.mark.parametrize(
    ("value", "sentence"),
    [
        (90, "so this is 90 m; must lie between 100 pm and 100 mm"),
        ("90", "so this is 90 m; must lie between 100 pm and 100 mm"),
        ("2e3", "so this is 2000 m; must lie"),
        ("90,5 um", "the decimal sign is a point: '90.5 um'"),
        (" 1,5e-1 mm", "the decimal sign is a point: '1.5e-1 mm'"),
    ],
)
def test_a_number_without_a_unit_and_a_decimal_comma_are_named(value, sentence):
    with pytest.raises(InputError, match=re.escape(sentence)):
        ev.load("vezzoli_2014/fig6", changes={"stack.insulator.thickness": value})


@pytest.mark.parametrize("value", ["90 m", "90 km"])
def test_a_number_with_its_unit_is_not_explained(value):
    with pytest.raises(InputError, match=r"must lie between 100 pm and 100 mm") as told:
        ev.load("vezzoli_2014/fig6", changes={"stack.insulator.thickness": value})
    assert "so this is" not in str(told.value)
    with pytest.raises(InputError) as told:
        ev.load("vezzoli_2014/fig6", changes={"stack.insulator.material.permittivity": 0.5})
    assert "so this is" not in str(told.value)


@pytest.mark.parametrize(
    "texture", ["gone.png", '{ model = "GreyscalePicture", file = "gone.png", pixels_per_millimetre = 5 }']
)
def test_a_missing_picture_comes_before_a_missing_limit(cli, texture):
    code, _, err = cli("design", "my.toml", "--texture", texture, "--path", "30mm/s")
    assert code == 2
    assert "gone.png: there is no such file" in err
    assert "limits" not in err


def test_a_design_is_its_verdict_and_the_rest_is_asked_for(cli):
    """Everything of the verdict is in the rest too, in the same words; what it depends on and how are not in the verdict."""
    wanted = ["design", "my.toml", "--want", "peak electrostatic_force = 1 mN", "--free", "drive.high"]
    *verdict, more = cli(*wanted)[1].splitlines()
    told = [line for line in verdict if not line.startswith("warning: ")]
    everything = cli(*wanted, "--all")[1].splitlines()
    assert told[0].startswith("drive.high = 624.706 V gives peak electrostatic_force = 1 mN")
    assert told[1] == "Other solutions: -624.706 V."
    assert len(told) <= 5
    assert set(verdict) <= set(everything)
    rest = [line for line in everything if line not in verdict]
    assert [line.split()[0] for line in rest] == ["Elasticities", "The"]
    assert more.startswith(f"--all prints {len(rest)} more lines")
