"""Materials of the library, skins and stacks of papers are named where they stand, and their sources travel with them."""

import json

import pytest

import electrovib as ev
from electrovib.core.diagnostics import read_diagnostics
from electrovib.core.errors import InputError
from electrovib.core.tables import Changed
from electrovib.papers import gabriel_1996, palmar_1995
from electrovib.scenario import load, preset, skins
from electrovib.scenario.files import sources_of_offers
from electrovib.scenario.sources import BY_THE_USER, not_in_paper

SKIN, FILM = "stack.stratum_corneum.material", "stack.insulator.material"
DRY_MEN = palmar_1995.skins()["dry_men"].material
TABLES = """
schema = 1
drive = { model = "Step", level = "100 V" }
force = { model = "MaxwellStressInGap" }
friction = { model = "Coulomb", coefficient = 0.5 }
contact = { model = "FixedArea", area = "1 cm2" }
load = { normal_force = "0.5 N" }
circuit = { return_path = { model = "Grounded" } }
"""
LAYERS = """
[stack.insulator]
thickness = "90 um"
material = "FILM"
[stack.stratum_corneum]
thickness = "200 um"
material = "gabriel_1996/wet"
"""


@pytest.fixture
def file(tmp_path):
    def write(text):
        place = tmp_path / "my.toml"
        place.write_text(TABLES + text, encoding="utf-8")
        return load(place)

    return write


@pytest.fixture
def on(file):
    """Load a scenario from a file that names the material of its film."""
    return lambda film: file(LAYERS.replace("FILM", film))


def material(scenario, layer="insulator"):
    return scenario.stack.layers[layer].material


def films_told(scenario):
    return {each.name: each for each in read_diagnostics(ev.simulate(scenario).attrs["validity"])}


@pytest.mark.parametrize("name", ["silica", "SiO2", "silicon dioxide"])
def test_a_file_names_a_material(on, name):
    read = on(name)
    assert (material(read).permittivity, material(read).conductivity) == (3.9, 1e-14)
    assert material(read).substance == "silica"
    told = read.sources[f"{FILM}.permittivity"]
    assert told.startswith(f"{name}: Brigham Young University cleanroom")
    assert told.endswith("(full text; thermal oxide)")
    strengths = read.sources[f"{FILM}.substance"]
    assert "breakdown strength 700 MV/m measured at 100 nm, Henein, Topolancik and Siebein" in strengths
    assert "(abstract; at least; ion-beam sputtered)" in strengths


def test_a_file_names_what_papers_offer(file, on):
    read = on("vezzoli_2014/film")
    assert material(read, "stratum_corneum") == gabriel_1996.skins()["wet"].material
    assert material(read).permittivity == 3.35
    told = read.sources[f"{SKIN}.terms.3.strength"]
    assert told.startswith("gabriel_1996/wet: S. Gabriel")
    assert "(derived; whole skin, not stratum corneum" in told
    assert "hal-01253573 (full text)" in read.sources[f"{FILM}.permittivity"]
    assert f"{SKIN}.terms.1.broadening" not in read.sources  # a default of 0, which nobody gives
    assert "stack.insulator.thickness" not in read.sources
    read, there = file('stack = "vezzoli_2014/fig6_gap"'), load("vezzoli_2014/fig6_gap")
    assert read.stack == there.stack
    gap = "stack.gap.thickness"
    assert read.sources[gap] == f"vezzoli_2014/fig6_gap: {there.sources[gap]}"
    assert set(read.sources) == {path for path in there.sources if path.startswith("stack.")}


def test_what_a_file_says_of_a_value_counts(file):
    read = file(f'{LAYERS.replace("FILM", "silica")}\n[sources]\n"{SKIN}.conductivity" = "mine"')
    assert read.sources[f"{SKIN}.conductivity"] == "mine"
    assert read.sources[f"{SKIN}.permittivity_high"].startswith("gabriel_1996/wet")


@pytest.mark.parametrize(("path", "name"), [(FILM, "silica"), (SKIN, "palmar_1995/dry_men")])
def test_a_name_is_the_same_scenario_as_its_tables_or_as_a_change(path, name):
    base = load("vezzoli_2014/fig7")
    named, content = base.replace({path: name}), base.to_dict()
    layer = path.split(".")[1]
    content["stack"][layer]["material"] = name
    assert load(content) == named
    written = base.replace({path: material(named, layer).to_dict()})
    assert named == written
    assert named.digest() == written.digest()
    assert "palmar_1995" not in named.canonical()  # resolved: it can be repeated without the paper


def test_the_user_sets_a_name_and_something_in_it(on):
    named = load("vezzoli_2014/fig6").replace({f"{SKIN}.conductivity": "1 uS/m", SKIN: "palmar_1995/dry_men"})
    assert material(named, "stratum_corneum").conductivity == 1e-6
    assert named.sources[f"{SKIN}.conductivity"] == BY_THE_USER
    assert named.sources[f"{SKIN}.exponent"].startswith(f"{BY_THE_USER} to palmar_1995/dry_men: ")
    assert not [path for path in not_in_paper(named, "vezzoli_2014") if path.startswith(SKIN)]
    film = named.replace({FILM: "silica"})
    assert film.sources[f"{FILM}.conductivity"].startswith(f"{BY_THE_USER} to silica: Brigham")
    assert film.sources[f"{FILM}.substance"].startswith(f"{BY_THE_USER} to silica: breakdown strength")
    lower = on("silica").replace({f"{FILM}.permittivity": 4.2})
    assert material(lower).substance == "silica"
    assert lower.sources[f"{FILM}.permittivity"] == BY_THE_USER
    other = on("silica").replace({FILM: {"model": "Constant", "permittivity": 5.0}})  # leaves nothing of it
    assert material(other).substance is None
    assert not [path for path in other.sources if path.startswith(f"{FILM}.substance")]


def test_a_skin_or_another_model_is_set_in_a_stack_that_is_named():
    changes = {SKIN: "palmar_1995/dry_men", "stack": "vezzoli_2014/fig6_gap"}
    scenario = load("vezzoli_2014/fig6")
    found = Changed(scenario)
    content = found.within(changes, scenario)
    told = sources_of_offers(found)
    assert told["stack.gap.thickness"].startswith("vezzoli_2014/fig6_gap")
    assert all(
        told[f"{SKIN}.{name}"].startswith("palmar_1995/dry_men") for name in ("exponent", "permittivity")
    )
    assert material(load("vezzoli_2014/fig6").replace(changes), "stratum_corneum") == DRY_MEN
    assert content["stack"]["gap"]["thickness"] == 1e-6
    another = {"stack": "vezzoli_2014/fig6", f"{SKIN}.model": "Debye"}
    found = Changed(scenario)
    found.within(another, scenario)
    told = sources_of_offers(found)
    assert not [path for path in told if path.startswith(SKIN)]  # that is not the paper's
    assert "stack.insulator.thickness" in told


def test_a_preset_names_a_skin():
    built = preset("vezzoli_2014/fig6", title="t", changes={SKIN: "palmar_1995/dry_men"})
    assert built.sources[f"{SKIN}.exponent"].startswith("palmar_1995/dry_men: ")
    assert f"{SKIN}.exponent" in not_in_paper(built, "vezzoli_2014")
    given = preset(
        "vezzoli_2014/fig6", title="t", changes={SKIN: "palmar_1995/dry_men"}, sources={SKIN: "a choice"}
    )
    assert given.sources[f"{SKIN}.exponent"] == "a choice"


A_MODEL = "no material 'Constnt'.*; a model is chosen by a table, { model = \"Constant\", ... }"
NO_OFFER = f"{SKIN} = 'palmar_1995/dry_man': no paper offers .*'palmar_1995/dry_men'"


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({SKIN: "palmar_1995/dry_man"}, NO_OFFER),
        ({SKIN: "palmr_1995/dry_men"}, "Did you mean 'palmar_1995/dry_men'"),
        ({SKIN: "Constnt"}, A_MODEL),
        ({FILM: "silicum"}, f"{FILM} = 'silicum': no material 'silicum'. Nearest: silica"),
        ({f"{FILM}.substance": "mylarr"}, r"no material 'mylarr'\. Nearest: pet"),
        ({"stack": "vezzoli_2014/fig66"}, "stack = 'vezzoli_2014/fig66': .*Did you mean 'vezzoli_2014/fig6'"),
        ({"stack": "fig6"}, "stack = 'fig6': expected \"author_year/name\" of a paper, or a table"),
        ({"drive": "vezzoli_2014/fig6"}, "drive = 'vezzoli_2014/fig6': expected a table"),
    ],
)
def test_a_wrong_name_is_refused_with_the_nearest(changes, sentence):
    with pytest.raises(InputError, match=sentence):
        load("vezzoli_2014/fig6").replace(changes)


def test_a_wrong_name_hides_no_other_mistake(file):
    with pytest.raises(InputError) as caught:
        file(LAYERS.replace("FILM", "silica").replace("wet", "wett").replace("90 um", "90 V"))
    assert len(caught.value.problems) == 2
    assert set(skins()) >= {"gabriel_1996/wet", "palmar_1995/dry_men", "plutchik_1963/skin"}


def test_a_substance_is_set_and_taken_away():
    own = load("vezzoli_2014/fig6").replace({f"{FILM}.substance": "Mylar"})
    assert (material(own).substance, material(own).permittivity) == ("pet", 3.35)
    assert material(own.replace({f"{FILM}.substance": None})).substance is None


def test_a_run_judges_every_layer_with_a_substance_and_marks_what_is_unverified(on):
    polyimide = on("polyimide")
    told = films_told(polyimide)
    assert told["material, insulator"].state == "unknown"
    assert "cited from memory, unverified: permittivity, conductivity" in told["material, insulator"].text
    assert told["film strength, insulator"].limit == pytest.approx(118e6)
    stored = json.loads(ev.simulate(polyimide).attrs["scenario"])
    assert stored["stack"]["insulator"]["material"]["substance"] == "polyimide"
    # for instance an artificial finger with a film on it
    told = films_told(on("silica").replace({f"{SKIN}.substance": "pet"}))
    assert "material, insulator" not in told
    assert {"film strength, insulator", "film strength, stratum_corneum"} <= set(told)
    # Persson's law takes the thickness of the layers that block; silica conducts a little
    law = {"model": "Persson2018RoughGap", "mean_gap": 1e-5, "rms_gap": 5e-6}
    blocked = on("silica").replace({"force": law, f"{FILM}.conductivity": 0.0})
    assert ev.simulate(blocked).electrostatic_force.max() > 0
