"""The page for heirs: short, its drawing is that of the layers, and what it names is there and says why."""

import ast
import re
from xml.etree import ElementTree as ET

from source import ROOT, SOURCE, text_of, tree_of
from test_rings import LAYERS

PAGE = ROOT / "docs" / "architecture.md"
DRAWING = ROOT / "docs" / "images" / "architecture.svg"
NAME = re.compile(r"`([\w.]*/[\w/.]*|\w+\.(?:py|toml|md))`")
QUESTION = re.compile(r"^\| .+\? \| `([\w/]+/)` \|$", re.MULTILINE)
MOST_WORDS = 600


def is_there(name):
    """Whether a file, or a folder that ends in a slash, is in the package or the repository."""
    places = (SOURCE / name, ROOT / name)
    return any(place.is_dir() if name.endswith("/") else place.is_file() for place in places)


def words_of(kind):
    """Texts of one kind in the drawing, from top to bottom and from left to right."""
    texts = [each for each in ET.parse(DRAWING).iter() if each.get("class") == kind]
    return [
        each.text for each in sorted(texts, key=lambda each: (float(each.get("y")), float(each.get("x"))))
    ]


def test_the_page_is_short_and_shows_the_drawing_and_the_tour():
    text = text_of(PAGE)
    assert len(text.split()) <= MOST_WORDS
    assert "](images/architecture.svg)" in text
    assert "](contribute/tour.md)" in text


def test_every_file_and_folder_that_is_named_exists():
    named = NAME.findall(text_of(PAGE))
    assert len(named) > 20
    assert [name for name in named + words_of("path") if not is_there(name)] == []
    assert not any(map(is_there, ("solve/electrics.py", "solve/choice/", "core/none.py")))


def test_every_folder_that_answers_a_question_says_more_than_what_it_is():
    folders = QUESTION.findall(text_of(PAGE))
    assert {"core/", "solve/population/", "studies/check/", "bench/", "apps/explorer/"} <= set(folders)
    for folder in folders:
        told = ast.get_docstring(tree_of(SOURCE / folder / "__init__.py"))
        assert len(told.split("\n\n")) > 1, folder


def test_the_drawing_has_the_folders_in_the_order_of_their_imports_and_the_data_in_theirs():
    assert words_of("folder") == [name.strip() for line in LAYERS for name in line.split("|")]
    flow = "drive -> amplifier -> stack and circuit -> force -> contact -> friction -> finger and rig -> perception"
    assert words_of("stage") == flow.split(" -> ")
