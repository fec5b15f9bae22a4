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


def entry(name, meaning="", kind="x", aliases=(), **texts):
    return Searchable(name=name, kind=kind, meaning=meaning, aliases=aliases, texts=texts)


SCREEN = {"keywords": "3M-type screen", "sources": "silica coating, a choice"}
ENTRIES = (
    entry("Constant", "A dielectric without dispersion.", "material"),
    entry("ConstantPhase", "A constant-phase element.", "material"),
    entry("Step", "A voltage that is switched on.", "drive"),
    entry("MaxwellStressInGap", "Stress in the gap.", "force law"),
    entry("vardar_2017/sine", "A sine on a touch screen", "scenario", **SCREEN),
    entry("Offset", "Another drive on a constant voltage.", "drive"),
    entry("bau_2010/sine", "Bau 2010", "scenario", keywords="touchscreens, 3mm"),
    entry("Sine", "A sine.", "drive"),
)
SILICA = entry("silica", "glass", "material", aliases=("SiO2", "thermal oxide"))
MAXWELL, VARDAR, BAU = ("MaxwellStressInGap", PREFIX), ("vardar_2017/sine", WORDS), ("bau_2010/sine", WORDS)


def found(query, *entries):
    return [(match.entry.name, match.stage) for match in search(query, entries or ENTRIES)]


@pytest.mark.parametrize(
    ("queries", "expected"),
    [
        (["Constant"], [("Constant", NAME), ("ConstantPhase", PREFIX), ("Offset", WORDS)]),
        # the name after the slash is a name too, but comes after the whole name
        (["sine"], [("Sine", NAME), ("vardar_2017/sine", LAST), ("bau_2010/sine", LAST)]),
        (["Maxwell", "Stress", "stressIn", "Stress in gap"], [MAXWELL]),
        (["touchscreen", "touch screen", "TOUCH-SCREENS", "touchscreens"], [VARDAR, BAU]),
        (
            ["3M", "3m type"],
            [VARDAR],
        ),  # a short word has to be there as it is: 3M is not the beginning of 3mm
        (["silica coating"], [VARDAR]),
        (["silica teflon", "axwell", "zzzz", "   ", "x" * 100_000], []),
        (["Maxwel stres"], [("MaxwellStressInGap", WORDS)]),
    ],
)
def test_what_is_found_and_at_which_stage(queries, expected):
    for query in queries:
        assert found(query) == expected, query


def test_capitals_blanks_and_hyphens_do_not_count_but_the_name_as_written_is_preferred():
    entries = entry("SINE"), entry("Sine")
    assert found("Sine", *entries) == [("Sine", NAME), ("SINE", NAME)]
    assert found("sInE", *entries) == [("SINE", NAME), ("Sine", NAME)]
    for query in ("soda lime glass", "Soda-Lime glass"):
        assert found(query, entry("soda_lime_glass")) == [("soda_lime_glass", NAME)]
    (match,) = search("Thermal-Oxide", [SILICA])
    assert (match.entry.name, match.stage) == ("silica", ALIAS)
    assert match.reason == "'Thermal-Oxide' is another name of silica"
    assert found("sio2", SILICA) == [("silica", ALIAS)]
    assert found("oxides", SILICA) == [("silica", WORDS)]


def test_a_result_of_a_better_text_comes_first_and_the_reason_quotes_it():
    film = entry("a", "m", keywords="none", sources="polyimide film of 25 um")
    matches = search("polyimide", [film, entry("b", "m", keywords="polyimide"), entry("c", "Polyimide.")])
    assert [(match.entry.name, match.reason) for match in matches] == [
        ("c", "its description"),
        ("b", "keywords: polyimide"),
        ("a", "sources: polyimide film of 25 um"),
    ]
    # the worst placed word of a query counts
    entries = (
        entry("a", "glass", keywords="thin", sources="hard"),
        entry("b", "glass", keywords="hard", sources=""),
    )
    assert [name for name, _ in found("glass hard", *entries)] == ["b", "a"]
    (match,) = search("polyimide", [entry("a", note=f"{'before ' * 30}polyimide {'after ' * 30}")])
    assert "polyimide" in match.reason
    assert len(match.reason) < 110


def test_spelling_is_the_last_resort_and_gives_three():
    assert found("onstantPhas")[0][1] == SPELLING
    near = search("Constnat", ENTRIES)
    assert {match.stage for match in near} == {SPELLING}
    assert near[0].entry.name == "Constant"
    assert len(near) == 3
    assert closest_entries("zzzz", ENTRIES) == ()
    assert closest_entries("vardar_2017/sinus", ENTRIES)[0].entry.name == "vardar_2017/sine"
    assert closest_entries("sinus", ENTRIES)[0].entry.name in {"Sine", "vardar_2017/sine", "bau_2010/sine"}


def test_a_question_names_what_a_search_finds_and_then_similar_names_each_with_what_it_is():
    matches = suggestions("Constant", ENTRIES)
    names = [match.entry.name for match in matches]
    assert names[:2] == ["Constant", "ConstantPhase"]
    assert len(set(names)) == len(names) == 3
    first = "'Constant' (A dielectric without dispersion)"
    assert as_question(matches[:1]) == f" Did you mean {first}?"
    assert as_question(matches[:2]) == f" Did you mean {first} or 'ConstantPhase' (A constant-phase element)?"
    assert as_question(()) == ""
