"""The gallery: the scripts of examples/, ordered by the question that each answers, run while the site is built."""

from __future__ import annotations

import ast
import re
import shutil
from pathlib import Path
from typing import Any, Final

QUESTIONS: Final = {
    "How does the attraction depend on voltage, time and layers?": ("step_by_hand", "insulator_sweep"),
    "Is a stack of layers in series a good description of a finger?": ("field_solution",),
    "What happens while the finger slides, or before it touches?": ("stick_slip", "pull_in"),
    "Which drive gives a wanted force or texture?": ("constant_force", "picture_texture"),
    "What would a published experiment have recorded?": ("whole_experiment",),
    "How is a recording evaluated?": ("measured_drive", "measured_swipe", "clutch_release"),
}
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
        "image_scrapers": ("gallery.saved_pictures",),
        "reset_argv": "gallery.arguments",
        "within_subsection_order": "FileNameSortKey",
        "min_reported_time": 1e9,
        "show_memory": False,
        "show_signature": False,
        "write_computation_times": False,  # its page loads scripts from a network
        "download_all_examples": False,
        "remove_config_comments": True,
        "abort_on_example_error": False,
        "only_warn_on_example_error": False,
        "copyfile_regex": r".*\.(png|csv|toml)$",
    }


def collect(examples: Path, target: Path) -> None:
    """Copy every script into the folder of its question; those without one come last."""
    shutil.rmtree(target, ignore_errors=True)
    scripts = {path.stem: path for path in sorted(examples.glob("*.py"))}
    listed = {name for names in QUESTIONS.values() for name in names}
    sections = QUESTIONS | {OTHERS: tuple(name for name in scripts if name not in listed)}
    target.mkdir()
    _head(
        target,
        "Gallery",
        "Each example is a script of the folder `examples`, run by a test and by the build of this page.",
    )
    for number, (question, names) in enumerate(sections.items()):
        present = [name for name in names if name in scripts]
        if not present:
            continue
        folder = target / f"{number}_{re.sub(r'[^a-z]+', '_', question.lower()).strip('_')}"
        folder.mkdir()
        _head(folder, question, "", line="-")
        for name in present:
            text = scripts[name].read_text(encoding="utf-8")
            (folder / f"{name}.py").write_text(with_title(text), encoding="utf-8")


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


def saved_pictures(block: Any, block_vars: dict[str, Any], gallery_conf: dict[str, Any]) -> str:
    """Show the pictures that a script has saved beside itself."""
    from sphinx_gallery.scrapers import figure_rst

    del block
    shown = []
    for picture in sorted(Path(block_vars["src_file"]).parent.glob("*.png")):
        place = next(block_vars["image_path_iterator"])
        shutil.move(picture, place)
        shown.append(place)
    return figure_rst(shown, gallery_conf["src_dir"])
