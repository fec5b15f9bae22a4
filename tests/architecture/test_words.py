"""The words that the nomenclature has replaced stand nowhere, apart from what reads files that were written with them."""

import re
from functools import cache

import pytest
from source import ROOT, text_of

from electrovib.core.signals import SIGNALS

PAGE = ROOT / "docs" / "nomenclature.md"
MIGRATION = re.compile(r"former", re.IGNORECASE)
"""Lines that name a former word in order to read it."""
ELSEWHERE = re.compile(r"(half|complex) plane|plane strain")
"""Mathematics and mechanics have planes of their own."""
PHRASES = {
    "`polarisation()` for a permittivity": r"\bpolarisation\(",
    "`ringing()`": r"\bringing\(",
    "trapezium": r"(?<![\w\"'.])trapezium(?![\w\"'(]| = )",
}
"""How an entry of the table is found in a text, where it is not simply the word."""


def terms():
    """Rows of the table of terms: term, meaning, former words."""
    text = PAGE.read_text(encoding="utf-8").split("## Terms")[1].split("## Signals")[0]
    rows = [line.strip("| ").split(" | ") for line in text.splitlines() if line.startswith("| ")]
    return [[cell.strip(" |") for cell in row] for row in rows if row[0] != "term"]


def former_words():
    return [word.strip() for row in terms() if len(row) > 2 for word in row[2].split(",") if word.strip()]


def pattern(word):
    if word in PHRASES:
        return re.compile(PHRASES[word])
    plain = re.escape(word.strip("`"))
    return re.compile(rf"\b{plain}(s|'s)?\b", re.IGNORECASE if plain.islower() else 0)


@cache
def lines():
    """All text that a user or an heir reads, line by line."""
    found = []
    places = [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")]
    for folder in ("src", "examples"):
        for ending in ("py", "jinja", "css", "toml", "md"):
            places += (ROOT / folder).rglob(f"*.{ending}")
    for path in sorted(places):
        if path == PAGE:
            continue
        for number, line in enumerate(text_of(path).splitlines(), 1):
            if not MIGRATION.search(line):
                found.append((f"{path.relative_to(ROOT)}:{number}", ELSEWHERE.sub("", line)))
    return found


def test_the_table_has_the_words_that_were_replaced():
    words = former_words()
    assert len(words) == len(set(words)) > 20
    known = {"lamp", "plane", "coat", "relief", "way", "programme", "recalled", "how read", "`truth_table`"}
    assert known <= set(words)


@cache
def whole():
    """All lines as one text, in which a word is found much sooner."""
    return "\n".join(line for _, line in lines())


@pytest.mark.parametrize("word", former_words())
def test_a_replaced_word_stands_nowhere(word):
    wanted = pattern(word)
    if not wanted.search(whole()):
        return
    found = [f"{where}: {line.strip()}" for where, line in lines() if wanted.search(line)]
    assert not found, "\n".join(found)


@pytest.mark.parametrize(
    ("word", "found", "other"),
    [
        ("lamp", ("a lamp warns", "two Lamps"), "clamped"),
        ("trapezium", ("a trapezium of 1 kV",), 'DRIVES["trapezium"] = Trapezium'),
        ("way", ("the way to go",), "always"),
        ("`GapPlane`", ('model = "GapPlane"',), "gapplane"),
        ("`ringing()`", ("ev.ringing(trace)",), "the ringing of a sensor"),
    ],
)
def test_words_are_found_and_not_their_like(word, found, other):
    assert all(pattern(word).search(line) for line in found)
    assert not pattern(word).search(other)


def test_the_table_of_signals_is_that_of_the_code():
    table = [
        f"| `{name}` | {known.symbol and f'${known.symbol}$'} | {known.unit} | {known.doc} |"
        for name, known in SIGNALS.items()
    ]
    text = PAGE.read_text(encoding="utf-8").split("<!-- signals -->\n")[1].split("<!-- end -->")[0]
    assert text == "\n".join(["| signal | symbol | unit | meaning |", "|---|---|---|---|", *table, ""])
