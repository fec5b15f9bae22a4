"""The search of the catalogue: by name, part of a name, words, and spelling, in this order."""

from __future__ import annotations

import pytest

from electrovib.core.search import (
    ALIAS,
    LAST,
    NAME,
    PREFIX,
    SPELLING,
    WORDS,
    Searchable,
    as_question,
    closest_entries,
    search,
    suggestions,
)

ENTRIES = (
    Searchable(name="Constant", kind="material", meaning="A dielectric without dispersion."),
    Searchable(name="ConstantPhase", kind="material", meaning="A constant-phase element."),
    Searchable(name="Step", kind="drive", meaning="A voltage that is switched on."),
    Searchable(name="MaxwellStressInGap", kind="force law", meaning="Stress in the gap."),
    Searchable(
        name="vardar_2017/sine",
        kind="scenario",
        meaning="A sine on a touch screen",
        texts={"keywords": "3M-type screen", "sources": "silica coating, a choice"},
    ),
    Searchable(name="Offset", kind="drive", meaning="Another drive on a constant voltage."),
    Searchable(
        name="bau_2010/sine", kind="scenario", meaning="Bau 2010", texts={"keywords": "touchscreens, 3mm"}
    ),
    Searchable(name="Sine", kind="drive", meaning="A sine."),
)


def found(query, entries=ENTRIES):
    return [(match.entry.name, match.stage) for match in search(query, entries)]


def test_an_exact_name_comes_first_then_parts_and_words():
    assert found("Constant") == [
        ("Constant", NAME),
        ("ConstantPhase", PREFIX),
        ("Offset", WORDS),
    ]


def test_capitals_do_not_count_but_the_name_as_written_is_preferred():
    entries = [Searchable(name="SINE", kind="a", meaning=""), Searchable(name="Sine", kind="b", meaning="")]
    assert found("Sine", entries) == [("Sine", NAME), ("SINE", NAME)]
    assert found("sInE", entries) == [("SINE", NAME), ("Sine", NAME)]


def test_the_name_after_the_slash_is_a_name_too_but_comes_after_the_whole_name():
    assert found("sine") == [("Sine", NAME), ("vardar_2017/sine", LAST), ("bau_2010/sine", LAST)]


def test_hyphens_of_another_name_do_not_count():
    silica = Searchable(name="silica", kind="material", meaning="glass", aliases=("SiO2", "thermal oxide"))
    matches = search("Thermal-Oxide", [silica])
    assert [(match.entry.name, match.stage) for match in matches] == [("silica", ALIAS)]
    assert matches[0].reason == "'Thermal-Oxide' is another name of silica"
    assert found("sio2", [silica]) == [("silica", ALIAS)]
    assert found("oxides", [silica]) == [("silica", WORDS)]


def test_blanks_and_underscores_of_a_name_do_not_count():
    entries = [Searchable(name="soda_lime_glass", kind="material", meaning="")]
    assert (
        found("soda lime glass", entries) == found("Soda-Lime glass", entries) == [("soda_lime_glass", NAME)]
    )


@pytest.mark.parametrize("query", ["Maxwell", "Stress", "gap", "stressIn", "Stress in gap"])
def test_a_name_is_found_by_the_beginning_of_each_of_its_parts(query):
    assert ("MaxwellStressInGap", PREFIX) in found(query)


def test_a_name_is_not_found_by_the_middle_of_a_part():
    assert found("onstantPhas")[0][1] == SPELLING
    assert found("axwell") == []


@pytest.mark.parametrize("query", ["touchscreen", "touch screen", "TOUCH-SCREENS", "touchscreens"])
def test_touch_screen_is_one_word_however_it_is_written(query):
    assert found(query) == [("vardar_2017/sine", WORDS), ("bau_2010/sine", WORDS)]


def test_a_short_word_has_to_be_there_as_it_is():
    """3M is not the beginning of 3mm."""
    assert found("3M") == [("vardar_2017/sine", WORDS)]
    assert found("3m type") == [("vardar_2017/sine", WORDS)]


def test_every_word_has_to_be_found():
    assert found("silica coating") == [("vardar_2017/sine", WORDS)]
    assert found("silica teflon") == []


def test_a_result_of_a_better_text_comes_first_and_the_reason_quotes_it():
    entries = [
        Searchable(
            name="a", kind="x", meaning="m", texts={"keywords": "none", "sources": "polyimide film of 25 um"}
        ),
        Searchable(name="b", kind="x", meaning="m", texts={"keywords": "polyimide", "sources": "none"}),
        Searchable(name="c", kind="x", meaning="Polyimide.", texts={}),
    ]
    matches = search("polyimide", entries)
    assert [match.entry.name for match in matches] == ["c", "b", "a"]
    assert matches[0].reason == "its description"
    assert matches[1].reason == "keywords: polyimide"
    assert matches[2].reason == "sources: polyimide film of 25 um"


def test_the_worst_placed_word_of_a_query_counts():
    entries = [
        Searchable(name="a", kind="x", meaning="glass", texts={"keywords": "thin", "sources": "hard"}),
        Searchable(name="b", kind="x", meaning="glass", texts={"keywords": "hard", "sources": "thin"}),
    ]
    assert [match.entry.name for match in search("glass hard", entries)] == ["b", "a"]


def test_a_long_text_is_quoted_around_the_word():
    text = f"{'before ' * 30}polyimide {'after ' * 30}"
    (match,) = search("polyimide", [Searchable(name="a", kind="x", meaning="m", texts={"note": text})])
    assert "polyimide" in match.reason
    assert len(match.reason) < 110


def test_spelling_is_the_last_resort_and_gives_three():
    assert found("Maxwel stres") == [("MaxwellStressInGap", WORDS)]
    near = search("Constnat", ENTRIES)
    assert {match.stage for match in near} == {SPELLING}
    assert near[0].entry.name == "Constant"
    assert len(near) == 3


def test_nothing_is_suggested_for_what_resembles_no_name():
    assert found("zzzz") == []
    assert found("   ") == []
    assert closest_entries("zzzz", ENTRIES) == ()


def test_a_name_with_a_slash_is_compared_as_a_whole():
    assert closest_entries("vardar_2017/sinus", ENTRIES)[0].entry.name == "vardar_2017/sine"
    assert closest_entries("sinus", ENTRIES)[0].entry.name in {"Sine", "vardar_2017/sine", "bau_2010/sine"}


def test_suggestions_are_what_a_search_finds_and_then_similar_names_none_twice():
    names = [match.entry.name for match in suggestions("Constant", ENTRIES)]
    assert names[:2] == ["Constant", "ConstantPhase"]
    assert len(set(names)) == len(names) == 3


def test_a_question_names_each_with_what_it_is():
    matches = search("Constant", ENTRIES)[:2]
    assert as_question(matches) == (
        " Did you mean 'Constant' (A dielectric without dispersion) or 'ConstantPhase' (A constant-phase element)?"
    )
    assert as_question(matches[:1]) == " Did you mean 'Constant' (A dielectric without dispersion)?"
    assert as_question(()) == ""


def test_a_query_as_long_as_a_file_ends_soon():
    assert search("x" * 100_000, ENTRIES) == ()
