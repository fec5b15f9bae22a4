"""What is written reads back equal: TOML, JSON, dotted paths; equal numbers written differently are one model."""

import json
import tomllib

import pytest
import tomlkit
from hypothesis import given, settings
from hypothesis import strategies as st

from electrovib.core.errors import InputError
from electrovib.core.model import read_model
from electrovib.core.paths import quantity_at, value_at
from electrovib.core.samples import Samples
from electrovib.core.units import exact_text, format_quantity
from electrovib.scenario import Scenario, load
from electrovib.scenario.toml import to_toml

FIG6 = load("vezzoli_2014/fig6")


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


def as_json(model):
    return json.loads(json.dumps(model.to_dict(), default=lambda samples: samples.packed()))


def test_tables_toml_and_json_round_trip(final_class, build):
    """Into the same canonical text however it was made, with only numbers, texts and tables in it."""
    model = build(final_class)
    toml = tomllib.loads(tomlkit.dumps(without_nothing(model.to_dict())))
    for content in (model.to_dict(), toml, as_json(model), dict(final_class.example)):
        assert_same(final_class.model_validate(content), model)
    assert json.loads(model.canonical()) is not None
    assert "NaN" not in model.canonical()
    if final_class.__name__ != "Stack":  # whose order is physics
        assert_same(final_class.model_validate(dict(reversed(list(final_class.example.items())))), model)


def changed(model, path, value, quantity):
    """Return the model with another value at a path, and the value; None if each is refused."""
    for factor in (0.99, 1.01, 0.5):
        other = value * factor if value else min(quantity.high, 1e-3)
        try:
            return model.replace({path: other}), other
        except InputError:  # out of range, or at odds with the other parameters
            continue
    return None, None


def test_every_path_is_accepted_and_counts_and_a_misspelt_one_is_refused(final_class, build):
    model = build(final_class)
    for path, value, quantity in model.parameters():
        assert value_at(model, path) == value
        assert quantity_at(model, path) == quantity
        assert_same(model.replace({path: value}), model)
        if value is not None:
            assert_same(model.replace({path: exact_text(value, quantity.unit)}), model)
            another, other = changed(model, path, value, quantity)
            # charge on the outer face of the last layer would sit on the conducting finger
            if another is None:
                assert path.endswith("stratum_corneum.initial_charge"), path
            else:
                assert another != model
                assert another.digest() != model.digest()
                assert value_at(another, path) == other
        wrong = path + "x"
        with pytest.raises(InputError) as caught:
            model.replace({wrong: 1.0})
        assert str(caught.value).startswith(f"{wrong}: unknown parameter")
        for find in (value_at, quantity_at):
            with pytest.raises(InputError):
                find(model, wrong)


@given(data=st.data())
def test_drawn_models_round_trip(material_class, drawn, data):
    material = data.draw(drawn(material_class))
    assert_same(material_class.model_validate(as_json(material)), material)


@given(data=st.data())
@settings(max_examples=25)
def test_exact_text_reads_back_to_the_same_model(drive_class, drawn, data):
    model = data.draw(drawn(drive_class))
    given = [
        (path, value, quantity.unit) for path, value, quantity in model.parameters() if value is not None
    ]
    assert_same(model.replace({path: exact_text(value, unit) for path, value, unit in given}), model)


def test_scenarios_round_trip_and_their_words_are_not_physics(scenario):
    before = scenario.canonical()
    for again in (load(tomllib.loads(to_toml(scenario))), load(json.loads(scenario.to_json()))):
        assert_same(again, scenario)
        assert again.title == scenario.title
        assert again.sources == scenario.sources
        assert again.to_json() == scenario.to_json()
    assert_same(scenario.replace({"title": "another"}), scenario)
    for path, value, quantity in scenario.parameters():
        if value:  # what people are shown, put back in, is the same within the digits shown
            again = value_at(scenario.replace({path: format_quantity(value, quantity.unit, digits=12)}), path)
            assert abs(again / value - 1) < 1e-11
    assert scenario.canonical() == before  # changes leave the original alone


def test_every_material_and_drive_is_written_as_toml(discovered, build):
    places = {"material_class": "stack.stratum_corneum.material", "drive_class": "drive"}
    for family, path in places.items():
        for kind in discovered[family].values():
            base = load("vezzoli_2014/fig6_gap") if family == "material_class" else FIG6
            scenario = base.replace({path: build(kind).to_dict()})
            assert_same(load(tomllib.loads(to_toml(scenario))), scenario)


def test_the_order_of_layers_is_physics():
    """The same slabs in another order are another stack, with another hash."""
    tables = load("vezzoli_2014/fig6_gap").to_dict()
    primer = {"primer": tables["stack"]["gap"] | {"role": "plate"}}
    insulator = {"insulator": tables["stack"]["insulator"]}
    first = read_model(Scenario, tables | {"stack": primer | tables["stack"]})
    turned = read_model(Scenario, tables | {"stack": insulator | primer | tables["stack"]})
    assert list(turned.stack.layers) == ["insulator", "primer", "gap", "stratum_corneum"]
    assert turned != first
    assert turned.digest() != first.digest()


def test_another_model_takes_its_own_parameters():
    changes = {"drive.amplitude": "100 V", "drive.frequency": "50 Hz", "drive.model": "Sine"}
    sine = {"model": "Sine", "amplitude": 100.0, "frequency": 50.0}
    assert_same(FIG6.replace(changes), FIG6.replace({"drive": sine}))
    assert_same(FIG6.replace({"drive.high": 1000}), FIG6.replace({"drive.high": "1 kV"}))
    with pytest.raises(InputError, match=r"drive\.frequency: missing"):
        FIG6.replace({"drive.model": "Sine", "drive.amplitude": "100 V"})
    with pytest.raises(InputError, match="unknown parameter 'rise' of Sine"):
        FIG6.replace({**changes, "drive.rise": 1.0})
