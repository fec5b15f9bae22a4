"""``electrovib bench`` as a person uses it."""

import sys

import pytest

import electrovib as ev
from electrovib.apps.cli import main
from electrovib.bench.settings import read_settings


@pytest.fixture
def cli(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)

    def call(*arguments):
        monkeypatch.setattr(sys, "argv", ["electrovib", "bench", *arguments])
        with pytest.raises(SystemExit) as stop:
            main()
        out, err = capsys.readouterr()
        return int(stop.value.code or 0), out, err

    return call


def test_without_arm_the_plan_is_printed_and_nothing_is_sent(cli, tmp_path):
    code, out, err = cli("run", "vezzoli_2014/fig6", "-o", "t.nc")
    assert (code, err) == (0, "")
    assert "hardware that limits the current: safety system of the amplifier" in out
    assert "one burst of 272 ms, from 0 V to 0 V, peak 1 kV" in out
    assert "nothing was sent" in out
    assert not list(tmp_path.iterdir())


def test_the_simulated_run_writes_a_trace(cli):
    code, out, err = cli("run", "vezzoli_2014/fig6", "--simulate", "-o", "t.nc")
    assert code == 0
    assert err == "electrovib: simulated: the generator is at 0 V; SWITCH THE HIGH VOLTAGE OFF BY HAND\n"
    steps = [line.removeprefix("step: ") for line in out.splitlines() if line.startswith("step: ")]
    assert (
        steps.index("read back")
        < steps.index("enable")
        < steps.index("low-voltage burst")
        < steps.index("full burst")
    )
    assert "written: t.nc" in out
    assert "lateral_force" in ev.open_trace("t.nc")


def test_a_drive_above_the_limit_is_one_line_and_exit_code_2(cli, tmp_path):
    code, _, err = cli("run", "vezzoli_2014/fig6", "--set", "drive.high=1200V", "--simulate", "-o", "t.nc")
    assert code == 2
    assert err.startswith("electrovib: the voltage of the plate reaches 1.2 kV, above 1 kV")
    assert err.count("\n") == 1
    assert not list(tmp_path.iterdir())


def test_init_prints_the_bench_file_to_start_from(cli, tmp_path):
    code, out, _ = cli("init")
    assert code == 0
    (tmp_path / "bench.toml").write_text(out, encoding="utf-8")
    assert read_settings(tmp_path / "bench.toml") == read_settings()
