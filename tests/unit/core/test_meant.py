"""What an unknown path may mean: parameters of that name, and other models that have it."""

from __future__ import annotations

import pytest

from electrovib.core.errors import InputError
from electrovib.core.meant import meant
from electrovib.core.paths import quantity_at, value_at
from electrovib.scenario import load


@pytest.fixture(scope="module")
def scenario():
    return load("vezzoli_2014/fig6_gap")


def test_a_single_word_names_the_parameters_that_end_with_it(scenario):
    asked = meant(scenario, "thickness")
    assert asked == (
        " Did you mean 'stack.insulator.thickness' (thickness of the layer),"
        " 'stack.gap.thickness' (thickness of the layer) or"
        " 'stack.stratum_corneum.thickness' (thickness of the layer)?"
    )
    assert meant(scenario, "rise") == " Did you mean 'drive.rise' (duration of an edge; 0 for a step)?"


def test_a_word_of_a_meaning_is_found_before_a_limit_that_is_not_declared(scenario):
    asked = meant(scenario, "voltage")
    assert asked.startswith(" Did you mean 'drive.low' (voltage before and after), 'drive.high'")
    assert "limits" not in asked
    assert meant(scenario, "gap").startswith(" Did you mean 'stack.gap.thickness' (")


def test_a_parameter_of_another_model_names_the_models_that_have_it(scenario):
    asked = meant(scenario, "drive.frequency")
    assert asked.startswith(" Models with 'frequency': Burst, ")
    assert " Sine, " in asked
    assert asked.endswith("; to take one, set drive.model as well.")
    deep = meant(scenario, "stack.insulator.material.exponent")
    assert (
        deep
        == " Models with 'exponent': ConstantPhase; to take one, set stack.insulator.material.model as well."
    )


@pytest.mark.parametrize(
    "path",
    [
        "drive.hihg",
        "drive.nothing_has_this",
        "stak",
        "nothing_has_this",
        "",
        ".",
        "drive.high.x",
        "no.such.x",
        "sources.x",
    ],
)
def test_nothing_is_added_where_a_spelling_is_near_or_nothing_has_the_name(scenario, path):
    assert meant(scenario, path) == ""


@pytest.mark.parametrize("path", ["thickness", "drive.frequency"])
def test_reading_changing_and_declaring_say_it_once(scenario, path):
    for ask in (value_at, quantity_at, lambda model, where: model.replace({where: 1.0})):
        with pytest.raises(InputError) as caught:
            ask(scenario, path)
        assert len(caught.value.problems) == 1
        assert str(caught.value).startswith(f"{path}: ")
        assert str(caught.value).count(meant(scenario, path)) == 1


def test_what_is_meant_stands_in_the_place_of_a_name_that_is_only_spelled_similarly(scenario):
    with pytest.raises(InputError) as caught:
        value_at(scenario, "rise")
    assert str(caught.value) == "rise: unknown parameter 'rise'." + meant(scenario, "rise")
    assert str(caught.value).endswith("Did you mean 'drive.rise' (duration of an edge; 0 for a step)?")
