"""``electrovib study``."""

from __future__ import annotations

import inspect
import signal

import pytest
from stand_in_population import SPACE, StandInPopulation, stand_in
from typer.testing import CliRunner

import electrovib as ev
from electrovib.apps.cli import app
from electrovib.apps.progress import progress_words
from electrovib.core.errors import InputError
from electrovib.study.population import study

SCENARIO = "vezzoli_2014/fig6"


@pytest.fixture
def command(tmp_path, monkeypatch):
    """Run a study of fingers in closed form in an empty folder."""
    monkeypatch.setattr("electrovib.solve.population.population", stand_in)
    monkeypatch.chdir(tmp_path)
    (path, table), *_ = SPACE.items()
    lines = [f'[space."{path}"]', *(f"{name} = {value!r}" for name, value in table.items())]
    (tmp_path / "space.toml").write_text("\n".join(lines))

    def run(*options):
        return CliRunner().invoke(app, ["study", SCENARIO, "--space", "space.toml", *options])

    return run


def test_the_command_prints_bands_and_writes_them(command, tmp_path):
    asked = ["-n", "200", "--seed", "1", "-o", "study.zarr", "--exceed", "1 mN", "--percentiles", "10,50"]
    done = command(*asked, "-o", "a.csv", "--report", "a.html")
    assert done.exit_code == 0, done.output
    assert "electrostatic force at 50 ms, where its median is largest: 10th percentile" in done.output
    assert "above 1 mN at some time" in done.output
    assert "200 fingers, seed 1; in closed form; kernel: stand-in" in done.output
    assert "validity of the scenario with its own values" in done.output
    assert "written: a.html" in done.output
    found = ev.open_study(tmp_path / "study.zarr")
    assert found["percentile"].values.tolist() == [10, 50]
    assert {each.name for each in tmp_path.iterdir()} == {"space.toml", "study.zarr", "a.csv", "a.html"}


def test_all_mistakes_are_reported_at_once(command):
    done = command(
        "-n",
        "0",
        "--seed",
        "-1",
        "-o",
        "a.zarr",
        "--quantity",
        "forse",
        "--percentiles",
        "100",
        "--budget-memory",
        "1",
    )
    assert isinstance(done.exception, InputError)
    text = str(done.exception)
    for words in (
        "n = 0: expected a number of fingers",
        "seed = -1",
        "signal = forse: not a signal",
        "percentiles = 100",
    ):
        assert words in text
    wrong = command("-n", "5", "--seed", "1", "-o", "a.zarr", "--exceed", "5 V", "--budget-memory", "much")
    assert "exceed = 5 V: expected a value in N" in str(wrong.exception)
    assert "budget_memory = much: expected an amount of memory" in str(wrong.exception)


def test_signals_over_two_axes_are_refused(command):
    done = command(
        "-n", "5", "--seed", "1", "-o", "a.zarr", "--quantity", "mean_force", "--quantity", "lateral_force"
    )
    assert "expected signals over the same axis" in str(done.exception)


def test_wrong_outputs_are_refused_before_the_study(command, tmp_path, monkeypatch):
    monkeypatch.setattr(StandInPopulation, "signals", None)
    done = command("-n", "5", "--seed", "1", "-o", "a.zarr", "-o", "a.txt")
    assert "at most one .csv file" in str(done.exception)
    done = command("-n", "5", "--seed", "1", "-o", "a.zarr", "--report", "a.pdf")
    assert ".html" in str(done.exception)
    assert not (tmp_path / "a.zarr").exists()


def test_an_interrupted_command_says_how_far_it_came(command, tmp_path, monkeypatch):
    evaluated, original = [], StandInPopulation.signals

    def interrupted(self, draws):
        evaluated.append(1)
        if len(evaluated) == 2:
            signal.raise_signal(signal.SIGINT)
        return original(self, draws)

    monkeypatch.setattr(StandInPopulation, "signals", interrupted)
    done = command("-n", "4000", "--seed", "1", "-o", "a.zarr")
    assert done.exit_code == 130
    assert "of 4000 fingers are complete; the same command continues with the next" in done.output
    assert not (tmp_path / "a.zarr" / ".lock").exists()
    assert command("-n", "4000", "--seed", "1", "-o", "a.zarr").exit_code == 0


def test_the_function_has_the_name_of_its_package():
    assert callable(ev.study)
    assert inspect.signature(ev.study) == inspect.signature(study)
    import electrovib.study.sweep  # which makes the package an attribute

    assert callable(ev.study)
    assert ev.study.sweep is electrovib.study.sweep


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ((0, None, None, None), ""),
        ((0, 100, None, None), "0 of 100"),
        ((20480, 100000, 51000.0, 1.6), "20480 of 100000, 5.1e+04/s, 1.6 s left"),
        ((50, 100, 0.5, 7200.0), "50 of 100, 0.5/s, 2 h left"),
    ],
)
def test_progress_in_words(given, words):
    assert progress_words(*given) == words
