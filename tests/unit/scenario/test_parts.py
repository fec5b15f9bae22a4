"""Optional parts are added by a change: layers at the interface, tables that were not given."""

from __future__ import annotations

import itertools

import pytest

from electrovib.core.errors import InputError
from electrovib.core.paths import quantity_at, value_at
from electrovib.physics.material import Constant
from electrovib.scenario import load, preset
from electrovib.scenario.sources import BY_THE_USER
from electrovib.study.sweep import parse_over

FILM = {"model": "Constant", "permittivity": 3.35}


@pytest.fixture
def touching():
    return load("vezzoli_2014/fig6")


@pytest.mark.parametrize(
    "changes",
    [
        {"stack.gap": {"thickness": "5 um"}},
        {"stack.gap.thickness": "5 um"},
        {"stack.gap.thickness": "5 um", "stack.insulator.thickness": "50 um"},
        {"stack": "vezzoli_2014/fig6", "stack.gap": {"thickness": "5 um"}},
    ],
)
def test_a_gap_of_air_is_added_between_plate_and_finger(touching, changes):
    stack = touching.replace(changes).stack
    assert list(stack.layers) == ["insulator", "gap", "stratum_corneum"]
    assert stack.layers["gap"].thickness == pytest.approx(5e-6)
    assert stack.layers["gap"].material == Constant(permittivity=1.0)
    assert stack.gap_name == "gap"


def test_what_is_set_in_a_new_layer_counts(touching):
    changes = {"stack.gap": {"thickness": "5 um"}, "stack.gap.thickness": "7 um"}
    changes |= {"stack.gap.material.model": "Constant", "stack.gap.material.permittivity": 2.0}
    found = touching.replace(changes)
    assert found.stack.layers["gap"].thickness == pytest.approx(7e-6)
    assert found.stack.layers["gap"].material.permittivity == 2
    assert found.sources["stack.gap.thickness"] == BY_THE_USER


@pytest.mark.parametrize(
    ("role", "order"),
    [
        ("plate", ["insulator", "new", "gap", "stratum_corneum"]),
        ("finger", ["insulator", "gap", "new", "stratum_corneum"]),
    ],
)
def test_a_declared_role_places_a_layer_at_the_interface(role, order):
    layer = {"thickness": "1 um", "role": role, "material": FILM}
    scenario = load("vezzoli_2014/fig6_gap")
    assert list(scenario.replace({"stack.new": layer}).stack.layers) == order
    parts = {f"stack.new.{name}": value for name, value in layer.items()}
    assert list(scenario.replace(parts).stack.layers) == order


@pytest.mark.parametrize("order", [*itertools.permutations(["sweat", "primer", "gap"])])
def test_several_layers_are_added_at_once_in_any_order(touching, order):
    layers = {
        "sweat": {"thickness": "1 um", "role": "finger", "material": FILM},
        "primer": {"thickness": "1 um", "role": "plate", "material": FILM},
        "gap": {"thickness": "2 um"},
    }
    changed = touching.replace({f"stack.{name}": layers[name] for name in order})
    assert list(changed.stack.layers) == ["insulator", "primer", "gap", "sweat", "stratum_corneum"]


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"stack.glue": {"thickness": "1 um"}}, "no layer 'glue'.* and a role, 'plate', 'gap' or 'finger'"),
        ({"stack.insulater.thickness": "1 um"}, "no layer 'insulater'.* Did you mean 'insulator'"),
        (
            {"stack.glue": {"thickness": "1 um", "role": "plate"}},
            "stack.glue.material: missing: .* only a gap is air",
        ),
        ({"stack.gap": {}}, "stack.gap.thickness: missing"),
        ({"stack.gap": {"thickness": "1 um", "role": "plate"}}, "contradicts the name"),
        (
            {"finger.mass": 1e-4},
            "'finger' is not given; choose its model too, finger.model, one of: MassSpringDamper",
        ),
        ({"perception.treshold": 1e-6}, "Did you mean 'threshold'"),
    ],
)
def test_what_cannot_be_added_is_refused_with_what_to_do(touching, changes, sentence):
    with pytest.raises(InputError, match=sentence):
        touching.replace(changes)


def test_a_second_gap_is_refused():
    with pytest.raises(InputError, match="'gap' is already the role of"):
        load("vezzoli_2014/fig6_gap").replace({"stack.second": {"thickness": "1 um", "role": "gap"}})


def test_tables_that_were_not_given_begin_with_their_defaults(touching):
    changes = {
        "perception.threshold": "1 um",
        "perception.threshold_uncertainty": 6,
        "circuit.amplifier.source_current": "250 uA",
        "motion.speed": "30 mm/s",
        "limits.voltage": "600 V",
    }
    found = touching.replace(changes)
    assert found.perception.threshold == pytest.approx(1e-6)
    assert found.circuit.amplifier.source_current == pytest.approx(250e-6)
    assert found.motion.speed == pytest.approx(30e-3)
    assert found.limits.voltage == 600
    finger = {"model": "MassSpringDamper", "mass": "0.15 g", "stiffness": "1 kN/m", "damping": "1 N s/m"}
    whole = touching.replace({"finger": finger, "finger.mass": "0.2 g"})
    assert whole.finger.mass == pytest.approx(2e-4)
    assert touching.replace({f"finger.{name}": value for name, value in finger.items()}).finger.mass == 1.5e-4


def test_a_change_mends_a_file_that_lacks_a_layer(tmp_path):
    content = load("vezzoli_2014/fig6").to_dict() | {"force": {"model": "Vezzoli2014Causal"}, "sources": {}}
    del content["stack"]["insulator"]
    layer = {"thickness": "90 um", "material": FILM}
    assert list(load(content, changes={"stack.insulator": layer}).stack.layers) == [
        "insulator",
        "stratum_corneum",
    ]


def test_a_preset_adds_a_gap():
    found = preset(
        "vezzoli_2014/fig6", title="with a gap", changes={"stack.gap.thickness": ("5 um", "a choice")}
    )
    assert list(found.stack.layers) == ["insulator", "gap", "stratum_corneum"]
    assert found.sources["stack.gap.thickness"] == "a choice"


@pytest.mark.parametrize(
    ("path", "sentence"),
    [
        ("stack.gap.thickness", "no layer 'gap'.* --set stack.gap='{ thickness = \"5 um\" }'"),
        (
            "perception.window",
            "'perception' is not given. Add it, for instance with --set perception='{ window",
        ),
        ("finger.mass", "--set finger='{ model = \"MassSpringDamper\", mass = ... }'"),
    ],
)
def test_a_part_that_is_missing_is_named_with_how_to_add_it(touching, path, sentence):
    for find in (quantity_at, value_at):
        with pytest.raises(InputError, match=sentence):
            find(touching, path)
    with pytest.raises(InputError, match=sentence):
        parse_over(touching, [f"{path}=1e-6:1e-5:3"])
