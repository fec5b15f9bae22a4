"""Every link and picture of the texts leads somewhere: in the repository, where a code host shows it, and on the site."""

import importlib
import os
import re
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
TEXTS = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")])
CODE = re.compile(r"^( *)```.*?^\1```|`[^`\n]*`", re.DOTALL | re.MULTILINE)
LINK = re.compile(r"(!?)\[((?:[^\[\]]|\[[^\]]*\])*)\]\(([^()\s]+)\)")
TAG = re.compile(r"<(?:img|a)\b[^>]*?(?:src|href)=\"([^\"]+)\"")
SOURCE = re.compile(r"^(?:\.\./)+((?:src|examples)\b.*)$")


@pytest.fixture
def sources(monkeypatch):
    """Return the part of the build that leads links into the source to pages."""
    monkeypatch.syspath_prepend(str(ROOT / "docs" / "_ext"))
    return importlib.import_module("sources")


def links(text: Path):
    """Words and targets of the links and pictures of a text, code left out."""
    content = text.read_text(encoding="utf-8")
    plain = re.sub(r"^( *)```.*?^\1```", "", content, flags=re.DOTALL | re.MULTILINE)
    found = [(words, target) for _, words, target in LINK.findall(plain)]
    found += [("a picture", target) for target in TAG.findall(plain)]
    return [(words, target) for words, target in found if not re.match(r"[a-z]+:", target)]


def anchors(text: Path):
    """Anchors that a code host gives to the headings of a text."""
    headings = re.findall(
        r"^#+ +(.+?) *$", CODE.sub(lambda found: found[0].strip("`"), text.read_text()), re.MULTILINE
    )
    return {re.sub(r"[^\w\- ]", "", each.lower()).replace(" ", "-") for each in headings}


@pytest.fixture(scope="module")
def ignored():
    """Return a function that tells whether the repository leaves a file out."""

    def is_left_out(file: Path) -> bool:
        done = subprocess.run(["git", "check-ignore", "-q", str(file)], cwd=ROOT, check=False)
        return (ROOT / ".git").exists() and done.returncode == 0

    return is_left_out


@pytest.mark.parametrize("text", TEXTS, ids=lambda text: text.relative_to(ROOT).as_posix())
def test_links_and_pictures_lead_to_files_of_the_repository(text, ignored):
    for words, target in links(text):
        path, _, anchor = target.partition("#")
        there = Path(os.path.normpath(text.parent / path)) if path else text
        assert words, f"{target}: a link without words is not seen"
        assert there.is_relative_to(ROOT), target
        assert there.exists(), target
        assert not ignored(there), target
        if there.suffix == ".md" and anchor:
            assert anchor in anchors(there), target
        if there.suffix == ".py" and anchor:
            assert f"class {anchor}(" in there.read_text(encoding="utf-8"), target


def test_every_picture_of_the_texts_is_shown():
    shown = {Path(target).name for text in TEXTS for _, target in links(text)}
    pictures = [file for file in (ROOT / "docs" / "images").rglob("*") if file.is_file()]
    assert {file.name for file in pictures} <= shown


def test_a_link_into_the_source_leads_to_the_page_that_is_written_from_it(sources):
    law = "src/electrovib/physics/force.py#MaxwellStressInGap"
    page = "reference/generated/models/force_law/MaxwellStressInGap.rst"
    assert sources.linked(f"[it](../../{law})", "explanation/a") == f"[it](../{page})"
    assert sources.linked("[all](../examples/), [a](b.md)", "index") == "[all](gallery/index.rst), [a](b.md)"
    papers = sources.linked(
        "[a](../src/electrovib/papers/vezzoli_2014), [b](../src/electrovib/papers)", "index"
    )
    generated = "reference/generated/papers"
    assert papers == f"[a]({generated}/vezzoli_2014.rst), [b]({generated}/index.rst)"
    with pytest.raises(KeyError):
        sources.linked("[it](../src/electrovib/core/units.py)", "index")


def test_the_site_has_a_page_for_every_link_into_the_source(sources):
    wanted = {
        found[1].rstrip("/")
        for text in TEXTS
        if text.parent != ROOT
        for _, each in links(text)
        if (found := SOURCE.match(each))
    }
    assert len(wanted) > 20
    assert wanted <= sources.pages().keys()
