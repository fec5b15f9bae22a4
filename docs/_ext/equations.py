"""Equations as SVG pictures beside the pages, so that they are readable without a network."""

from __future__ import annotations

import hashlib
import io
from functools import cache
from pathlib import Path
from typing import Any

import matplotlib as mpl
from docutils import nodes
from matplotlib import mathtext
from matplotlib.font_manager import FontProperties
from sphinx.application import Sphinx
from sphinx.errors import ExtensionError

FOLDER = "_images/equations"
POINTS = 11.0
"""Size of the letters of an equation, which stands for 1 em of the text."""
SETTINGS = {
    "mathtext.fontset": "dejavusans",
    "savefig.transparent": True,
    "svg.fonttype": "path",
    "svg.hashsalt": "equations",
}


@cache
def drawn(latex: str) -> tuple[bytes, float, float, float]:
    """Draw one equation.

    Parameters
    ----------
    latex : str
        In the part of LaTeX that Matplotlib sets.

    Returns
    -------
    picture : bytes
        SVG.
    width, height, depth : float
        Of the picture and below the baseline, in em of the text.
    """
    text, picture = f"${latex}$", io.BytesIO()
    with mpl.rc_context(SETTINGS):
        font = FontProperties(size=POINTS)
        width, height, depth, _, _ = mathtext.MathTextParser("path").parse(text, dpi=72, prop=font)
        mathtext.math_to_image(text, picture, prop=font, dpi=72, format="svg")
    return picture.getvalue(), width / POINTS, height / POINTS, depth / POINTS


def written(translator: Any, latex: str) -> str:
    """Write the picture of an equation into the built site, and return the HTML that shows it."""
    latex = " ".join(latex.split())
    try:
        picture, width, height, depth = drawn(latex)
    except ValueError as error:
        raise ExtensionError(f"Matplotlib cannot set the equation '{latex}': {error}") from error
    name = f"{hashlib.sha256(latex.encode()).hexdigest()[:16]}.svg"
    builder = translator.builder
    file = Path(builder.outdir) / FOLDER / name
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_bytes(picture)
    up = "../" * builder.current_docname.count("/") if builder.name == "html" else ""
    size = f"width:{width:.3f}em;height:{height:.3f}em;vertical-align:{-depth:.3f}em"
    alternative = translator.attval(latex)
    return f'<img class="equation dark-light" src="{up}{FOLDER}/{name}" alt="{alternative}" style="{size}">'


def show_inline(translator: Any, node: nodes.math) -> None:
    """Show an equation in a line of text."""
    translator.body.append(written(translator, node.astext()))
    raise nodes.SkipNode


def show_block(translator: Any, node: nodes.math_block) -> None:
    """Show an equation on a line of its own."""
    latex = node.astext().replace(r"\frac", r"\dfrac")
    translator.body.append(
        f'<div class="math equation-block" tabindex="0">{written(translator, latex)}</div>\n'
    )
    raise nodes.SkipNode


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the pictures as the form in which HTML shows equations."""
    app.add_html_math_renderer("svg", (show_inline, None), (show_block, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
