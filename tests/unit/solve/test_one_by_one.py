"""Many fingers, each solved by itself: the numbers of `prepare`, in the order of the draws."""

import numpy as np
import pytest

import electrovib as ev
from electrovib.core.errors import InputError
from electrovib.solve.one_by_one import OneByOne
from electrovib.solve.population import population
from electrovib.solve.prepare import prepare

SCENARIO = "vezzoli_2014/fig6_gap"
FREE = ("stack.stratum_corneum.thickness", "friction.coefficient")


def draws(count, free=FREE, scenario=SCENARIO, seed=1):
    rng = np.random.default_rng(seed)
    begin = prepare(scenario, free=free).begin
    return {path: begin[path] * rng.uniform(0.7, 1.4, count) for path in free}


def alone(scenario, free, names, time=None):
    member = ev.load(scenario)
    times = member.time.times(member.drive) if time is None else time
    return OneByOne(member, free, names, times)


@pytest.mark.parametrize("scenario", [SCENARIO, "kaczmarek_2006/gap_biphasic", "vezzoli_2014/fig2_tremor"])
def test_the_signals_are_those_of_prepare(scenario):
    names, time = ("electrostatic_force", "lateral_force"), np.linspace(0.0, 0.02, 40)
    given = draws(3, scenario=scenario)
    found = population(scenario, FREE, names, time).signals(given)
    single = prepare(scenario, free=FREE)
    for finger in range(3):
        point = {path: values[finger] for path, values in given.items()}
        expected = single.signals(point, names=names, time=time)
        for name in names:
            assert found[name].shape == (3, 40)
            peak = np.nanmax(np.abs(expected[name]))
            np.testing.assert_allclose(found[name][finger], expected[name], rtol=0, atol=1e-12 * peak)


@pytest.mark.parametrize("scenario", [SCENARIO, "kaczmarek_2006/gap_positive", "vardar_2017/square"])
def test_a_finger_does_not_depend_on_the_others(scenario):
    time = np.linspace(0.0, 0.01, 30)
    engine = alone(scenario, FREE, ("electrostatic_force", "lateral_force"), time)
    given = draws(7, scenario=scenario)
    given["stack.stratum_corneum.thickness"][3] = given["stack.stratum_corneum.thickness"][2]
    whole = engine.signals(given)
    for finger in range(7):
        fresh = alone(scenario, FREE, ("electrostatic_force", "lateral_force"), time)
        one = fresh.signals({path: values[finger : finger + 1] for path, values in given.items()})
        for name, row in one.items():
            np.testing.assert_array_equal(row[0], whole[name][finger])


def test_the_times_are_those_of_the_scenario_unless_given():
    member = ev.load(SCENARIO)
    found = population(SCENARIO, FREE)
    np.testing.assert_array_equal(found.time, member.time.times(member.drive))
    assert found.frequency is None
    assert found.signals(draws(1))["electrostatic_force"].shape == (1, len(found.time))


def test_signals_over_frequency_are_those_of_simulate():
    found = population(SCENARIO, ["stack.stratum_corneum.thickness"], ["mean_force", "impedance"])
    assert found.time is None
    thickness = np.array([1e-4, 3e-4])
    signals = found.signals({"stack.stratum_corneum.thickness": thickness})
    for finger, value in enumerate(thickness.tolist()):
        member = ev.load(SCENARIO).replace({"stack.stratum_corneum.thickness": value})
        trace = ev.simulate(member, signals=["mean_force", "impedance"])
        np.testing.assert_array_equal(found.frequency, trace.frequency)
        for name in ("mean_force", "impedance"):
            np.testing.assert_allclose(signals[name][finger], trace[name].values, rtol=1e-12)


def test_a_path_that_is_omitted_keeps_its_value():
    found = population(SCENARIO, FREE, ["lateral_force"])
    given = draws(2)
    left = found.signals({FREE[0]: given[FREE[0]]})
    kept = found.signals(
        {FREE[0]: given[FREE[0]], FREE[1]: np.full(2, ev.load(SCENARIO).friction.coefficient)}
    )
    np.testing.assert_array_equal(left["lateral_force"], kept["lateral_force"])


@pytest.mark.parametrize(
    ("free", "names", "words"),
    [
        (["stack.gap.thicknes"], ["electrostatic_force"], "Did you mean 'stack.gap.thickness'"),
        (["stack.gap.thickness"], ["electrostatic_forc"], "Did you mean 'electrostatic_force'"),
        (["time.duration"], ["electrostatic_force"], "the grid is the same for all fingers"),
        ([], ["electrostatic_force"], "name at least one parameter"),
        (["stack.gap.thickness"], ["electrostatic_force", "mean_force"], "ask for one kind"),
        (["stack.gap.thickness"], ["time"], "not a signal"),
    ],
)
def test_what_does_not_exist_is_refused(free, names, words):
    with pytest.raises(InputError, match=words):
        population(SCENARIO, free, names)


@pytest.mark.parametrize(
    "time", [[], [0.0, 0.0], [1e-3, 0.0], [-1e-3, 0.0], [0.0, np.nan], [0.0, np.inf], [[0.0, 1.0]]]
)
def test_wrong_times_are_refused(time):
    with pytest.raises(InputError, match="time: expected"):
        population(SCENARIO, FREE, time=time)


def test_wrong_draws_are_refused():
    with pytest.raises(InputError, match="at least one finger"):
        population(SCENARIO, FREE).signals({FREE[0]: [], FREE[1]: []})
    found = population(SCENARIO, FREE)
    with pytest.raises(InputError, match="not a free parameter"):
        found.signals({"contact.area": [1e-4]})
    with pytest.raises(InputError, match="one value for each finger"):
        found.signals({FREE[0]: [1e-4, 2e-4], FREE[1]: [0.5]})
    engine = alone(SCENARIO, FREE, ("electrostatic_force",), np.array([0.0, 1e-3]))
    with pytest.raises(InputError, match=r"finger 1 of the call: stack.stratum_corneum.thickness = 1,"):
        engine.signals({FREE[0]: np.array([1e-4, 1.0]), FREE[1]: np.array([0.5, 0.5])})
