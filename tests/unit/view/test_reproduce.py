"""A reproduced paper as files."""

import csv
import io
import json
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from xml.etree import ElementTree as ET

import numpy as np
import pytest

from electrovib.core import discovery
from electrovib.core.answer import Curve, Drawing, Page, Panel, Table
from electrovib.core.diagnostics import Diagnostic
from electrovib.core.errors import InputError
from electrovib.studies.reproduction import GroupOfRows, Part, Reproduction, Row, group, shown
from electrovib.view import plots
from electrovib.view.pages import _write, reproduce

X = np.linspace(0, 1, 20)
AXES = {"x": ("time", "s"), "y": ("force", "N")}
LINE = Curve(label="a", x=X, y=X)
BAND = Curve(label="a, b", x=X, y=X, upper=X + 1)
SHORT = Curve(label="c", x=X[:2] / 3, y=np.array([np.nan, 0.1]))


@pytest.fixture(scope="module")
def found():
    return Reproduction(
        paper="nobody_2099",
        citation="N. Nobody, On <nothing>, 2099",
        rows=(
            Row("C", "capacitance", 32, 32.96, "pF", "reproduced", "cut off"),
            Row("ramp", "ramp", None, 36.0, "ms", "ours", "a long note", brief="a short one"),
            Row("past", "force in the past", 100.0, 56.0, "mN", "open", "on another film, 5 um"),
            Row("tau", "time constant", 7.7, (0.05, 6.6), "ms", "disagrees", "no resistivity is printed"),
            Row("own", "its own reading", 2.5, 2.54, "mN", "open", "no ramp is printed", leads=True),
            Row("rise", "rise", (1.0, 2.0), 1.5, "1", "consistent", ""),
            Row("hold", "hold", None, 1.0, "1", "consistent", "", "roughly constant", agrees=(0.9, 1.1)),
            Row("sum", "sum of charges", None, 1e-16, "1", "check", "0 is exact"),
        ),
        panels=(
            Panel(id="fig1", title="Figure 1", caption="One & only.", **AXES, curves=(LINE,)),
            Panel(id="fig2", title="Figure 2", caption="Two.", **AXES, curves=(BAND, SHORT)),
        ),
        pages=(
            Page("What this paper leaves open", ("First paragraph.", "Second one.")),
            Page("The rest", ("In full, and at length.", "More."), id="rest", brief=("Shortened.",)),
        ),
        tables=(
            Table("Skins", ("name", "tau"), (("dry", "1"), ("wet", "2"))),
            Table("Causes", ("cause", "how, exactly"), (("sliding", "fresh film"),), id="causes", shown=(0,)),
            Table("Sources", ("source",), (("somewhere",),), id="sources", on_page=False),
        ),
        equations={"1": r"$f = \frac{a}{b}$", "2": r"v = \tau s", "3": r"$\nosuchthing{x}$"},
        references=("Somebody 2000",),
        findings=("One thing to know.", "Another: 5 um."),
    )


@pytest.fixture
def paper(found, monkeypatch):
    asked = []
    fake = ModuleType("nobody_2099")
    fake.reproduce = lambda *, skin: asked.append(skin) or found
    known = {"nobody_2099": fake, "bare_2099": ModuleType("bare_2099")}
    monkeypatch.setattr(discovery, "paper", known.__getitem__)
    monkeypatch.setattr(discovery, "papers", lambda: known)
    return asked


BESIDE = {"numbers.json", "rest.md", "causes.csv", "sources.csv"}
FILES = BESIDE | {"report.html"} | {f"fig{n}.{kind}" for n in (1, 2) for kind in ("svg", "png", "csv")}


@pytest.fixture(scope="module")
def folder(found, tmp_path_factory):
    """Return a folder with what was found, written once: drawing takes most of the time."""
    place = tmp_path_factory.mktemp("written")
    _write(found, place)
    return place


def read(folder, name):
    return (folder / name).read_text(encoding="utf-8")


def test_all_files_are_written_into_a_new_folder(tmp_path, paper, found):
    folder = tmp_path / "deep" / "folder"
    assert reproduce("nobody_2099", folder, skin="own.csv") is found
    assert paper == ["own.csv"]
    assert {file.name for file in folder.iterdir()} == FILES
    assert (folder / "fig1.png").read_bytes().startswith(b"\x89PNG")
    ET.parse(folder / "fig1.svg")


@pytest.mark.usefixtures("blank_pictures")
def test_numbers_and_curves_are_written_as_they_are(tmp_path, found):
    """To the last bit; a curve with its band, its gaps, and names that hold a comma, also one that is not drawn."""
    twice = Curve(label="b", x=X, y=2 * X, drawn=False)
    hidden = replace(found.panels[0], curves=(*found.panels[0].curves, twice))
    assert [line.get_label() for line in plots.panel(hidden).lines] == ["a"]
    _write(replace(found, panels=(hidden, found.panels[1])), tmp_path)
    numbers = json.loads(read(tmp_path, "numbers.json"))
    assert numbers == [row.to_dict() for row in found.ordered]
    assert [each["id"] for each in numbers] == ["own", "C", "rise", "hold", "tau", "past", "ramp", "sum"]
    assert numbers[4]["ours"] == [0.05, 6.6]
    assert numbers[6]["paper"] is None
    heading, *lines = csv.reader(io.StringIO(read(tmp_path, "fig2.csv")))
    assert heading == ["curve", "time [s]", "force [N]", "force [N], upper edge"]
    band = [line for line in lines if line[0] == "a, b"]
    assert [tuple(map(float, line[1:])) for line in band] == [(x, x, x + 1) for x in X.tolist()]
    short = [["c", "0.0", "", ""], ["c", repr(float(X[1] / 3)), "0.1", ""]]
    assert [line for line in lines if line[0] == "c"] == short
    heading, *lines = csv.reader(io.StringIO(read(tmp_path, "fig1.csv")))
    assert heading == ["curve", "time [s]", "force [N]"]
    assert lines[-1] == ["b", "1.0", "2.0"]
    assert len(lines) == 2 * len(X)
    drawn = [each for each in found.document.pages if isinstance(each, Panel)]
    assert [each.caption for each in drawn] == [each.caption for each in found.panels], (
        "and no names of files"
    )


def test_a_drawing_has_no_curves_and_panels_below_have_a_file_each(tmp_path, found):
    """A folded figure is opened by a click."""
    lower = replace(found.panels[1], id="fig2_force")
    drawing = Drawing(id="fig3", title="Circuit", plot=lambda figure: figure.add_subplot(), caption="A loop.")
    upper = replace(found.panels[0], below=(lower,), folded=True)
    _write(replace(found, panels=(upper, drawing)), tmp_path)
    names = {file.name for file in tmp_path.iterdir()} - BESIDE - {"report.html"}
    assert names == {"fig1.svg", "fig1.png", "fig1.csv", "fig2_force.csv", "fig3.svg", "fig3.png"}
    text = read(tmp_path, "report.html")
    assert "<details><summary>Figure 1</summary>" in text
    assert "<h2>Circuit</h2>" in text
    assert "fig1.csv" not in text.partition("beside this page")[0], "a caption says what one sees"
    assert "fig3.csv" not in text


def test_the_page_opens_with_count_and_findings_then_tables_then_explanations(folder, found):
    counted = "1 reproduced, 2 consistent, 1 disagree, 2 open, 1 quantities of ours, 1 checks"
    assert found.count() == counted
    text = read(folder, "report.html")
    order = [
        *(counted, "One thing to know.", "Another: 5 µm."),
        *("Numbers of the paper", "its own reading", "capacitance", "roughly constant", "time constant"),
        *("force in the past", "Figure 1", "<td>wet</td>", "What this paper leaves open"),
        *("Quantities of which the paper states nothing", "a short one", "Checks of this software"),
        "sum of charges",
    ]
    places = [text.index(words) for words in order]
    assert places == sorted(places)
    between = text[text.index("Numbers of the paper") : text.index("Quantities of which")]
    assert "sum of charges" not in between
    assert "a short one" not in between


def test_the_page_fetches_nothing_and_names_the_files_of_what_it_shortens(folder):
    text = read(folder, "report.html")
    for words in (
        *("a short one", "Shortened.", "In full: rest.md", "<td>sliding</td>", "Whole table: causes.csv"),
        *(f'<span class="word {name}">{name}</span>' for name in ("reproduced", "open", "disagrees")),
        *("On &lt;nothing&gt;", "32.96 pF", "0.05 to 6.6 ms", "5 µm", "One &amp; only.", "Second one."),
        *("<td>wet</td>", "Somebody 2000", "numpy"),
        r"$\nosuchthing{x}$",  # what mathtext cannot draw is shown as it is written
    ):
        assert words in text, words
    left_out = ("a long note", "In full, and at length.", "how, exactly", "fresh film", "somewhere")
    for words in (*left_out, "http://", "https://", "<script", "<img", "src="):
        assert words not in text, words
    assert text.count("<svg") == 2 + 2
    assert "a long note" in read(folder, "numbers.json")
    assert read(folder, "rest.md") == "# The rest\n\nIn full, and at length.\n\nMore.\n"
    assert read(folder, "causes.csv") == 'cause,"how, exactly"\nsliding,fresh film\n'
    assert read(folder, "sources.csv") == "source\nsomewhere\n"


@pytest.mark.usefixtures("blank_pictures")
def test_what_it_wrote_is_replaced_and_what_it_did_not_write_is_kept(tmp_path, found):
    """The same reproduction gives the same bytes; other numbers replace the earlier ones."""
    found = replace(found, panels=found.panels[:1], equations={})
    (tmp_path / "mine.txt").write_text("mine", encoding="utf-8")

    def content():
        return {file.name: file.read_bytes() for file in tmp_path.iterdir()}

    _write(found, tmp_path)
    first = content()
    _write(found, tmp_path)
    assert content() == first
    assert set(first) == BESIDE | {"report.html", "fig1.svg", "fig1.png", "fig1.csv", "mine.txt"}
    _write(replace(found, rows=found.rows[:1]), tmp_path)
    assert content()["numbers.json"] != first["numbers.json"]
    changed = {"fig1.csv": "changed since", "report.html": "another page", "numbers.json": "[]"}
    for name, text in changed.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    before = content()
    with pytest.raises(InputError, match="--force") as caught:
        _write(found, tmp_path)
    assert {Path(problem.partition(":")[0]).name for problem in caught.value.problems} == set(changed)
    assert content() == before
    _write(found, tmp_path, force=True)
    _write(found, tmp_path)
    skin = tmp_path / "fig1.csv"
    skin.write_text("frequency,permittivity", encoding="utf-8")
    with pytest.raises(InputError, match=r"fig1\.csv: is an input"):
        _write(found, tmp_path, inputs=[skin], force=True)


@pytest.mark.parametrize("older", [{}, {"numbers.json": "older"}], ids=["new", "there"])
@pytest.mark.parametrize("at", [0, 1, 6])
def test_what_fails_or_is_interrupted_leaves_nothing_half_done(tmp_path, monkeypatch, found, older, at):
    """While a figure is drawn, or at the first or the sixth file."""
    found = replace(found, panels=found.panels[:1], equations={})
    folder, calls, whole = tmp_path / "out", [], Path.write_bytes
    for name, text in older.items():
        folder.mkdir()
        (folder / name).write_text(text, encoding="utf-8")

    def interrupted(self, content=b"", **_):
        calls.append(self)
        if at in (0, len(calls)):
            raise KeyboardInterrupt
        return whole(self, content)

    monkeypatch.setattr("pathlib.Path.write_bytes" if at else "electrovib.view.pages.drawn", interrupted)
    with pytest.raises(KeyboardInterrupt):
        _write(found, folder, force=True)
    assert folder.exists() == bool(older)
    assert {name: read(folder, name) for name in older} == older
    assert len(list(tmp_path.rglob("*.*"))) == len(older)


def test_a_paper_without_reproduction_and_an_output_that_is_a_file_are_refused(tmp_path, paper):
    words = r"'bare_2099' has nothing to reproduce\. Papers that have: nobody_2099"
    with pytest.raises(InputError, match=words):
        reproduce("bare_2099", tmp_path / "out")
    assert list(tmp_path.iterdir()) == []
    file = tmp_path / "file"
    file.write_text("mine", encoding="utf-8")
    for output in (file, file / "below"):
        with pytest.raises(InputError, match="is a file, not a folder"):
            reproduce("nobody_2099", output)
    assert paper == [], "before the work"


def test_parts_come_first_and_all_else_is_folded(tmp_path, found):
    """Each part with its groups of rows and its figures; a group that disagrees anywhere disagrees."""
    rows = {row.id: row for row in found.rows}
    said = group("C is {C.here}, printed {C.said}, off by {percent:.0f} %.", rows, "C tau own", percent=3)
    assert said == GroupOfRows("C is 32.96 pF, printed 32 pF, off by 3 %.", "disagrees", ("C", "tau", "own"))
    assert group("", rows, "C ramp own").verdict == "open"
    assert group("", rows, "ramp sum").verdict == "check"
    parts = (Part("Done", "In short.", (said,), ("fig2",)), Part("Left", "", (group("Rest.", rows, "own"),)))
    warned = Diagnostic("gap", "warning", "the gap is large (scenario fig1)")
    _write(replace(found, parts=parts, diagnostics=(warned,)), tmp_path)
    text = read(tmp_path, "report.html")
    before, *folded = text.split("<details>")
    order = ["One thing to know.", ">Done<", "In short.", "off by 3 %.", ">Figure 2<", ">Left<", "Rest."]
    assert [before.index(words) for words in order] == sorted(before.index(words) for words in order)
    for words in (
        "Numbers of the paper",
        "Warnings on the paper",
        "Figure 1",
        "Skins",
        "The rest",
        "Equations",
        "sum of charges",
    ):
        assert words not in before, words
        assert sum(words in each.partition("</details>")[0] for each in folded) == 1, words
    assert "the gap is large (scenario fig1)" in text
    assert "fig1.csv" in text.partition("</details>")[2]
    assert text.count("<svg") == 2 + 2


def test_numbers_are_shown_in_the_unit_of_the_row():
    assert shown(0.5, "1") == "0.5"
    assert shown(None, "mN") == "not printed"
    assert shown((2, 5), "mN") == "2 to 5 mN"
    assert shown(5.57e5, "ohm m") == "5.57e+05 ohm m"
