"""Draws of fingers, and the comparison of arrays over fingers with the same fingers one by one."""

import numpy as np

import electrovib as ev
from electrovib.core.paths import quantity_at, value_at
from electrovib.solve.one_by_one import OneByOne
from electrovib.solve.population import population

OVER_TIME = (
    "electrostatic_force",
    "lateral_force",
    "normal_force",
    "drive_voltage",
    "stack_voltage",
    "interface_field",
    "field",
    "displacement",
)
FOR_ZERO = {
    "S/m": 1e-8,
    "ohm": 1e4,
    "V": 20.0,
    "C/m2": 1e-6,
    "C": 1e-9,
    "s": 1e-4,
    "1": 0.1,
    "N": 0.1,
    "m/s": 0.05,
    "rad": 0.5,
}
"""A typical value of a parameter that is 0 in a scenario, by its unit."""


def draw(scenario, free, count, seed=1, spread=0.3):
    """Values around those of the scenario."""
    rng = np.random.default_rng(seed)
    found = {}
    for path in free:
        quantity, value = quantity_at(scenario, path), value_at(scenario, path)
        middle = value or FOR_ZERO[quantity.unit]
        found[path] = np.clip(
            middle * rng.uniform(1 - spread, 1 + spread, count), quantity.low, quantity.high
        )
    return found


def times_of(scenario, every=40):
    return scenario.time.times(scenario.drive)[::every]


def difference(scenario, free, names=OVER_TIME, count=3, seed=1, draws=None, time=None):
    """Largest difference over the peak of a signal of one finger, and how the fingers were computed."""
    member = ev.load(scenario)
    time = times_of(member) if time is None else time
    many = population(member, free, names, time)
    given = draw(member, free, count, seed) if draws is None else draws
    found = many.signals(given)
    expected = OneByOne(member, free, names, time).signals(many.columns(given))
    worst = 0.0
    for name in names:
        np.testing.assert_array_equal(np.isnan(found[name]), np.isnan(expected[name]))
        for mine, its in zip(found[name], expected[name], strict=True):
            peak = np.max(np.abs(its[~np.isnan(its)]), initial=0.0)
            gap = np.max(np.abs(mine - its)[~np.isnan(its)], initial=0.0)
            worst = max(worst, gap / peak if peak else gap)
    return worst, many.method
