"""The posterior of a well determined fit, and diagnostics of chains that are too short."""

import sys

import numpy as np
import pytest
from twins import FILM, GAP, exact, noisy, plate

from electrovib.core.errors import InputError
from electrovib.recordings.fit import CancelledError, fit_scenario
from electrovib.recordings.fit.posterior import sample_posterior


@pytest.fixture(scope="module")
def found():
    few = np.geomspace(1e2, 1e5, 6)
    trace = noisy(exact(plate(), "impedance", frequencies=few), np.random.default_rng(1), noise=0.001)
    return fit_scenario(plate(), trace, free=[GAP, FILM])


@pytest.mark.slow
def test_it_agrees_with_the_covariance_where_that_holds(found):
    posterior = sample_posterior(found, seed=1, steps=8000)
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
    assert together == pytest.approx(found.correlation[0][1], abs=0.1)


def test_the_seed_decides_and_short_chains_say_so(found):
    one, same, other = (sample_posterior(found, seed=seed, steps=30) for seed in (1, 1, 2))
    assert (one.samples[GAP] == same.samples[GAP]).all()
    assert not np.array_equal(one.samples[GAP], other.samples[GAP])
    assert "autocorrelation times long" in one.problems[0]


def test_it_can_be_cancelled_and_refuses_few_chains(found, monkeypatch):
    with pytest.raises(CancelledError):
        sample_posterior(found, seed=1, steps=30, progress=lambda done, _: done == 2)
    with pytest.raises(InputError, match="even number of at least 4"):
        sample_posterior(found, seed=1, walkers=5)
    with pytest.raises(InputError, match="at least 20"):
        sample_posterior(found, seed=1, steps=3)
    monkeypatch.setitem(sys.modules, "emcee", None)
    with pytest.raises(InputError, match=r"pip install 'electrovib\[fit\]'"):
        sample_posterior(found, seed=1)
