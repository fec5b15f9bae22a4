"""A citation as data: a text for people, an entry for BibTeX, nothing invented."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from electrovib.core.citation import Citation, bibtex_of, cited
from electrovib.core.discovery import papers
from electrovib.study import catalogue

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
    assert whole > 0.7 * len(keys)


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
    for key, value in (
        ("title", paper.title),
        ("collection-title", paper.booktitle),
        ("notes", paper.archive),
    ):
        assert f'{key}: "{value}"' in references
