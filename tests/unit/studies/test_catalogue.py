"""What a user finds: the catalogue of models, papers and scenarios, and the search of it."""

import functools
import re

import pytest

import electrovib as ev
import electrovib.bench.settings  # its models are found once they are imported
from electrovib.core.discovery import find_members, offers, paper, papers
from electrovib.core.errors import InputError
from electrovib.core.model import Model
from electrovib.core.search import search
from electrovib.physics.amplifier import Amplifier
from electrovib.physics.force import ForceLaw
from electrovib.physics.material.library import materials
from electrovib.scenario import Scenario
from electrovib.studies import catalogue
from electrovib.studies.catalogue import items, pages
from electrovib.studies.catalogue.items import everything

MODELS = {name: kind for family in items.families() for name, kind in find_members(family).items()}


@pytest.fixture(autouse=True)
def width(monkeypatch):
    """Text is laid out for the width of the terminal, which is not the same everywhere."""
    monkeypatch.setenv("COLUMNS", "120")


@functools.cache
def models(query="", **options):
    return ev.models(query, **options)


@functools.cache
def scenarios(query=""):
    return ev.scenarios(query)


def names(records):
    return [record.name for record in records]


def rows(thing):
    return {row[0]: row for row in pages.parameters(thing).rows}


def test_every_preset_is_declared_and_listed_with_its_title_and_what_it_reproduces():
    offered = offers(("scenarios",))
    assert names(scenarios()) == list(offered)
    for record in scenarios():
        assert record.meaning == offered[record.name].title
        assert record.reproduces, record.name
        assert record.name in str(scenarios())
        assert record.reproduces in str(scenarios())
        if ", figure " in record.meaning:
            figure = record.meaning.split(", figure ")[1].split()[0].strip(":,")
            assert f"figure {figure}" in record.reproduces
    (line,) = [line for line in str(scenarios()).splitlines() if line.startswith("vezzoli_2014/fig6 ")]
    assert line.split("figure 6")[1].strip().startswith("0 to 1000 V trapezoidal pulse"), "nothing repeated"
    for name, module in papers().items():
        declared = set(getattr(module, "PRESETS", {}))
        offered = set(getattr(module, "scenarios", dict)())
        assert declared == offered or not items.is_own(module), name


@pytest.mark.parametrize("query", ["3M", "3M-type screen"])
def test_the_presets_nearest_to_a_3m_type_screen(query):
    """Thin coatings of 1 um and permittivity 3.9, first the one whose numbers `compare` uses; the reason says so."""
    found = scenarios(query)
    assert names(found)[0] == "persson_2018/coating"
    assert {"vardar_2017/sine", "vardar_2017/square"} <= set(names(found))
    assert "unverified" in str(found)
    assert "insulator 1 um (silica, permittivity 3.9)" in str(found)
    for record in found:
        assert "3M-type screen" in record.reason
        layer = offers(("scenarios",))[record.name].stack.layers["insulator"]
        assert (layer.thickness, layer.material.permittivity) == (1e-6, 3.9)


def test_presets_are_found_by_device_model_figure_and_layer_and_shown_in_full():
    for query, expected in {
        "touchscreen": {"bau_2010/sine", "meyer_2013/first_order", "vezzoli_2014/fig7"},
        "figure 6": {"vezzoli_2014/fig6", "vezzoli_2014/fig6_gap"},
        "CurrentSine": {"kim_2015/current"},
        "sliding finger": {"shultz_2018/sliding"},
    }.items():
        assert expected <= set(names(scenarios(query)))
    assert "rauf_2025/field_50" not in names(scenarios("touchscreen"))
    own = [f"vezzoli_2014/{key}" for key in paper("vezzoli_2014").scenarios()]
    assert names(scenarios("vezzoli_2014"))[: len(own)] == own
    said = str(scenarios("vezzoli_2014/fig6"))
    for words in (
        "figure 6",
        "Vezzoli2014Causal",
        "insulator 90 um",
        "full text",
        "electrovib run vezzoli_2014/fig6",
    ):
        assert words in said


def test_unknown_names_are_answered_with_the_nearest_three_and_what_each_is():
    near = "Did you mean 'vezzoli_2014/fig6' (Vezzoli 2014, figure 6: 0 to 1000 V trapezoidal pulse"
    for door, wrong, words, counted, times in (
        (ev.scenarios, "vezzoli_2014/fgi66", near, "'vezzoli_2014/fig", 3),
        (ev.models, "MaxwellStressInGp", "Did you mean 'MaxwellStressInGap' (", "MaxwellStressIn", 4),
        (catalogue.find, "MaxwellStressInGp", "neither a model nor a paper", "", 0),
    ):
        with pytest.raises(InputError) as caught:
            door(wrong)
        said = str(caught.value)
        assert words in said
        assert not counted or said.count(counted) == times


def test_what_is_found_comes_with_a_reason_and_what_else_was_found_after_it():
    said = str(models("Constant"))
    assert "Constant (material)" in said
    assert "ConstantPhase" in said[said.index("Also found") :]
    found = models("touchscreen")
    assert {record.kind for record in found} >= {"paper", "scenario"}
    assert all(record.reason for record in found)
    assert "and " in str(found).splitlines()[-1]
    assert len(str(models("touchscreen", complete=True))) > len(str(found))
    assert "LuGre" in names(models("Stribeck speed"))
    assert "stribeck_speed (" in models("Stribeck speed")[0].reason
    assert "Square" in names(models("offset"))
    assert "gabriel_1996/wet" in names(models("whole skin"))
    shown = [str(models("Square", complete=each)) for each in (False, True)]
    assert ["[notes" in each for each in shown] == [False, True], "what only remarks mention"


@pytest.mark.parametrize("query", ["silica", "SiO2", "thermal oxide", "Silicon-dioxide"])
def test_a_material_of_the_library_is_found_by_each_of_its_names(query):
    found = models(query)
    assert found[0].name == "silica"
    assert 'stack.LAYER.material = "silica"' in str(found)
    for words in ("permittivity    3.9", "breakdown       1 GV/m", "abstract only", "measured at 50 nm"):
        assert words in str(found)
    assert "cited from memory" not in str(found)


def test_every_material_is_listed_found_by_every_name_and_finds_what_is_made_of_it():
    overview, entries = str(models()), tuple(everything())
    for substance in materials():
        assert substance.name in overview
        assert f"{substance.name} (material)\n===" in str(models(substance.name))
        for word in substance.aliases:
            first = search(word, entries)[0].entry
            assert (first.name, first.kind) == (substance.name, "material"), word
    assert {"persson_2018/coating", "vardar_2017/sine"} <= set(names(models("silica")))
    assert {"pet", "polyimide"} <= {record.name.casefold() for record in models("polymer film")}
    found = " ".join(str(models("polyimide")).split())
    for each in ("permittivity 3.4, 1 kHz, 25 um, 23 C", "conductivity 0.6667 fS/m, 23 C, 25 um"):
        assert f"{each} (unverified, cited from memory; " in found
    assert found.count("unverified, cited from memory") == 2, "exactly the values that were not read"
    assert "minimum of the data sheet, 60 Hz (full text; " in found


def test_the_overview_has_every_name_and_the_complete_list_every_status():
    said, complete = str(models()), str(models(complete=True))
    for record in models():
        assert record.name in complete
        assert record.status in complete
        assert record.name in said or record.kind in {"scenario", "part of a scenario"}
    assert len(said.splitlines()) <= 60
    assert max(map(len, said.splitlines())) <= 120
    assert "stack.LAYER.material" in said
    (record,) = [record for record in models() if record.name == "Vezzoli2014Causal"]
    assert "Vezzoli et al. 2014" in record.meaning, "its first sentence does not end at et al."


def test_records_show_themselves_in_a_terminal_and_in_a_notebook():
    for found in (models(), models("Sine"), scenarios(), scenarios("3M")):
        assert repr(found) == str(found)
        page = found._repr_html_()
        assert page.count("<tr>") == len(found) + 1
        assert page.startswith("<table>")
        assert all(record.name in page for record in found)
    assert "<script" not in catalogue.models("Maxwell")._repr_html_()


def test_a_place_in_a_scenario_takes_the_members_of_its_family():
    """Only the clock of a recorded measurement, and textures with their paths, have no place."""
    found = {path: family for family, path in items.places().items()}
    expected = {"drive": "Drive", "stack.LAYER.material": "Material", "contact.surface": "Surface"}
    assert {path: found[path].__name__ for path in expected} == expected
    for path, family in found.items():
        assert family.is_family
        assert "." in path or Scenario.part(path) is family
    without = set(items.families()) - set(items.places())
    assert {each.__name__ for each in without} == {"Clock", "FingerPath", "GratingWaveform", "Texture"}


def test_models_and_papers_are_listed_with_status_and_checks_and_found_by_name():
    listed = {entry.name: entry for entry in catalogue.models()}
    assert set(find_members(ForceLaw)) | set(papers()) <= set(listed)
    law = listed["Vezzoli2014Causal"]
    assert (law.paper, law.status, listed["vezzoli_2014"].checks) == ("vezzoli_2014", "full text", 3)
    assert re.search("\nchecked +2 full text, 1 derived here\n", str(catalogue.models("vezzoli_2014")))
    assert catalogue.models("MaxwellStressInGap")[0].group == "attraction of the finger"
    assert issubclass(catalogue.find("sine"), Model)
    assert catalogue.find("MaxwellStressInGap").__name__ == "MaxwellStressInGap"
    assert catalogue.find("bau_2010") is paper("bau_2010")
    assert catalogue.find("Amplifier") is Amplifier, "a part without a choice"


def test_every_paper_says_what_it_claims_and_what_not_and_shows_its_values_with_their_sources():
    """Of one film 1 um is a choice for a figure whose film Vezzoli et al. 2014 does not print; 90 um is printed."""
    for name, module in papers().items():
        said = pages.claims(module)
        assert said["claims"], name
        assert said["does not claim"], name
    said = pages.claims(papers()["nakamura_2017"])
    assert said["does not claim"].endswith("a spring constant.")
    assert said["here"].startswith("The electrics are two leaky layers"), (
        "what is computed here is told apart"
    )
    values = {row[0]: row[1:] for row in pages.values(papers()["kim_2015"]).rows}
    assert values["stack.insulator.thickness"] == ("90 um", "not read; as in vezzoli_2014, section 3.1")
    assert pages.values(papers()["ciavarella_2020"]) is None
    table = pages.values(papers()["vezzoli_2014"]).rows
    assert [row[1:] for row in table if row[0] == "stack.insulator.thickness"] == [
        ("90 um", "Vezzoli 2014, section 3.1"),
        ("1 um", "not printed: only that C_i is comparable with C_s"),
    ]
    places = [row[0] for row in table]
    for i, path in enumerate(places):
        assert places.count(path) == 1 or path in (places[i + 1 : i + 2] + places[max(i - 1, 0) : i])


def test_every_parameter_has_a_meaning_and_a_default_or_none_with_its_source():
    assert pages.parameters(Scenario).headings == (
        "name",
        "unit",
        "range",
        "default",
        "meaning",
        "source",
    )
    for item in everything(own=True):
        if isinstance(item.thing, type):
            assert all(row[4] for row in pages.parameters(item.thing).rows), item.thing.__name__
    for model, kind in MODELS.items():
        for name, _, _, default, meaning, source in pages.parameters(kind).rows:
            assert len(meaning) > 3, f"{model}.{name}"
            assert default, f"{model}.{name}"
            assert source, f"{model}.{name}"
            assert (source == "no default") == (default == "required"), f"{model}.{name}"
    assert "IEEE" in rows(MODELS["Grounded"])["resistance"][-1]
    rough = rows(MODELS["Persson2018RoughGap"])
    assert rough["mean_gap"][3:6:2] == ("required", "no default")
    assert rough["spots"][3] == "PullingSpots"
    assert rows(Scenario)["moisture"][4] == "moisture of a finger, from dry to wet"
