"""The documentation is built without a warning, is complete, and loads nothing from a network."""

import html
import importlib
import json
import os
import re
import shutil
import subprocess
import sys
from collections import Counter
from html.parser import HTMLParser
from io import BytesIO
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from PIL import Image

import electrovib as ev
from electrovib.core.citation import counted, status_text
from electrovib.studies.catalogue.items import everything, paper_items, scenario_items

ROOT = Path(__file__).parent.parent
EXAMPLES = [*(ROOT / "examples").glob("*.py"), *(ROOT / "examples").glob("*.ipynb")]
NOT_RUN = "whole_experiment"
LOADED = dict.fromkeys(("script", "img", "source", "iframe", "video"), "src") | {
    "link": "href",
    "object": "data",
}
"""Elements that load a file when a page is opened, and the attribute that names it."""
NETWORK = re.compile(r"^(https?:)?//")
STYLE = re.compile(
    r"url\(\s*['\"]?((?:https?:)?//[^)'\"]*)|@import\s+(?:url\()?['\"]?((?:https?:)?//[^)'\"]*)"
)
SCRIPT = re.compile(
    r"(?:import\s*\(|import\s|from\s|fetch\(|importScripts\(|\.src\s*=)\s*[`'\"]((?:https?:)?//[^`'\"]*)"
)


OUTSIDE = re.compile(
    r"https://(doi\.org|arxiv\.org|experts\.illinois\.edu|ieeexplore\.ieee\.org|github\.com)/"
)
"""Addresses of the network that a page may link to: those of publications."""


class Page(HTMLParser):
    """What a page loads, and what it shows as equations."""

    def __init__(self, file: Path) -> None:
        super().__init__()
        self.loaded: list[str] = []
        self.equations: list[str] = []
        self.links: list[str] = []
        self.anchors: set[str] = {""}
        text = file.read_text(encoding="utf-8")
        self.feed(text)
        self.loaded += [found for pair in STYLE.findall(text) for found in pair if found]

    def handle_starttag(self, tag, attrs):
        values = dict(attrs)
        self.anchors |= {values[name] for name in ("id", "name") if values.get(name)}
        if tag == "a" and values.get("href"):
            self.links.append(values["href"])
        if tag in LOADED and values.get(LOADED[tag]):
            self.loaded.append(values[LOADED[tag]])
        self.loaded += [part.split()[0] for part in (values.get("srcset") or "").split(",") if part.strip()]
        if tag == "img" and "equation" in (values.get("class") or "").split():
            self.equations.append(values["src"])


def is_of_network(address):
    return bool(NETWORK.match(address))


WHICH_GAP = "explanation/5_which_gap"
"""Page with a slider."""


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """Build the site in a new folder, the example that takes longest apart, which is shown without its results."""
    folder = tmp_path_factory.mktemp("site")
    docs = folder / "docs"
    ignored = ("_build", "_gallery", "gallery", "generated")
    shutil.copytree(ROOT / "docs", docs, ignore=shutil.ignore_patterns(*ignored))
    shutil.copytree(ROOT / "examples", folder / "examples")
    run = rf"sphinx_gallery_conf.filename_pattern=^(?!.*{NOT_RUN}).*\.py$"
    options = ["-q", "-W", "--keep-going", "-D", run]
    command = [sys.executable, "-m", "sphinx", *options, str(docs), str(folder / "html")]
    package = os.environ | {"PYTHONPATH": str(Path(ev.__file__).parents[1])}
    done = subprocess.run(command, env=package, capture_output=True, text=True, check=False, timeout=600)
    assert (done.returncode, done.stderr) == (0, ""), done.stderr
    return folder / "html"


@pytest.fixture(scope="module")
def pages(site):
    """Return the pages; the theme keeps a template for pages among its files."""
    return {file: Page(file) for file in sorted(site.rglob("*.html")) if "_static" not in file.parts}


@pytest.mark.slow
def test_pages_load_files_that_are_there_and_nothing_from_a_network(site, pages):
    assert len(pages) > 150
    for file, page in pages.items():
        for address in page.loaded:
            assert not is_of_network(address), f"{file}: {address}"
            there = file.parent / address.partition("?")[0].partition("#")[0]
            assert address.startswith("data:") or there.exists(), f"{file}: {address}"
    for ending, pattern in (("css", STYLE), ("js", SCRIPT)):
        for file in site.rglob(f"*.{ending}"):
            assert not pattern.findall(file.read_text(encoding="utf-8")), file


@pytest.mark.slow
def test_links_lead_to_pages_of_the_site_and_outside_only_from_references(site, pages):
    """No link inside the site is broken, and none leads outside but those of publications."""
    assert sum(len(page.links) for page in pages.values()) > 5000
    outside = set()
    for file, page in pages.items():
        for address in page.links:
            target, _, anchor = address.partition("#")
            if is_of_network(address):
                assert OUTSIDE.match(address), f"{file}: {address}"
                outside.add(file.relative_to(site).parts[0])
                continue
            there = (file.parent / target).resolve() if target else file
            assert there.exists(), f"{file}: {address}"
            if anchor and there in pages:
                assert anchor in pages[there].anchors, f"{file}: {address}"
    assert outside == {"reference"}


@pytest.mark.slow
def test_every_model_paper_function_and_material_has_a_page(site):
    generated = site / "reference" / "generated"
    for item in everything(own=True):
        if isinstance(item.thing, type):
            file = generated / "models" / item.kind.replace(" ", "_") / f"{item.name}.html"
            page, text = Page(file), file.read_text(encoding="utf-8")
            assert len(page.equations) >= len(item.thing.equation), item.name
            assert all((file.parent / equation).stat().st_size > 500 for equation in page.equations)
            for name in (*item.thing.model_fields, *item.thing.derived):
                assert f"<p>{name}</p>" in text, f"{item.name}: {name}"
            assert "Source status" in text
    bibliography = (generated / "bibliography.html").read_text(encoding="utf-8")
    for item in paper_items(own=True):
        assert (generated / "papers" / f"{item.name}.html").exists()
        for citation in item.thing.CITATIONS:
            assert citation.doi in bibliography
    for name in dir(ev):
        if name not in {"plot", "__version__"}:
            assert (generated / "functions" / f"{name}.html").exists(), name
    assert "--series-resistor" in (generated / "commands.html").read_text(encoding="utf-8")
    assert "silica" in (site / "materials.html").read_text(encoding="utf-8")


@pytest.mark.slow
def test_every_text_and_every_example_is_a_page(site, part):
    results = part("gallery_results")
    texts = [path for path in (ROOT / "docs").rglob("*.md") if "generated" not in path.parts]
    assert len(texts) > 15
    for text in texts:
        assert (site / text.relative_to(ROOT / "docs").with_suffix(".html")).exists()
    guides = (site / "how_to" / "index.html").read_text(encoding="utf-8")
    for guide in ("bench", "fitting", "importing", "populations"):
        assert f'href="../{guide}.html"' in guides
    gallery = (site / "gallery" / "index.html").read_text(encoding="utf-8")
    for example in EXAMPLES:
        assert f"{example.stem}.html" in gallery
        (shown,) = (site / "gallery").rglob(f"{example.stem}.html")
        text = shown.read_text(encoding="utf-8")
        if example.stem == NOT_RUN:
            continue
        assert re.search("sphx-glr-(single|multi)-img", text), example.stem
        question = html.escape(results.question_of(example.stem), quote=False)
        assert question
        assert question in gallery
        for label in ("Question", "Number", "Time to run"):
            (entry,) = re.findall(rf"<dt[^>]*>{label}<.*?</dt>\s*<dd[^>]*>(.*?)</dd>", text, re.DOTALL)
            shown_number = re.sub("<[^>]+>", "", entry).strip()
            assert shown_number, f"{example.stem}: {label}"
            assert label == "Question" or re.search(r"\d", shown_number), f"{example.stem}: {shown_number}"
    notebook = next((site / "gallery").rglob("from_load_to_plot.html")).read_text(encoding="utf-8")
    for shown_text in ("notebook-output", "Validity: 1 warning", "largest attraction: 1.342 mN"):
        assert shown_text in notebook


@pytest.mark.slow
def test_pages_are_shown_by_a_browser_without_a_network(site):
    """No request leaves the machine, no picture is missing, nothing overflows, search works, axe has no serious finding."""
    playwright = pytest.importorskip("playwright.sync_api")
    axe = pytest.importorskip("axe_playwright_python.sync_playwright").Axe()
    of_the_theme = {"summary-name"}  # arrows of the navigation
    problems, asked = [], []
    with playwright.sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
        for scheme, width in (("light", 1280), ("dark", 390)):
            size = {"width": width, "height": 900}
            page = browser.new_context(viewport=size, color_scheme=scheme, offline=True).new_page()
            page.on("request", lambda request: asked.append(request.url))
            page.on("pageerror", lambda error: problems.append(str(error)))
            shown = (
                "index",
                "tutorial",
                "explanation/1_how_it_works",
                "gallery/index",
                "nomenclature",
                WHICH_GAP,
            )
            for name in shown:
                page.goto((site / f"{name}.html").as_uri())
                missing = "[...document.images].filter(one => one.complete && !one.naturalWidth).map(one => one.src)"
                problems.extend(page.evaluate(missing))
                root = "document.documentElement"
                assert page.evaluate(f"{root}.scrollWidth <= {root}.clientWidth"), name
                problems.extend(
                    f"{name}: {found['id']}"
                    for found in axe.run(page).response["violations"]
                    if found["impact"] in {"serious", "critical"} and found["id"] not in of_the_theme
                )
            page.goto((site / f"{WHICH_GAP}.html").as_uri())
            slider, maps = page.get_by_role("slider", name="voltage"), page.locator(".cell img")
            for place, volts in (("0", "0 V"), ("4", "40 V")):
                slider.fill(place)
                assert page.locator("output").inner_text() == slider.get_attribute("aria-valuetext") == volts
                seen, cell = maps.bounding_box(), page.locator(".cell").bounding_box()
                assert seen["width"] == pytest.approx(5 * cell["width"], rel=0.01)
                assert seen["x"] + int(place) * cell["width"] == pytest.approx(cell["x"], abs=2)
            page.goto((site / "search.html").as_uri() + "?q=leaking+gap")
            page.locator("#search-results li").nth(3).wait_for()  # they appear one after the other
        assert not problems, problems
        assert {address.partition(":")[0] for address in asked} <= {"file", "data", "blob"}


@pytest.fixture
def part(monkeypatch):
    """Return a function that imports a part of the build."""
    monkeypatch.syspath_prepend(str(ROOT / "docs" / "_ext"))
    return importlib.import_module


def test_the_pages_of_papers_and_commands_have_what_these_declare(part):
    pages = part("papers_pages").pages()
    plain, linked = part("rst").plain, part("rst").linked
    for item in paper_items(own=True):
        page = pages[f"papers/{item.name}.rst"]
        assert f":doc:`papers/{item.name}`" in pages["bibliography.rst"]
        assert f"{{{item.name},\n" in pages["electrovib.bib"]
        for citation in item.thing.CITATIONS:
            shown = linked(plain(str(citation)))
            assert not citation.doi or f"<https://doi.org/{citation.doi}>`__" in shown
            assert shown in pages["bibliography.rst"]
            assert shown in page
        assert page.count("\n- ") >= len(getattr(item.thing, "CHECKS", ()))
        told = counted(item.thing.CHECKS)
        assert f":doc:`papers/{item.name}`, checks: {told})" in pages["bibliography.rst"]
        assert told in pages["papers/index.rst"]
    listed = [item.thing for item in paper_items(own=True)]
    total = counted(check for paper in listed for check in paper.CHECKS)
    for name in ("bibliography.rst", "papers/index.rst"):
        assert total in pages[name]
        (told,) = re.findall(rf"Of {len(listed)} papers: (.+)\. Of their \d+ checks: ", pages[name])
        statuses = Counter(status_text(paper.STATUS) for paper in listed)
        assert {each.partition(" ")[2]: int(each.split()[0]) for each in told.split("; ")} == statuses
    for item in scenario_items():
        assert f"``{item.name}``" in pages["scenarios.rst"]
    assert ":doc:`../models/force_law/Vezzoli2014Causal`" in pages["papers/vezzoli_2014.rst"]
    (text,) = part("commands").pages().values()
    for shown in ("electrovib bench run\n", "``SCENARIO``", "``--series-resistor``", "``--output, -o``"):
        assert shown in text


def test_the_page_of_the_evidence_has_the_failures_the_laws_and_every_measurement(part):
    pages = part("evidence_pages").pages("israr_2006/cylinder", n=4, seed=3)
    found = ev.evidence("israr_2006/cylinder", n=4, seed=3)
    plain, laws = part("rst").plain, pages["evidence.rst"]
    parts = [
        plain(found.document.sentences[0]),
        plain(found.document.numbers[0].title),
        "Measurements that no law or model covers whole\n---",
    ]
    places = [laws.index(each) for each in parts]
    assert places == sorted(places)
    (compared,) = found.comparisons
    for standing in compared.standings:
        assert f"* - {standing.model}\n     - none: {standing.skill:.2f}\n" in laws
    assert found.comparisons[0].null in laws
    assert ":doc:`evidence_measurements`" in laws
    whole = pages["evidence_measurements.rst"]
    assert plain(found.measured["israr_2006/cylinder"].note) in whole
    assert "Cannot predict\n---" in whole
    for figure, text in zip(found.document.figures, (laws, whole), strict=True):
        assert f".. figure:: evidence_{figure.id}.svg\n   :alt: {plain(figure.title)}\n\n   " in text
        ET.fromstring(pages[f"evidence_{figure.id}.svg"])
    assert (
        whole.count("<details>")
        == whole.count("</details>")
        == 1 + len([1 for each in found.document.pages if each.rows])
    )
    assert set(part("reference").PARTS) >= {part("evidence_pages"), part("models")}


@pytest.mark.parametrize("name", ["first", pytest.param("evidence", marks=pytest.mark.slow)])
def test_a_first_picture_is_the_one_that_its_script_draws(part, name):
    """README and site begin with the same ones; a telephone shows 350 pixels of their width."""
    place = ROOT / "docs" / "images" / f"{name}.png"
    with Image.open(BytesIO(part("first_pictures").picture(name))) as drawn, Image.open(place) as there:
        ours, kept = (np.asarray(each.convert("L"), dtype=float) for each in (drawn, there))
    assert ours.shape == kept.shape
    assert np.mean(np.abs(ours - kept)) < 1
    assert 350 / (ours.shape[1] / 200) * part("first_pictures").LETTERS[name] / 72 > 9
    pages = [(ROOT / page).read_text(encoding="utf-8") for page in ("README.md", "docs/index.md")]
    places = [text.index(f"images/{name}.png") for text in pages]
    assert all(text.index("images/first.png") <= at for text, at in zip(pages, places, strict=True))


def test_a_text_is_shown_as_it_is(part):
    plain = part("rst").plain
    assert plain("E. Vezzoli, |u|*2 and rms_") == r"\E. Vezzoli, \|u\|\*2 and rms\_"
    assert plain("use `a_b*c`") == "use `a_b*c`"
    assert plain("at tcp://host:1, not https://a.org") == "at tcp\\://host:1, not https://a.org"
    linked = part("rst").linked
    assert linked("A, doi:10.1/a-b (abstract)") == "A, `doi:10.1/a-b <https://doi.org/10.1/a-b>`__ (abstract)"
    assert linked("arXiv:1805.08714; doi:10.1/x") == (
        "`arXiv:1805.08714 <https://arxiv.org/abs/1805.08714>`__; `doi:10.1/x <https://doi.org/10.1/x>`__"
    )


def test_every_example_is_in_the_gallery_under_its_question(part, tmp_path):
    gallery = part("gallery")
    gallery.collect(ROOT / "examples", tmp_path / "gallery")
    found = {path.stem: path for path in (tmp_path / "gallery").rglob("*.py")}
    assert set(found) == {path.stem for path in EXAMPLES}
    for names in gallery.QUESTIONS.values():
        assert len({found[name].parent for name in names}) == 1
    listed = [name for names in gallery.QUESTIONS.values() for name in names]
    assert sorted(listed) == sorted(found), "an example without a question is among the further examples"
    assert all(text.endswith("?") for names in gallery.QUESTIONS.values() for text in names.values())
    text = found["stick_slip"].read_text(encoding="utf-8")
    title = text.splitlines()[1]
    assert title.startswith("Stick-slip of a slowly sliding fingertip")
    assert text.splitlines()[2] == "=" * len(title)
    (tmp_path / "new").mkdir()
    (tmp_path / "new" / "another.py").write_text('"""Another example."""\n\nprint(1)\n', encoding="utf-8")
    gallery.collect(tmp_path / "new", tmp_path / "gallery")
    (other,) = (tmp_path / "gallery").rglob("*.py")
    assert other.parent.name.endswith("further_examples")
    assert "print(1)" in other.read_text(encoding="utf-8")
    built = tmp_path / "built"
    for name in ("another", "removed", "index"):
        (built / other.parent.name).mkdir(parents=True, exist_ok=True)
        (built / other.parent.name / f"{name}.rst").touch()
    (built / "former_question").mkdir()
    gallery.remove_old(built, tmp_path / "gallery")
    assert {path.name for path in built.rglob("*")} == {other.parent.name, "another.rst", "index.rst"}


def test_a_notebook_is_a_script_of_cells(part, tmp_path):
    cells = [
        {"cell_type": "markdown", "source": ["# A title\n", "\n", "What it shows."]},
        {"cell_type": "code", "source": ["a = 1\n", "a"]},
        {"cell_type": "markdown", "source": ["Then\n", "\n", "this."]},
    ]
    file = tmp_path / "a.ipynb"
    file.write_text(json.dumps({"cells": cells}), encoding="utf-8")
    script = part("gallery").from_notebook(file)
    assert script == '"""A title.\n\nWhat it shows.\n"""\n\n# %%\na = 1\na\n\n# %%\n# Then\n#\n# this.\n'


def test_question_number_and_time_are_those_of_the_run(part, tmp_path):
    results = part("gallery_results")
    page = (
        ".. _label:\n\n\nA title\n=======\n\ntext\n\n.. rst-class:: sphx-glr-script-out\n\n .. code-block:: none\n\n"
        "    electrovib: simulated: the generator is at 0 V\n    pull-in at 201.78 V\n    no voltage: 1 N\n\n"
        "    500 V held: 2 N\n\n\n"
        "   **Total running time of the script:** (1 minutes 2.541 seconds)\n"
    )
    for time, shown in (
        ("1 minutes 2.541", "63 s"),
        ("2 minutes 1.6", "122 s"),
        ("0 minutes 0.0943", "0.09 s"),
    ):
        of_time = page.replace("1 minutes 2.541", time)
        assert results.result_of(of_time, "pull_in") == ("A title", "pull-in at 201.78 V", shown)
    assert results.result_of(page, "stick_slip").number == "no voltage: 1 N; 500 V held: 2 N"
    assert "simulated" not in results.headed(page, "pull_in")
    headed = results.headed(page, "pull_in")
    assert "A title\n=======\n\n:Question: At which voltage" in headed
    assert ":Number: ``pull-in at 201.78 V``\n:Time to run: 63 s\n" in headed
    assert results.headed("A title\n=====\n\nunlisted", "other") == "A title\n=====\n\n\n\nunlisted"
    unrun = "A title\n====\n"
    for folder, name, text in (("1_b", "stick_slip", unrun), ("1_b", "pull_in", page), ("0_a", "z", page)):
        (tmp_path / folder).mkdir(exist_ok=True)
        (tmp_path / folder / f"{name}.rst").write_text(text, encoding="utf-8")
    (tmp_path / "1_b" / "index.rst").touch()
    table = results.table(tmp_path)
    assert re.findall(r"<([\w/]+)>`", table) == ["0_a/z", "1_b/stick_slip", "1_b/pull_in"]
    assert table.count("not run in this build") == 1
    assert table.count("63 s") == 2


@pytest.mark.slow  # needs Sphinx, as the site does
def test_an_equation_is_a_picture_that_stands_on_the_line_of_the_text(part):
    drawn = part("equations").drawn
    picture, width, height, depth = drawn(r"\frac{V}{K + g}")
    assert picture.startswith(b"<?xml")
    assert 0 < depth < height < width + height
    assert drawn("V")[3] == pytest.approx(0, abs=0.1)


def test_what_is_of_a_network():
    assert all(is_of_network(address) for address in ("https://a.org/b.js", "//a.org/b.js"))
    assert not any(is_of_network(address) for address in ("_static/b.js", "data:image/png;base64,a//"))


def test_a_thumbnail_shows_a_panel_that_can_be_read(part):
    """A red panel in a white picture of 1000 x 800 fills the thumbnail in one direction and is in its middle."""
    thumbnails, gallery = part("thumbnails"), part("gallery")
    assert set(thumbnails.PANELS) <= {name for names in gallery.QUESTIONS.values() for name in names}
    picture = Image.new("RGBA", (1000, 800), "white")
    picture.paste("red", (500, 200, 1000, 400))
    found = np.asarray(thumbnails.thumbnail(picture, (0.5, 0.25, 1.0, 0.5)))
    red = (found == (255, 0, 0)).all(axis=-1)
    width, height = thumbnails.SIZE
    assert found.shape == (height, width, 3)
    assert red.any(axis=0).all()
    rows = np.flatnonzero(red.any(axis=1))
    assert len(rows) == pytest.approx(width * 200 / 500, abs=1)
    assert rows[0] + rows[-1] == pytest.approx(height - 1, abs=1)
    assert np.mean(found[0] == 255) == 1
