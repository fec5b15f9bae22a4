"""Scenarios are changed: parts are added, presets keep a source beside each value, moisture moves what is there."""

import itertools
import tomllib

import numpy as np
import pytest

from electrovib.apps.explorer.state import presets
from electrovib.core.errors import InputError
from electrovib.core.paths import quantity_at, value_at
from electrovib.core.tables import stored_changes
from electrovib.physics.finger import Moisture
from electrovib.physics.material import Constant
from electrovib.physics.stack import Layer
from electrovib.scenario import Scenario, load, plain, preset
from electrovib.scenario.experiment import moistened
from electrovib.scenario.sources import BY_THE_USER
from electrovib.solve.simulate import simulate
from electrovib.studies.sweep import parse_over

TOUCHING = load("vezzoli_2014/fig6")
PLASTIC = {"model": "Constant", "permittivity": 3.35}
FILM = Layer(thickness=90e-6, material=Constant(permittivity=3.35))
GAP = {"stack.gap.thickness": "5 um"}
GLUE = {"thickness": "1 um", "role": "plate"}


@pytest.mark.parametrize(
    "changes",
    [
        {"stack.gap": {"thickness": "5 um"}},
        GAP | {"stack.insulator.thickness": "50 um"},
        {"stack": "vezzoli_2014/fig6", "stack.gap": {"thickness": "5 um"}},
        GAP | {"stack.gap": {"thickness": "7 um"}},
    ],
)
def test_a_gap_of_air_is_added_between_plate_and_finger(changes):
    stack = TOUCHING.replace(changes).stack
    assert list(stack.layers) == ["insulator", "gap", "stratum_corneum"]
    assert stack.layers["gap"] == Layer(thickness=5e-6, material=Constant(permittivity=1.0))
    assert stack.gap_name == "gap"


def test_what_is_set_in_a_new_layer_counts():
    other = {"stack.gap.material.model": "Constant", "stack.gap.material.permittivity": 2.0}
    found = TOUCHING.replace(GAP | other)
    assert found.stack.layers["gap"].material.permittivity == 2
    assert found.sources["stack.gap.thickness"] == BY_THE_USER
    content = TOUCHING.to_dict() | {"force": {"model": "Vezzoli2014Causal"}, "sources": {}}
    del content["stack"]["insulator"]  # a change mends a file that lacks a layer
    mended = load(content, changes={"stack.insulator": {"thickness": "90 um", "material": PLASTIC}})
    assert list(mended.stack.layers) == ["insulator", "stratum_corneum"]


@pytest.mark.parametrize("order", [*itertools.permutations(["sweat", "primer", "gap"])])
def test_several_layers_are_added_at_once_in_any_order(order):
    layer = {"thickness": "1 um", "material": PLASTIC}
    layers = {
        "sweat": layer | {"role": "finger"},
        "primer": layer | {"role": "plate"},
        "gap": {"thickness": "2 um"},
    }
    whole = {f"stack.{name}": layers[name] for name in order}
    parts = {f"{path}.{name}": value for path, each in whole.items() for name, value in each.items()}
    for changes in (whole, parts):
        found = TOUCHING.replace(changes).stack
        assert list(found.layers) == ["insulator", "primer", "gap", "sweat", "stratum_corneum"]


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"stack.glue": {"thickness": "1 um"}}, "no layer 'glue'.* and a role, 'plate', 'gap' or 'finger'"),
        ({"stack.insulater.thickness": "1 um"}, "no layer 'insulater'.* Did you mean 'insulator'"),
        ({"stack.glue": GLUE}, "stack.glue.material: missing: only a gap is vacuum without one. Declare it"),
        ({"stack.gap": {}}, "stack.gap.thickness: missing"),
        ({"stack.gap": GLUE}, "contradicts the name"),
        (GAP | {"stack.second": {"thickness": "1 um", "role": "gap"}}, "'gap' is already the role of"),
        ({"finger.mass": 1e-4}, "'finger' is not given; choose its model too, .* one of: MassSpringDamper"),
        ({"perception.treshold": 1e-6}, "Did you mean 'threshold'"),
        ({"stack.insulator.leak.conductivity_positve": 1e-6}, "leak"),
    ],
)
def test_what_cannot_be_added_is_refused_with_what_to_do(changes, sentence):
    with pytest.raises(InputError, match=sentence):
        TOUCHING.replace(changes)


def test_tables_that_were_not_given_begin_with_their_defaults():
    changes = {
        "perception.threshold": "1 um",
        "perception.threshold_uncertainty": "6",
        "circuit.amplifier.source_current": "250 uA",
        "motion.speed": "30 mm/s",
        "limits.voltage": "600 V",
    }
    found = TOUCHING.replace(changes)
    assert [value_at(found, path) for path in changes] == pytest.approx([1e-6, 6, 250e-6, 30e-3, 600])
    finger = {"model": "MassSpringDamper", "mass": "0.15 g", "stiffness": "1 kN/m", "damping": "1 N s/m"}
    whole = TOUCHING.replace({"finger": finger, "finger.mass": "0.2 g"})
    assert whole.finger.mass == pytest.approx(2e-4)
    assert TOUCHING.replace({f"finger.{name}": value for name, value in finger.items()}).finger.mass == 1.5e-4


@pytest.mark.parametrize(
    ("path", "sentence"),
    [
        ("stack.gap.thickness", "no layer 'gap'.* --set stack.gap='{ thickness = \"5 um\" }'"),
        ("perception.window", "'perception' is not given. Add it, .* --set perception='{ window"),
        ("finger.mass", "--set finger='{ model = \"MassSpringDamper\", mass = ... }'"),
    ],
)
def test_a_part_that_is_missing_is_named_with_how_to_add_it(path, sentence):
    for find in (quantity_at, value_at, lambda scenario, path: parse_over(scenario, [f"{path}=1e-6:1e-5:3"])):
        with pytest.raises(InputError, match=sentence):
            find(TOUCHING, path)


def made(changes, base=None, unchanged="", **sources):
    return preset(base, title="a title", changes=changes, unchanged=unchanged, **sources)


def told(scenario, under):
    return {path: text for path, text in scenario.sources.items() if path.startswith(under)}


def test_a_value_has_its_own_source():
    sources = {"drive.level": "table 1", "load.normal_force": "table 2"}
    built = made({"drive.level": 200.0, "load.normal_force": "0.3 N"}, sources=sources)
    assert (built.title, built.load.normal_force) == ("a title", 0.3)
    assert (built.sources["drive.level"], built.sources["load.normal_force"]) == ("table 1", "table 2")
    assert built == plain().replace({"drive.level": 200.0, "load.normal_force": 0.3})
    order = [path for path, _, _ in built.parameters()]
    assert list(built.sources) == sorted(built.sources, key=order.index)
    dry = "stack.insulator.material.conductivity"  # at its default, and named itself
    assert made({dry: 0.0}, sources={dry: "dry"}).sources[dry] == "dry"
    load = {"load.normal_force": "table 2"}
    ours = made({"load.normal_force": 1.0}, unchanged="ours", sources=load).sources
    assert (ours["friction.coefficient"], ours["load.normal_force"]) == ("ours", "table 2")
    assert set(ours) == set(plain().sources)


def test_a_table_shares_its_source_with_what_it_gives_and_the_inner_source_counts():
    gap = {"thickness": 1e-6, "material": {"model": "Constant", "permittivity": 2.0}}
    stack = {"stack": {"insulator": FILM, "gap": gap, "stratum_corneum": FILM}}
    built = made(stack, sources={"stack": "figure 1", "stack.gap.thickness": "measured"})
    assert list(built.stack.layers) == ["insulator", "gap", "stratum_corneum"]
    given = [
        f"stack.{name}.{path}"
        for name in built.stack.layers
        for path in ("thickness", "material.permittivity")
    ]
    # a conductivity at its default of 0 is nothing that the table gives
    assert told(built, "stack.") == dict.fromkeys(given, "figure 1") | {"stack.gap.thickness": "measured"}
    inner = "stack.insulator.material.permittivity"
    sources = made(
        {"stack.insulator": FILM.to_dict(), inner: 4.0}, sources={"stack": "outer", inner: "inner"}
    ).sources
    assert (sources["stack.insulator.thickness"], sources[inner]) == ("outer", "inner")
    part = {"model": "Sine", "amplitude": 10.0, "frequency": 30.0}
    two = {"drive": {"model": "Sum", "drives": [part, {**part, "frequency": 60.0}]}}
    own = {"drive": "c", "drive.drives.0.amplitude": "a", "drive.drives.1.frequency": "b"}
    sources = {"0.amplitude": "a", "0.frequency": "c", "1.amplitude": "c", "1.frequency": "b"}
    expected = {f"drive.drives.{place}": source for place, source in sources.items()}
    assert told(made(two, sources=own), "drive") == expected


def test_the_base_keeps_its_sources_and_its_values():
    halved = {"changes": {"drive.high": 500.0}, "sources": {"drive.high": "halved"}}
    built = made(base=TOUCHING, **halved)
    assert built.sources == TOUCHING.sources | {"drive.high": "halved"}
    assert built == TOUCHING.replace({"drive.high": 500.0})
    assert BY_THE_USER not in built.sources.values()
    assert made(base="vezzoli_2014/fig6", **halved).sources == built.sources
    gap = "stack.gap.thickness"
    assert made({gap: "5 um"}, TOUCHING, sources={gap: "ours"}).sources[gap] == "ours"
    assert made({"force.model": "MaxwellStressInGap"}, TOUCHING).sources == TOUCHING.sources


def test_another_model_leaves_no_source_of_the_former_behind():
    sine = {"drive.model": "Sine", "drive.amplitude": 1.0, "drive.frequency": 30.0}
    assert set(told(made(sine, sources={"drive.amplitude": "x"}), "drive")) == {"drive.amplitude"}
    current = {"drive.model": "CurrentSine", "drive.amplitude": 1e-3, "drive.frequency": 30.0}
    sources = {"drive.amplitude": "x", "drive.frequency": "y"}
    assert "drive.phase" in load("kang_2017/sine").sources  # which both have, at the default of the second
    assert set(told(made(current, "kang_2017/sine", sources=sources), "drive.")) == set(sources)


def test_mistakes_are_told_at_once_with_the_nearest_name():
    with pytest.raises(InputError) as caught:
        made({"drive.levle": 3.0, "contact.aera": 1e-4})
    assert "Did you mean 'level'" in str(caught.value)
    assert "Did you mean 'area'" in str(caught.value)
    wrong = {"drive.hihg": 1, "drive.rise": "2 V", "stack.air": {}, "load.normal_force": -1, "title.x": 1}
    with pytest.raises(InputError) as caught:
        TOUCHING.replace(wrong)
    assert sorted(problem.path for problem in caught.value.problems) == sorted(wrong)
    with pytest.raises(InputError, match=r"load\.normal_force"):
        made({"load.normal_force": -1.0})
    with pytest.raises(InputError, match=r"sources\.drive\.levle: .* Did you mean 'drive\.level'"):
        made({"drive.level": 3.0}, sources={"drive.levle": "a"})


WRONG = (
    {"drve.high": 1},
    {"drive.hihg": 1},
    {"drive.high.more": 1},
    {"stack.gpa.thickness": 1e-6},
    {"stack.gap": {"thickness": "-1 um"}},
    {"load.normal_force": "1 V"},
    {"finger.mass": 1},
    {"circuit.series_resistance": -1, "contact.area": "x"},
    {"motion.distance.gap": 1},
    {"title.words": "x"},
    {"sources.x": "y"},
)


def changes_of(scenario):
    """Return a change of the first number of every part, alone, and all of them together."""
    first = {}
    for path, value, _ in scenario.parameters():
        if value:
            first.setdefault(path.split(".")[0], {path: value * 1.01})
    together = {path: value for each in first.values() for path, value in each.items()}
    return [*first.values(), together, {"title": "another"}]


def in_tables(scenario, changes):
    """Return the tables of a scenario with changes of stored parameters in them, put there one by one."""
    tables = scenario.to_dict()
    for path, value in stored_changes(scenario, changes)[0].items():
        *parents, last = path.split(".")
        table = tables
        for key in parents:
            table = table[int(key) if isinstance(table, list) else key]
        table[last] = value
    return tables


@pytest.mark.parametrize("name", sorted(presets({})))
def test_a_change_is_the_same_as_building_the_whole_anew(name):
    scenario = load(name)
    cases = changes_of(scenario)
    for changes in cases:
        assert scenario.replace(changes) == load(in_tables(scenario, changes))
    assert scenario.replace({"drive": scenario.drive.to_dict()}).stack is scenario.stack
    assert len(cases) >= 5
    for wrong in WRONG:
        with pytest.raises(InputError) as caught:
            scenario.replace(wrong)
        assert {each.path for each in caught.value.problems} <= {
            *wrong,
            *(f"{path}.{name}" for path, table in wrong.items() if isinstance(table, dict) for name in table),
        }


WET = Moisture(**{**Moisture.example, "level": 1.0})
AIR = {"thickness": 3e-6, "material": {"model": "Constant", "permittivity": 1.0}}
BRIDGES = {"model": "BridgedAir", "bridged_share": 0.01, "spot_conductivity": 0.0}


def with_gap(**gap):
    insulator, skin = (Scenario.example["stack"][name] for name in ("insulator", "stratum_corneum"))
    stack = {"insulator": insulator, "gap": AIR | gap, "stratum_corneum": skin}
    return Scenario.model_validate(dict(Scenario.example) | {"stack": stack})


def test_moisture_moves_what_is_there():
    scenario = with_gap()
    moved = {"stack.stratum_corneum.material.conductivity": 0.2 * 200e-6, "friction.coefficient": 0.8}
    changes = moistened(scenario, WET)
    assert changes == pytest.approx(moved | {"stack.gap.material.conductivity": 1e-6}, rel=1e-14)
    assert value_at(scenario.replace(changes), "stack.gap.material.conductivity") == pytest.approx(1e-6)
    bridged = moistened(with_gap(material=BRIDGES), WET)
    assert bridged == pytest.approx(moved | {"stack.gap.material.spot_conductivity": 1e-6}, rel=1e-14)
    assert set(moistened(TOUCHING, WET)) == set(moved)
    alone = {"stack": {"insulator": Scenario.example["stack"]["insulator"]}}
    assert list(moistened(Scenario.model_validate(dict(Scenario.example) | alone), WET)) == [
        "friction.coefficient"
    ]


def test_a_moist_finger_loses_a_held_force_sooner_and_rubs_harder():
    """The attraction decays with the resistivity of the gap; friction without voltage rises with the coefficient."""
    scenario = with_gap().replace({"time.duration": 1e-3, "time.samples": 51})
    left, rubs = [], []
    for level in (0.0, 0.5, 1.0):
        moisture = Moisture(**{**Moisture.example, "level": level, "wet_gap_resistivity": 1e6})
        trace = simulate(scenario.replace(moistened(scenario, moisture)))
        left.append(float(trace.electrostatic_force[-1] / trace.electrostatic_force[1]))
        rubs.append(float((trace.lateral_force / (trace.electrostatic_force + 0.5))[-1]))
    assert np.all(np.diff(left) < 0)
    assert left[0] > 0.99
    assert rubs == pytest.approx([0.4, 0.6, 0.8], rel=1e-12)


TABLES = {
    "insulator": {"thickness": "1 um", "material": {"model": "Constant", "permittivity": 3.0}},
    "coat": {"thickness": "1 um", "role": "plate", "material": {"model": "Constant", "permittivity": 3.0}},
    "gap": {"thickness": "1 um"},
    "stratum_corneum": {"thickness": "200 um", "material": {"model": "Constant", "permittivity": 1560.0}},
}


def bare(name):
    return {
        each: {key: value for key, value in table.items() if (each, key) != (name, "material")}
        for each, table in TABLES.items()
    }


@pytest.mark.parametrize("name", ["insulator", "coat", "stratum_corneum"])
def test_a_layer_that_is_no_gap_needs_a_material_wherever_it_is_declared(name):
    """A thickness alone was vacuum in silence; a gap is vacuum, and vacuum that is declared is taken."""
    sentence = rf"stack\.{name}\.material: missing: only a gap is vacuum.*electrovib list skins"
    with pytest.raises(InputError, match=sentence):
        TOUCHING.replace({"stack": bare(name)})
    with pytest.raises(InputError, match=sentence):
        load(TOUCHING.to_dict() | {"stack": bare(name)})
    vacuum = bare(name)
    vacuum[name] = vacuum[name] | {"material": {"model": "Constant", "permittivity": 1.0}}
    found = TOUCHING.replace({"stack": vacuum})
    assert load(found.to_dict()) == load(tomllib.loads(found.to_toml())) == found
    assert found.stack.layers[name].material == found.stack.layers["gap"].material


def test_a_derived_parameter_changes_those_that_are_stored():
    """And is none of them: what is stored is what a sweep sets, and whose source becomes the user."""
    assert stored_changes(load("vezzoli_2014/fig6"), {"drive.amplitude": 50.0}) == (
        {"drive.high": 550.0, "drive.low": 450.0},
        [],
    )
