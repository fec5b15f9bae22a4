"""The command ``electrovib design``: the answer first, its files, its exit codes, and mistakes in one sentence."""

from __future__ import annotations

import json
import sys

import pytest
from typer.testing import CliRunner

import electrovib as ev
from electrovib.apps.cli import app, main
from electrovib.core.errors import InputError
from electrovib.study.design.function import FORMS, form_of

ASKED = ["design", "bau_2010/sine", "--want", "mean electrostatic_force = 50 mN", "--free", "drive.amplitude"]
LIMITS = ["--set", "limits.voltage=60 V", "--set", "limits.current=1 mA"]


@pytest.fixture
def cli(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)

    def call(*arguments):
        monkeypatch.setattr(sys, "argv", ["electrovib", *ASKED, *arguments])
        code = 0
        try:
            main()
        except SystemExit as stop:
            code = int(stop.code or 0)
        return (code, *capsys.readouterr())

    return call


def test_the_answer_comes_first(cli):
    code, out, err = cli()
    assert (code, err) == (0, "")
    assert out.startswith("drive.amplitude = 50.8183 V gives mean electrostatic_force = 50 mN.\n")


def test_the_scenario_with_the_value_can_be_run(cli, tmp_path):
    assert cli("--set", "contact.area=2 cm2", "-o", "found.toml")[0] == 0
    found = ev.sweep("found.toml", {}, quantities=["mean electrostatic_force"])
    assert found["mean electrostatic_force"].item() == pytest.approx(0.05, rel=1e-9)
    assert ev.load("found.toml").contact.area == 2e-4


def test_all_numbers_as_json(cli, tmp_path):
    cli("-o", "found.json")
    found = json.loads((tmp_path / "found.json").read_text())
    direct = ev.design("bau_2010/sine", want="mean electrostatic_force = 50 mN", free="drive.amplitude")
    assert found["value"] == direct.value
    assert found["elasticities"] == {each.path: each.value for each in direct.influences}
    assert found["written_by"].startswith("electrovib design as JSON, checksum ")


def test_nothing_that_can_be_played_is_written_without_limits(cli, tmp_path):
    code, _, err = cli("--edge", "line", "-o", "drive.csv")
    assert code == 2
    assert "limits.voltage" in err
    assert "limits.current" in err
    assert not list(tmp_path.iterdir())


def test_within_declared_limits_the_drive_is_written(cli, tmp_path):
    (tmp_path / "own.toml").write_text('limits = { current = "1 mA" }\n')
    code, out, _ = cli(
        "--set", "limits.voltage=60 V", "--limits", "own.toml", "--edge", "line", "-o", "drive.csv"
    )
    assert code == 0
    assert "written: drive.csv" in out
    assert "Nearest limit: the voltage of the plate reaches 50.8183 V, within 60 V" in out


@pytest.mark.parametrize("name", ["found.toml", "drive.csv"])
def test_a_forbidden_value_is_not_written(cli, tmp_path, name):
    code, _, err = cli(
        "--set", "limits.voltage=40 V", "--set", "limits.current=1 mA", "--edge", "line", "-o", name
    )
    assert code == 2
    assert "there is no result within the limits that could be written" in err
    assert not list(tmp_path.iterdir())


def test_a_forbidden_value_is_exit_code_1(cli):
    code, out, _ = cli("--set", "limits.voltage=40 V")
    assert code == 1
    assert out.startswith(
        "No value of drive.amplitude from 0 V to 100 kV gives mean electrostatic_force = 50 mN within"
    )


def test_a_wrong_suffix_is_refused_before_anything_is_computed(cli):
    code, out, err = cli("-o", "found.xyz")
    assert (code, out) == (2, "")
    assert "a design is written as .toml, .json, .csv" in err


def test_a_space_with_its_draws(cli):
    code, out, _ = cli("--space", "fingers", "-n", "5", "--seed", "2", "--linear")
    assert code == 0
    assert (
        "over 5 draws from 'fingertips of adults, dry and moist' (seed 2, linear propagation from the medians)"
        in out
    )


def test_the_command_takes_every_option_of_the_function():
    import inspect

    command = next(
        each for each in app.registered_commands if each.callback.__module__.endswith("cli.design")
    )
    own = set(inspect.signature(command.callback).parameters)
    # --want has the band and the force over time too, and --free the range
    inside = {"band", "target", "between"}
    assert set(inspect.signature(ev.design).parameters) - own == {"set", "progress", *inside}


@pytest.mark.parametrize("form", FORMS, ids=lambda form: form.name)
def test_every_argument_of_a_form_is_one_of_the_function(form):
    import inspect

    assert set(form.accepts) <= set(inspect.signature(ev.design).parameters)
    assert form_of(dict.fromkeys(form.needs, "given")) is form
    with pytest.raises(InputError, match=r"colour: does not belong to the design of .*omit it"):
        form_of(dict.fromkeys([*form.needs, "colour"], "given"))


def test_help_names_every_option():
    shown = CliRunner().invoke(app, ["design", "-h"], env={"COLUMNS": "200"}).stdout
    for option in ("--want", "--free", "--texture", "--limits", "--space", "--linear", "--output", "--set"):
        assert option in shown
