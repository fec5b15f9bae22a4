"""What a user finds: the catalogue of models, papers and scenarios, and the search of it."""

from __future__ import annotations

import functools

import pytest

import electrovib as ev
from electrovib.core.discovery import offers, paper, papers
from electrovib.core.errors import InputError
from electrovib.core.model import Model
from electrovib.scenario import Scenario
from electrovib.study import catalogue
from electrovib.study.catalogue.items import everything


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


def test_every_preset_is_listed_with_its_title_and_what_it_reproduces():
    offered = offers(("scenarios",))
    assert names(scenarios()) == list(offered)
    for record in scenarios():
        assert record.meaning == offered[record.name].title
        assert record.reproduces, record.name
        assert record.name in str(scenarios())
        assert record.reproduces in str(scenarios())


def test_a_line_does_not_repeat_the_paper_and_the_figure_that_stand_beside_it():
    (line,) = [line for line in str(scenarios()).splitlines() if line.startswith("vezzoli_2014/fig6 ")]
    assert line.split("figure 6")[1].strip().startswith("0 to 1000 V trapezoidal pulse")


def test_a_figure_is_named_where_the_title_names_one():
    for record in scenarios():
        if ", figure " in record.meaning:
            figure = record.meaning.split(", figure ")[1].split()[0].strip(":,")
            assert f"figure {figure}" in record.reproduces


@pytest.mark.parametrize("query", ["3M", "3M-type screen"])
def test_the_presets_nearest_to_a_3m_type_screen(query):
    """Thin coatings of 1 um and permittivity 3.9, first the one whose numbers `compare` uses; the reason says so."""
    found = scenarios(query)
    assert names(found)[0] == "persson_2018/coating"
    assert {"vardar_2017/sine", "vardar_2017/square"} <= set(names(found))
    assert all("3M-type screen" in record.reason and "unverified" in str(found) for record in found)
    assert "insulator 1 um (silica, permittivity 3.9)" in str(found)
    for record in found:
        layer = offers(("scenarios",))[record.name].stack.layers["insulator"]
        assert (layer.thickness, layer.material.permittivity) == (1e-6, 3.9)


def test_presets_are_found_by_device_model_figure_and_layer():
    assert {"bau_2010/sine", "meyer_2013/first_order", "vezzoli_2014/fig7"} <= set(
        names(scenarios("touchscreen"))
    )
    assert "rauf_2025/field_50" not in names(scenarios("touchscreen"))
    assert set(names(scenarios("figure 6"))) >= {"vezzoli_2014/fig6", "vezzoli_2014/fig6_gap"}
    assert "kim_2015/current" in names(scenarios("CurrentSine"))
    own = [f"vezzoli_2014/{key}" for key in paper("vezzoli_2014").scenarios()]
    assert names(scenarios("vezzoli_2014"))[: len(own)] == own
    assert "shultz_2018/sliding" in names(scenarios("sliding finger"))


def test_one_preset_is_shown_in_full():
    said = str(scenarios("vezzoli_2014/fig6"))
    for words in (
        "figure 6",
        "Vezzoli2014Causal",
        "insulator 90 um",
        "full text",
        "electrovib run vezzoli_2014/fig6",
    ):
        assert words in said


def test_an_unknown_preset_is_answered_with_the_nearest_three_and_what_each_is():
    with pytest.raises(InputError) as caught:
        ev.scenarios("vezzoli_2014/fgi66")
    said = str(caught.value)
    assert "Did you mean 'vezzoli_2014/fig6' (Vezzoli 2014, figure 6: 0 to 1000 V trapezoidal pulse" in said
    assert said.count("'vezzoli_2014/fig") == 3


def test_a_model_is_shown_in_full_and_what_else_was_found_after_it():
    said = str(models("Constant"))
    assert "Constant (material)" in said
    assert "ConstantPhase" in said[said.index("Also found") :]


def test_a_word_finds_materials_papers_and_scenarios_with_a_reason_each():
    found = models("touchscreen")
    assert {record.kind for record in found} >= {"paper", "scenario"}
    assert all(record.reason for record in found)
    assert "and " in str(found).splitlines()[-1]
    assert len(str(models("touchscreen", complete=True))) > len(str(found))


@pytest.mark.parametrize("query", ["silica", "SiO2", "thermal oxide", "Silicon-dioxide"])
def test_a_material_of_the_library_is_found_by_each_of_its_names(query):
    found = models(query)
    assert found[0].name == "silica"
    assert 'stack.LAYER.material = "silica"' in str(found)
    for words in ("permittivity    3.9", "breakdown       1 GV/m", "abstract only", "measured at 50 nm"):
        assert words in str(found)
    assert "cited from memory" not in str(found)


def test_exactly_the_values_that_were_not_read_are_marked_as_unverified():
    found = " ".join(str(models("polyimide")).split())
    for each in ("permittivity 3.4, 1 kHz, 25 um, 23 C", "conductivity 0.6667 fS/m, 23 C, 25 um"):
        assert f"{each} (unverified, cited from memory; " in found
    assert found.count("unverified, cited from memory") == 2
    assert "minimum of the data sheet, 60 Hz (full text; " in found


def test_a_material_finds_the_scenarios_that_are_made_of_it():
    assert {"persson_2018/coating", "vardar_2017/sine"} <= set(names(models("silica")))
    assert {"pet", "polyimide"} <= {record.name.casefold() for record in models("polymer film")}


def test_every_material_of_the_library_is_listed_and_found_by_every_name():
    from electrovib.physics.material.library import materials

    for substance in materials():
        for word in (substance.name, *substance.aliases):
            assert f"{substance.name} (material)\n===" in str(models(word)), word
        assert substance.name in str(models())


def test_a_parameter_and_a_note_are_found():
    assert "LuGre" in names(models("Stribeck speed"))
    assert "stribeck_speed (" in models("Stribeck speed")[0].reason
    assert "Square" in names(models("offset"))
    assert "gabriel_1996/wet" in names(models("whole skin"))


def test_what_only_remarks_mention_is_not_listed_beside_an_entry_of_the_name():
    assert "[notes" not in str(models("Square"))
    assert "[notes" in str(models("Square", complete=True))


def test_the_first_sentence_of_a_model_does_not_end_at_et_al():
    (record,) = [record for record in models() if record.name == "Vezzoli2014Causal"]
    assert "Vezzoli et al. 2014" in record.meaning


def test_an_unknown_name_is_answered_with_three_and_what_each_is():
    with pytest.raises(InputError) as caught:
        ev.models("MaxwellStressInGp")
    said = str(caught.value)
    assert "Did you mean 'MaxwellStressInGap' (" in said
    assert said.count("MaxwellStressIn") == 4  # what was written, and three


def test_the_overview_has_every_name_and_fits_a_screen_or_so():
    said = str(models())
    for record in models():
        if record.kind not in {"scenario", "part of a scenario"}:
            assert record.name in said, record.name
    assert len(said.splitlines()) <= 60
    assert max(map(len, said.splitlines())) <= 120
    assert "stack.LAYER.material" in said


def test_the_complete_list_has_every_record_with_its_status():
    said = str(models(complete=True))
    for record in models():
        assert record.name in said
        assert record.status in said


def test_a_place_in_a_scenario_takes_the_members_of_its_family():
    found = {path: family for family, path in catalogue.places().items()}
    assert found["drive"].__name__ == "Drive"
    assert found["stack.LAYER.material"].__name__ == "Material"
    assert found["contact.surface"].__name__ == "Surface"
    for path, family in found.items():
        assert family.is_family
        if "." not in path:
            assert Scenario.part(path) is family


def test_every_family_that_a_scenario_holds_has_a_place():
    """Only the clock of a recorded measurement, and textures with their paths, have none."""
    without = {family.__name__ for family in catalogue.families()} - {
        family.__name__ for family in catalogue.places()
    }
    assert without == {"Clock", "FingerPath", "GratingWaveform", "Texture"}


def test_records_show_themselves_in_a_terminal_and_in_a_notebook():
    for found in (models(), models("Sine"), scenarios(), scenarios("3M")):
        assert repr(found) == str(found)
        page = found._repr_html_()
        assert page.count("<tr>") == len(found) + 1
        assert page.startswith("<table>")
        assert all(record.name in page for record in found)
    assert "<script" not in catalogue.models("Maxwell")._repr_html_()


def test_every_preset_of_a_paper_is_declared_and_no_other():
    for name, module in papers().items():
        declared = set(getattr(module, "PRESETS", {}))
        offered = set(getattr(module, "scenarios", dict)())
        assert declared == offered or not catalogue.is_own(module), name


def test_a_model_by_itself_is_found_by_its_class():
    assert issubclass(catalogue.find("sine"), Model)
    assert catalogue.find("MaxwellStressInGap").__name__ == "MaxwellStressInGap"
    assert catalogue.find("bau_2010") is paper("bau_2010")


def test_every_parameter_of_every_model_has_a_meaning():
    import electrovib.bench.settings  # its models are found once they are imported

    assert electrovib.bench.settings
    for item in everything(own=True):
        if isinstance(item.thing, type):
            for name, *_, meaning, _ in catalogue.parameters(item.thing).rows:
                assert meaning, f"{item.thing.__name__}.{name}"
    rows = {row[0]: row[4] for row in catalogue.parameters(Scenario).rows}
    assert rows["moisture"] == "moisture of a finger, from dry to wet"
