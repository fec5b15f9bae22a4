"""Draws of fingers, and the comparison of arrays over fingers with the same fingers one by one."""

from types import SimpleNamespace

import numpy as np
import pytest

import electrovib as ev
from electrovib.core.paths import quantity_at, value_at
from electrovib.solve.one_by_one import ParametricScenario
from electrovib.solve.population import Population

OVER_TIME = ("electrostatic_force", "lateral_force", "normal_force", "drive_voltage", "stack_voltage")
OVER_TIME += ("interface_field", "field", "displacement")
FOR_ZERO = {"S/m": 1e-8, "ohm": 1e4, "V": 20.0, "C/m2": 1e-6, "C": 1e-9, "s": 1e-4, "1": 0.1, "N": 0.1}
FOR_ZERO |= {"m/s": 0.05, "rad": 0.5}
"""A typical value of a parameter that is 0 in a scenario, by its unit."""
EQUAL = 1e-12
"""Of the peak. Rounding of the time decides what remains of the fastest mode of a current after a corner."""


def draw(scenario, free, count, seed=1, spread=0.3):
    """Values around those of the scenario."""
    rng, found = np.random.default_rng(seed), {}
    for path in free:
        quantity, value = quantity_at(scenario, path), value_at(scenario, path)
        some = (value or FOR_ZERO[quantity.unit]) * rng.uniform(1 - spread, 1 + spread, count)
        found[path] = np.clip(some, quantity.low, quantity.high)
    return found


def times_of(scenario, every=40):
    return scenario.time.times(scenario.drive)[::every]


def close(one, other):
    """Whether signals agree to 1e-12 of the peak, NaN included."""
    peak = np.nanmax(np.abs(other), initial=0.0)
    return np.allclose(one, other, rtol=0, atol=EQUAL * peak, equal_nan=True)


def difference(scenario, free, names=OVER_TIME, count=3, seed=1, draws=None, time=None):
    """Largest difference over the peak of a signal of one finger, by name, and how the fingers were computed.

    Over frequency, over the value itself.
    """
    member = ev.load(scenario)
    if time is None and "mean_force" not in names:
        time = times_of(member)
    many = Population(member, free, names, time)
    given = draw(member, free, count, seed) if draws is None else draws
    found = many.signals(given)
    expected = ParametricScenario(member, free).of_many(many.columns(given), names=names, time=many.time)
    worst = dict.fromkeys(names, 0.0)
    for name in names:
        np.testing.assert_array_equal(np.isnan(found[name]), np.isnan(expected[name]))
        assert found[name].shape == expected[name].shape
        for mine, its in zip(found[name], expected[name], strict=True):
            known = ~np.isnan(its)
            size = np.abs(its[known])
            gaps = np.abs(mine - its)[known]
            if many.time is not None:
                size = np.max(size, initial=0.0)
            with np.errstate(invalid="ignore"):
                gaps = np.where(gaps > 0, gaps / size, 0.0)
            worst[name] = max(worst[name], np.max(gaps, initial=0.0))
    return worst, many.method


def assert_together(scenario, free, names=OVER_TIME, **given):
    """Check that fingers are computed in arrays, and have the signals that each has by itself."""
    worst, method = difference(scenario, free, names, **given)
    assert method.startswith("together"), method
    assert all(worst[name] < EQUAL for name in names), worst


@pytest.fixture(scope="session")
def fingers():
    names = (OVER_TIME, draw, times_of, close, difference, assert_together)
    return SimpleNamespace(OVER_TIME=OVER_TIME, **{each.__name__: each for each in names[1:]})
