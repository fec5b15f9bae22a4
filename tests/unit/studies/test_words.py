"""Words of the field in `electrovib list`: each leads to what exists, or to the statement that it is not modelled."""

import re
from types import ModuleType

import pytest
from typer.testing import CliRunner

import electrovib as ev
from electrovib.apps.cli import app
from electrovib.core.discovery import papers
from electrovib.core.errors import InputError
from electrovib.core.search import ALIAS, NAME, Searchable, search
from electrovib.scenario import Scenario
from electrovib.studies.catalogue import items
from electrovib.studies.catalogue.found import meanings
from electrovib.studies.catalogue.items import everything

ENTRIES = tuple(everything())
TABLE = [(kind, each) for kind, found in meanings().items() for each in found]
WORDS = [word for _, each in TABLE for word in each["words"]]


@pytest.mark.parametrize(("kind", "each"), TABLE, ids=[each["words"][0] for _, each in TABLE])
def test_what_a_word_leads_to_exists(kind, each):
    """Entries, commands, functions and parameters alike."""
    assert set(each["see"]) <= {item.name for item in ENTRIES}
    assert kind == "missing" or each["see"], "a word that is here leads somewhere"
    commands = {command.name or command.callback.__name__ for command in app.registered_commands}
    assert set(re.findall(r"'electrovib ([\w-]+)", each["says"])) <= commands
    assert all(hasattr(ev, name) for name in re.findall(r"\bev\.(\w+)", each["says"]))
    for part, name in re.findall(r"\b(circuit)\.([a-z_]+)", each["says"]):
        assert name in Scenario.model_fields[part].annotation.model_fields


def test_no_word_hides_an_entry_or_another_word():
    known = [frozenset(word.split()) for word in WORDS]
    assert len(set(known)) == len(known)
    named = [Searchable(name=each.name, kind="", meaning="", aliases=each.aliases) for each in ENTRIES]
    for word in WORDS:
        assert word == word.casefold()
        described = Searchable(name="", kind="", meaning=word)  # with which every search ends
        assert not {match.stage for match in search(word, [*named, described])} & {NAME, ALIAS}, word


@pytest.mark.parametrize(
    ("query", "first"),
    [
        ("differential", ["SecondElectrode", "OneOfTwoInAntiphase"]),
        ("two electrodes", ["SecondElectrode", "OneOfTwoInAntiphase", "kaczmarek_2006"]),
        ("electrodes, two", ["SecondElectrode", "OneOfTwoInAntiphase", "kaczmarek_2006"]),
        ("differential drive of a screen", ["SecondElectrode", "OneOfTwoInAntiphase"]),
        ("ridges", ["FittedSurface", "PerssonSurface", "BearingArea", "Persson2018RoughGap"]),
        ("ITO", ["Circuit", "persson_2018/coating", "vardar_2017/sine", "SecondElectrode"]),
        (
            "coating",
            ["Layer", "vezzoli_2014/coating", "vezzoli_2014/film", "persson_2018/coating", "popov_2018"],
        ),
    ],
)
def test_a_word_of_the_field_finds_what_is_here_under_another_name(query, first):
    found = ev.models(query)
    assert [each.name for each in found][: len(first)] == first
    assert str(found).startswith(f"{query}: ")
    assert found[0].reason == "belongs to it"
    assert query in found._repr_html_()


@pytest.mark.parametrize(
    "query", ["mutual capacitance", "ultrasonic", "sound", "ultrasonic friction reduction"]
)
def test_what_is_not_modelled_is_said_and_is_no_mistake(query):
    done = CliRunner().invoke(app, ["list", *query.split()])
    assert done.exit_code == 0
    assert done.output.startswith(f"{query}: not modelled: ")
    with pytest.raises(InputError, match="no model, material"):
        ev.models("quantum")


def test_the_overview_names_what_is_not_modelled():
    said = " ".join(str(ev.models()).split())
    assert "Not modelled: mutual capacitance, ultrasonic, capillary" in said
    assert f"scenarios {len(ev.scenarios())}, listed by" in said
    assert said == " ".join(CliRunner().invoke(app, ["list"]).output.split())


def test_the_scenarios_of_another_package_are_counted_although_it_declares_none(monkeypatch):
    other = ModuleType("other_2099")
    other.scenarios = lambda: {"one": None, "two": None}
    monkeypatch.setattr(
        items, "papers", lambda: {**papers(), "other_2099": other, "none_2099": ModuleType("none")}
    )
    assert items.scenario_count() == len(ev.scenarios()) + 2
