"""Sliders and choices, made from the declarations of every shipped scenario."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

import electrovib as ev
from electrovib.apps.explorer.choices import AS_GIVEN, choices, chosen
from electrovib.apps.explorer.controls import STEPS, Control, controls
from electrovib.apps.explorer.declared import blanks
from electrovib.apps.explorer.state import PageState, presets, scenario_of
from electrovib.core.errors import ElectrovibError
from electrovib.core.paths import value_at


def log(low=1e-6, value=1e-4, high=1e-2):
    return Control("a.b_c", "what", "m", "", value, low, high, (low, high), is_logarithmic=True)


@pytest.mark.parametrize("name", presets())
def test_every_scenario_has_sliders_that_begin_at_its_values(name):
    scenario = ev.load(name)
    found = controls(scenario)
    assert len(found) > 8
    for each in found:
        assert each.value == value_at(scenario, each.path)
        assert each.allowed[0] <= each.low < each.high <= each.allowed[1]
        assert each.low <= each.value <= each.high
        assert each.at(each.position(each.value)) == each.value
        assert each.meaning in each.help
        assert each.path in each.help
        assert not each.is_logarithmic or each.low > 0


@pytest.mark.parametrize("name", ["vezzoli_2014/fig6_gap", "kang_2017/both"])
def test_both_ends_of_every_slider_are_valid_values(name):
    """A single parameter at its end may contradict another one, and is then refused with a sentence, never a traceback."""
    scenario = ev.load(name)
    for each in controls(scenario):
        for position in (0, STEPS):
            state = PageState(name).changed(each.path, each.written(each.at(position)))
            try:
                assert value_at(scenario_of(state, own={}), each.path) == pytest.approx(
                    each.at(position), rel=1e-3, abs=1e-300
                )
            except ElectrovibError as error:
                assert each.path.partition(".")[0] in str(error)


def test_positions_of_a_logarithmic_slider_are_equal_ratios():
    each = log()
    assert [each.at(position) for position in (0, 250, 750, STEPS)] == pytest.approx([1e-6, 1e-5, 1e-3, 1e-2])
    assert [each.position(value) for value in (1e-7, 1e-6, 1e-5, 1e-2, 1.0)] == [0, 0, 250, STEPS, STEPS]


@given(st.floats(-5e3, 5e3), st.integers(0, STEPS))
def test_positions_of_a_linear_slider(value, position):
    each = Control("a.b", "what", "V", "", 0.0, -1e3, 3e3, (-1e5, 1e5), is_logarithmic=False)
    assert each.at(position) == pytest.approx(-1e3 + 4e3 * position / STEPS, abs=1e-9)
    assert -1e3 <= each.at(each.position(value)) <= 3e3
    assert each.position(each.at(position)) == position


def test_a_value_that_spans_decades_has_a_logarithmic_slider_around_it():
    by_path = {each.path: each for each in controls(ev.load("vezzoli_2014/fig6_gap"))}
    thickness = by_path["stack.gap.thickness"]
    assert thickness.is_logarithmic
    assert (thickness.low, thickness.high) == pytest.approx((1e-8, 1e-4))
    assert not by_path["drive.high"].is_logarithmic
    assert by_path["drive.high"].low < 0
    assert by_path["drive.delay"].low == 0
    assert "Vezzoli 2014" in by_path["drive.high"].help


def test_choices_name_what_a_scenario_takes():
    by_label = {each.label: each for each in choices(ev.load("vezzoli_2014/fig6_gap"))}
    assert list(by_label) == ["Drive", "Force law", "Skin", "Insulator"]
    assert by_label["Skin"].options["gabriel_1996/dry"].startswith("dry finger")
    assert all(next(iter(each.options)) == AS_GIVEN for each in by_label.values())
    without = ev.load("rauf_2025/field_3")
    assert "stratum_corneum" not in without.stack.layers
    assert "Skin" not in {each.label for each in choices(without)}


def test_a_parameter_without_a_value_has_an_empty_field():
    scenario = ev.load("vezzoli_2014/fig6_gap")
    empty = {each.path: each for each in blanks(scenario)}
    assert {"limits.voltage", "drive.repeat", "time.duration"} <= set(empty)
    assert not set(empty) & {each.path for each in controls(scenario)}
    assert (
        empty["limits.voltage"].help
        == "largest voltage of the plate (limits.voltage); allowed from 1 mV to 1 MV."
    )


def test_what_is_written_has_the_letters_of_its_unit_and_is_read_again():
    by_path = {each.path: each for each in controls(ev.load("vezzoli_2014/fig6_gap"))}
    thickness = by_path["stack.gap.thickness"]
    assert thickness.written(thickness.value) == "1 µm"
    changed = ev.load("vezzoli_2014/fig6_gap").replace({"stack.gap.thickness": thickness.written(2e-6)})
    assert changed.stack.layers["gap"].thickness == pytest.approx(2e-6)
    assert "slider from 10 nm to 100 µm, logarithmic. Source: not in the paper" in thickness.help
    assert by_path["stack.gap.material.permittivity"].name == "gap, permittivity"


@pytest.mark.parametrize("place", range(4))
def test_every_choice_gives_a_scenario_or_a_sentence(place):
    name = "vezzoli_2014/fig6_gap"
    choice = choices(ev.load(name))[place]
    fitting = 0
    for value in choice.options:
        state = chosen(PageState(name), choice, value, {})
        try:
            changed = scenario_of(state, own={})
        except ElectrovibError as error:
            assert str(error)
        else:
            assert choice.present(state, changed) == value
            fitting += changed != ev.load(name)
    assert fitting >= min(4, len(choice.options) - 2)
