"""Data flows one way, and every folder is a package."""

from __future__ import annotations

import subprocess
import sys
import tomllib

from source import ROOT, SOURCE, text_of

CONFIGURATION = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
LAYERS = CONFIGURATION["tool"]["importlinter"]["contracts"][0]["layers"]


def lint(configuration, folder):
    """Run import-linter as its command does, in a folder that holds the configuration."""
    script = "import sys; from importlinter.cli import lint_imports_command as c; c(sys.argv[1:])"
    command = [sys.executable, "-c", script, "--config", str(configuration), "--no-cache"]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=120, check=False)


def test_layers_are_kept():
    done = lint(ROOT / "pyproject.toml", ROOT)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "1 kept, 0 broken" in done.stdout


def test_a_broken_layer_would_be_noticed(tmp_path):
    """With two layers swapped the same tool refuses."""
    layers = list(LAYERS)
    first, second = layers.index("solve"), layers.index("core")
    layers[first], layers[second] = layers[second], layers[first]
    listed = "\n  ".join(layers)
    wrong = tmp_path / "wrong.ini"
    wrong.write_text(
        "[importlinter]\nroot_package = electrovib\n\n[importlinter:contract:one]\nname = one\ntype = layers\n"
        f"containers =\n  electrovib\nlayers =\n  {listed}\n",
        encoding="utf-8",
    )
    done = lint(wrong, tmp_path)
    assert done.returncode != 0
    assert "BROKEN" in done.stdout


def test_layers_are_in_the_order_of_the_data():
    order = ["core", "physics", "scenario", "solve", "study", "papers", "view", "bench", "apps"]
    places = {name.strip(): place for place, line in enumerate(reversed(LAYERS)) for name in line.split("|")}
    assert [places[name] for name in order] == sorted(places[name] for name in order)
    assert places["data"] == places["physics"]
    assert places["export"] == places["view"]
    assert places["recordings"] == places["study"]


def test_every_folder_is_in_a_layer():
    named = {name.strip() for line in LAYERS for name in line.split("|")}
    assert named == {path.name for path in SOURCE.iterdir() if (path / "__init__.py").exists()}


def test_every_folder_with_code_is_a_package():
    folders = {path.parent for path in SOURCE.rglob("*.py")}
    assert not [str(folder.relative_to(ROOT)) for folder in folders if not (folder / "__init__.py").exists()]


def test_papers_are_found_and_not_imported_from_below():
    """No file below the papers names one: a new paper needs no line anywhere."""
    names = [
        path.stem for path in (SOURCE / "papers").iterdir() if path.stem != "__init__" and "_" in path.stem
    ]
    named = [
        f"{path.relative_to(SOURCE)}: {name}"
        for folder in ("core", "physics", "data", "scenario", "solve", "study", "recordings")
        for path in (SOURCE / folder).rglob("*.py")
        for name in names
        if f"papers.{name}" in text_of(path)
    ]
    assert not named
    assert "vezzoli_2014" in names
