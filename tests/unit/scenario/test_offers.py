"""A skin, a material and a stack that papers offer are named where they stand in a scenario."""

from __future__ import annotations

import pytest

from electrovib.core.errors import InputError
from electrovib.papers import gabriel_1996, palmar_1995
from electrovib.physics.material import Material
from electrovib.physics.stack import Stack
from electrovib.scenario import load, preset, skins
from electrovib.scenario.offers import with_offers
from electrovib.scenario.sources import BY_THE_USER, not_in_paper

SKIN = "stack.stratum_corneum.material"
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
material = "vezzoli_2014/film"
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


def test_a_file_names_a_skin_and_a_material(file):
    read = file(LAYERS)
    assert read.stack.layers["stratum_corneum"].material == gabriel_1996.WET
    assert read.stack.layers["insulator"].material.permittivity == 3.35
    told = read.sources[f"{SKIN}.terms.3.strength"]
    assert told.startswith("gabriel_1996/wet: S. Gabriel")
    assert "(derived; whole skin, not stratum corneum" in told
    assert "hal-01253573 (full text)" in read.sources["stack.insulator.material.permittivity"]
    assert f"{SKIN}.terms.1.broadening" not in read.sources  # a default of 0, which nobody gives
    assert "stack.insulator.thickness" not in read.sources


def test_a_file_names_a_stack(file):
    read = file('stack = "vezzoli_2014/fig6_gap"')
    there = load("vezzoli_2014/fig6_gap")
    assert read.stack == there.stack
    assert (
        read.sources["stack.gap.thickness"]
        == f"vezzoli_2014/fig6_gap: {there.sources['stack.gap.thickness']}"
    )
    assert set(read.sources) == {path for path in there.sources if path.startswith("stack.")}


def test_what_a_file_says_of_a_value_counts(file):
    read = file(f'{LAYERS}\n[sources]\n"{SKIN}.conductivity" = "mine"')
    assert read.sources[f"{SKIN}.conductivity"] == "mine"
    assert read.sources[f"{SKIN}.permittivity_high"].startswith("gabriel_1996/wet")


def test_a_name_is_the_same_scenario_as_its_tables():
    named = load("vezzoli_2014/fig6").replace({SKIN: "palmar_1995/dry_men"})
    skin = palmar_1995.skins()["dry_men"].material
    written = load("vezzoli_2014/fig6").replace({SKIN: skin.to_dict()})
    assert named == written
    assert named.digest() == written.digest()
    assert "palmar_1995" not in named.canonical()  # resolved: it can be repeated without the paper


def test_the_user_sets_a_name_and_something_in_it():
    named = load("vezzoli_2014/fig6").replace({f"{SKIN}.conductivity": "1 uS/m", SKIN: "palmar_1995/dry_men"})
    assert named.stack.layers["stratum_corneum"].material.conductivity == 1e-6
    assert named.sources[f"{SKIN}.conductivity"] == BY_THE_USER
    assert named.sources[f"{SKIN}.exponent"].startswith(f"{BY_THE_USER} to palmar_1995/dry_men: ")
    assert not [path for path in not_in_paper(named, "vezzoli_2014") if path.startswith(SKIN)]


def test_a_skin_is_set_in_a_stack_that_is_named():
    changes = {SKIN: "palmar_1995/dry_men", "stack": "vezzoli_2014/fig6_gap"}
    read, told = with_offers(changes)
    assert told[f"{SKIN}.exponent"].startswith("palmar_1995/dry_men")
    assert told["stack.gap.thickness"].startswith("vezzoli_2014/fig6_gap")
    assert told[f"{SKIN}.permittivity"].startswith("palmar_1995/dry_men")
    found = load("vezzoli_2014/fig6").replace(changes)
    assert found.stack.layers["stratum_corneum"].material == palmar_1995.skins()["dry_men"].material
    assert read["stack"]["gap"]["thickness"] == 1e-6


def test_another_model_in_a_stack_that_is_named_is_not_the_papers():
    _, told = with_offers({"stack": "vezzoli_2014/fig6", f"{SKIN}.model": "Debye"})
    assert not [path for path in told if path.startswith(SKIN)]
    assert "stack.insulator.thickness" in told


def test_a_preset_names_a_skin():
    built = preset("vezzoli_2014/fig6", title="t", changes={SKIN: "palmar_1995/dry_men"})
    assert built.sources[f"{SKIN}.exponent"].startswith("palmar_1995/dry_men: ")
    assert f"{SKIN}.exponent" in not_in_paper(built, "vezzoli_2014")
    given = preset("vezzoli_2014/fig6", title="t", changes={SKIN: ("palmar_1995/dry_men", "a choice")})
    assert given.sources[f"{SKIN}.exponent"] == "a choice"


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        (
            {SKIN: "palmar_1995/dry_man"},
            f"{SKIN} = 'palmar_1995/dry_man': no paper offers .*'palmar_1995/dry_men'",
        ),
        ({SKIN: "palmr_1995/dry_men"}, "Did you mean 'palmar_1995/dry_men'"),
        (
            {SKIN: "Constnt"},
            "no material 'Constnt'.*; a model is chosen by a table, { model = \"Constant\", ... }",
        ),
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
        file(LAYERS.replace("wet", "wett").replace("90 um", "90 V"))
    assert len(caught.value.problems) == 2


def test_every_skin_of_a_paper_can_be_named():
    assert set(skins()) >= {"gabriel_1996/wet", "palmar_1995/dry_men", "plutchik_1963/skin"}
    for name, skin in skins().items():
        assert Material.model_validate(name) == skin.material


def test_every_stack_of_a_ready_made_scenario_can_be_named():
    assert Stack.model_validate("vezzoli_2014/fig2") == load("vezzoli_2014/fig2").stack
