"""Figures as text."""

from __future__ import annotations

import re
from xml.etree import ElementTree as ET

from electrovib.view import plots
from electrovib.view.svg import inline, to_png, to_svg


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
