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

    def install(name, text, *, module="contributed_example", dist="contributed"):
        (tmp_path / f"{module}.py").write_text(text, encoding="utf-8")
        info = tmp_path / f"{dist}-1.0.dist-info"
        info.mkdir()
        (info / "METADATA").write_text(
            f"Metadata-Version: 2.1\nName: {dist}\nVersion: 1.0\n", encoding="utf-8"
        )
        (info / "entry_points.txt").write_text(
            f"[{ENTRY_POINT_GROUP}]\n{name} = {module}\n", encoding="utf-8"
        )
        monkeypatch.syspath_prepend(str(tmp_path))
        return module

    yield install
    for module in ("contributed_example", "contributed_other"):
        sys.modules.pop(module, None)


def test_our_papers_are_found_without_importing_them():
    assert "vezzoli_2014" in paper_names()
    assert list(paper_names()) == sorted(paper_names())
    assert set(paper_names()) <= set(papers())


def test_a_contributed_paper_is_found(installed):
    installed("example_2099", MODULE)
    assert "example_2099" in papers()
    module = paper("example_2099")
    assert module.CITATION.startswith("A. Example")
    assert set(find_members(module.Shade)) == {"Dark"}
    assert read_model(module.Shade, {"model": "Dark"}).depth == 0.5


def test_a_contributed_paper_has_a_near_name(installed):
    installed("example_2099", MODULE)
    with pytest.raises(InputError, match="Did you mean 'example_2099'"):
        paper("exampel_2099")


def test_two_papers_of_one_name_are_refused(installed):
    installed("vezzoli_2014", MODULE)
    with pytest.raises(ElectrovibError, match="two papers are called 'vezzoli_2014'"):
        papers()


def test_a_paper_that_cannot_be_imported_says_which(installed):
    installed("broken_2099", "import no_such_module_anywhere")
    with pytest.raises(ElectrovibError, match=r"'broken_2099' of another package.*no_such_module_anywhere"):
        papers()


def test_a_contribution_has_to_be_a_module(monkeypatch, fresh):
    entry = EntryPoint("odd_2099", "os:sep", ENTRY_POINT_GROUP)
    monkeypatch.setattr(discovery, "_contributed", lambda: (entry,))
    with pytest.raises(ElectrovibError, match="is not a module"):
        papers()


@pytest.mark.parametrize(
    ("name", "sentence"),
    [("vezoli_2014", "Did you mean 'vezzoli_2014'"), ("nothing", "is neither a file nor a paper")],
)
def test_unknown_papers_are_refused(name, sentence):
    with pytest.raises(InputError, match=sentence):
        paper(name)


def test_members_of_families_within_families_are_found():
    class Outer(Model, family=True):
        """Of this test."""

    class Inner(Outer, family=True):
        """Of this test."""

    class One(Outer):
        """Of this test."""

    class Two(Inner):
        """Of this test."""

    assert find_members(Outer) == {"One": One, "Two": Two}
    assert find_members(Inner) == {"Two": Two}


def test_a_member_is_found_wherever_in_the_room_of_its_family_it_is():
    """A folder of the family's own does not hide members beside the folder; no paper is imported for them."""
    code = (
        "import sys; from electrovib.core.discovery import find_members; from electrovib.physics.material import Material;"
        " found = find_members(Material, wanted='BridgedAir');"
        " print('BridgedAir' in found, any(name.startswith('electrovib.papers.') for name in sys.modules))"
    )
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert said == "True False\n"


def test_two_models_of_one_name_are_refused():
    class Family(Model, family=True):
        """Of this test."""

    class Within(Family, family=True):
        """Of this test."""

    first = type("Same", (Family,), {"__module__": "one", "__doc__": "First."})
    second = type("Same", (Within,), {"__module__": "two", "__doc__": "Second."})
    with pytest.raises(ElectrovibError, match=r"two models are called Same: (one and two|two and one)"):
        find_members(Family)
    assert first is not second


def test_a_paper_is_imported_only_when_its_name_is_wanted(monkeypatch, fresh):
    from electrovib.physics.drive.base import Drive

    def refuse():
        raise AssertionError("papers were imported")

    monkeypatch.setattr(discovery, "papers", refuse)
    assert "Sine" in find_members(Drive, wanted="Sine")
    with pytest.raises(AssertionError, match="papers were imported"):
        find_members(Drive, wanted="NoSuchDrive")
    monkeypatch.undo()
