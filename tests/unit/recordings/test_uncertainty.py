"""Systematic errors by the calibration of the signals, and the posterior of a well determined fit."""

import sys

import numpy as np
import pytest
from twins import FILM, GAP, LEAK, exact, noisy, plate

from electrovib.core.errors import InputError
from electrovib.recordings.fit.least_squares import FreeParameter
from electrovib.recordings.fit.measured import MeasuredTrace
from electrovib.recordings.fit.of_scenario import (
    Posterior,
    Sampling,
    _summary,
    fit_scenario,
    sample_posterior,
)
from electrovib.recordings.fit.problem import CancelledError
from electrovib.recordings.fit.result import parameter_table, systematic_deviations
from electrovib.recordings.recording import CalibrationError

FORCE = "electrostatic_force"
PLATE = plate()
FREE = [GAP, LEAK]


@pytest.fixture(scope="module")
def step():
    return noisy(exact(PLATE, "step"), np.random.default_rng(1), noise=0.003)


def fitted(trace, error=None, **more):
    given = {} if error is None else {"calibration": {FORCE: CalibrationError(**error)}}
    return fit_scenario(PLATE, MeasuredTrace(trace=trace, **given, **more), free=FREE)


@pytest.mark.parametrize("error", [{"gain": 1e-3}, {"zero": 1e-6}])
def test_it_is_the_change_of_a_fit_to_changed_data(step, error):
    changed = step.copy(deep=True)
    changed[FORCE].values[:] = changed[FORCE].values * (1 + error.get("gain", 0)) + error.get("zero", 0)
    plain, moved = fitted(step, error), fitted(changed, error)
    found = systematic_deviations(plain)
    for name in FREE:
        change = abs(moved.estimate.values[name] - plain.estimate.values[name])
        assert found[name] == pytest.approx(change, rel=0.02)
    row = parameter_table(plain)[0]
    assert row.systematic == found[GAP]
    assert row.systematic_ends[1] - row.value == pytest.approx(1.96 * found[GAP], rel=1e-3)


def test_gain_and_zero_combine_with_their_covariance_and_a_free_zero_takes_the_zero_up(step):
    gain, zero = {"gain": 1e-3}, {"zero": 1e-6}
    one, other, both, opposed = (
        systematic_deviations(fitted(step, each))[GAP]
        for each in (gain, zero, gain | zero, gain | zero | {"covariance": -1e-9})
    )
    assert both == pytest.approx(np.hypot(one, other), rel=1e-6)
    assert opposed == pytest.approx(abs(one - other), rel=1e-6)
    assert systematic_deviations(fitted(step, zero, offsets=[FORCE]))[GAP] < 1e-6 * other


def test_recordings_and_sessions_share_the_error_of_a_sensor(step):
    error = CalibrationError(gain=0.01)
    alone = systematic_deviations(fitted(step, {"gain": 0.01}))[LEAK]
    data = [MeasuredTrace(trace=step, name=name, session=name, calibration={FORCE: error}) for name in "abc"]
    together = systematic_deviations(fit_scenario(PLATE, data, free=FREE, varying=[LEAK]))
    assert together[LEAK] == pytest.approx(alone, rel=1e-3)  # of the mean: it does not average out
    assert together[f"{LEAK} [a]"] == pytest.approx(alone, rel=1e-3)
    different = [
        MeasuredTrace(trace=step, name=name, calibration={FORCE: CalibrationError(gain=gain)})
        for name, gain in (("a", 0.01), ("b", 0.0100001))
    ]
    two = systematic_deviations(fit_scenario(PLATE, different, free=FREE))
    assert two[LEAK] == pytest.approx(alone / np.sqrt(2), rel=1e-3)  # two sensors are independent


def test_it_is_unknown_without_a_statement(step):
    found = fitted(step)
    assert systematic_deviations(found) == {}
    assert np.isnan(parameter_table(found)[0].systematic)
    with pytest.raises(InputError, match="0 or more"):
        CalibrationError(gain=-0.1)
    with pytest.raises(InputError, match="product of both"):
        CalibrationError(gain=0.1, zero=1.0, covariance=0.2)


@pytest.fixture(scope="module")
def found():
    few = np.geomspace(1e2, 1e5, 6)
    trace = noisy(exact(plate(), "impedance", frequencies=few), np.random.default_rng(1), noise=0.001)
    return fit_scenario(plate(), trace, free=[GAP, FILM])


@pytest.mark.slow
def test_it_agrees_with_the_covariance_where_that_holds(found):
    posterior = sample_posterior(found, Sampling(seed=1, steps=8000))
    assert posterior.problems == (), posterior.problems
    assert 0.5 < posterior.acceptance < 0.8
    for name in (GAP, FILM):
        deviation = found.estimate.standard_deviations[name]
        assert np.mean(posterior.samples[name]) == pytest.approx(
            found.estimate.values[name], abs=0.15 * deviation
        )
        assert np.std(posterior.samples[name]) == pytest.approx(deviation, rel=0.1)
        lower, upper = posterior.interval(name)
        assert (upper - lower) / 2 == pytest.approx(1.96 * deviation, rel=0.1)
    together = np.corrcoef(posterior.samples[GAP], posterior.samples[FILM])[0, 1]
    assert together == pytest.approx(found.estimate.correlation[0][1], abs=0.1)


def test_the_seed_decides_and_short_chains_say_so(found):
    one, same, other = (sample_posterior(found, Sampling(seed=seed, steps=30)) for seed in (1, 1, 2))
    assert (one.samples[GAP] == same.samples[GAP]).all()
    assert not np.array_equal(one.samples[GAP], other.samples[GAP])
    assert "autocorrelation times long" in one.problems[0]


def test_it_can_be_cancelled_and_refuses_few_chains(found, monkeypatch):
    with pytest.raises(CancelledError):
        sample_posterior(found, Sampling(seed=1, steps=30, progress=lambda done, _: done == 2))
    with pytest.raises(InputError, match="even number of at least 4"):
        sample_posterior(found, Sampling(seed=1, walkers=5))
    with pytest.raises(InputError, match="at least 20"):
        sample_posterior(found, Sampling(seed=1, steps=3))
    monkeypatch.setitem(sys.modules, "emcee", None)
    with pytest.raises(InputError, match=r"pip install 'electrovib\[fit\]'"):
        sample_posterior(found, Sampling(seed=1))


def test_the_interval_of_a_posterior_lies_between_quantiles_of_its_samples():
    numbers = {
        "chains": {},
        "autocorrelation_time": {},
        "log_density": np.zeros(1),
        "burn_in": 0,
        "acceptance": 0.5,
        "steps": 1,
        "seed": 0,
        "problems": (),
    }
    found = Posterior(samples={"a": np.linspace(0.0, 1.0, 1001)}, **numbers)
    assert found.interval("a") == pytest.approx((0.025, 0.975))
    assert found.interval("a", level=0.5) == pytest.approx((0.25, 0.75))


@pytest.mark.parametrize(("accepted", "told"), [(0.1, True), (0.5, False), (0.9, True)])
def test_chains_that_accept_too_few_or_too_many_proposals_are_told(accepted, told):
    class Sampler:
        acceptance_fraction = np.full(4, accepted)

        def get_autocorr_time(self, **_):
            return np.array([1.0])

        def get_chain(self):
            return np.zeros((400, 4, 1))

        def get_log_prob(self):
            return np.zeros((400, 4))

    problems = _summary(Sampler(), {"a": FreeParameter(start=1.0)}, Sampling(seed=0, steps=400)).problems
    assert any("of the proposals were accepted" in each for each in problems) == told
