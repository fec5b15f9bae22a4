"""The job with the lowest versions installs what `pyproject.toml` states, for every extra that a user installs."""

from __future__ import annotations

import re
import subprocess
import sys
import tomllib
from pathlib import Path

from packaging.requirements import Requirement

ROOT = Path(__file__).parents[2]
FOR_WORK_ON_THE_PACKAGE = {"all", "benchmarks", "docs", "test"}


def test_the_constraints_are_the_lowest_versions_that_are_allowed():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    optional = project["optional-dependencies"]
    (extras,) = re.findall(r"^extras=(.*)$", (ROOT / ".ci" / "run").read_text(encoding="utf-8"), re.MULTILINE)
    assert set(extras.split(",")) == set(optional) - FOR_WORK_ON_THE_PACKAGE
    command = [sys.executable, ROOT / ".ci" / "lowest_versions.py", extras]
    printed = subprocess.run(command, capture_output=True, text=True, check=True, timeout=60).stdout
    asked = [*project["dependencies"], *(each for extra in extras.split(",") for each in optional[extra])]
    for line, each in zip(printed.splitlines(), asked, strict=True):
        pinned, requirement = Requirement(line), Requirement(each)
        (lowest,) = [one.version for one in requirement.specifier if one.operator == ">="]
        assert (pinned.name, pinned.extras) == (requirement.name, set())  # pip refuses extras in constraints
        assert str(pinned.specifier) == f"=={lowest}"
