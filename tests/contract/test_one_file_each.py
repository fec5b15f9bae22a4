"""A law, a skin, a friction with memory and a preset, one file each: found everywhere without touching another file.

Once in the folder of our papers, and once in another package that names them in its entry points.
"""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import electrovib

pytestmark = pytest.mark.slow

TESTS = Path(__file__).parent
PACKAGE = Path(electrovib.__file__).parent
HEAD = '''"""{author}, "{title}", Journal of Examples, 2099.

Claims: {claims} Does not claim: anything above 10 MV/m.
"""

from electrovib.core.citation import Check

CITATION = "{author}, {title}, Journal of Examples (2099), doi:10.0000/{author}.2099"
STATUS = "full text"
'''
LAW = '''
from collections.abc import Mapping
from typing import Annotated, ClassVar

from electrovib.core.constants import VACUUM_PERMITTIVITY as eps0
from electrovib.core.quantity import Number, Quantity
from electrovib.physics.force import ForceLaw, layer_of


class SaturatingStress(ForceLaw):
    """Pressure under a film of sweat that levels off as the field of the gap nears breakdown."""

    reference: ClassVar[str] = "doi:10.0000/law.2099"
    status: ClassVar[str] = "full text"
    needs: ClassVar[tuple[str, ...]] = ("stratum_corneum", "gap", "sweat")
    equation: ClassVar[Mapping[str, str]] = {"pressure": "eps0*E**2/2/(1 + (E/breakdown)**2)"}
    checks: ClassVar = (Check("pressure", given={"E": 3e6}, expect=19.92, rtol=2e-3, source="table 1, row 2"),)

    breakdown: Annotated[
        Number, Quantity("V/m", 1e5, 1e9, "gap field at which the pressure has halved")
    ] = 3e6

    def amplitudes(self, section):
        """Give the field of the gap, less what a wet skin takes off it."""
        skin, sweat = (layer_of(section, name) for name in ("stratum_corneum", "sweat"))
        return {"E": layer_of(section, "gap").field + (skin.field + sweat.field) * 0.01}

    def pressure(self, E):
        """Attraction per area from the gap field [V/m]."""
        return eps0 * E**2 / 2 / (1 + (E / self.breakdown) ** 2)
'''
SKIN = '''
from electrovib.physics.material import Constant
from electrovib.physics.skin import Skin

WRIST = Constant(permittivity=1100.0, conductivity=3e-6)
CHECKS = (
    Check("permittivity of the wrist", expect=1100.0, rtol=1e-3, source="table 2, row 1",
          compute=lambda: WRIST.permittivity),
)


def skins():
    """Give the wrist."""
    note = "one person, one electrode of 1 cm2"
    return {"wrist": Skin(name="skin of a wrist", material=WRIST, status="full text", source=CITATION, note=note)}
'''
FRICTION = '''
from typing import Annotated, Any, ClassVar

import numpy as np

from electrovib.core.quantity import Number, Quantity
from electrovib.physics.friction import FollowingFriction


class TwoPaces(FollowingFriction):
    """Friction of which half follows at once and half after a time."""

    reference: ClassVar[str] = "doi:10.0000/friction.2099"
    status: ClassVar[str] = "full text"
    example: ClassVar[dict[str, Any]] = {"steady": {"model": "Coulomb", "coefficient": 0.5}}

    time: Annotated[Number, Quantity("s", 1e-6, 1e3, "in which the slow half follows")] = 20e-3

    def memory(self, speed):
        """Give the slow half, the same at every speed."""
        return ((0.5, np.full(np.shape(speed), 1 / self.time)),)


CHECKS = (
    Check("rate of the slow half", expect=50.0, rtol=1e-9, source="table 3",
          compute=lambda: float(TwoPaces.model_validate(TwoPaces.example).memory(np.array(0.1))[0][1])),
)
'''
PRESET = """
from electrovib.papers import published

scenarios = published(__name__).scenarios
CHECKS = (
    Check("voltage", expect=150.0, rtol=1e-6, source="section 2",
          compute=lambda: scenarios()["press"].drive.high),
)
"""
PUBLISHED = """
schema = 1
status = "full text"
citations = [{ kind = "misc", title = "A preset of its own", year = 2099 }]

[scenarios.press]
title = "Preset 2099: pressed"
scenario = "vezzoli_2014/fig6_gap"
changes = { "drive.high" = "150 V", "load.normal_force" = "0.3 N" }
sources = { "drive.high" = "Preset 2099, section 2", "load.normal_force" = "Preset 2099, section 2" }
"""
FILES = {
    "law_2099": ("attraction levels off near breakdown.", LAW),
    "skin_2099": ("the skin of a wrist does not disperse.", SKIN),
    "friction_2099": ("half of the friction is slow.", FRICTION),
    "preset_2099": ("a finger is pressed on a film.", PRESET),
}


def text_of(name):
    claims, body = FILES[name]
    author = name.partition("_")[0]
    return HEAD.format(author=author, title=f"A {author} of its own", claims=claims) + body


def publish(folder):
    """Lay what the paper with a preset states beside its module."""
    (folder / "published").mkdir(exist_ok=True)
    (folder / "published" / "preset_2099.toml").write_text(PUBLISHED, encoding="utf-8")


def put_into_our_papers(folder):
    """Copy the package, and put the files into its folder of papers."""
    shutil.copytree(PACKAGE, folder / "electrovib", ignore=shutil.ignore_patterns("__pycache__"))
    for name in FILES:
        (folder / "electrovib" / "papers" / f"{name}.py").write_text(text_of(name), encoding="utf-8")
    publish(folder / "electrovib" / "papers")
    return str(folder)


def put_into_another_package(folder):
    """Lay the files down as an installer does, with entry points in a dist-info folder."""
    for name in FILES:
        (folder / f"{name}.py").write_text(text_of(name), encoding="utf-8")
    publish(folder)
    about = folder / "example_models-1.0.dist-info"
    about.mkdir()
    about.joinpath("METADATA").write_text("Metadata-Version: 2.1\nName: example-models\nVersion: 1.0\n")
    entries = "".join(f"{name} = {name}\n" for name in FILES)
    about.joinpath("entry_points.txt").write_text(f"[electrovib.models]\n{entries}")
    return os.pathsep.join([str(folder), str(PACKAGE.parent)])


PLACES = {"ours": put_into_our_papers, "theirs": put_into_another_package}


@pytest.fixture(scope="module", params=PLACES)
def environment(request, tmp_path_factory):
    """Environment of a child process that finds the four files."""
    return os.environ | {"PYTHONPATH": PLACES[request.param](tmp_path_factory.mktemp("place"))}


def call(environment, *arguments, cwd=None):
    command = [sys.executable, *arguments]
    result = subprocess.run(command, env=environment, cwd=cwd, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stdout + result.stderr
    return result.stdout


def electrovib_says(environment, *arguments, cwd=None):
    return call(environment, "-m", "electrovib", *arguments, cwd=cwd)


def test_the_command_line_lists_and_shows_them(environment):
    listed = electrovib_says(environment, "list")
    for word in (*FILES, "SaturatingStress", "TwoPaces"):
        assert word in listed
    shown = electrovib_says(environment, "list", "SaturatingStress")
    for word in ("breakdown", "100 kV/m to 1 GV/m", "levels off", "anything above 10 MV/m", "19.92"):
        assert word in shown
    assert "skin_2099/wrist: skin of a wrist (full text)" in electrovib_says(environment, "list", "skin_2099")


def test_they_run(environment, tmp_path):
    said = electrovib_says(environment, "run", "preset_2099/press", cwd=tmp_path)
    assert "electrostatic force" in said
    assert "drive.high" not in said  # it stands in the paper, and nobody has set it
    changes = {
        "force.model": "SaturatingStress",
        "force.breakdown": "5 MV/m",
        "friction": '{ model = "TwoPaces", steady = { model = "Coulomb", coefficient = 0.5 } }',
        "stack.stratum_corneum.material": "skin_2099/wrist",
    }
    file = tmp_path / "my.toml"
    file.write_text(electrovib_says(environment, "init", "vezzoli_2014/fig6_gap"), encoding="utf-8")
    water = 'material = { model = "Constant", permittivity = 80 }'
    with_sweat = f'[stack.sweat]\nrole = "plate"\nthickness = "1 um"\n{water}\n\n[stack.gap]'
    file.write_text(file.read_text(encoding="utf-8").replace("[stack.gap]", with_sweat), encoding="utf-8")
    options = [part for path, value in changes.items() for part in ("--set", f"{path}={value}")]
    said = electrovib_says(environment, "run", "my.toml", *options, "-o", "out.nc", cwd=tmp_path)
    assert "electrostatic force" in said
    kept = electrovib_says(environment, "init", "out.nc", cwd=tmp_path)
    assert "skin_2099/wrist: skin, A skin of its own" in kept
    assert 'model = "TwoPaces"' in kept
    assert "SaturatingStress" in electrovib_says(environment, "compare", "my.toml", cwd=tmp_path)


def test_the_catalogue_and_the_citations_have_them(environment):
    code = (
        "from electrovib.studies import catalogue; from electrovib.core.discovery import papers;"
        " print(catalogue.models(complete=True));"
        " print(*(catalogue.models(name) for name in papers()));"
        " print(*(catalogue.bibtex(papers()[name], name) for name in papers()))"
    )
    page = call(environment, "-c", code)
    for name in FILES:
        assert f"{name} (paper)" in page
        assert f"@misc{{{name}," in page
        assert f"10.0000/{name.replace('_', '.')}" in page
    for offered in ("SaturatingStress", "TwoPaces", "skin_2099/wrist", "electrovib run preset_2099/press"):
        assert offered in page


A_PAPER = "paper_cites paper_carries_a_check"
A_MODEL = "every_number says_what_it_is a_member_is_built cannot_be_subclassed round_trip every_path changed_equations"
A_PRESET = "scenarios_round_trip names_the_source each_insulator shipped_scenario"
TAKEN = {
    "law_2099": A_PAPER,
    "friction_2099": f"{A_PAPER} check_passes",
    "skin_2099": f"{A_PAPER} check_passes skins_are_passive",
    "preset_2099": f"{A_PAPER} check_passes {A_PRESET}",
    "SaturatingStress": f"{A_MODEL} check_passes equations_hold scalar_equals_array steady_force",
    "TwoPaces": A_MODEL,
}
"""What is contributed to words in the names of contract tests that have to run for it."""


def test_the_contract_tests_take_each_of_them(environment):
    options = ("-q", "-rA", "-p", "no:cacheprovider", "-m", "not slow", "-k", " or ".join(TAKEN))
    said = call(environment, "-m", "pytest", str(TESTS), *options, cwd=TESTS.parent.parent)
    passed = [line for line in said.splitlines() if line.startswith("PASSED")]
    for name, words in TAKEN.items():
        missing = [
            word for word in words.split() if not any(word in line and name in line for line in passed)
        ]
        assert not missing, name
    # the law is among those that run on a stack, with each filling of the finger
    assert len([line for line in passed if "test_steady_force_under_a_sine" in line]) >= 6


def test_without_the_files_they_are_unknown():
    command = [sys.executable, "-m", "electrovib", "run", "preset_2099/press"]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    assert result.returncode == 2
    assert "neither a file nor a paper" in result.stderr
