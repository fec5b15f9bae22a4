"""Models and papers are found: in our folder, and in what other packages contribute."""

from __future__ import annotations

import subprocess
import sys
from importlib.metadata import EntryPoint

import pytest

from electrovib.core import discovery
from electrovib.core.discovery import ENTRY_POINT_GROUP, find_members, paper, paper_names, papers
from electrovib.core.errors import ElectrovibError, InputError
from electrovib.core.model import Model, read_model
from electrovib.physics.drive.base import Drive

MODULE = '''
"""A. Example, "A contributed paper", 2099. Claims: nothing. Does not claim: anything."""

from typing import Annotated

from electrovib.core.model import Model
from electrovib.core.quantity import Number, Quantity

CITATION, STATUS, CHECKS = "A. Example (2099), doi:10.0000/x", "derived", ()


class Shade(Model, family=True):
    """A family of the contributed package."""


class Dark(Shade):
    """A member of it."""

    depth: Annotated[Number, Quantity("1", 0, 1, "how dark")] = 0.5


def scenarios():
    return {}
'''


@pytest.fixture
def fresh():
    """Forget what was discovered before and after."""
    papers.cache_clear()
    yield
    papers.cache_clear()


@pytest.fixture
def installed(tmp_path, monkeypatch, fresh):
    """Put a package on the path as an installer would, with its entry points in a dist-info folder."""

    def install(name, text):
        info = tmp_path / "contributed-1.0.dist-info"
        info.mkdir()
        for file, content in {
            tmp_path / "contributed_example.py": text,
            info / "METADATA": "Metadata-Version: 2.1\nName: contributed\nVersion: 1.0\n",
            info / "entry_points.txt": f"[{ENTRY_POINT_GROUP}]\n{name} = contributed_example\n",
        }.items():
            file.write_text(content, encoding="utf-8")
        monkeypatch.syspath_prepend(str(tmp_path))

    yield install
    sys.modules.pop("contributed_example", None)


def test_our_papers_are_found_without_importing_them():
    assert "vezzoli_2014" in paper_names()
    assert list(paper_names()) == sorted(paper_names())
    assert set(paper_names()) <= set(papers())


def test_a_contributed_paper_is_found_and_has_a_near_name(installed):
    installed("example_2099", MODULE)
    assert "example_2099" in papers()
    module = paper("example_2099")
    assert module.CITATION.startswith("A. Example")
    assert set(find_members(module.Shade)) == {"Dark"}
    assert read_model(module.Shade, {"model": "Dark"}).depth == 0.5
    for name, words in (
        ("exampel_2099", "Did you mean 'example_2099'"),
        ("vezoli_2014", "Did you mean 'vezzoli_2014'"),
        ("nothing", "is neither a file nor a paper"),
    ):
        with pytest.raises(InputError, match=words):
            paper(name)


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("vezzoli_2014", MODULE, "two papers are called 'vezzoli_2014'"),
        ("broken_2099", "import no_such", "'broken_2099' of another package.*no_such"),
    ],
)
def test_a_contribution_that_cannot_be_taken_is_named(installed, name, text, words):
    installed(name, text)
    with pytest.raises(ElectrovibError, match=words):
        papers()


def test_a_contribution_has_to_be_a_module(monkeypatch, fresh):
    entry = EntryPoint("odd_2099", "os:sep", ENTRY_POINT_GROUP)
    monkeypatch.setattr(discovery, "_contributed", lambda: (entry,))
    with pytest.raises(ElectrovibError, match="is not a module"):
        papers()


def test_members_of_families_within_families_are_found_and_two_of_one_name_are_refused():
    class Outer(Model, family=True):
        """Of this test."""

    class Inner(Outer, family=True):
        """Of this test."""

    one = type("One", (Outer,), {"__module__": "one", "__doc__": "First."})
    two = type("Two", (Inner,), {"__module__": "two", "__doc__": "Second."})
    assert find_members(Outer) == {"One": one, "Two": two}
    assert find_members(Inner) == {"Two": two}
    same = type("One", (Inner,), {"__module__": "two", "__doc__": "Third."})
    with pytest.raises(ElectrovibError, match=r"two models are called One: (one and two|two and one)"):
        find_members(Outer)
    assert same is not one


def test_a_member_is_found_wherever_in_the_room_of_its_family_it_is():
    """A folder of the family's own does not hide members beside the folder; no paper is imported for them."""
    code = (
        "import sys; from electrovib.core.discovery import find_members; from electrovib.physics.material import Material;"
        " found = find_members(Material, wanted='BridgedAir');"
        " print('BridgedAir' in found, any(name.startswith('electrovib.papers.') for name in sys.modules))"
    )
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert said == "True False\n"


def test_a_paper_is_imported_only_when_its_name_is_wanted(monkeypatch, fresh):
    def refuse():
        raise AssertionError("papers were imported")

    monkeypatch.setattr(discovery, "papers", refuse)
    assert "Sine" in find_members(Drive, wanted="Sine")
    with pytest.raises(AssertionError, match="papers were imported"):
        find_members(Drive, wanted="NoSuchDrive")
    monkeypatch.undo()
