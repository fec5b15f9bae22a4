"""Figures as files and as elements of a page: the same figure gives the same bytes and fetches nothing."""

from __future__ import annotations

import re
from io import BytesIO, StringIO
from typing import TYPE_CHECKING, Any, Final

from electrovib.view.style import style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_NO_METADATA: Final[dict[str, Any]] = {"Date": None, "Creator": None, "Format": None, "Type": None}


def to_svg(figure: Figure, *, tight: bool = False) -> str:
    """Write a figure as an SVG file without date, creator or random names."""
    text = StringIO()
    box: dict[str, Any] = {"bbox_inches": "tight", "pad_inches": 0.02} if tight else {}
    with style():
        figure.savefig(text, format="svg", metadata=_NO_METADATA, **box)
    return re.sub(r"\s*<metadata>.*?</metadata>", "", text.getvalue(), flags=re.DOTALL)


def to_png(figure: Figure, *, resolution: float = 150.0) -> bytes:
    """Write a figure as a PNG file at this many dots per inch."""
    content = BytesIO()
    with style():
        figure.savefig(content, format="png", dpi=resolution, metadata={"Software": None})
    return content.getvalue()


def inline(svg: str, *, name: str, words: str) -> str:
    """Turn an SVG file into an element of an HTML page, with `name` before every identifier and `words` as description."""
    body = svg[svg.index("<svg") :]
    body = re.sub(r'\sxmlns(:\w+)?="[^"]*"', "", body)
    body = body.replace("xlink:href=", "href=")
    body = re.sub(r'\bid="', f'id="{name}-', body)
    body = re.sub(r'\bhref="#', f'href="#{name}-', body)
    body = re.sub(r"url\(#", f"url(#{name}-", body)
    label = words.replace("&", "&amp;").replace('"', "&quot;").replace("<", "&lt;")
    return body.replace("<svg", f'<svg role="img" aria-label="{label}"', 1)
