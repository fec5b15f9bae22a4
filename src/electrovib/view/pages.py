"""HTML pages from templates: each is one file that fetches nothing."""

from __future__ import annotations

import functools
import re
from io import BytesIO, StringIO
from typing import TYPE_CHECKING, Any, Final

from electrovib.core.errors import InputError
from electrovib.data.atomic import check_writable
from electrovib.data.marks import Form, unsigned
from electrovib.view.style import style
from electrovib.view.units import typeset

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence
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


def page(
    template: str,
    *,
    judged: Mapping[str, Sequence[Any]],
    judged_note: str = "",
    **content: Any,
) -> str:
    """Fill a template; its texts are escaped, figures from `markup` are not.

    `judged` has the diagnostics of what the numbers were computed from, by a label where it is several.
    """
    told = {label: found for label, found in judged.items() if found}
    mark = unsigned(Form.PAGE)
    return filled(template, mark=mark, judged=told, judged_note=judged_note, **content)


def filled(template: str, **content: Any) -> str:
    """Fill a template that is part of a page of others."""
    return _environment().get_template(template).render(**content)


def check_page(path: Path, *, inputs: Iterable[Path] = (), force: bool = False) -> None:
    """Check, before the computation, that a page can be written."""
    if path.suffix.lower() not in {".html", ".htm"}:
        raise InputError(f"a report is an .html file, not '{path.suffix}'", path=path)
    check_writable({path: Form.PAGE}, inputs=inputs, force=force)


def breakable(path: str) -> Markup:
    """Return a dotted path that a browser may break after its dots and underscores."""
    from markupsafe import Markup, escape

    return Markup(str(escape(path)).replace(".", ".<wbr>").replace("_", "_<wbr>"))  # noqa: S704 - escaped


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
    environment.filters |= {"breakable": breakable, "typeset": typeset}
    return environment
