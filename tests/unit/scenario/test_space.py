"""Parameters by path, with distributions and relations."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

import electrovib as ev
from electrovib.core.errors import InputError
from electrovib.scenario.distributions import Empirical, LogNormal, LogUniform, Normal, Triangular, Uniform
from electrovib.scenario.space import read_space
from electrovib.solve.prepare import prepare

SINE = "bau_2010/sine"
FILM, SKIN = "stack.insulator.thickness", "stack.stratum_corneum.thickness"
REFERENCES = [
    (Uniform(low=2.0, high=5.0), stats.uniform(2, 3)),
    (LogUniform(low=2.0, high=5.0), stats.loguniform(2, 5)),
    (Normal(mean=1.0, deviation=2.0), stats.norm(1, 2)),
    (Normal(mean=1.0, deviation=2.0, low=0.0, high=2.5), stats.truncnorm(-0.5, 0.75, loc=1, scale=2)),
    (LogNormal(median=3.0, factor=1.5), stats.lognorm(math.log(1.5), scale=3)),
    (Triangular(low=1.0, likely=2.0, high=5.0), stats.triang(0.25, loc=1, scale=4)),
]


@pytest.mark.parametrize(("ours", "reference"), REFERENCES, ids=lambda each: type(each).__name__)
def test_values_are_those_of_scipy(ours, reference):
    shares = np.linspace(0.001, 0.999, 999)
    np.testing.assert_allclose(ours.value(shares), reference.ppf(shares), rtol=1e-9, atol=1e-12)


def test_measured_values_are_equally_likely():
    shares = (np.arange(300) + 0.5) / 300
    found = Empirical(values=(3.0, 1.0, 2.0)).value(shares)
    assert [int(np.count_nonzero(found == value)) for value in (1.0, 2.0, 3.0)] == [100, 100, 100]


@given(st.sampled_from([ours for ours, _ in REFERENCES]), st.floats(1e-9, 1 - 1e-9))
def test_no_value_lies_beyond_the_ends(ours, share):
    low, high = ours.ends
    assert low <= float(ours.value(np.array(share))) <= high


def space(**changes):
    table = {
        FILM: {"model": "Normal", "mean": "1 um", "deviation": "0.1 um", "low": "0.5 um", "high": "2 um"},
        SKIN: {"model": "LogNormal", "median": "200 um", "factor": 1.3},
    }
    return read_space(ev.load(SINE), table | changes.pop("table", {}), **changes)


def test_a_space_is_read_in_the_units_of_its_parameters_and_feeds_a_prepared_scenario():
    found = space(relations=[f"{FILM} < {SKIN}"])
    assert found.paths == (FILM, SKIN)
    assert found.distributions[FILM] == Normal(mean=1e-6, deviation=1e-7, low=5e-7, high=2e-6)
    values = found.values(np.array([[0.5, 0.9], [0.5, 0.1]]))
    assert values[FILM][0] == pytest.approx(1e-6)
    assert list(found.allowed(values)) == [True, True]
    force = prepare(SINE, free=found.paths, quantities=["mean electrostatic_force"])(values)
    assert force["mean electrostatic_force"].shape == (2,)


def test_relations_are_told_apart():
    found = space(relations=[f"{SKIN} < {FILM}"])
    values = {FILM: np.array([1.0, 2.0, 3.0]), SKIN: np.array([2.0, 2.0, 2.0])}
    assert list(found.allowed(values)) == [False, False, True]


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (
            {"table": {"stack.insulator.thicknes": {"model": "Uniform"}}},
            "Did you mean 'stack.insulator.thickness'",
        ),
        ({"table": {FILM: {"model": "Norml"}}}, "Did you mean 'Normal'"),
        ({"table": {FILM: {"model": "Normal", "mean": "1 um"}}}, "deviation: missing"),
        ({"table": {FILM: {"model": "Uniform", "low": "1 um", "hihg": "2 um"}}}, "Did you mean 'high'"),
        ({"table": {FILM: {"model": "Uniform", "low": "2 um", "high": "1 um"}}}, "expected more than low"),
        ({"table": {FILM: {"model": "Uniform", "low": "1 V", "high": "2 um"}}}, "low = 1 V"),
        ({"table": {FILM: {"model": "Uniform", "low": True, "high": "2 um"}}}, "low = True"),
        ({"table": {FILM: {"model": "Uniform", "low": "1 um", "high": "2 km"}}}, "allowed is"),
        ({"relations": [f"{FILM} > {SKIN}"]}, "expected PATH < PATH"),
        ({"relations": [f"{FILM} < contact.area"]}, "'contact.area' is not in the space"),
    ],
)
def test_mistakes_are_one_sentence(changes, words):
    with pytest.raises(InputError, match=words):
        space(**changes)
