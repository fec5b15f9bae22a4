"""The simulated recording that a visitor can load, and whether a fit finds what it hides."""

import numpy as np
import pytest

import electrovib as ev
from electrovib.apps.explorer import reading
from electrovib.apps.explorer.computed import compute
from electrovib.apps.explorer.page.recording import FACTOR, NOISE, example
from electrovib.apps.explorer.pictures import recorded
from electrovib.apps.explorer.reading import RunningFit, fittable
from electrovib.apps.explorer.state import presets
from electrovib.core.errors import InputError
from electrovib.core.paths import value_at

QUICK = ("vezzoli_2014/fig6", "bau_2010/sine", "rauf_2025/field_3", "kim_2015/current", "nakamura_2017/fall")
"""Scenarios of the fast test: all kinds of drives, signals and hidden parameters are among them."""


@pytest.fixture
def here(monkeypatch):
    """Read in this process, without the second that another one takes to start."""
    monkeypatch.setattr("electrovib.apps.explorer.reading.read_apart", reading.read_here)


@pytest.mark.parametrize(
    "name", [pytest.param(each, marks=() if each in QUICK else pytest.mark.slow) for each in presets()]
)
def test_a_fit_finds_the_hidden_value_of_the_example_of_every_scenario(name, here):
    shown = compute(ev.load(name))
    made = example(shown, name)
    assert made.path in fittable(shown.scenario)
    assert made.value == pytest.approx(FACTOR * value_at(shown.scenario, made.path), rel=5e-3)
    (row,) = RunningFit(shown.scenario, made.read(), [made.path]).run().rows
    assert row.lower < made.value < row.upper
    assert row.value == pytest.approx(made.value, rel=0.01)


def test_the_example_is_the_scenario_shown_with_one_value_changed_and_noise_and_is_called_simulated(here):
    scenario = ev.load("vezzoli_2014/fig6_gap").replace({"drive.high": 700})
    shown = compute(scenario)
    made = example(shown, "mine")
    assert (made.path, made.signal) == ("stack.insulator.thickness", "lateral_force")
    assert made.name == "example (simulated: mine with one value changed and noise)"
    assert made.remark == "The example was simulated with stack.insulator.thickness = 117 µm."
    trace = made.read()
    time = trace.time.values
    np.testing.assert_allclose(np.diff(time), time[1] - time[0], rtol=1e-4)
    truth = ev.simulate(scenario.replace({made.path: made.value}), time=time).lateral_force.values
    noise = (trace.lateral_force.values - truth) / np.ptp(ev.simulate(scenario).lateral_force.values)
    assert np.std(noise) == pytest.approx(NOISE, rel=0.1)
    assert abs(np.mean(noise)) < NOISE / 10
    assert trace.attrs["title"] == made.name
    names = [each["name"] for each in recorded(shown, trace)[0]["data"]]
    assert names == ["example (simulated)", "computed"]
    trace.attrs["title"] = "scope.csv"
    assert recorded(shown, trace)[0]["data"][0]["name"] == "recorded"
    assert example(shown, "mine").content == made.content
    weak = example(compute(scenario.replace({"drive.high": 100})), "weak")
    assert weak.signal == "electrostatic_force"  # as the friction hardly varies


def test_a_scenario_without_a_signal_that_a_parameter_changes_says_so():
    still = ev.load("vezzoli_2014/fig2").replace({"drive.high": 0})
    with pytest.raises(InputError, match=r"no lateral force measured or .* electrostatic force over"):
        example(compute(still), "still")
