"""A document as a page: its sentences, warnings, tables and figures, each in its place, and figures as text."""

from __future__ import annotations

import re
from xml.etree import ElementTree as ET

import numpy as np

from electrovib.core.answer import Curve, Document, Drawing, Page, Panel, Table
from electrovib.core.diagnostics import Diagnostic
from electrovib.view import plots
from electrovib.view.documents import drawn, html, on_page
from electrovib.view.pages import inline, to_png, to_svg

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
