"""What is written reads back equal: TOML, JSON, dotted paths; equal numbers written differently are one model."""

from __future__ import annotations

import json
import tomllib

import numpy as np
import pytest
import tomlkit
from hypothesis import given
from hypothesis import strategies as st

from electrovib.core.errors import InputError
from electrovib.core.model import read_model
from electrovib.core.paths import quantity_at, value_at
from electrovib.core.samples import Samples
from electrovib.core.units import exact_text, format_quantity
from electrovib.scenario import Scenario, load
from electrovib.scenario.toml import to_toml


def without_nothing(value):
    """TOML has no null: what is absent is left out; samples become the text that holds them."""
    if isinstance(value, dict):
        return {key: without_nothing(item) for key, item in value.items() if item is not None}
    if isinstance(value, list):
        return [without_nothing(item) for item in value]
    return value.packed() if isinstance(value, Samples) else value


def assert_same(one, other):
    assert one == other
    assert hash(one) == hash(other)
    assert one.digest() == other.digest()
    assert one.canonical() == other.canonical()


def test_tables_round_trip(final_class, build):
    model = build(final_class)
    assert_same(final_class.model_validate(model.to_dict()), model)


def test_toml_round_trip(final_class, build):
    model = build(final_class)
    text = tomlkit.dumps(without_nothing(model.to_dict()))
    assert_same(final_class.model_validate(tomllib.loads(text)), model)


def test_json_round_trip(final_class, build):
    model = build(final_class)
    text = json.dumps(model.to_dict(), default=lambda samples: samples.packed())
    assert_same(final_class.model_validate(json.loads(text)), model)


def test_canonical_json_is_stable(final_class, build):
    """The same from the same numbers however it was made, and only numbers, texts and tables in it."""
    model, again = build(final_class), build(final_class)
    assert model.canonical() == again.canonical()
    assert json.loads(model.canonical()) is not None
    assert "NaN" not in model.canonical()
    shuffled = dict(reversed(list(final_class.example.items())))
    if final_class.__name__ != "Stack":  # whose order is physics
        assert_same(final_class.model_validate(shuffled), model)


def test_a_changed_parameter_is_another_model(final_class, build):
    model = build(final_class)
    for path, value, quantity in model.parameters():
        if value is None:
            continue
        changed = None
        for factor in (0.99, 1.01, 0.5):
            other = value * factor if value else min(quantity.high, 1e-3)
            try:
                changed = model.replace({path: other})
            except InputError:  # out of range, or at odds with the other parameters
                continue
            assert changed != model
            assert changed.digest() != model.digest()
            assert value_at(changed, path) == other
            break
        # charge on the outer face of the last layer would sit on the conducting finger
        assert changed is not None or path.endswith("stratum_corneum.initial_charge"), path


def test_every_path_is_accepted(final_class, build):
    model = build(final_class)
    for path, value, quantity in model.parameters():
        assert value_at(model, path) == value
        assert quantity_at(model, path) == quantity
        assert_same(model.replace({path: value}), model)
        if value is not None:
            assert_same(model.replace({path: exact_text(value, quantity.unit)}), model)


def test_misspelt_paths_are_refused(final_class, build):
    model = build(final_class)
    for path, _, _ in model.parameters():
        wrong = path + "x"
        with pytest.raises(InputError) as caught:
            model.replace({wrong: 1.0})
        assert str(caught.value).startswith(f"{wrong}: unknown parameter")
        with pytest.raises(InputError):
            value_at(model, wrong)
        with pytest.raises(InputError):
            quantity_at(model, wrong)


@given(data=st.data())
def test_drawn_models_round_trip(material_class, drawn, data):
    material = data.draw(drawn(material_class))
    text = json.dumps(material.to_dict(), default=lambda samples: samples.packed())
    assert_same(material_class.model_validate(json.loads(text)), material)


@given(data=st.data())
def test_exact_text_reads_back_to_the_same_model(drive_class, drawn, data):
    model = data.draw(drawn(drive_class))
    written = {
        path: exact_text(value, quantity.unit)
        for path, value, quantity in model.parameters()
        if value is not None
    }
    assert_same(model.replace(written), model)


def test_scenarios_round_trip_as_toml(scenario):
    again = load(tomllib.loads(to_toml(scenario)))
    assert_same(again, scenario)
    assert again.title == scenario.title
    assert again.sources == scenario.sources


def test_every_material_is_written_as_toml(material_class, build):
    material = build(material_class)
    scenario = load("vezzoli_2014/fig6_gap").replace({"stack.stratum_corneum.material": material.to_dict()})
    again = load(tomllib.loads(to_toml(scenario)))
    assert_same(again, scenario)
    assert again.stack.layers["stratum_corneum"].material == material


def test_every_drive_is_written_as_toml(drive_class, build):
    drive = build(drive_class)
    scenario = load("vezzoli_2014/fig6").replace({"drive": drive.to_dict()})
    assert_same(load(tomllib.loads(to_toml(scenario))), scenario)


def test_scenarios_round_trip_as_json(scenario):
    again = load(json.loads(scenario.to_json()))
    assert_same(again, scenario)
    assert again.to_json() == scenario.to_json()


def test_words_for_people_are_not_physics(scenario):
    renamed = scenario.replace({"title": "another"})
    assert renamed == scenario
    assert renamed.digest() == scenario.digest()


def measured(voltages):
    return {"drive": {"model": "Sampled", "time_samples": [0.0, 0.1, 0.3], "voltage_samples": voltages}}


def test_a_scenario_with_samples_round_trips_without_loss():
    voltages = [0.1 + 0.2, 1e-300, -np.pi * 1e4]
    scenario = load("vezzoli_2014/fig6").replace(measured(voltages))
    again = load(json.loads(scenario.to_json()))
    assert_same(again, scenario)
    assert again.drive.voltage_samples.values.tolist() == voltages
    assert_same(load(tomllib.loads(to_toml(scenario))), scenario)


def test_samples_count_for_equality_and_hash():
    scenario = load("vezzoli_2014/fig6")
    one, other = scenario.replace(measured([0, 1, 2])), scenario.replace(measured([0, 1, np.nextafter(2, 3)]))
    assert one != other
    assert one.digest() != other.digest()


@pytest.mark.parametrize(
    "text", ["90 um", "90um", "0.09 mm", "9e-5 m", "90 µm", "90 μm", "0.000090", " 90  um "]
)
def test_one_length_written_differently_is_one_model(text):
    scenario = load("vezzoli_2014/fig6")
    written = scenario.replace({"stack.insulator.thickness": text})
    assert_same(written, scenario.replace({"stack.insulator.thickness": 9e-05}))
    assert written.stack.layers["insulator"].thickness == 9e-05


def test_whole_numbers_and_negative_zero_are_the_same_model():
    scenario = load("vezzoli_2014/fig6")
    assert_same(scenario.replace({"drive.high": 1000}), scenario.replace({"drive.high": "1 kV"}))
    assert_same(scenario.replace({"drive.low": -0.0}), scenario.replace({"drive.low": 0}))
    assert_same(
        scenario.replace({"drive.high": np.int64(1000)}), scenario.replace({"drive.high": np.float32(1000)})
    )


def test_the_order_of_layers_is_physics():
    """The same slabs in another order are another stack, with another hash."""
    tables = load("vezzoli_2014/fig6_gap").to_dict()
    tables["stack"] = {"primer": tables["stack"]["gap"] | {"role": "plate"}, **tables["stack"]}
    scenario = read_model(Scenario, tables)
    first, second, *others = tables["stack"].items()
    tables["stack"] = dict([second, first, *others])
    turned = read_model(Scenario, tables)
    assert list(turned.stack.layers) == ["insulator", "primer", "gap", "stratum_corneum"]
    assert turned != scenario
    assert turned.digest() != scenario.digest()


def test_another_model_takes_its_own_parameters():
    scenario = load("vezzoli_2014/fig6")
    changes = {"drive.amplitude": "100 V", "drive.frequency": "50 Hz", "drive.model": "Sine"}
    sine = {"model": "Sine", "amplitude": 100.0, "frequency": 50.0}
    assert_same(scenario.replace(changes), scenario.replace({"drive": sine}))
    with pytest.raises(InputError, match=r"drive\.frequency: missing"):
        scenario.replace({"drive.model": "Sine", "drive.amplitude": "100 V"})
    with pytest.raises(InputError, match="unknown parameter 'rise' of Sine"):
        scenario.replace({**changes, "drive.rise": 1.0})


def test_every_mistake_of_a_change_is_told_at_once():
    with pytest.raises(InputError) as caught:
        load("vezzoli_2014/fig6").replace(
            {"drive.hihg": 1, "drive.rise": "2 V", "stack.air": {}, "load.normal_force": -1, "title.x": 1}
        )
    assert caught.value.problems == (
        "drive.hihg: unknown parameter 'hihg' of Trapezium. Did you mean 'high'?",
        "stack.air: the stack has no layer 'air'; its layers are insulator, stratum_corneum. A new layer needs a thickness,"
        " a material and a role, 'plate', 'gap' or 'finger'",
        "title.x: 'title' is a single value, without parameters of its own",
        "drive.rise = '2 V': expected a time, for instance '36 ms'",
        "load.normal_force = -1: a number without a unit is in SI, so this is -1 N; must lie between 0 N and 1 kN",
    )


def test_paths_lead_into_lists():
    skin = {"model": "ColeCole", "permittivity_high": 4, "conductivity": 1e-4}
    terms = [{"strength": 1e3, "relaxation_time": 1e-6}, {"strength": 10, "relaxation_time": 1e-3}]
    scenario = load("vezzoli_2014/fig6").replace({"stack.stratum_corneum.material": skin | {"terms": terms}})
    path = "stack.stratum_corneum.material.terms.1.broadening"
    assert value_at(scenario, path) == 0.0
    assert value_at(scenario.replace({path: 0.2}), path) == 0.2
    with pytest.raises(InputError, match="has entries 0 to 1"):
        scenario.replace({path.replace(".1.", ".2."): 0.2})


def test_changes_leave_the_original_alone(scenario):
    before = scenario.canonical()
    scenario.replace({"load.normal_force": "1 N"})
    assert scenario.canonical() == before


def test_shown_numbers_read_back(scenario):
    """What people are shown, put back in, is the same within the digits shown."""
    for path, value, quantity in scenario.parameters():
        if value:
            again = value_at(scenario.replace({path: format_quantity(value, quantity.unit, digits=12)}), path)
            assert abs(again / value - 1) < 1e-11
