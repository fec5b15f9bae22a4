"""A material of the library is named where it stands in a scenario, and its sources travel with it."""

from __future__ import annotations

import json

import pytest

import electrovib as ev
from electrovib.core.diagnostics import read_diagnostics
from electrovib.core.errors import InputError
from electrovib.scenario import load
from electrovib.scenario.sources import BY_THE_USER
from electrovib.scenario.toml import to_toml

FILM = "stack.insulator.material"
FILE = """
schema = 1
drive = { model = "Step", level = "100 V" }
force = { model = "MaxwellStressInGap" }
friction = { model = "Coulomb", coefficient = 0.5 }
contact = { model = "FixedArea", area = "1 cm2" }
load = { normal_force = "0.5 N" }
circuit = { return_path = { model = "Grounded" } }
[stack.insulator]
thickness = "1 um"
material = "MATERIAL"
[stack.stratum_corneum]
thickness = "200 um"
material = { model = "Constant", permittivity = 1560 }
"""


def insulator(scenario):
    return scenario.stack.layers["insulator"].material


@pytest.fixture
def file(tmp_path):
    def write(material):
        place = tmp_path / "my.toml"
        place.write_text(FILE.replace("MATERIAL", material), encoding="utf-8")
        return place

    return write


@pytest.mark.parametrize("name", ["silica", "SiO2", "silicon dioxide"])
def test_a_file_names_a_material(file, name):
    read = load(file(name))
    assert (insulator(read).permittivity, insulator(read).conductivity) == (3.9, 1e-14)
    assert insulator(read).substance == "silica"
    told = read.sources[f"{FILM}.permittivity"]
    assert told.startswith(f"{name}: Brigham Young University cleanroom")
    assert told.endswith("(full text; thermal oxide)")
    strengths = read.sources[f"{FILM}.substance"]
    assert "breakdown strength 700 MV/m measured at 100 nm, Henein, Topolancik and Siebein" in strengths
    assert "(abstract; at least; ion-beam sputtered)" in strengths


def test_a_mapping_and_a_change_name_it_alike(file):
    base = load("vezzoli_2014/fig7")
    by_change = base.replace({FILM: "silica"})
    content = base.to_dict()
    content["stack"]["insulator"]["material"] = "silica"
    assert load(content) == by_change
    assert by_change.sources[f"{FILM}.conductivity"].startswith(f"{BY_THE_USER} to silica: Brigham")
    assert by_change.sources[f"{FILM}.substance"].startswith(f"{BY_THE_USER} to silica: breakdown strength")


def test_a_misspelt_name_in_a_file_has_the_nearest_ones(file):
    with pytest.raises(
        InputError, match=r"stack.insulator.material = 'silicum': no material 'silicum'. Nearest: silica"
    ):
        load(file("silicum"))


def test_another_material_leaves_nothing_of_it(file):
    read = load(file("silica")).replace({FILM: {"model": "Constant", "permittivity": 5.0}})
    assert insulator(read).substance is None
    assert not [path for path in read.sources if path.startswith(f"{FILM}.substance")]
    named = load(file("silica")).replace({f"{FILM}.permittivity": 4.2})
    assert insulator(named).substance == "silica"
    assert named.sources[f"{FILM}.permittivity"] == BY_THE_USER


def test_it_is_written_and_read_again(file, tmp_path):
    read = load(file("polyimide"))
    text = to_toml(read)
    assert 'substance = "polyimide"' in text
    again = tmp_path / "again.toml"
    again.write_text(text, encoding="utf-8")
    assert load(again) == read
    assert load(again).sources == read.sources
    assert load(again).digest() == read.digest()


def test_a_substance_is_set_and_taken_away(file):
    own = load("vezzoli_2014/fig6").replace({f"{FILM}.substance": "Mylar"})
    assert (insulator(own).substance, insulator(own).permittivity) == ("pet", 3.35)
    assert insulator(own.replace({f"{FILM}.substance": None})).substance is None
    with pytest.raises(InputError, match=r"no material 'mylarr'\. Nearest: pet"):
        load("vezzoli_2014/fig6").replace({f"{FILM}.substance": "mylarr"})


def test_a_run_marks_what_is_unverified(file):
    trace = ev.simulate(load(file("polyimide")))
    found = {each.name: each for each in read_diagnostics(trace.attrs["validity"])}
    material = found["material, insulator"]
    assert material.state == "unknown"
    assert "cited from memory, unverified: permittivity, conductivity" in material.text
    assert found["film strength, insulator"].limit == pytest.approx(118e6)
    assert json.loads(trace.attrs["scenario"])["stack"]["insulator"]["material"]["substance"] == "polyimide"
    silica = {each.name for each in read_diagnostics(ev.simulate(load(file("silica"))).attrs["validity"])}
    assert "material, insulator" not in silica


def test_a_law_that_needs_a_layer_without_conduction_says_so(file):
    """Persson's law takes the thickness of the layers that block; silica conducts a little."""
    read = load(file("silica"))
    changes = {"force": {"model": "Persson2018RoughGap", "mean_gap": 1e-5, "rms_gap": 5e-6}}
    blocked = read.replace(changes | {f"{FILM}.conductivity": 0.0})
    assert ev.simulate(blocked).electrostatic_force.max() > 0


def test_a_layer_of_the_finger_with_a_substance_is_judged_too(file):
    """For instance an artificial finger with a film on it."""
    read = load(file("silica")).replace({"stack.stratum_corneum.material.substance": "pet"})
    names = {each.name for each in read_diagnostics(ev.simulate(read).attrs["validity"])}
    assert {"film strength, insulator", "film strength, stratum_corneum"} <= names
