"""Sliders and choices from the declarations of every scenario, and what stays when a part is replaced."""

import itertools

import pytest
from hypothesis import given
from hypothesis import strategies as st

import electrovib as ev
from electrovib.apps.explorer.computed import FREQUENCY, TIME, Further, compute
from electrovib.apps.explorer.controls import (
    AS_GIVEN,
    STEPS,
    Control,
    carried,
    choices,
    chosen,
    controls,
    inline,
    parameters_of,
)
from electrovib.apps.explorer.page.plots import content
from electrovib.apps.explorer.state import PageState, presets, scenario_of
from electrovib.core.errors import ElectrovibError
from electrovib.core.paths import value_at
from electrovib.core.quantity import quantity_of
from electrovib.physics.drive.current import CurrentSine
from electrovib.physics.drive.sines import Sine
from electrovib.physics.perception import Perception

GAP = "vezzoli_2014/fig6_gap"
SCENARIO = ev.load(GAP)
DRIVE, LAW, SKIN, INSULATOR, COMPLIANCE = choices(SCENARIO)
DRIVES = [name for name in DRIVE.options if name != AS_GIVEN]


def sliders(scenario):
    return [each for each in controls(scenario) if each.value is not None]


def blanks(scenario):
    return [each for each in controls(scenario) if each.value is None]


@pytest.fixture(scope="module")
def by_path():
    return {each.path: each for each in sliders(SCENARIO)}


@pytest.mark.parametrize("name", presets())
def test_every_scenario_has_sliders_that_begin_at_its_values(name):
    scenario = ev.load(name)
    found, values = sliders(scenario), {path: value for path, value, _ in parameters_of(scenario)}
    assert len(found) > 8
    for each in found:
        assert each.value == values[each.path]
        assert each.allowed[0] <= each.low < each.high <= each.allowed[1]
        assert each.low <= each.value <= each.high
        assert each.at(each.position(each.value)) == each.value
        assert each.meaning in each.help
        assert each.path in each.help
        assert not each.is_logarithmic or each.low > 0


@pytest.mark.parametrize("name", [GAP, "kang_2017/both"])
def test_both_ends_of_every_slider_are_valid_values(name):
    """A single parameter at its end may contradict another one, and is then refused with a sentence, never a traceback."""
    for each, position in itertools.product(sliders(ev.load(name)), (0, STEPS)):
        state = PageState(name).changed(each.path, each.written(each.at(position)))
        wanted = pytest.approx(each.at(position), rel=1e-3, abs=1e-300)
        try:
            assert value_at(scenario_of(state, own={}), each.path) == wanted
        except ElectrovibError as error:
            assert each.path.partition(".")[0] in str(error)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["vezzoli_2014/fig6", "bau_2010/sine"])
def test_both_ends_of_every_slider_show_plots_or_a_sentence(name):
    for each, position in itertools.product(sliders(ev.load(name)), (0, STEPS)):
        state = PageState(name).changed(each.path, each.written(each.at(position)))
        try:
            found = compute(scenario_of(state, own={}))
        except ElectrovibError as error:
            assert str(error)
            continue
        for tab in (TIME, FREQUENCY):
            assert content(tab, found, Further()).figures


@given(st.floats(-5e3, 5e3), st.integers(0, STEPS))
def test_positions_of_a_slider_are_equal_steps_or_ratios(value, position):
    each = Control("a.b", "what", "V", "", 0.0, -1e3, 3e3, (-1e5, 1e5), is_logarithmic=False)
    assert each.at(position) == pytest.approx(-1e3 + 4e3 * position / STEPS, abs=1e-9)
    assert -1e3 <= each.at(each.position(value)) <= 3e3
    assert each.position(each.at(position)) == position
    each = Control("a.b_c", "what", "m", "", 1e-4, 1e-6, 1e-2, (1e-6, 1e-2), is_logarithmic=True)
    assert each.at(position) == pytest.approx(1e-6 * 1e4 ** (position / STEPS))
    assert each.position(each.at(position)) == position
    assert [each.position(value) for value in (1e-7, 1.0)] == [0, STEPS]


def test_a_slider_has_range_name_and_source_and_what_it_writes_is_read_again(by_path):
    thickness, high = by_path["stack.gap.thickness"], by_path["drive.high"]
    assert thickness.is_logarithmic
    assert (thickness.low, thickness.high) == pytest.approx((1e-8, 1e-4))
    assert "slider from 10 nm to 100 µm, logarithmic. Source: not in the paper" in thickness.help
    assert thickness.written(thickness.value) == "1 µm"
    changed = SCENARIO.replace({"stack.gap.thickness": thickness.written(2e-6)})
    assert changed.stack.layers["gap"].thickness == pytest.approx(2e-6)
    assert by_path["stack.gap.material.permittivity"].name == "gap, permittivity"
    assert not high.is_logarithmic
    assert high.low < 0 == by_path["drive.delay"].low
    assert "Vezzoli 2014" in high.help


def test_a_parameter_that_can_only_be_0_has_no_slider_and_one_without_a_value_an_empty_field(by_path):
    assert "stack.stratum_corneum.initial_charge" not in by_path  # it would lie on the conducting finger
    zeros = {"drive.low", "drive.delay", "stack.insulator.material.conductivity"}  # which can move
    assert zeros | {"stack.insulator.initial_charge"} <= set(by_path)
    empty = {each.path: each for each in blanks(SCENARIO)}
    assert {"limits.voltage", "drive.repeat", "time.duration"} <= set(empty)
    assert not set(empty) & set(by_path)
    words = "largest voltage of the plate (limits.voltage); allowed from 1 mV to 1 MV."
    assert empty["limits.voltage"].help == words


def test_choices_name_what_a_scenario_takes():
    labels = [each.label for each in choices(SCENARIO)]
    assert labels == ["Drive", "Force law", "Skin", "Insulator", "Compliance of the skin (perception)"]
    assert SKIN.options["gabriel_1996/dry"].startswith("dry finger")
    assert all(next(iter(each.options)) == AS_GIVEN for each in choices(SCENARIO))
    without = ev.load("rauf_2025/field_3")
    assert "stratum_corneum" not in without.stack.layers
    assert "Skin" not in {each.label for each in choices(without)}


@pytest.mark.parametrize("choice", choices(SCENARIO), ids=lambda each: each.label)
def test_every_choice_gives_a_scenario_or_a_sentence(choice):
    fitting = 0
    for value in choice.options:
        state = chosen(PageState(GAP), choice, value, {})
        try:
            changed = scenario_of(state, own={})
        except ElectrovibError as error:
            assert str(error)
        else:
            assert choice.present(state, changed) == value
            fitting += changed != SCENARIO
    assert fitting >= min(4, len(choice.options) - 1)


def after(*names, changes=None, choice=DRIVE, preset=GAP):
    """Return the state and scenario after some choices."""
    state = PageState(preset, changes or {})
    for name in names:
        state = chosen(state, choice, name, {})
    return state, scenario_of(state, own={})


@pytest.mark.parametrize(("first", "second"), list(itertools.product(DRIVES, DRIVES)))
def test_every_pair_of_drives_gives_a_scenario_or_a_sentence_and_exceeds_no_range(first, second):
    state, before = after(first)
    state = chosen(state, DRIVE, second, {})
    try:
        scenario = scenario_of(state, own={})
    except ElectrovibError as error:
        assert str(error)
        return
    old, new = before.drive, scenario.drive
    assert type(new).__name__ == second
    if old.quantity == new.quantity:
        lowest, highest = old.extremes()
        assert new.extremes()[0] >= min(lowest, 0.0) - 1e-9
        assert new.extremes()[1] <= max(highest, 0.0) + 1e-9
        assert new.largest() == pytest.approx(old.largest(), rel=1e-3)
    else:
        assert new.largest() <= {"current": 250e-6, "voltage": 1000.0}[new.quantity] * (1 + 1e-12)
    for name in set(type(old).model_fields) & set(type(new).model_fields) - {"width", "delay"}:
        declared, other = quantity_of(type(new), name), quantity_of(type(old), name)
        if declared and other and declared.unit == other.unit != "V" and second != "PulseTrain":
            assert getattr(new, name) == getattr(old, name)


KILOVOLT = {"drive": '{ model = "Sine", amplitude = "1 kV", frequency = "200 Hz" }'}
FALLING = {"drive": '{ model = "Trapezium", high = -300, low = 0, rise = 0.01, hold = 0.1, fall = 0.01 }'}
STEP = {"drive": '{ model = "Step", level = -300 }'}
TONE = '{{ model = "Sine", amplitude = {}, frequency = {} }}'
TWO = {"drive": f'{{ model = "Sum", drives = [{TONE.format(50, 100)}, {TONE.format(20, 250)}] }}'}
BEATING = {
    "drive": '{ model = "AmplitudeModulation", amplitude = 9, carrier = 3000, modulation = 100, depth = 0.5 }'
}
SMALL = {"limits.voltage": "50 V"}


@pytest.mark.parametrize("second", DRIVES)
def test_every_drive_that_replaces_another_one_runs(second):
    assert compute(after(second, changes=KILOVOLT)[1]).trace.electrostatic_force.size > 0


@pytest.mark.parametrize(
    ("names", "changes", "expected"),
    [
        (["Square"], KILOVOLT | {"drive.amplitude": "800 V"}, {"high": 800, "low": -800, "frequency": 200}),
        (["Square", "Sine"], KILOVOLT, {"amplitude": 1000, "offset": 0, "frequency": 200}),
        (["Step"], FALLING, {"level": -300}),
        (["Sine"], FALLING, {"amplitude": 150, "offset": -150}),
        (["AmplitudeModulation"], FALLING, {"high": 0, "low": -300}),
        (["Square"], STEP, {"high": 0, "low": -300}),
        (["Sine"], STEP, {"amplitude": 150, "offset": -150}),
        (["Square"], TWO, {"frequency": 100}),  # of which only the period is known; the first of that name
        (["Square"], BEATING, {"frequency": 100}),
        (["CurrentSine"], {}, {"amplitude": 250e-6}),  # the limit of the scenario
        (["CurrentSine"], {"limits.current": "10 A"}, {"amplitude": 1e-3}),  # the example
        (["Step"], SMALL, {"level": 1000}),  # the present voltage is not reduced
        (["CurrentSine", "Step"], SMALL, {"level": 50}),
    ],
)
def test_a_drive_keeps_extremes_and_frequency_within_the_limits_of_the_set_up(names, changes, expected):
    state, scenario = after(*names, changes=changes)
    found = {name: getattr(scenario.drive, name) for name in expected}
    assert found == pytest.approx(expected, abs=1e-9)
    assert DRIVE.present(state, scenario) == names[-1]


def test_an_offset_drive_is_its_level_and_what_it_is_added_to_and_the_own_one_is_given_back():
    drive = after("Sine", preset="kang_2017/both")[1].drive
    assert (drive.offset, drive.amplitude) == pytest.approx((200, 180), rel=0.01)
    state, scenario = after("Square", AS_GIVEN, changes={"stack.gap.thickness": "2 um"})
    assert scenario.drive == SCENARIO.drive
    assert dict(state.changes) == {"stack.gap.thickness": "2 um"}


def test_a_law_with_parameters_of_its_own_begins_with_its_example():
    state = chosen(PageState("strong_1970/display", {}), LAW, "Persson2018RoughGap", {})
    assert scenario_of(state, own={}).force.mean_gap == 1e-5
    changed = chosen(state.changed("force.mean_gap", "20 um"), LAW, "Persson2018RoughGap", {})
    assert scenario_of(changed, own={}).force.mean_gap == 2e-5


def test_a_material_keeps_what_was_set_and_its_source_does_not_state():
    path, film = INSULATOR.path, {"stack.insulator.thickness": "50 um"}
    mine = film | {f"{path}.permittivity": "7", f"{path}.conductivity": "1 nS/m"}
    state, scenario = after("pet", changes=mine, choice=INSULATOR)
    layer = scenario.stack.layers["insulator"]
    pet, alumina = (
        SCENARIO.replace({path: name}).stack.layers["insulator"].material for name in ("pet", "alumina")
    )
    assert layer.thickness == pytest.approx(50e-6)
    assert layer.material.permittivity == pet.permittivity != 7
    assert layer.material.conductivity == pytest.approx(1e-9) != pet.conductivity
    assert INSULATOR.present(state, scenario) == "pet"
    _, other = after("alumina", changes=mine, choice=INSULATOR)
    assert other.stack.layers["insulator"].material == alumina
    mine = {"stack.stratum_corneum.thickness": "300 um"}
    skin = after("gabriel_1996/wet", changes=mine, choice=SKIN)[1].stack.layers["stratum_corneum"]
    assert skin.thickness == pytest.approx(300e-6)
    wet = SCENARIO.replace({SKIN.path: "gabriel_1996/wet"}).stack.layers["stratum_corneum"]
    assert skin.material == wet.material


def test_parameters_of_another_unit_do_not_stay_and_numbers_of_a_link_are_short_and_exact():
    sine = Sine(amplitude=5, frequency=200, phase=1)
    assert carried(CurrentSine, sine) == {"frequency": 200, "phase": 1}
    assert carried(Sine, sine) == {"amplitude": 5, "offset": 0, "frequency": 200, "phase": 1}
    written = '{ model = "Sine", amplitude = 1000, frequency = 0.3333333333333333, cycles = 10 }'
    assert inline("Sine", {"amplitude": 1000.0, "frequency": 1 / 3, "cycles": 10}) == written


def test_a_perception_can_be_declared_where_a_scenario_has_none(by_path):
    assert SCENARIO.perception is None
    empty = {each.path for each in blanks(SCENARIO)}
    assert {"perception.threshold", "perception.threshold_uncertainty"} <= empty
    assert by_path["perception.window"].value == Perception().window
    assert not any(path.startswith("perception.channels") for path in by_path)
    changed = scenario_of(PageState(GAP).changed("perception.window", "0.2 s"), own={})
    assert changed.perception == Perception(window=0.2)
    rows = {each.path: each for each in controls(changed)}
    channel = rows["perception.channels.0.best_frequency"]
    assert (channel.name, channel.is_detail) == ("channel 1, best frequency", True)
    assert not rows["perception.window"].is_detail


def test_a_link_that_gives_a_whole_perception_shows_its_compliance():
    for table, present, own in (
        (
            "{ compliance = { model = 'ElasticSkin', stiffness = 1000 } }",
            "ElasticSkin",
            "ElasticSkin, as in the scenario",
        ),
        ("{ window = 1 }", AS_GIVEN, "none"),
    ):
        state = PageState(GAP, {"perception": table})
        scenario = scenario_of(state, own={})
        assert COMPLIANCE.present(state, scenario) == present
        assert choices(scenario)[-1].options[AS_GIVEN] == own
