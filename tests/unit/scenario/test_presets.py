"""A preset is a base and changes to it, and each value keeps its source beside it."""

from __future__ import annotations

import pytest

from electrovib.core.errors import InputError
from electrovib.physics.material import Constant
from electrovib.physics.stack import Layer
from electrovib.scenario import load, plain, preset, sourced
from electrovib.scenario.sources import BY_THE_USER

FILM = Layer(thickness=90e-6, material=Constant(permittivity=3.35))


def made(changes, base=None, unchanged=""):
    return preset(base, title="a title", changes=changes, unchanged=unchanged)


def test_a_value_and_its_source_stand_in_one_place():
    built = made({"drive.level": (200.0, "table 1"), "load.normal_force": ("0.3 N", "table 2")})
    assert built.title == "a title"
    assert built.load.normal_force == 0.3
    assert built.sources["drive.level"] == "table 1"
    assert built.sources["load.normal_force"] == "table 2"
    assert built == plain().replace({"drive.level": 200.0, "load.normal_force": 0.3})


def test_a_table_shares_its_source_with_what_it_gives_and_does_not_source_itself():
    gap = {"thickness": (1e-6, "measured"), "material": {"model": "Constant", "permittivity": 2.0}}
    built = made({"stack": ({"insulator": FILM, "gap": gap, "stratum_corneum": FILM}, "figure 1")})
    assert list(built.stack.layers) == ["insulator", "gap", "stratum_corneum"]
    told = {path: text for path, text in built.sources.items() if path.startswith("stack.")}
    assert told == {
        "stack.insulator.thickness": "figure 1",
        "stack.insulator.material.permittivity": "figure 1",
        "stack.gap.thickness": "measured",
        "stack.gap.material.permittivity": "figure 1",
        "stack.stratum_corneum.thickness": "figure 1",
        "stack.stratum_corneum.material.permittivity": "figure 1",
    }  # a conductivity at its default of 0 is nothing that the table gives


def test_a_default_that_is_named_itself_has_its_source():
    built = made({"stack.insulator.material.conductivity": (0.0, "dry")})
    assert built.sources["stack.insulator.material.conductivity"] == "dry"


def test_the_inner_of_two_sources_counts():
    changes = {
        "stack.insulator": (FILM, "outer"),
        "stack.insulator.material.permittivity": (4.0, "inner"),
    }
    sources = made(changes).sources
    assert sources["stack.insulator.thickness"] == "outer"
    assert sources["stack.insulator.material.permittivity"] == "inner"


def test_what_a_list_gives_has_its_place():
    part = {"model": "Sine", "amplitude": (10.0, "a"), "frequency": 30.0}
    built = made({"drive": ({"model": "Sum", "drives": [part, {**part, "frequency": (60.0, "b")}]}, "c")})
    told = {path: text for path, text in built.sources.items() if path.startswith("drive")}
    assert told == {
        "drive.drives.0.amplitude": "a",
        "drive.drives.0.frequency": "c",
        "drive.drives.1.amplitude": "a",
        "drive.drives.1.frequency": "b",
    }


def test_the_base_keeps_its_sources_and_its_values():
    base = load("vezzoli_2014/fig6")
    built = made({"drive.high": (500.0, "halved")}, base)
    assert built.sources == base.sources | {"drive.high": "halved"}
    assert built == base.replace({"drive.high": 500.0})
    assert BY_THE_USER not in built.sources.values()
    assert made({"drive.high": (500.0, "halved")}, "vezzoli_2014/fig6").sources == built.sources


def test_another_model_leaves_no_source_of_the_former_behind():
    sources = made({"drive.model": "Sine", "drive.amplitude": (1.0, "x"), "drive.frequency": 30.0}).sources
    assert {path for path in sources if path.startswith("drive")} == {"drive.amplitude"}
    current = {"drive.model": "CurrentSine", "drive.amplitude": (1e-3, "x"), "drive.frequency": (30.0, "y")}
    assert "drive.phase" in load("kang_2017/sine").sources  # which both have, at the default of the second
    told = {path for path in made(current, "kang_2017/sine").sources if path.startswith("drive.")}
    assert told == {"drive.amplitude", "drive.frequency"}
    changed = made({"force.model": "MaxwellStressInGap"}, "vezzoli_2014/fig6")
    assert changed.sources == load("vezzoli_2014/fig6").sources


def test_what_stays_of_the_base_can_be_given_one_source():
    built = made({"load.normal_force": (1.0, "table 2")}, unchanged="ours")
    assert built.sources["friction.coefficient"] == "ours"
    assert built.sources["load.normal_force"] == "table 2"
    assert set(built.sources) == set(plain().sources)


def test_sources_are_in_the_order_of_the_parameters():
    built = made({"stack.insulator": (FILM, "b"), "drive.level": (3.0, "a")})
    order = [path for path, _, _ in built.parameters()]
    assert list(built.sources) == sorted(built.sources, key=order.index)


def test_mistakes_are_told_at_once_with_the_nearest_name():
    with pytest.raises(InputError) as caught:
        made({"drive.levle": (3.0, "a"), "contact.aera": 1e-4})
    assert "Did you mean 'level'" in str(caught.value)
    assert "Did you mean 'area'" in str(caught.value)
    with pytest.raises(InputError, match=r"load\.normal_force"):
        made({"load.normal_force": (-1.0, "a")})


def test_every_parameter_can_be_given_a_source():
    built = sourced(made({"drive.level": (3.0, "a")}), {"": "rest", "stack": "layers", "time": ""})
    assert built.sources["drive.level"] == "a"
    assert built.sources["stack.insulator.initial_charge"] == "layers"
    assert built.sources["limits.voltage"] == "rest"
    assert not any(path.startswith("time.") for path in built.sources)
    assert {path for path, _, _ in built.parameters() if not path.startswith("time.")} == set(built.sources)
