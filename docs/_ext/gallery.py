"""The gallery: scripts and notebooks of examples/, ordered by the question that each answers, run while the site is built."""

from __future__ import annotations

import ast
import json
import re
import shutil
from pathlib import Path
from typing import Any, Final

import xarray as xr
from thumbnails import SIZE

from electrovib.scenario import Scenario

QUESTIONS: Final = {
    "How does the attraction depend on voltage, time and layers?": {
        "from_load_to_plot": "How do I begin in a notebook?",
        "insulator_sweep": "How much more does a thinner insulator attract?",
        "step_by_hand": "Does the attraction after a step follow its closed form?",
    },
    "Is a stack of layers in series a good description of a finger?": {
        "field_solution": "How far does the field of a finger with edges deviate from layers in series?",
    },
    "What happens while the finger slides, or before it touches?": {
        "stick_slip": "What does a voltage change in the stick-slip of a slowly sliding finger?",
        "pull_in": "At which voltage is a compliant surface pulled in, and at which is it released?",
    },
    "Which drive gives a wanted force or texture?": {
        "constant_force": "How large a constant force can be held for 1 s?",
        "picture_texture": "Which drive renders a picture as a texture along the path of a finger?",
    },
    "What would a published experiment have recorded?": {
        "whole_experiment": "Which lateral forces would the set-up of Vezzoli et al. 2014 have recorded, law by law?",
    },
    "How is a recording evaluated?": {
        "measured_drive": "Which force does a measured voltage with uneven time stamps give?",
        "measured_swipe": "What is the friction of a recorded swipe, and how uncertain is it?",
        "clutch_release": "How long after the end of the drive does a clutch let go?",
    },
}
"""Sections of the gallery, each a question, and the examples in it with the question that each answers."""
TABLE: Final = "{examples}"
"""Place of the table of all examples on the first page of the gallery, which `gallery_results` writes."""
NUMBERS: Final = {
    "constant_force": ("slow voltage", "carrier of 3 kHz, 0 pF"),
    "insulator_sweep": ("insulator of 1 um", "insulator of 90 um"),
    "stick_slip": ("no voltage", "500 V held"),
    "whole_experiment": ("law (1) of the paper:", "Maxwell stress in a leaky gap:"),
}
"""Beginnings of the lines of its output that answer the question of an example, where it is not the first one."""
OTHERS: Final = "Further examples"
ARGUMENTS: Final = {name: [f"{name}.png"] for name in ("constant_force", "field_solution")}
"""What a script is started with, where it draws only on demand."""


def settings(docs: Path) -> dict[str, Any]:
    """Return the settings of sphinx-gallery, after the scripts have been put where it reads them.

    Parameters
    ----------
    docs : Path
        Folder of the documentation.
    """
    collect(docs.parent / "examples", docs / "_gallery")
    remove_old(docs / "gallery", docs / "_gallery")
    return {
        "examples_dirs": "_gallery",
        "gallery_dirs": "gallery",
        "filename_pattern": r"\.py$",
        "image_scrapers": ("gallery.shown_results",),
        "reset_argv": "gallery.arguments",
        "within_subsection_order": "FileNameSortKey",
        "thumbnail_size": SIZE,
        "min_reported_time": 0,
        "show_memory": False,
        "show_signature": False,
        "ignore_repr_types": ".*",  # what a notebook shows is added by `shown_results`
        "write_computation_times": False,  # its page loads scripts from a network
        "download_all_examples": False,
        "remove_config_comments": True,
        "abort_on_example_error": False,
        "only_warn_on_example_error": False,
        "copyfile_regex": r".*\.(png|csv|toml)$",
    }


def collect(examples: Path, target: Path) -> None:
    """Copy every script into the folder of its question, a notebook as a script; those without a question come last."""
    shutil.rmtree(target, ignore_errors=True)
    scripts = {path.stem: path.read_text(encoding="utf-8") for path in sorted(examples.glob("*.py"))}
    scripts |= {path.stem: from_notebook(path) for path in sorted(examples.glob("*.ipynb"))}
    listed = {name for names in QUESTIONS.values() for name in names}
    sections = QUESTIONS | {OTHERS: {name: "" for name in scripts if name not in listed}}
    target.mkdir()
    _head(target, "Gallery", TABLE)
    for number, (question, names) in enumerate(sections.items()):
        present = [name for name in names if name in scripts]
        if not present:
            continue
        folder = target / f"{number}_{re.sub(r'[^a-z]+', '_', question.lower()).strip('_')}"
        folder.mkdir()
        _head(folder, question, "", line="-")
        for name in present:
            (folder / f"{name}.py").write_text(with_title(scripts[name]), encoding="utf-8")


def from_notebook(file: Path) -> str:
    """Return a notebook as a script with one block for each cell; its first cell is the docstring."""
    first, *cells = json.loads(file.read_text(encoding="utf-8"))["cells"]
    title, _, text = "".join(first["source"]).removeprefix("# ").partition("\n\n")
    parts = [f'"""{title}.\n\n{text}\n"""']
    for cell in cells:
        source = "".join(cell["source"])
        if cell["cell_type"] == "markdown":
            source = "\n".join(f"# {line}".rstrip() for line in source.splitlines())
        parts.append(f"# %%\n{source}")
    return "\n\n".join(parts) + "\n"


def remove_old(built: Path, scripts: Path) -> None:
    """Remove the pages of an earlier build whose script or question is no longer there."""
    for folder in [path for path in built.glob("*") if path.is_dir()]:
        if not (scripts / folder.name).is_dir():
            shutil.rmtree(folder)
            continue
        for page in folder.glob("*.rst"):
            if page.stem != "index" and not (scripts / folder.name / f"{page.stem}.py").exists():
                page.unlink()


def with_title(script: str) -> str:
    """Return a script whose docstring begins with its first sentence as a title in reStructuredText."""
    docstring = ast.get_docstring(ast.parse(script)) or ""
    title, _, rest = docstring.partition("\n\n")
    title = " ".join(title.split()).rstrip(".")
    _, _, code = script.partition('"""')[2].partition('"""')
    return f'r"""\n{title}\n{"=" * len(title)}\n\n{rest}\n"""{code}'


def _head(folder: Path, title: str, text: str, line: str = "=") -> None:
    (folder / "GALLERY_HEADER.rst").write_text(f"{title}\n{line * len(title)}\n\n{text}\n", encoding="utf-8")


def arguments(gallery_conf: dict[str, Any], script_vars: dict[str, Any]) -> list[str]:
    """Return the arguments that a script is started with."""
    del gallery_conf
    return ARGUMENTS.get(Path(script_vars["src_file"]).stem, [])


def shown_results(block: Any, block_vars: dict[str, Any], gallery_conf: dict[str, Any]) -> str:
    """Show the pictures that a script has saved beside itself, or what a cell of a notebook shows.

    Parameters
    ----------
    block : tuple
        Block of the script; not needed.
    block_vars : dict
        Variables of sphinx-gallery for this block.
    gallery_conf : dict
        Settings of sphinx-gallery.

    Returns
    -------
    str
        reStructuredText.
    """
    from sphinx_gallery.scrapers import figure_rst

    del block
    shown, text = [], ""
    for picture in sorted(Path(block_vars["src_file"]).parent.glob("*.png")):
        place = next(block_vars["image_path_iterator"])
        shutil.move(picture, place)
        shown.append(place)
    value = block_vars["example_globals"].pop("___", None)  # of the last line of a cell
    block_vars["example_globals"]["___"] = None
    if hasattr(value, "figure"):
        place = next(block_vars["image_path_iterator"])
        value.figure.savefig(place)
        shown.append(place)
    elif value is not None:
        lines = "\n".join(f"   {line}" for line in as_html(value).splitlines())
        text = f'.. raw:: html\n\n   <div class="notebook-output">\n{lines}\n   </div>\n\n'
    return text + figure_rst(shown, gallery_conf["src_dir"])


def as_html(value: Any) -> str:
    """Return what a notebook shows for a Scenario, a Trace, a sweep or a table."""
    from electrovib.view.notebook.shown import scenario_html, trace_html

    if isinstance(value, Scenario):
        return scenario_html(value)
    shown = trace_html(value) if isinstance(value, xr.Dataset) else value._repr_html_()
    return str(shown)
