"""HTML pages from templates, each one file that fetches nothing; answers as such pages; a reproduced paper as its files."""

from __future__ import annotations

import functools
import hashlib
import json
import re
from contextlib import suppress
from dataclasses import dataclass, replace
from io import BytesIO, StringIO
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final
from zlib import crc32

import numpy as np

from electrovib.core.answer import REFERENCE, Drawing, Panel
from electrovib.core.budget import each_item
from electrovib.core.errors import InputError, gathered, refuse
from electrovib.core.files import inputs_noted
from electrovib.data.atomic import (
    Form,
    check_folder,
    check_writable,
    is_ours,
    left_by_a_kill,
    output_path,
    unsigned,
    write_folder,
)
from electrovib.view.style import MOST, new_figure, style, typeset

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from jinja2 import Environment
    from markupsafe import Markup
    from matplotlib.figure import Figure

    from electrovib.core.answer import Curve, Document, Shown
    from electrovib.core.diagnostics import Diagnostic
    from electrovib.scenario import Scenario
    from electrovib.studies.reproduction import Reproduction

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


def part(template: str, name: str, /, **content: Any) -> str:
    """Fill one macro of a template as `filled` does."""
    macro = getattr(_environment().get_template(template).module, name)
    return str(macro(**content))


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


PANEL_SIZE: Final = (8.2, 4.3)
"""Width and height of a figure of a page [inch]."""
BELOW: Final = 1.6
"""What each panel below adds to the height [inch]."""


@dataclass(frozen=True)
class PageFigure:
    """A figure in a page: heading, inline SVG, words below; opened by a click if `folded`."""

    title: str
    svg: Markup
    caption: str
    folded: bool = False


def html(document: Document, *, pictures: Mapping[str, Figure] | None = None) -> str:
    """Write a document as one HTML page that fetches nothing; `pictures` are figures that are drawn already, by their `id`."""
    from electrovib.view import summary

    made = pictures or {}
    figures = [
        on_page(each, figure=made.get(each.id))
        for whole in document.figures
        for each in ((whole,) if whole.id in made else parts(whole))
    ]
    titles = ["", *(each.title for each in figures)]
    return filled(
        "page.html.jinja",
        mark=unsigned(Form.PAGE),
        said=document,
        judged={label: found for label, found in document.judged.items() if found},
        figures=[
            replace(each, title="" if each.title == before else each.title)
            for each, before in zip(figures, titles, strict=False)
        ],
        pages=[
            on_page(each, figure=made.get(each.id)) if isinstance(each, (Panel, Drawing)) else each
            for each in document.pages
        ],
        versions=summary.versions(),
    )


def parts(shown: Shown) -> tuple[Shown, ...]:
    """Split a figure into those that are drawn."""
    return few_curves(shown) if isinstance(shown, Panel) else (shown,)


def on_page(shown: Shown, *, figure: Figure | None = None) -> PageFigure:
    """Put a figure, drawn already or not, into a page, where its title is a heading."""
    figure = figure or drawn(shown)
    words = shown.title
    if isinstance(shown, Drawing) and callable(shown.plot):
        words = shown.words or words
    else:
        figure.axes[0].set_title("", loc="left")
    picture = markup(inline(to_svg(figure), name=shown.id, words=words))
    return PageFigure(shown.title, picture, shown.caption, isinstance(shown, Panel) and shown.folded)


def drawn(shown: Shown) -> Figure:
    """Draw a figure, with its title."""
    from electrovib.view import plots
    from electrovib.view.style import new_figure, style

    if isinstance(shown, Panel):
        parts = (shown, *shown.below)
        figure = new_figure((PANEL_SIZE[0], PANEL_SIZE[1] + BELOW * len(shown.below)))
        heights = [0.5 if shown.below else 1.0, *(1.0 for _ in shown.below)]
        with style():
            axes = figure.subplots(len(parts), sharex=True, squeeze=False, height_ratios=heights)[:, 0]
            for part, ax in zip(parts, axes, strict=True):
                plots.panel(part, ax=ax)
                ax.label_outer()
        return figure
    plot = shown.plot
    if callable(plot):
        figure = new_figure(shown.size or PANEL_SIZE)
        with style():
            plot(figure)
        return figure
    figure = new_figure(shown.size or plots.SIZES[plot](shown.of))
    with style():
        getattr(plots, plot)(shown.of, **shown.options, ax=figure.add_subplot())
    return figure


_SAME, _SAME_OVER_DECADES = 0.02, 0.1
"""Largest relative difference of curves that share a line: on a linear axis, and on a logarithmic one."""


def few_curves(panel: Panel) -> tuple[Panel, ...]:
    """Split a panel into panels of at most five things, each beginning with the first thing; equal lines share one.

    Curves of one look are one thing, which stays together. References, and points that are of no line, are in every panel.
    Lines are equal that differ nowhere by more than 2 %, or 10 % on a logarithmic axis.
    """
    shown = [
        replace(each, look=REFERENCE if each.background else at if each.look is None else each.look)
        for at, each in enumerate(curve for curve in panel.curves if curve.drawn)
    ]
    of_lines = {curve.look for curve in shown if curve.kind != "points"} - {REFERENCE}
    of_no_line = (each.look for each in shown if of_lines and each.kind == "points")
    apart = {REFERENCE, *of_no_line} - of_lines
    beside = [each for each in shown if each.look in apart]
    looks = dict.fromkeys(each.look for each in shown if each.look not in apart)
    things = [[curve for curve in shown if curve.look == look] for look in looks]
    found = _merged(things, _SAME_OVER_DECADES if panel.log_y else _SAME)
    further = [[found[0], *found[start : start + MOST - 1]] for start in range(MOST, len(found), MOST - 1)]
    parts = [found[:MOST], *further]
    return tuple(
        replace(
            panel,
            id=f"{panel.id}_{number}" if further else panel.id,
            title=f"{panel.title}, {number} of {len(parts)}" if further else panel.title,
            curves=tuple(sorted(chain(beside, *part), key=_height)),
        )
        for number, part in enumerate(parts, start=1)
    )


def _height(curve: Curve) -> tuple[bool, bool]:
    """Order bands below lines, these below the lines of references, and points on top."""
    return curve.kind == "points", curve.look == REFERENCE and curve.upper is None


def _merged(things: Sequence[list[Curve]], same: float) -> list[list[Curve]]:
    """Put things whose lines lie on each other everywhere into one, under all names, in the order of the first of each."""
    groups: list[list[list[Curve]]] = []
    for thing in things:
        group = next((each for each in groups if _equal(each[0], thing, same)), None)
        if group is None:
            groups.append([thing])
        else:
            group.append(thing)
    names = [",\n".join(thing[0].label for thing in group) for group in groups]
    points = [[curve for thing in group for curve in thing[1:]] for group in groups]
    return [
        [replace(group[0][0], label=name), *more]
        for group, name, more in zip(groups, names, points, strict=True)
    ]


def _equal(one: Sequence[Curve], other: Sequence[Curve], same: float) -> bool:
    """Return whether two things are a line each, with points or without, and the lines are equal."""
    first, second = one[0], other[0]
    return bool(
        all(each.kind == "points" for each in (*one[1:], *other[1:]))
        and all(each.kind != "points" and each.upper is None for each in (first, second))
        and np.array_equal(first.x, second.x)
        and np.allclose(first.y, second.y, rtol=same, atol=0.0)
    )


_PAGE: Final = "report.html"


def reproduce(
    paper: str = "vezzoli_2014",
    output: str | Path = "reproduction",
    *,
    skin: str | None = None,
    force: bool = False,
) -> Reproduction:
    """Compute everything that a paper states, and write it beside the printed values.

    Parameters
    ----------
    paper : str
        ``author_year``.
    output : str or Path
        Folder; made if it is not there. Files of an earlier reproduction in it are replaced, others are left.
    skin : str, optional
        File with a table of one's own skin, for papers that take one.
    force : bool
        Whether files of the same names that we did not write, or that were changed since, may be replaced.

    Returns
    -------
    Reproduction
        Rows, panels and words, as they were written.

    Raises
    ------
    InputError
        If there is no such paper, if it has nothing to reproduce, if the table cannot be used, if the folder
        cannot be written, or if a file in it would be replaced that is read or not ours; nothing has been written then.
    """
    folder = output_path(output)
    check_folder(folder, {_PAGE: Form.PAGE}, force=force)
    with inputs_noted() as inputs:
        found = _found(paper, skin)
    _write(found, folder, inputs=inputs, force=force)
    return found


def _found(paper: str, skin: str | None) -> Reproduction:
    from electrovib.core.discovery import paper as find
    from electrovib.core.discovery import papers
    from electrovib.solve.quantities.answer import validity

    module = find(paper)
    if not hasattr(module, "reproduce"):
        able = ", ".join(name for name, other in papers().items() if hasattr(other, "reproduce"))
        raise InputError(f"'{paper}' has nothing to reproduce. Papers that have: {able or 'none'}.")
    found: Reproduction = module.reproduce(skin=skin)
    own: Mapping[str, Scenario] = module.scenarios() if hasattr(module, "scenarios") else {}
    warned: dict[str, tuple[Diagnostic, list[str]]] = {}
    for name, scenario in own.items():
        for each in validity(scenario):
            if each.state == "warning":
                warned.setdefault(each.text, (each, []))[1].append(name)
    stated = (
        replace(each, text=f"{text} (scenario {', '.join(names)})") for text, (each, names) in warned.items()
    )
    return replace(found, diagnostics=tuple(stated)) if warned else found


def _write(found: Reproduction, folder: Path, *, inputs: Sequence[Path] = (), force: bool = False) -> None:
    contents = contents_of(found)
    if folder.exists():
        _refuse_to_replace(contents, folder, inputs, force=force)
    made = not folder.exists()
    try:
        write_folder(folder, contents, dict.fromkeys(contents) | {_PAGE: Form.PAGE}, force=True)
    except BaseException:
        if made:
            with suppress(OSError):
                folder.rmdir()
        raise


def _refuse_to_replace(
    contents: Mapping[str, bytes], folder: Path, inputs: Sequence[Path], *, force: bool
) -> None:
    """Refuse to replace what is read, and what an earlier reproduction did not write here."""
    problems: list[str] = []
    with gathered(problems):
        check_writable({folder / _PAGE: Form.PAGE}, inputs=inputs, force=force)
    others = {folder / name: content for name, content in contents.items() if name != _PAGE}
    with gathered(problems):
        check_writable(dict.fromkeys(others), inputs=inputs, force=True)
    page = folder / _PAGE  # a process that was killed has left its page beside that of an earlier one
    earlier = {entry for one in (page, *left_by_a_kill(page)) for entry in _listed(one).items()}
    for place, content in others.items():
        if place.is_file() and not force:
            there = place.read_bytes()
            if there != content and (place.name, _checksum(there)) not in earlier:
                problems.append(
                    f"{place}: exists already and is not of an earlier reproduction, or was changed since; give another"
                    " folder, or replace it with --force (force=True)."
                )
    refuse(problems)


def _listed(page: Path) -> dict[str, str]:
    """Return the checksums of the files written beside a page of ours."""
    if not is_ours(page, Form.PAGE):
        return {}
    found = re.search(r"<!-- beside this page: (\{.*\}) -->", page.read_text(encoding="utf-8"))
    return dict(json.loads(found[1])) if found else {}


def _checksum(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()[:32]


def contents_of(found: Reproduction) -> dict[str, bytes]:
    """Make the files of a reproduction, figures, curves, whole tables and explanations, with ``report.html`` last."""
    contents: dict[str, bytes] = {}
    pictures = {}
    names = each_item([f"drawing of {panel.id}" for panel in found.panels])
    for _, panel in zip(names, found.panels, strict=True):
        figure = pictures[panel.id] = drawn(panel)
        contents[f"{panel.id}.svg"] = to_svg(figure).encode()
        contents[f"{panel.id}.png"] = to_png(figure)
    contents |= {name: found.content(name).encode() for name in found.files}
    beside = json.dumps({name: _checksum(content) for name, content in contents.items()})
    page = html(found.document, pictures=pictures)
    contents[_PAGE] = f"{page}\n<!-- beside this page: {beside} -->\n".encode()
    return contents
