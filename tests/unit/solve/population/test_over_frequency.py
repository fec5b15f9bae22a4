"""Signals over frequency of fingers in arrays are those of the same fingers one by one."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest

import electrovib as ev
from electrovib.solve.one_by_one import OneByOne
from electrovib.solve.population import population

_SPEC = importlib.util.spec_from_file_location("fingers_of", Path(__file__).with_name("fingers_of.py"))
fingers_of = importlib.util.module_from_spec(_SPEC)
_SPEC.loader.exec_module(fingers_of)
draw = fingers_of.draw

EQUAL = 1e-12
SIGNALS = ("mean_force", "impedance", "field_gain", "permittivity")
CASES = {
    "vezzoli_2014/fig6_gap": ("stack.gap.thickness", "stack.gap.material.conductivity", "contact.area"),
    "vezzoli_2014/fig6": ("stack.stratum_corneum.thickness", "stack.insulator.material.permittivity"),
    "vezzoli_2014/fig7": (
        "stack.stratum_corneum.thickness",
        "stack.stratum_corneum.material.permittivity",
        "stack.stratum_corneum.material.exponent",
        "stack.stratum_corneum.material.conductivity",
        "drive.amplitude",
    ),
    "vardar_2017/sine": ("stack.stratum_corneum.material.permittivity", "circuit.source_resistance"),
    "rauf_2025/relaxor": (
        "stack.insulator.material.terms.0.strength",
        "stack.insulator.material.terms.0.broadening",
        "circuit.return_path.area",
    ),
    "bau_2010/sine": ("drive.amplitude", "stack.insulator.thickness"),
}


def both(scenario, free, names, count=3, spread=0.2):
    member = ev.load(scenario)
    many = population(member, free, names)
    given = draw(member, free, count, spread=spread)
    return many, given, many.signals(given), OneByOne(member, free, names, None).signals(given)


@pytest.mark.parametrize("scenario", CASES)
def test_signals_agree_with_one_by_one(scenario):
    names = SIGNALS + (("effective_voltage_gain",) if scenario.startswith("vezzoli_2014/fig7") else ())
    many, _, found, expected = both(scenario, CASES[scenario], names)
    assert many.method.startswith("together")
    for name in names:
        assert found[name].shape == expected[name].shape
        np.testing.assert_allclose(found[name], expected[name], rtol=EQUAL)


def test_a_conductivity_of_0_among_others():
    free = ["stack.gap.material.conductivity", "stack.gap.thickness"]
    many, given, _, _ = both("vezzoli_2014/fig6_gap", free, ["mean_force"], 5)
    given[free[0]][[1, 4]] = 0.0
    found = many.signals(given)["mean_force"]
    expected = OneByOne(many.scenario, free, ("mean_force",), None).signals(given)["mean_force"]
    assert np.max(np.abs(found - expected) / np.max(expected, axis=1, keepdims=True)) < EQUAL


def test_a_finger_does_not_depend_on_the_others():
    scenario = "vezzoli_2014/fig7"
    many, given, _, _ = both(scenario, CASES[scenario], SIGNALS, 200)
    whole = many.signals(given)
    for size, places in ((1, (0, 70, 199)), (7, (0, 60, 130))):
        for begin in places:
            part = many.signals({path: values[begin : begin + size] for path, values in given.items()})
            for name in SIGNALS:
                np.testing.assert_allclose(part[name], whole[name][begin : begin + size], rtol=1e-14)


@pytest.mark.parametrize(
    ("scenario", "free", "name", "words"),
    [
        ("kaczmarek_2006/gap_positive", "contact.area", "mean_force", "nonlinear branch"),
        ("bau_2010/sine", "drive.frequency", "mean_force", "more of the drive than its amplitude"),
        ("persson_2018/coating", "stack.insulator.thickness", "mean_force", "does not run on arrays"),
    ],
)
def test_what_is_one_by_one_has_a_reason(scenario, free, name, words):
    many, _, found, expected = both(scenario, [free], [name], 2)
    assert many.method.startswith("one by one: ")
    assert words in many.method
    np.testing.assert_array_equal(found[name], expected[name])
