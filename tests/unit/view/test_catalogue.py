"""The page of models is as the code is."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import electrovib
from electrovib.view.catalogue import as_markdown

PAGE = Path(__file__).parents[3] / "docs" / "models.md"


def test_the_page_is_as_the_code_is():
    # to renew it:
    # python -c "from electrovib.view.catalogue import as_markdown; print(as_markdown(own=True), end='')" > docs/models.md
    assert PAGE.read_text(encoding="utf-8") == as_markdown(own=True)


def test_recalled_models_are_shown_as_such():
    page = as_markdown(own=True)
    assert "| Persson2018RoughGap | persson_2018 | unverified |" in page
    assert "| Vezzoli2014Causal | vezzoli_2014 | full text |" in page


CONTRIBUTED = '''
"""A. Example, "Another package", 2099. Claims: nothing.  Does not claim: anything."""

from electrovib.core.model import Model
from electrovib.physics.friction import Coulomb, Friction

CITATION, STATUS, CHECKS = "A. Example, 2099", "derived", ()


class Shade(Model, family=True):
    """A family of another package."""


class Dark(Shade):
    """A member of it."""


class Example2099Friction(Friction):
    """A member of a family of ours."""
'''


def test_the_page_is_of_this_package_whatever_else_is_installed(tmp_path):
    (tmp_path / "example_2099.py").write_text(CONTRIBUTED, encoding="utf-8")
    about = tmp_path / "example-1.0.dist-info"
    about.mkdir()
    about.joinpath("METADATA").write_text("Metadata-Version: 2.1\nName: example\nVersion: 1.0\n")
    about.joinpath("entry_points.txt").write_text("[electrovib.models]\nexample_2099 = example_2099\n")
    script = (
        "import sys; from electrovib.study.catalogue import models; from electrovib.view.catalogue import as_markdown;"
        "found = {entry.name for entry in models()}; assert {'example_2099', 'Dark', 'Example2099Friction'} <= found;"
        "assert 'example_2099' in as_markdown(own=False);"
        "sys.stdout.buffer.write(as_markdown(own=True).encode())"
    )
    place = os.pathsep.join([str(tmp_path), str(Path(electrovib.__file__).parents[1])])
    environment = os.environ | {"PYTHONPATH": place}
    done = subprocess.run([sys.executable, "-c", script], env=environment, capture_output=True, check=False)
    assert done.returncode == 0, done.stderr.decode()
    assert done.stdout.decode() == PAGE.read_text(encoding="utf-8")
