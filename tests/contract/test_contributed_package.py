"""Another group's package contributes a paper by entry point: listed, contract-tested, runnable, in one file."""

from __future__ import annotations

import base64
import hashlib
import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

TESTS = Path(__file__).parent

PAPER = '''
"""A. Example, "A saturating force law", Journal of Examples, 2099.

Claims: attraction levels off near breakdown. Does not claim: anything above 10 MV/m.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar

from electrovib.core.checks import Check
from electrovib.core.constants import VACUUM_PERMITTIVITY as eps0
from electrovib.core.quantity import Number, Quantity
from electrovib.physics.force import ForceLaw
from electrovib.scenario import Scenario, load

CITATION = "A. Example, A saturating force law, Journal of Examples (2099), doi:10.0000/example.2099"
STATUS = "full text"


class SaturatingStress(ForceLaw):
    """Pressure in the gap that levels off as the gap field nears breakdown."""

    reference: ClassVar[str] = "doi:10.0000/example.2099"
    status: ClassVar[str] = "full text"
    equation: ClassVar[Mapping[str, str]] = {"pressure": "eps0*E**2/2/(1 + (E/breakdown)**2)"}
    checks: ClassVar = (Check("pressure", given={"E": 3e6}, expect=19.92, rtol=2e-3, source="table 1, row 2"),)

    breakdown: Annotated[
        Number, Quantity("V/m", 1e5, 1e9, "gap field at which the pressure has halved")
    ] = 3e6

    def pressure(self, E):
        """Attraction per area from the gap field [V/m]."""
        return eps0 * E**2 / 2 / (1 + (E / self.breakdown) ** 2)


CHECKS = (
    Check("pressure at breakdown", expect=19.92, rtol=2e-3, source="table 1, row 2",
          compute=lambda: SaturatingStress().pressure(3e6)),
)


def scenarios() -> dict[str, Scenario]:
    """Give the paper's set-up."""
    base = load("vezzoli_2014/fig2").replace({"force.model": "SaturatingStress"})
    return {"fig3": base}
'''  # fmt: skip


@pytest.fixture(scope="module")
def contributed(tmp_path_factory) -> dict[str, str]:
    """A folder into which pip has installed the package, on the path of a child process."""
    folder = tmp_path_factory.mktemp("contributed")
    wheel = folder / "example_models-1.0-py3-none-any.whl"
    about = "example_models-1.0.dist-info"
    files = {
        "example_2099.py": PAPER,
        f"{about}/METADATA": "Metadata-Version: 2.1\nName: example-models\nVersion: 1.0\n",
        f"{about}/WHEEL": "Wheel-Version: 1.0\nGenerator: test\nRoot-Is-Purelib: true\nTag: py3-none-any\n",
        f"{about}/entry_points.txt": "[electrovib.models]\nexample_2099 = example_2099\n",
    }
    record = ""
    with zipfile.ZipFile(wheel, "w") as archive:
        for name, text in files.items():
            archive.writestr(name, text)
            digest = base64.urlsafe_b64encode(hashlib.sha256(text.encode()).digest()).rstrip(b"=").decode()
            record += f"{name},sha256={digest},{len(text.encode())}\n"
        archive.writestr(f"{about}/RECORD", record + f"{about}/RECORD,,\n")
    place = folder / "site"
    install = [
        sys.executable,
        "-m",
        "pip",
        "install",
        "--quiet",
        "--no-index",
        "--no-deps",
        "--target",
        str(place),
    ]
    subprocess.run([*install, str(wheel)], check=True, capture_output=True)
    before = [os.environ["PYTHONPATH"]] if os.environ.get("PYTHONPATH") else []
    return os.environ | {"PYTHONPATH": os.pathsep.join([str(place), *before])}


def call(environment: dict[str, str], *arguments: str, cwd: Path | None = None) -> str:
    result = subprocess.run(
        [sys.executable, "-m", *arguments],
        env=environment,
        cwd=cwd,
        capture_output=True,
        text=True,
        check=False,
    )
    assert result.returncode == 0, result.stdout + result.stderr
    return result.stdout


def test_it_is_listed_and_shown(contributed):
    listed = call(contributed, "electrovib", "models")
    assert "SaturatingStress" in listed
    assert "example_2099" in listed
    shown = call(contributed, "electrovib", "models", "SaturatingStress")
    for word in (
        "breakdown",
        "100 kV/m to 1 GV/m",
        "attraction levels off",
        "anything above 10 MV/m",
        "19.92",
    ):
        assert word in shown
    assert "10.0000/example.2099" in call(contributed, "electrovib", "models", "example_2099", "--bibtex")


def test_it_runs_and_is_compared(contributed, tmp_path):
    assert "electrostatic force" in call(contributed, "electrovib", "run", "example_2099/fig3", cwd=tmp_path)
    changed = ("--set", "force.model=SaturatingStress", "--set", "force.breakdown=5 MV/m")
    assert "electrostatic force" in call(
        contributed, "electrovib", "run", "vezzoli_2014/fig2", *changed, cwd=tmp_path
    )
    assert "SaturatingStress" in call(contributed, "electrovib", "compare", "vezzoli_2014/fig2")


def test_it_is_contract_tested(contributed):
    names = "example_2099 or SaturatingStress"
    said = call(
        contributed,
        "pytest",
        "-q",
        str(TESTS),
        "-k",
        names,
        "-p",
        "no:cacheprovider",
        cwd=TESTS.parent.parent,
    )
    passed = [line for line in said.splitlines() if " passed" in line]
    assert passed
    assert int(passed[0].split(" passed")[0].split()[-1]) >= 10


def test_without_the_package_it_is_unknown():
    result = subprocess.run(
        [sys.executable, "-m", "electrovib", "run", "example_2099/fig3"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert result.returncode == 2
    assert "neither a file nor a paper" in result.stderr
