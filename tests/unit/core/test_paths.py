"""Dotted paths: reading, changing, and what is said of a path that is not there."""

from __future__ import annotations

import pytest

from electrovib.core.errors import InputError
from electrovib.core.paths import quantity_at, value_at
from electrovib.core.samples import Samples
from electrovib.core.tables import put
from electrovib.scenario import load


@pytest.fixture(scope="module")
def scenario():
    return load("vezzoli_2014/fig6_gap")


def test_values_of_every_kind(scenario):
    assert value_at(scenario, "stack.gap.thickness") == 1e-6
    assert value_at(scenario, "drive.model") == "Trapezium"
    assert value_at(scenario, "load") == {"normal_force": 0.5, "time_profile": {"model": "Steady"}}
    assert value_at(scenario, "drive.repeat") is None


def test_declarations(scenario):
    assert quantity_at(scenario, "stack.gap.thickness").unit == "m"
    with pytest.raises(InputError, match="no physical parameter has this path"):
        quantity_at(scenario, "stack.gap")


def test_parameters_come_in_the_order_of_the_file(scenario):
    paths = [path for path, _, _ in scenario.parameters()]
    assert len(set(paths)) == len(paths)
    layers = [path.split(".")[1] for path in paths if path.startswith("stack.")]
    assert list(dict.fromkeys(layers)) == ["insulator", "gap", "stratum_corneum"]


@pytest.mark.parametrize(
    ("path", "sentence"),
    [
        ("stack.gap.thicknes", "unknown parameter 'thicknes' in 'stack.gap'. Did you mean 'thickness'?"),
        ("drive.hihg", "unknown parameter 'hihg' of Trapezium. Did you mean 'high'?"),
        ("stak.gap", "unknown parameter 'stak'. Did you mean 'stack'?"),
        (
            "stack.gop.thickness",
            "the stack has no layer 'gop'; its layers are insulator, gap, stratum_corneum. Did you mean 'gap'?",
        ),
        ("load.normal_force.x", "'load.normal_force' is a single value, without parameters of its own"),
        ("drive.repeat.x", "without parameters of its own"),
        ("", "unknown parameter ''"),
        (".", "unknown parameter ''"),
        ("stack..gap", "unknown parameter '' in 'stack'"),
    ],
)
def test_paths_that_are_not_there(scenario, path, sentence):
    with pytest.raises(InputError) as caught:
        value_at(scenario, path)
    assert sentence in str(caught.value)
    with pytest.raises(InputError) as caught:
        scenario.replace({path: 1.0})
    assert sentence in str(caught.value)


def test_a_new_model_comes_before_its_parameters():
    tables = {"drive": {"model": "Sine", "amplitude": 1.0}}
    assert put(tables, {"drive.level": 5.0, "drive.model": "Step"}) == []
    assert tables == {"drive": {"model": "Step", "level": 5.0}}


def test_the_same_model_keeps_its_parameters():
    tables = {"drive": {"model": "Sine", "amplitude": 1.0}}
    assert put(tables, {"drive.model": "Sine"}) == []
    assert tables == {"drive": {"model": "Sine", "amplitude": 1.0}}


@pytest.mark.parametrize("key", ["file", "time_column", "voltage_unit"])
def test_samples_do_not_outlive_how_they_were_read(key):
    tables = {
        "drive": {
            "file": "old.csv",
            "time_column": "time",
            "voltage_unit": "V",
            "level": 1.0,
            "time_samples": Samples([0, 1]),
        }
    }
    assert put(tables, {"drive.level": 2.0}) == []
    assert "time_samples" in tables["drive"]
    assert put(tables, {f"drive.{key}": "new"}) == []
    assert "time_samples" not in tables["drive"]


def test_samples_without_a_file_stay():
    tables = {"drive": {"file": "", "voltage_unit": "V", "time_samples": Samples([0, 1])}}
    assert put(tables, {"drive.voltage_unit": "kV"}) == []
    assert "time_samples" in tables["drive"]


def test_tables_can_be_made_on_the_way():
    tables = {}
    assert put(tables, {"a.b.c": 1, "a.b.d": 2}, strict=False) == []
    assert tables == {"a": {"b": {"c": 1, "d": 2}}}
    assert len(put(tables, {"a.x.c": 1})) == 1


def test_a_part_of_a_table_that_is_not_given_is_told_apart_from_a_value():
    content = {"perception": None}
    (problem,) = put(content, {"perception.threshold": 1e-6})
    assert "'perception' is not given, " in problem
    assert "set it whole" in problem
