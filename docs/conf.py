"""Settings of the documentation: `sphinx-build -W --keep-going docs docs/_build`; nothing is loaded from a network."""

from __future__ import annotations

import sys
from importlib.metadata import version as version_of
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE / "_ext"))

import gallery  # noqa: E402
from pygments.lexers.special import TextLexer  # noqa: E402
from sphinx.highlighting import lexers  # noqa: E402

lexers["csv"] = TextLexer()

project = "electrovib"
author = "The electrovib authors"
copyright = "The electrovib authors"  # noqa: A001
version = release = version_of("electrovib")

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "numpydoc",
    "sphinx_gallery.gen_gallery",
    "equations",
    "figures",
    "gallery_results",
    "reference",
    "sources",
    "thumbnails",
]
exclude_patterns = ["_build", "_ext", "_static", "_gallery"]
default_role = "literal"
smartquotes = False  # "--set" is no dash
html_math_renderer = "svg"

myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 3

add_module_names = False
autodoc_typehints = "none"
numpydoc_show_class_members = False

sphinx_gallery_conf = gallery.settings(HERE)

html_theme = "pydata_sphinx_theme"
html_title = "electrovib"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_js_files = [("slider.js", {"defer": "defer"})]
html_show_sourcelink = False
html_sidebars = {"tutorial": [], "search": []}
html_context = {"default_mode": "auto"}
html_show_search_summary = False  # a page opened as a file may not read the others
html_copy_source = False
html_theme_options = {
    "navbar_align": "left",
    "navbar_end": ["theme-switcher"],
    "show_prev_next": False,
    "secondary_sidebar_items": ["page-toc"],
    "header_links_before_dropdown": 6,
    "footer_start": ["copyright"],
    "footer_end": [],
}
