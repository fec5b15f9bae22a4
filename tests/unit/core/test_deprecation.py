"""Former names are read with a warning that says what to use; here they are those of a test, put into the tables."""

import importlib
import inspect
import re

import pytest

import electrovib as ev
from electrovib.core import deprecation
from electrovib.core.deprecation import Former
from electrovib.core.errors import InputError
from electrovib.core.paths import quantity_at, value_at
from electrovib.physics.force import ForceLaw
from electrovib.scenario import Scenario

GAP = "vezzoli_2014/fig6_gap"


def former(now):
    return Former(now, since="1.1.0", goes="2.0.0")


def warns(name, now, since="1.1.0"):
    text = f"{name} is deprecated since electrovib {since} and goes in 2.0.0: use {now}"
    return pytest.warns(DeprecationWarning, match=f"^{re.escape(text)}$")


@pytest.fixture
def load(monkeypatch):
    """Give a load whose parameter and whose place in a scenario have former names."""
    found = ev.load(GAP).load
    monkeypatch.setattr(Scenario, "former", {"weight": former("load")})
    monkeypatch.setattr(type(found), "former", {"newtons": former("normal_force")})
    return found


def test_nothing_has_a_former_name_before_a_release_has_had_it():
    assert not deprecation.FORMER
    with pytest.raises(AttributeError, match="no attribute 'simulate_scenario'"):
        _ = ev.simulate_scenario


def test_a_former_name_of_the_package_warns_where_it_is_used(monkeypatch):
    monkeypatch.setitem(deprecation.FORMER, "simulate_scenario", former("simulate"))
    with warns("electrovib.simulate_scenario", "simulate") as told:
        assert ev.simulate_scenario is ev.simulate
    assert told[0].filename == __file__
    with warns("electrovib.simulate_scenario", "simulate") as told:
        from electrovib import simulate_scenario
    assert (simulate_scenario, told[0].filename) == (ev.simulate, __file__)
    assert "simulate_scenario" not in dir(ev)


def test_a_former_parameter_is_read_in_a_table_and_as_an_attribute(load):
    with warns("Load.newtons", "normal_force") as told:
        assert type(load)(newtons=2.0).normal_force == 2
    assert {each.filename for each in told} == {__file__}
    with warns("Load.newtons", "normal_force"):
        assert load.newtons == load.normal_force
    table = ev.load(GAP).to_dict()
    table["weight"] = table.pop("load")
    with warns("Scenario.weight", "load"):
        assert ev.load(table) == ev.load(GAP)
    with pytest.raises(AttributeError):
        _ = load.pounds


def test_a_former_parameter_is_a_path(load):
    scenario = ev.load(GAP)
    with warns("Scenario.weight", "load"), warns("Load.newtons", "normal_force"):
        changed = scenario.replace({"weight.newtons": "2 N"})
    assert changed == scenario.replace({"load.normal_force": 2.0})
    with warns("Load.newtons", "normal_force"):
        assert value_at(changed, "load.newtons") == 2
    with warns("Load.newtons", "normal_force"):
        assert quantity_at(changed, "load.newtons") is quantity_at(changed, "load.normal_force")
    with warns("Load.newtons", "normal_force"):
        swept = ev.sweep(scenario, {"load.newtons": [1.0, 2.0]}, quantity=["mean lateral_force"])
    assert swept["mean lateral_force"].size == 2


@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_both_names_at_once_are_a_mistake(load):
    with pytest.raises(InputError, match="unknown parameter 'newtons' of Load"):
        ev.load(GAP, changes={"load": {"newtons": 2.0, "normal_force": 1.0}})
    with pytest.raises(InputError, match="unknown parameter 'newtons'"):
        ev.load(GAP).replace({"load.newtons": 2.0, "load.normal_force": 1.0})


def test_a_former_model_is_read_by_its_name(monkeypatch):
    law = ev.load(GAP).force
    monkeypatch.setattr(ForceLaw, "former", {"StressInGap": former(type(law).__name__)})
    with warns("ForceLaw.StressInGap", type(law).__name__):
        found = ev.load("vezzoli_2014/fig6", changes={"force": {"model": "StressInGap"}})
    assert found.force == law


def test_the_table_is_looked_up_only_for_a_name_that_is_unknown(monkeypatch):
    monkeypatch.setitem(deprecation.FORMER, "simulate", former("load"))
    assert importlib.import_module("electrovib").simulate is not ev.load


def test_former_parameters_of_a_function_are_read_with_a_warning():
    changes = {"drive.high": [100.0]}
    with warns("sweep(quantities=)", "quantity", since="1.0.0"):
        former_ = ev.sweep("vezzoli_2014/fig6", changes, quantities=["peak current"])
    assert former_.identical(ev.sweep("vezzoli_2014/fig6", changes, quantity=["peak current"]))
    with pytest.raises(TypeError, match="quantities"):
        ev.sweep("vezzoli_2014/fig6", changes, quantities=["peak current"], quantity=["peak current"])


def test_every_former_parameter_stands_for_a_present_one():
    for name, parameters in deprecation.FORMER_PARAMETERS.items():
        present = inspect.signature(getattr(ev, name)).parameters
        for old, new in parameters.items():
            assert old not in present
            assert new.now in present
