"""What is found and by which words: models and papers, here and in other packages, the search, citations."""

import re
import subprocess
import sys
from importlib.metadata import EntryPoint
from pathlib import Path

import pytest

from electrovib.core import discovery
from electrovib.core.citation import Check, Citation, bibtex_of, cited, counted
from electrovib.core.discovery import ENTRY_POINT_GROUP, find_members, paper, paper_names, papers
from electrovib.core.errors import ElectrovibError, InputError
from electrovib.core.model import Model, read_model
from electrovib.core.search import STAGES, Searchable, as_question, closest_entries, search, suggestions
from electrovib.physics.drive.base import Drive
from electrovib.studies import catalogue

NAME, LAST, ALIAS, _, PREFIX, WORDS, SPELLING = STAGES
MODULE = '''
from electrovib.core.model import Model

CITATION, STATUS, CHECKS, scenarios = "A. Example (2099), doi:10.0000/x", "derived", (), dict


class Shade(Model, family=True):
    """A family of the contributed package."""


class Dark(Shade):
    """A member of it."""

    depth: int = 5
'''


@pytest.fixture
def fresh():
    """Forget what was discovered before and after."""
    papers.cache_clear()
    yield
    papers.cache_clear()


@pytest.fixture
def installed(tmp_path, monkeypatch, fresh):
    """Put a package on the path as an installer would, with its entry points in a dist-info folder."""

    def install(name, text):
        info = tmp_path / "contributed-1.0.dist-info"
        info.mkdir()
        for file, content in {
            tmp_path / "contributed_example.py": text,
            info / "METADATA": "Metadata-Version: 2.1\nName: contributed\nVersion: 1.0\n",
            info / "entry_points.txt": f"[{ENTRY_POINT_GROUP}]\n{name} = contributed_example\n",
        }.items():
            file.write_text(content, encoding="utf-8")
        monkeypatch.syspath_prepend(str(tmp_path))

    yield install
    sys.modules.pop("contributed_example", None)


def test_our_papers_are_found_without_importing_them():
    assert "vezzoli_2014" in paper_names()
    assert list(paper_names()) == sorted(paper_names())
    assert set(paper_names()) <= set(papers())


def test_a_contributed_paper_is_found_and_has_a_near_name(installed):
    installed("example_2099", MODULE)
    assert "example_2099" in papers()
    module = paper("example_2099")
    assert module.CITATION.startswith("A. Example")
    assert set(find_members(module.Shade)) == {"Dark"}
    assert read_model(module.Shade, {"model": "Dark"}).depth == 5
    near = {"exampel_2099": "'example_2099'", "vezoli_2014": "'vezzoli_2014'"}
    for name, words in (near | {"nothing": "is neither a file nor a paper"}).items():
        with pytest.raises(InputError, match=words):
            paper(name)


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("vezzoli_2014", MODULE, "two papers are called 'vezzoli_2014'"),
        ("broken_2099", "import no_such", "'broken_2099' of another package.*no_such"),
    ],
)
def test_a_contribution_that_cannot_be_taken_is_named(installed, name, text, words):
    installed(name, text)
    with pytest.raises(ElectrovibError, match=words):
        papers()


def test_a_contribution_has_to_be_a_module(monkeypatch, fresh):
    entry = EntryPoint("odd_2099", "os:sep", ENTRY_POINT_GROUP)
    monkeypatch.setattr(discovery, "_contributed", lambda: (entry,))
    with pytest.raises(ElectrovibError, match="is not a module"):
        papers()


def test_members_of_families_within_families_are_found_and_two_of_one_name_are_refused():
    class Outer(Model, family=True):
        """Of this test."""

    class Inner(Outer, family=True):
        """Of this test."""

    one = type("One", (Outer,), {"__module__": "one", "__doc__": "First."})
    two = type("Two", (Inner,), {"__module__": "two", "__doc__": "Second."})
    assert find_members(Outer) == {"One": one, "Two": two}
    assert find_members(Inner) == {"Two": two}
    same = type("One", (Inner,), {"__module__": "two", "__doc__": "Third."})
    with pytest.raises(ElectrovibError, match=r"two models are called One: (one and two|two and one)"):
        find_members(Outer)
    assert same is not one


def test_a_member_is_found_wherever_in_the_room_of_its_family_it_is():
    """A folder of the family's own does not hide members beside the folder; no paper is imported for them."""
    code = (
        "import sys; from electrovib.core.discovery import find_members; from electrovib.physics.material import Material;"
        " found = find_members(Material, wanted='BridgedAir');"
        " print('BridgedAir' in found, any(name.startswith('electrovib.papers.') for name in sys.modules))"
    )
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert said == "True False\n"


def test_a_family_that_is_not_of_physics_has_its_members_beside_it():
    """So none is missed, although no other folder is imported for a name."""
    for family in Model.__subclasses__():
        if (
            family.is_family
            and family.__module__.startswith("electrovib.")
            and ".physics." not in family.__module__
        ):
            assert {each.__module__ for each in find_members(family).values()} == {family.__module__}


def test_a_paper_is_imported_only_when_its_name_is_wanted(monkeypatch, fresh):
    def refuse():
        raise AssertionError("papers were imported")

    monkeypatch.setattr(discovery, "papers", refuse)
    assert "Sine" in find_members(Drive, wanted="Sine")
    with pytest.raises(AssertionError, match="papers were imported"):
        find_members(Drive, wanted="NoSuchDrive")
    monkeypatch.undo()


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
        # a short word has to be there as it is: 3M is not the beginning of 3mm
        (["3M", "3m type"], [VARDAR]),
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


CITATION_FILE = Path(__file__).parents[3] / "CITATION.cff"
JOURNAL = {"journal": "J. Examples", "year": 2099, "volume": "7", "number": "2", "pages": "11-19"}
AUTHORS = ("A. Example", "B. de Other")
TITLE = "Forces & fields: 100 % of them"
ARTICLE = Citation(kind="article", authors=AUTHORS, title=TITLE, doi="10.0000/a_b", **JOURNAL)


def parsed(text):
    """Read BibTeX: entries as (type, key, fields); braces have to balance, and every field has one value."""
    entries, place = [], 0
    while (start := text.find("@", place)) >= 0:
        head = re.compile(r"@(\w+)\{([^,\s{}]+),\n").match(text, start)
        assert head, text[start : start + 60]
        fields, place = {}, head.end()
        while text[place] != "}":
            field = re.compile(r"  (\w+) = \{").match(text, place)
            assert field, text[place : place + 60]
            depth, end = 1, field.end()
            while depth:
                depth += {"{": 1, "}": -1}.get(text[end], 0)
                end += 1
            assert field[1] not in fields
            fields[field[1]] = text[field.end() : end - 1]
            place = end + (text[end] == ",") + 1
        entries.append((head[1], head[2], fields))
        place += 1
    return entries


def test_an_article_has_every_field_in_text_and_entry():
    said = f"A. Example, B. de Other, {TITLE}, J. Examples 7(2), 11-19 (2099), doi:10.0000/a_b"
    assert str(ARTICLE) == said
    assert cited((ARTICLE, ARTICLE)) == f"{said}; {said}"
    ((kind, key, fields),) = parsed(ARTICLE.bibtex("example_2099"))
    assert (kind, key) == ("article", "example_2099")
    written = {"author": "A. Example and B. de Other", "title": r"Forces \& fields: 100 \% of them"}
    assert fields == JOURNAL | written | {"year": "2099", "pages": "11--19", "doi": "10.0000/a_b"}


def test_what_is_not_known_is_omitted_and_further_authors_are_others():
    bare = Citation(kind="article", about="a subject", journal="J. Examples", year=2099, doi="10.0000/x")
    ((_, _, fields),) = parsed(bare.bibtex("bare_2099"))
    assert fields == {"journal": "J. Examples", "year": "2099", "doi": "10.0000/x", "note": "a subject"}
    assert str(bare) == "a subject, J. Examples (2099), doi:10.0000/x"
    place = {"kind": "inproceedings", "booktitle": "Conf 2099", "year": 2099}
    some = Citation(authors=("A. Example", "others"), title="T", **place)
    assert str(some) == "A. Example and others, T, Conf 2099"
    ((kind, _, fields),) = parsed(some.bibtex("example_2099"))
    assert (kind, fields["author"]) == ("inproceedings", "A. Example and others")


def test_checks_are_counted_by_status_the_best_first():
    checks = [
        Check("C", expect=1.0, rtol=0.1, source="a table", status=each) for each in ("derived", "in part")
    ]
    assert counted([*checks, *checks[:1]]) == "1 in part, 2 derived here"
    assert counted([]) == ""


def test_how_it_was_read_stands_before_the_entry_and_a_doubt_in_it_too():
    read = Citation(kind="misc", title="T", eprint="2099.00001", year=2099, read="abstract")
    doubtful = Citation(kind="misc", title="T", read="cited from memory, unverified", key="own_key")
    assert read.bibtex("a_2099").startswith("% source status: abstract\n@misc{a_2099,")
    assert "note" not in parsed(read.bibtex("a_2099"))[0][2]
    assert parsed(read.bibtex("a_2099"))[0][2]["archiveprefix"] == "arXiv"
    assert str(read) == "T, arXiv:2099.00001 (2099) (abstract)"
    ((_, key, fields),) = parsed(doubtful.bibtex("b_2099"))
    assert (key, fields["note"]) == ("own_key", "cited from memory, unverified")


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"kind": "book"}, "one of article, inproceedings, misc, not 'book'"),
        ({"kind": "article", "booktitle": "Conf"}, "an article has a journal"),
        ({"kind": "misc", "journal": "J. Examples"}, "an article has a journal"),
    ],
)
def test_a_kind_and_its_place_of_publication_belong_together(given, words):
    with pytest.raises(TypeError, match=words):
        Citation(**given)


def test_a_paper_of_another_package_may_give_a_text_only():
    text = "A. Example (2099), doi:10.0000/a_b (abstract)"
    ((kind, key, fields),) = parsed(bibtex_of(text, "example_2099"))
    assert (kind, key) == ("misc", "example_2099")
    assert fields == {"note": text.replace("_", r"\_"), "year": "2099", "doi": "10.0000/a_b"}


def test_every_paper_is_cited_by_entries_that_parse():
    """Each with its own key, the first with the name of the paper; a number stands in the text for people as well."""
    keys, whole = [], 0
    for name, module in papers().items():
        entries = parsed(catalogue.bibtex(module, name))
        assert entries[0][1] == name
        assert module.STATUS != "unverified" or "unverified" in entries[0][2]["note"]
        for kind, key, fields in entries:
            keys.append(key)
            assert {"title", "author", "note", "doi"} & set(fields)
            whole += kind in {"article", "inproceedings"} and {"author", "title", "year"} <= set(fields)
            for field in ("doi", "volume", "eprint"):
                assert field not in fields or fields[field] in module.CITATION
    assert len(keys) == len(set(keys))
    assert whole > 0.6 * len(keys), "a title that was not read is left out"


def test_the_citation_file_names_vezzoli_2014_as_the_paper_module_does():
    """A check of the few lines that are ours; the format is that of cff-version 1.2.0."""
    text = CITATION_FILE.read_text(encoding="utf-8")
    paper = papers()["vezzoli_2014"].CITATIONS[0]
    assert text.startswith("cff-version: 1.2.0\n")
    for field in ("message", "title", "type", "version", "date-released", "license", "authors", "references"):
        assert re.search(rf"^{field}:", text, re.MULTILINE), field
    references = text[text.index("references:") :]
    names = re.findall(r"family-names: (\S+)\n\s+given-names: (\S+)", references)
    assert tuple(f"{given} {family}" for family, given in names) == paper.authors
    assert f"year: {paper.year}" in references
    lines = {"title": paper.title, "collection-title": paper.booktitle, "notes": paper.archive}
    for key, value in lines.items():
        assert f'{key}: "{value}"' in references
