"""HTML pages from templates: each is one file that fetches nothing."""

from __future__ import annotations

import functools
import re
from io import BytesIO, StringIO
from typing import TYPE_CHECKING, Any, Final
from zlib import crc32

from electrovib.core.errors import InputError
from electrovib.data.atomic import check_writable, output_path
from electrovib.data.marks import Form
from electrovib.view.style import new_figure, style
from electrovib.view.units import typeset

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path

    from jinja2 import Environment
    from markupsafe import Markup
    from matplotlib.figure import Figure


_NO_METADATA: Final[dict[str, Any]] = {"Date": None, "Creator": None, "Format": None, "Type": None}


def to_svg(figure: Figure, *, tight: bool = False) -> str:
    """Write a figure as an SVG file without date, creator or random names."""
    text = StringIO()
    box: dict[str, Any] = {"bbox_inches": "tight", "pad_inches": 0.02} if tight else {}
    with style():
        figure.savefig(text, format="svg", metadata=_NO_METADATA, **box)
    return re.sub(r"\s*<metadata>.*?</metadata>", "", text.getvalue(), flags=re.DOTALL)


def to_pdf(figure: Figure) -> bytes:
    """Write a figure as a PDF file with its letters in it, without date and creator."""
    content = BytesIO()
    with style():
        figure.savefig(content, format="pdf", metadata=dict.fromkeys(("Creator", "Producer", "CreationDate")))
    return content.getvalue()


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


def filled(template: str, **content: Any) -> str:
    """Fill a template; its texts are escaped, figures from `markup` are not."""
    return _environment().get_template(template).render(**content)


def check_page(path: str | Path, *, inputs: Iterable[Path] = (), force: bool = False) -> None:
    """Check, before the computation, that a page can be written."""
    path = output_path(path)
    if path.suffix.lower() not in {".html", ".htm"}:
        raise InputError(f"a report is an .html file, not '{path.suffix}'", path=path)
    check_writable({path: Form.PAGE}, inputs=inputs, force=force)


def breakable(path: str) -> Markup:
    """Return a dotted path that a browser may break after its dots and underscores."""
    from markupsafe import Markup, escape

    return Markup(str(escape(path)).replace(".", ".<wbr>").replace("_", "_<wbr>"))  # noqa: S704 - escaped


def formula(text: str) -> Markup | str:
    """Draw a formula written in mathtext; one that cannot be drawn is shown as it is written."""
    written = (text if "$" in text else f"${text}$").replace(
        r"\frac", r"\dfrac"
    )  # legible in a line of its own
    figure = new_figure((6.0, 1.0))
    try:
        with style():
            figure.text(0, 0.5, written, fontsize=13, math_fontfamily="stix", color="#222222")
        svg = to_svg(figure, tight=True)
    except ValueError:
        return text
    return markup(inline(svg, name=f"formula{crc32(text.encode())}", words=f"Formula: {text}"))


def markup(svg: str) -> Markup:
    """Mark an inline figure as HTML that needs no escaping."""
    from markupsafe import Markup

    return Markup(svg)  # noqa: S704 - made by matplotlib, with its texts escaped


@functools.cache
def _environment() -> Environment:
    from jinja2 import Environment, PackageLoader, StrictUndefined

    environment = Environment(
        loader=PackageLoader("electrovib.view"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {"breakable": breakable, "typeset": typeset, "formula": formula}
    return environment
