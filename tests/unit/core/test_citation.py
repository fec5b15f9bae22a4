"""A citation as data: a text for people, an entry for BibTeX, nothing invented."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from electrovib.core.citation import Citation, bibtex_of, cited
from electrovib.core.discovery import papers
from electrovib.study import catalogue

ROOT = Path(__file__).parents[3]
ARTICLE = Citation(
    kind="article",
    authors=("A. Example", "B. de Other"),
    title="Forces & fields: 100 % of them",
    journal="J. Examples",
    year=2099,
    volume="7",
    number="2",
    pages="11-19",
    doi="10.0000/a_b",
)


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


def test_an_article_is_written_for_people():
    said = "A. Example, B. de Other, Forces & fields: 100 % of them, J. Examples 7(2), 11-19 (2099), doi:10.0000/a_b"
    assert str(ARTICLE) == said


def test_an_article_is_an_entry_with_every_field():
    assert parsed(ARTICLE.bibtex("example_2099")) == [
        (
            "article",
            "example_2099",
            {
                "author": "A. Example and B. de Other",
                "title": r"Forces \& fields: 100 \% of them",
                "journal": "J. Examples",
                "year": "2099",
                "volume": "7",
                "number": "2",
                "pages": "11--19",
                "doi": "10.0000/a_b",
            },
        )
    ]


def test_what_is_not_known_is_omitted():
    bare = Citation(kind="article", about="a subject", journal="J. Examples", year=2099, doi="10.0000/x")
    ((_, _, fields),) = parsed(bare.bibtex("bare_2099"))
    assert fields == {"journal": "J. Examples", "year": "2099", "doi": "10.0000/x", "note": "a subject"}
    assert str(bare) == "a subject, J. Examples (2099), doi:10.0000/x"


def test_further_authors_are_others():
    some = Citation(
        kind="inproceedings", authors=("A. Example", "others"), title="T", booktitle="Conf 2099", year=2099
    )
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


def test_a_kind_and_its_place_of_publication_belong_together():
    with pytest.raises(TypeError, match="one of article, inproceedings, misc, not 'book'"):
        Citation(kind="book")
    with pytest.raises(TypeError, match="an article has a journal"):
        Citation(kind="article", booktitle="Conf")
    with pytest.raises(TypeError, match="an article has a journal"):
        Citation(kind="misc", journal="J. Examples")


def test_several_citations_are_one_text():
    assert cited((ARTICLE, ARTICLE)) == f"{ARTICLE}; {ARTICLE}"


def test_a_paper_of_another_package_may_give_a_text_only():
    ((kind, key, fields),) = parsed(
        bibtex_of("A. Example (2099), doi:10.0000/a_b (abstract)", "example_2099")
    )
    assert (kind, key) == ("misc", "example_2099")
    assert fields == {
        "note": r"A. Example (2099), doi:10.0000/a\_b (abstract)",
        "year": "2099",
        "doi": "10.0000/a_b",
    }


def test_every_paper_is_cited_by_entries_that_parse():
    """Each with its own key, the first with the name of the paper; a number stands in the text for people as well."""
    keys = []
    for name, module in papers().items():
        entries = parsed(catalogue.bibtex(module, name))
        assert entries[0][1] == name
        for _kind, key, fields in entries:
            keys.append(key)
            assert {"title", "author", "note", "doi"} & set(fields)
            for field in ("doi", "year", "volume", "eprint"):
                assert field not in fields or fields[field] in module.CITATION or field == "year"
    assert len(keys) == len(set(keys))
    assert len(keys) >= len(papers())


def test_most_papers_are_articles_or_contributions_with_authors_and_title():
    entries = [entry for name, module in papers().items() for entry in parsed(catalogue.bibtex(module, name))]
    whole = [
        fields
        for kind, _, fields in entries
        if kind in {"article", "inproceedings"} and {"author", "title", "year"} <= set(fields)
    ]
    assert len(whole) > 0.7 * len(entries)


def test_an_unverified_paper_says_so_in_its_entry():
    for name, module in papers().items():
        if module.STATUS == "unverified":
            assert "unverified" in parsed(catalogue.bibtex(module, name))[0][2]["note"]


def test_the_citation_file_names_vezzoli_2014_as_the_paper_module_does():
    """A check of the few lines that are ours; the format is that of cff-version 1.2.0."""
    text = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    paper = papers()["vezzoli_2014"].CITATIONS[0]
    assert text.startswith("cff-version: 1.2.0\n")
    for field in ("message", "title", "type", "version", "date-released", "license", "authors", "references"):
        assert re.search(rf"^{field}:", text, re.MULTILINE), field
    references = text[text.index("references:") :]
    names = re.findall(r"family-names: (\S+)\n\s+given-names: (\S+)", references)
    assert tuple(f"{given} {family}" for family, given in names) == paper.authors
    assert f'title: "{paper.title}"' in references
    assert f"year: {paper.year}" in references
    assert f'collection-title: "{paper.booktitle}"' in references
    assert f'notes: "{paper.archive}"' in references
