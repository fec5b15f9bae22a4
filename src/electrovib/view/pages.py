"""HTML pages from templates: each is one file that fetches nothing."""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING, Any

from electrovib.core.errors import InputError
from electrovib.data.atomic import check_writable
from electrovib.data.marks import Form, unsigned
from electrovib.view.units import typeset

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence
    from pathlib import Path

    from jinja2 import Environment
    from markupsafe import Markup


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
        raise InputError(f"a report or a comparison is an .html file, not '{path.suffix}'", path=path)
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
