"""Many fingers, each solved by itself: the numbers of `prepare`, in the order of the draws."""

import numpy as np
import pytest

import electrovib as ev
from electrovib.core.errors import InputError
from electrovib.solve.one_by_one import OneByOne
from electrovib.solve.population import population
from electrovib.solve.prepare import prepare

SCENARIO = "vezzoli_2014/fig6_gap"
FREE = SKIN, FRICTION = ("stack.stratum_corneum.thickness", "friction.coefficient")
NAMES = FORCE, LATERAL = ("electrostatic_force", "lateral_force")


def draws(count, scenario=SCENARIO):
    rng = np.random.default_rng(1)
    begin = prepare(scenario, free=FREE).begin
    return {path: begin[path] * rng.uniform(0.7, 1.4, count) for path in FREE}


@pytest.mark.parametrize(
    "scenario", [SCENARIO, "kaczmarek_2006/gap_biphasic", "vezzoli_2014/fig2_tremor", "vardar_2017/square"]
)
def test_a_finger_has_the_signals_of_prepare_whatever_the_others(scenario):
    time, given = np.linspace(0.0, 0.02, 40), draws(5, scenario)
    given[SKIN][3] = given[SKIN][2]
    found = population(scenario, FREE, NAMES, time).signals(given)
    whole = OneByOne(ev.load(scenario), FREE, NAMES, time).signals(given)
    for finger in range(5):
        point = {path: values[finger] for path, values in given.items()}
        expected = prepare(scenario, free=FREE).signals(point, names=NAMES, time=time)
        for name in NAMES:
            assert found[name].shape == (5, 40)
            np.testing.assert_array_equal(whole[name][finger], expected[name])
            peak = np.nanmax(np.abs(expected[name]))
            np.testing.assert_allclose(found[name][finger], expected[name], rtol=0, atol=1e-12 * peak)


def test_the_times_are_those_of_the_scenario_unless_given_and_an_omitted_path_keeps_its_value():
    member, found = ev.load(SCENARIO), population(SCENARIO, FREE, [LATERAL])
    np.testing.assert_array_equal(found.time, member.time.times(member.drive))
    assert found.frequency is None
    given = draws(2)
    left = found.signals({SKIN: given[SKIN]})[LATERAL]
    assert left.shape == (2, len(found.time))
    kept = found.signals({SKIN: given[SKIN], FRICTION: np.full(2, member.friction.coefficient)})[LATERAL]
    np.testing.assert_array_equal(left, kept)


def test_signals_over_frequency_are_those_of_simulate():
    found, thickness = population(SCENARIO, [SKIN], ["mean_force", "impedance"]), [1e-4, 3e-4]
    assert found.time is None
    signals = found.signals({SKIN: np.array(thickness)})
    for finger, value in enumerate(thickness):
        trace = ev.simulate(ev.load(SCENARIO, changes={SKIN: value}), signals=["mean_force", "impedance"])
        np.testing.assert_array_equal(found.frequency, trace.frequency)
        for name in ("mean_force", "impedance"):
            np.testing.assert_allclose(signals[name][finger], trace[name].values, rtol=1e-12)


GAP = ["stack.gap.thickness"]
TIMES = [[], [0.0, 0.0], [1e-3, 0.0], [-1e-3, 0.0], [0.0, np.nan], [0.0, np.inf], [[0.0, 1.0]]]


@pytest.mark.parametrize(
    ("free", "names", "time", "words"),
    [
        (["stack.gap.thicknes"], [FORCE], None, "Did you mean 'stack.gap.thickness'"),
        (GAP, ["electrostatic_forc"], None, "Did you mean 'electrostatic_force'"),
        (["time.duration"], [FORCE], None, "the grid is the same for all fingers"),
        ([], [FORCE], None, "name at least one parameter"),
        (GAP, [FORCE, "mean_force"], None, "ask for one kind"),
        (GAP, ["time"], None, "not a signal"),
        *[(GAP, [FORCE], time, "time: expected") for time in TIMES],
    ],
)
def test_what_does_not_exist_and_wrong_times_are_refused(free, names, time, words):
    with pytest.raises(InputError, match=words):
        population(SCENARIO, free, names, time=time)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({SKIN: [], FRICTION: []}, "at least one finger"),
        ({"contact.area": [1e-4]}, "not a free parameter"),
        ({SKIN: [1e-4, 2e-4], FRICTION: [0.5]}, "one value for each finger"),
    ],
)
def test_wrong_draws_are_refused(given, words):
    with pytest.raises(InputError, match=words):
        population(SCENARIO, FREE).signals(given)
    engine = OneByOne(ev.load(SCENARIO), FREE, (FORCE,), np.array([0.0, 1e-3]))
    with pytest.raises(InputError, match=r"finger 1 of the call: stack.stratum_corneum.thickness = 1,"):
        engine.signals({SKIN: np.array([1e-4, 1.0]), FRICTION: np.array([0.5, 0.5])})
