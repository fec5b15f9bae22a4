"""Sliders and choices, made from the declarations of every shipped scenario."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

import electrovib as ev
from electrovib.apps.explorer.choices import AS_GIVEN, choices, chosen
from electrovib.apps.explorer.controls import STEPS, Control, controls
from electrovib.apps.explorer.declared import blanks, parameters_of
from electrovib.apps.explorer.state import PageState, presets, read_query, scenario_of
from electrovib.core.errors import ElectrovibError
from electrovib.core.paths import value_at
from electrovib.physics.perception import ElasticSkin, Perception

COMPLIANCE = "Compliance of the skin (perception)"


def log(low=1e-6, value=1e-4, high=1e-2):
    return Control("a.b_c", "what", "m", "", value, low, high, (low, high), is_logarithmic=True)


@pytest.mark.parametrize("name", presets())
def test_every_scenario_has_sliders_that_begin_at_its_values(name):
    scenario = ev.load(name)
    found, values = controls(scenario), {path: value for path, value, _ in parameters_of(scenario)}
    assert len(found) > 8
    for each in found:
        assert each.value == values[each.path]
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
    assert list(by_label) == ["Drive", "Force law", "Skin", "Insulator", COMPLIANCE]
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


@pytest.mark.parametrize("place", range(5))
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
    assert fitting >= min(4, len(choice.options) - 1)


def test_a_perception_can_be_declared_where_a_scenario_has_none():
    scenario = ev.load("vezzoli_2014/fig6_gap")
    assert scenario.perception is None
    rows = {each.path: each for each in controls(scenario)}
    empty = {each.path for each in blanks(scenario)}
    assert {"perception.threshold", "perception.threshold_uncertainty"} <= empty
    assert rows["perception.window"].value == Perception().window
    assert not any(path.startswith("perception.channels") for path in rows)
    state = PageState("vezzoli_2014/fig6_gap").changed("perception.window", "0.2 s")
    changed = scenario_of(state, own={})
    assert changed.perception == Perception(window=0.2)
    by_path = {each.path: each for each in controls(changed)}
    channel = by_path["perception.channels.0.best_frequency"]
    assert (channel.name, channel.is_detail) == ("channel 1, best frequency", True)
    assert not by_path["perception.window"].is_detail


def test_a_calibrated_perception_survives_the_link():
    name = "vezzoli_2014/fig6_gap"
    *_, choice = choices(ev.load(name))
    assert (choice.label, choice.options[AS_GIVEN]) == (COMPLIANCE, "none")
    state = chosen(PageState(name), choice, "ElasticSkin", {})
    state = state.changed("perception.compliance.stiffness", "2 kN/m")
    state = state.changed("perception.threshold", "1 um").changed("perception.threshold_uncertainty", "3")
    again = read_query(state.to_query(), own={}, default=name)
    scenario = scenario_of(again, own={})
    wanted = Perception(compliance=ElasticSkin(stiffness=2000), threshold=1e-6, threshold_uncertainty=3)
    assert scenario.perception == wanted
    assert choice.present(again, scenario) == "ElasticSkin"
    viscous = chosen(again, choice, "ElasticViscousSkin", {})
    changed = scenario_of(viscous, own={}).perception
    assert (changed.compliance.stiffness, changed.threshold) == (2000, 1e-6)
    assert scenario_of(chosen(again, choice, AS_GIVEN, {}), own={}).perception.compliance is None


def test_a_link_that_gives_a_whole_perception_shows_its_compliance():
    table = "{ compliance = { model = 'ElasticSkin', stiffness = 1000 } }"
    state = PageState("bau_2010/sine", {"perception": table})
    scenario = scenario_of(state, own={})
    (choice,) = [each for each in choices(ev.load("bau_2010/sine")) if each.label == COMPLIANCE]
    assert choice.present(state, scenario) == "ElasticSkin"
    (without,) = [each for each in choices(scenario) if each.label == COMPLIANCE]
    assert without.options[AS_GIVEN] == "ElasticSkin, as in the scenario"
    plain = PageState("bau_2010/sine", {"perception": "{ window = 1 }"})
    assert choice.present(plain, scenario_of(plain, own={})) == AS_GIVEN
