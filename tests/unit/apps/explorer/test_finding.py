"""Which parameters come first on the page, held against the elasticities of the forces, and which ones words find."""

import numpy as np
import pytest

import electrovib as ev
from electrovib.apps.explorer.computed import compute
from electrovib.apps.explorer.controls import controls
from electrovib.apps.explorer.page.knobs import (
    MOST_IMPORTANT,
    important,
    is_found,
    not_found,
    texts_of,
    words_of,
)
from electrovib.apps.explorer.state import presets
from electrovib.core.errors import InputError

GAP = "vezzoli_2014/fig6_gap"
OFFERED = controls(ev.load(GAP))
STEP = 0.01
"""Relative step of the finite differences."""
LARGE = 1 / 3
"""Part of the largest elasticity of a force from which that of a parameter is large."""
AIR = ".gap.material.permittivity"
"""Not among the important ones where it is 1: it is then that of air, which nobody changes."""
TWO_PULSES = {"drive.drives.0.hold", "drive.drives.1.delay"}
"""Times of two pulses after each other, of which there are seven: they would fill the group; `Drive` is the next section."""
SLOW = (
    "kaczmarek_2006/skin_",
    "kaczmarek_2006/gap_",
    "vezzoli_2014/fig2_tremor",
    "rauf_2025/relaxor",
    "persson_2018",
)
"""Scenarios that take seconds for all parameters: most of them advance in steps."""
FIRST = {name.partition("/")[0]: name for name in reversed(presets()) if not name.startswith(SLOW)}.values()
"""One scenario of each paper; the others are slow together."""


def peaks(scenario):
    """Return the largest value of each force."""
    found = compute(scenario)
    names = [each for each in ("electrostatic_force", "lateral_force") if found.has(each)]
    return {each: float(np.max(found.values(each))) for each in names}


def elasticity(scenario, control, before):
    """Return the relative change of each force over that of a parameter."""
    for step in (STEP, -STEP):  # one of both may be beyond the range
        try:
            after = peaks(scenario.replace({control.path: control.value * (1 + step)}))
        except InputError:
            continue
        return {name: abs((after[name] / old - 1) / step) for name, old in before.items() if old > 0}
    raise AssertionError(control.path)


@pytest.mark.parametrize(
    "name",
    [pytest.param(each, marks=() if each in FIRST else pytest.mark.slow) for each in presets()],
)
def test_parameters_with_a_large_elasticity_of_a_force_come_first(name):
    scenario = ev.load(name)
    offered = controls(scenario)
    before, first = peaks(scenario), {each.path for each in important(offered)}
    found = {each.path: elasticity(scenario, each, before) for each in offered if each.value}
    assert 6 <= len(first) <= MOST_IMPORTANT
    for force in before:
        largest = max(each.get(force, 0) for each in found.values())
        large = {path for path, each in found.items() if each.get(force, 0) > LARGE * largest > 0}
        missing = {path for path in large - first if not path.endswith(AIR)}
        assert missing <= (TWO_PULSES if "biphasic" in name else set()), force


def test_important_parameters_are_few_have_a_value_and_keep_the_order_of_the_page():
    first = important(OFFERED)
    assert first == [each for each in OFFERED if each in first]
    assert all(each.value for each in first)
    paths = [each.path for each in first]
    assert paths[0] == "drive.high"
    assert {"stack.gap.thickness", "contact.area", "load.normal_force", "friction.coefficient"} <= set(paths)
    assert "stack.gap.material.permittivity" not in paths
    filled = controls(ev.load(GAP).replace({"stack.gap.material.permittivity": 2}))
    assert "stack.gap.material.permittivity" in [each.path for each in important(filled)]


def found(typed, offered=OFFERED):
    return [each.path for each in offered if is_found(words_of(typed), texts_of(each))]


@pytest.mark.parametrize(
    ("typed", "expected"),
    [
        ("GAP Thick", ["stack.gap.thickness"]),
        ("thickness gap", ["stack.gap.thickness"]),
        ("stack.gap.thickness", ["stack.gap.thickness"]),
        ("normal_force", ["load.normal_force"]),  # name
        ("skin thickness", ["stack.stratum_corneum.thickness"]),
        ("time at the high", ["drive.hold"]),  # meaning
        ("limits slew", ["limits.slew_rate"]),  # section
        ("gap drive", []),
    ],
)
def test_every_word_that_is_typed_has_to_occur_in_any_case_and_order(typed, expected):
    assert found(typed) == expected


def test_nothing_typed_finds_everything_and_nothing_found_gives_the_nearest_name():
    assert found("") == found(" _ ") == [each.path for each in OFFERED]
    for typed, sentence in (
        ("gap thiknes", "No parameter is called 'thiknes'. Did you mean 'thickness'?"),
        ("gap drive", "No parameter has all of these words; leave one out."),
    ):
        assert not_found(words_of(typed), OFFERED) == sentence
    assert "Known: amplifier, " in not_found(["zzz"], OFFERED)
