"""A document as a page: its sentences, warnings, tables and figures, each in its place, and figures as text."""

import re
from xml.etree import ElementTree as ET

import numpy as np

from electrovib.core.answer import Curve, Document, Drawing, Page, Panel, Table
from electrovib.core.diagnostics import Diagnostic
from electrovib.view import plots
from electrovib.view.pages import drawn, html, inline, on_page, to_png, to_svg

LINE = Curve(label="force", x=np.array([0.0, 1.0]), y=np.array([1.0, 2.0]))
AXES = {"x": ("time", "s"), "y": ("force", "N")}
PANEL = Panel(id="p", title="Force <over> time", caption="Made up.", **AXES, curves=(LINE,))
DRAWING = Drawing(id="d", title="A drawing", plot="panel", of=PANEL, size=(2.0, 1.0))


def test_a_page_has_all_that_a_document_says():
    page = html(
        Document(
            title="A title",
            sentences=["The answer.", "More of it."],
            remarks=["A remark."],
            diagnostics=[Diagnostic("current", "warning", "the current is large")],
            note="Of one scenario.",
            figures=[PANEL, DRAWING],
            tables=[Table("Numbers", ("a", "b"), (("1", "2"),))],
            pages=[Page("Limits", ("What is not known.",))],
            references=["A paper"],
        )
    )
    once = ("<strong>The answer.</strong>", "<p>More of it.</p>", "<p>A remark.</p>", "the current is large")
    for words in (*once, "Of one scenario.", "Numbers", "A paper"):
        assert page.count(words) == 1, words
    assert "What is not known." in page
    places = [page.index(words) for words in ("The answer.", "Made up.", "Numbers", "A drawing")]
    assert places == sorted(places)
    assert "Force &lt;over&gt; time" in page


def test_tables_and_texts_look_as_they_say():
    """Numbers stand before the validity, what is looked up after the figures, folded where it is long."""
    looks = {0: "code", 1: "state", 2: "formula", 3: "number"}
    row = ("stack.gap", "warning", r"\frac{1}{2}", "5 uA\nless than that")
    page = html(
        Document(
            title="A title",
            sentences=["The answer."],
            numbers=[Table("", ("", ""), (("largest force", "1 N"),))],
            diagnostics={
                "a": [Diagnostic("current", "ok", "small")],
                "b": [Diagnostic("field", "warning", "large")],
            },
            tables=[Table("Beside the page", ("x",), (("absent",),), on_page=False)],
            figures=[PANEL, PANEL],
            pages=[
                Table("Looked up", ("where", "state", "formula", "value"), (row,), looks=looks, folded=True),
                Page("A file", ("drive = <b>\n  x = 1",), listing=True),
            ],
        )
    )
    for words in (
        '<table class="narrow">\n<tbody>',
        "<h3>a</h3>",
        "<details><summary>Looked up</summary>",
        "<code>stack.<wbr>gap</code>",
        '<span class="word warning">warning</span></td>\n<td class="formula"><svg',
        '<td class="number">5 µA<br><span class="quiet">less than that</span></td>',
        "<pre>drive = &lt;b&gt;\n  x = 1</pre>",
    ):
        assert words in page, words
    assert "absent" not in page
    assert page.count("<h2>Force &lt;over&gt; time</h2>") == 1, "one heading for two figures of one title"
    places = [page.index(words) for words in ("largest force", "Validity", "Made up.", "Looked up", "A file")]
    assert places == sorted(places)


def test_a_figure_may_be_a_function_that_fills_it():
    def two(figure):
        for ax in figure.subplots(2):
            ax.set_title("kept")

    placed = Drawing(id="two", title="Two plots", plot=two, size=(3.0, 2.0), words="one above the other")
    figure = drawn(placed)
    assert tuple(figure.get_size_inches()) == (3.0, 2.0)
    assert 'aria-label="one above the other"' in on_page(placed, figure=figure).svg
    assert [ax.get_title(loc="left") for ax in figure.axes] == ["kept", "kept"]


def test_on_a_page_the_title_of_a_figure_is_its_heading_alone():
    for shown in (PANEL, DRAWING):
        figure = drawn(shown)
        assert figure.axes[0].get_title(loc="left") or figure.axes[0].get_title()
        assert on_page(shown, figure=figure).title == shown.title
        assert figure.axes[0].get_title(loc="left") == ""
    assert tuple(drawn(DRAWING).get_size_inches()) == (2.0, 1.0)


def test_the_same_figure_gives_the_same_bytes_without_a_date(trace):
    first, second = (to_svg(plots.force(trace).figure) for _ in range(2))
    assert first == second
    assert "<metadata" not in first
    assert to_png(plots.force(trace).figure) == to_png(plots.force(trace).figure)
    assert to_svg(plots.drive(trace).figure) != first
    ET.fromstring(first)


def test_inline_figures_share_a_page_without_sharing_names(trace):
    svg = to_svg(plots.drive(trace).figure)
    element = inline(svg, name="one", words='a "drive" & more')
    assert element.startswith("<svg ")
    assert 'aria-label="a &quot;drive&quot; &amp; more"' in element
    for address in ("http://", "https://", "xmlns", "xlink", "<!DOCTYPE"):
        assert address not in element
    names = re.findall(r'\bid="([^"]*)"', element)
    assert names
    assert all(name.startswith("one-") for name in names)
    used = re.findall(r'href="#([^"]*)"', element) + re.findall(r"url\(#([^)]*)\)", element)
    assert used
    assert set(used) <= set(names)
