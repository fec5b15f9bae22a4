"""What stays when a drive, a force law or a material is replaced."""

from __future__ import annotations

import itertools

import pytest

import electrovib as ev
from electrovib.apps.explorer.choices import AS_GIVEN, carried, choices, chosen, inline
from electrovib.apps.explorer.computed import compute
from electrovib.apps.explorer.state import PageState, scenario_of
from electrovib.core.errors import ElectrovibError
from electrovib.core.quantity import quantity_of
from electrovib.physics.drive.current import CurrentSine
from electrovib.physics.drive.sines import Sine

GAP = "vezzoli_2014/fig6_gap"
DRIVE, LAW, SKIN, INSULATOR, _ = choices(ev.load(GAP))
DRIVES = [name for name in DRIVE.options if name != AS_GIVEN]


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


@pytest.mark.parametrize("second", DRIVES)
def test_every_drive_that_replaces_another_one_runs(second):
    _, scenario = after(
        second, changes={"drive": '{ model = "Sine", amplitude = "1 kV", frequency = "200 Hz" }'}
    )
    assert compute(scenario).trace.electrostatic_force.size > 0


def test_a_square_after_a_sine_of_one_kilovolt_has_its_amplitude_and_frequency():
    given = {"drive": '{ model = "Sine", amplitude = "1 kV", frequency = "200 Hz" }'}
    state, scenario = after("Square", changes=given | {"drive.amplitude": "800 V"})
    assert (scenario.drive.high, scenario.drive.low, scenario.drive.frequency) == (800, -800, 200)
    assert DRIVE.present(state, scenario) == "Square"
    _, again = after("Square", "Sine", changes=given)
    assert (again.drive.amplitude, again.drive.offset, again.drive.frequency) == (1000, 0, 200)


def test_a_step_has_the_largest_voltage_and_a_modulation_the_extremes():
    given = {"drive": '{ model = "Trapezium", high = -300, low = 0, rise = 0.01, hold = 0.1, fall = 0.01 }'}
    assert after("Step", changes=given)[1].drive.level == -300
    sine = after("Sine", changes=given)[1].drive
    assert (sine.amplitude, sine.offset) == (150, -150)
    modulated = after("AmplitudeModulation", changes=given)[1].drive
    assert modulated.amplitude < 150
    assert (modulated.high, modulated.low) == pytest.approx((0, -300), abs=1e-9)
    _, scenario = after("Sine", preset="kang_2017/both")  # an offset drive: the level and what it is added to
    assert scenario.drive.offset == pytest.approx(200, rel=0.01)
    assert scenario.drive.amplitude == pytest.approx(180, rel=0.01)


def test_a_drive_of_the_other_kind_stays_within_the_limits_of_the_set_up():
    assert after("CurrentSine")[1].drive.amplitude == pytest.approx(250e-6)  # the limit of the scenario
    free = {"limits.current": "10 A"}
    assert after("CurrentSine", changes=free)[1].drive.amplitude == pytest.approx(1e-3)  # the example
    low = {"limits.voltage": "50 V"}
    assert after("Step", changes=low)[1].drive.level == 1000  # the present voltage is not reduced
    assert after("CurrentSine", "Step", changes=low)[1].drive.level == pytest.approx(50)


def test_the_drive_of_the_scenario_is_given_back():
    state, scenario = after("Square", AS_GIVEN, changes={"stack.gap.thickness": "2 um"})
    assert scenario.drive == ev.load(GAP).drive
    assert dict(state.changes) == {"stack.gap.thickness": "2 um"}


def test_a_law_with_parameters_of_its_own_begins_with_its_example():
    state = chosen(PageState("strong_1970/display", {}), LAW, "Persson2018RoughGap", {})
    scenario = scenario_of(state, own={})
    assert scenario.force.mean_gap == 1e-5
    changed = state.changed("force.mean_gap", "20 um")
    assert scenario_of(chosen(changed, LAW, "Persson2018RoughGap", {}), own={}).force.mean_gap == 2e-5


def test_a_material_keeps_what_was_set_and_its_source_does_not_state():
    path = "stack.insulator.material"
    mine = {
        f"{path}.permittivity": "7",
        f"{path}.conductivity": "1 nS/m",
        "stack.insulator.thickness": "50 um",
    }
    state, scenario = after("pet", changes=mine, choice=INSULATOR)
    layer = scenario.stack.layers["insulator"]
    pet = ev.load(GAP).replace({path: "pet"}).stack.layers["insulator"].material
    assert layer.thickness == pytest.approx(50e-6)
    assert layer.material.permittivity == pet.permittivity != 7
    assert layer.material.conductivity == pytest.approx(1e-9)
    assert pet.conductivity != pytest.approx(1e-9)
    _, other = after("alumina", changes=mine, choice=INSULATOR)
    stated = ev.load(GAP).replace({path: "alumina"}).stack.layers["insulator"].material
    assert other.stack.layers["insulator"].material == stated
    assert INSULATOR.present(state, scenario) == "pet"


def test_a_skin_keeps_the_thickness_that_was_set():
    _, scenario = after(
        "gabriel_1996/wet", changes={"stack.stratum_corneum.thickness": "300 um"}, choice=SKIN
    )
    assert scenario.stack.layers["stratum_corneum"].thickness == pytest.approx(300e-6)
    wet = ev.load(GAP).replace({SKIN.path: "gabriel_1996/wet"}).stack.layers["stratum_corneum"]
    assert scenario.stack.layers["stratum_corneum"].material == wet.material


def test_a_step_becomes_a_drive_between_zero_and_its_level():
    given = {"drive": '{ model = "Step", level = -300 }'}
    square = after("Square", changes=given)[1].drive
    assert (square.high, square.low) == (0, -300)
    sine = after("Sine", changes=given)[1].drive
    assert (sine.amplitude, sine.offset) == (150, -150)


def test_a_drive_of_which_only_the_period_is_known_gives_its_frequency():
    tones = '[{ model = "Sine", amplitude = 50, frequency = 100 }, { model = "Sine", amplitude = 20, frequency = 250 }]'
    found = after("Square", changes={"drive": f'{{ model = "Sum", drives = {tones} }}'})[1].drive
    assert found.frequency == pytest.approx(100)  # the first of that name
    modulated = (
        '{ model = "AmplitudeModulation", amplitude = 9, carrier = 3000, modulation = 100, depth = 0.5 }'
    )
    assert after("Square", changes={"drive": modulated})[1].drive.frequency == pytest.approx(100)


def test_parameters_of_the_same_name_and_another_unit_do_not_stay():
    sine = Sine(amplitude=5, frequency=200, phase=1)
    assert carried(CurrentSine, sine) == {"frequency": 200, "phase": 1}
    assert carried(Sine, sine) == {"amplitude": 5, "offset": 0, "frequency": 200, "phase": 1}


def test_numbers_of_a_link_are_short_and_exact():
    assert inline("Sine", {"amplitude": 1000.0, "frequency": 1 / 3, "cycles": 10}) == (
        '{ model = "Sine", amplitude = 1000, frequency = 0.3333333333333333, cycles = 10 }'
    )
