"""Models of a user's file at the command line: run in one process of its own, which registers them for good."""

import json
import subprocess
import sys

import pytest

from electrovib.core.own_models import described

LAW = '''"""A force law that levels off."""
from typing import Annotated

from electrovib.core.constants import VACUUM_PERMITTIVITY
from electrovib.core.quantity import Number, Quantity
from electrovib.physics.force import ForceLaw
from electrovib.physics.material import Material


class Saturating(ForceLaw):
    """Maxwell stress in the gap that levels off near breakdown."""

    breakdown: Annotated[Number, Quantity("V/m", 1e5, 1e9, "field at which the pressure has halved")] = 3e7

    def pressure(self, E):
        return VACUUM_PERMITTIVITY * E**2 / 2 / (1 + (E / self.breakdown) ** 2)


class Failing(ForceLaw):
    """Law with a mistake."""

    def pressure(self, E):
        return E / undefined


class Bare(Material):
    """Material without what the solvers read."""

    def bound_permittivity(self, frequency):
        return 7.0 + 0j * frequency


class Misnamed(ForceLaw):
    """Law whose argument has another name than its amplitude."""

    def pressure(self, field):
        return field**2


class Unfinished(ForceLaw):
    """Law without a pressure."""
'''
DRIVER = """
import contextlib, io, json, sys
import numpy as np
from electrovib.apps.cli import main
import electrovib as ev

def call(*arguments):
    sys.argv = ["electrovib", *arguments]
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            main()
            code = 0
        except SystemExit as stop:
            code = stop.code or 0
    return code, out.getvalue(), err.getvalue()

GAP = ["--set", "stack.gap.thickness=5um"]
def law(name):
    return [*GAP, "--set", "force.model=" + name]

found = {}
found["without the file"] = call("run", *law("Saturating"))
for name in ("nothing.py", "syntax.py", "broken.py", "empty.py", "law.txt"):
    found[name] = call("--models", name, "run")
found["helper"] = call("--models", "second.py", "run", *law("Second"), "-o", "second.csv")
found["its name"] = call("--models", "law.py", "run", *law("Saturating"), "-o", "own.nc")
found["behind the command"] = call("run", *law("Saturating"), "--models", "law.py")
laws = ["--models", "law.py,MaxwellStressInGap", "--models", "Saturating"]
found["compared"] = call("compare", "vezzoli_2014/fig6", *GAP, *laws)
found["listed"] = call("list", "Saturating")
for name in ("Failing", "Misnamed", "Unfinished"):
    found[name] = call("run", *law(name))
found["Bare"] = call("run", "--set", "stack.insulator.material.model=Bare")
found["attribute"] = json.loads(ev.open_trace("own.nc").attrs["own_models"])
found["repeated"] = call("run", "own.nc")
with open("law.py", "a") as file:
    file.write("\\n# changed\\n")
found["changed"] = call("run", "own.nc")
found["taken"] = call("--models", "taken.py", "run")
print(json.dumps(found))
"""
BEFORE = """
import contextlib, io, json, sys
exec(open("driver.py").read().split("GAP =")[0])
"""
READER = f"""{BEFORE}
found = {{name: call(name, "own.nc") for name in ("run", "check")}}
found["states"] = call("run", "own.nc", "--states")
found["export"] = call("export", "own.nc", "own.cir")
found["largest"] = float(ev.open_trace("own.nc").electrostatic_force.max())
print(json.dumps(found))
"""
REPORTER = f"""{BEFORE}
print(json.dumps(call("report", "own.nc", "-o", "own.html")))
"""
SECOND = LAW.split("class Failing", maxsplit=1)[0].replace("Saturating", "Second")
FILES = {
    "law.py": LAW,
    "syntax.py": "x = 1\nclass Law(\n",
    "broken.py": "import math\n\nmath.nothing\n",
    "empty.py": "from electrovib.physics.force import MaxwellStressInGap\n",
    "law.txt": LAW,
    "second.py": f"{SECOND}import shared\nassert shared.ONE == 1\n",
    "shared.py": "ONE = 1\n",
    "taken.py": LAW.replace("Saturating", "EffectiveMedium"),
    "driver.py": DRIVER,
    "reader.py": READER,
    "reporter.py": REPORTER,
}


def outcomes(folder, script):
    command = [sys.executable, script]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False, timeout=120)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout.splitlines()[-1])


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("own")
    for name, text in FILES.items():
        (place / name).write_text(text)
    return place


@pytest.fixture(scope="module")
def found(folder):
    return outcomes(folder, "driver.py")


@pytest.mark.parametrize(
    ("name", "sentence"),
    [
        ("without the file", "unknown ForceLaw model 'Saturating'"),
        ("without the file", "'electrovib --models FILE.py ...', or import its file in Python"),
        ("nothing.py", "--models nothing.py: there is no such file"),
        ("syntax.py", "syntax.py, line 2: SyntaxError: '(' was never closed"),
        ("broken.py", "broken.py, line 3: AttributeError: module 'math' has no attribute 'nothing'"),
        ("empty.py", "--models empty.py: defines no model"),
        ("law.txt", "--models law.txt: expected a Python file"),
        (
            "taken",
            "two models are called EffectiveMedium: electrovib.physics.force and taken; rename",
        ),
        ("Failing", ": Failing.pressure (law.py, line 23): NameError: name 'undefined' is not defined"),
        ("Bare", ": law.py, Bare: AttributeError: 'Bare' object has no attribute 'conductivity'"),
        (
            "Misnamed",
            ": Misnamed.pressure (law.py, line 36): TypeError: Misnamed.pressure() got an unexpected keyword argument 'E'",
        ),
        ("Unfinished", ": force.model = 'Unfinished': the class does not define pressure(self, E)"),
    ],
)
def test_a_file_or_a_model_that_cannot_be_used_is_one_line(found, name, sentence):
    code, _, err = found[name]
    assert code == 2
    assert err.startswith("electrovib: ")
    assert sentence in err
    assert err.count("\n") == 1


def test_a_law_of_ones_own_runs_and_is_compared(found):
    gone = (
        "electrovib: --models is deprecated since electrovib 1.0.0 and goes in 2.0.0: use electrovib --models"
    )
    for how, said in {"its name": "", "behind the command": gone, "repeated": ""}.items():
        code, out, err = found[how]
        assert code == 0
        assert err.startswith(said)
        assert bool(err) == bool(said)
        assert "electrostatic force: 0 N to 208.2 mN" in out
    code, out, _ = found["compared"]
    assert code == 0
    assert "Saturating" in out
    assert "EffectiveMedium" not in out
    assert out.startswith("Believe MaxwellStressInGap here, 432.5 mN")
    assert "Maxwell stress in the gap that levels off" in found["listed"][1]
    assert found["helper"][0] == 0  # a file imports what lies beside it


def test_a_trace_names_the_file_of_its_models_and_says_which_is_missing(found, folder):
    (entry,) = found["attribute"]
    assert (entry["model"], entry["family"], entry["file"]) == ("Saturating", "ForceLaw", "law.py")
    assert len(entry["sha256"]) == 64
    assert "has changed since" not in found["repeated"][1]
    warning = "warning: the model 'Saturating' is not the one of this Trace: law.py has changed since"
    assert warning in found["changed"][1]
    without = outcomes(folder, "reader.py")
    for command in ("run", "check", "states", "export"):
        code, out, err = without[command]
        assert (code, out) == (2, "")
        assert "force: this Trace needs the ForceLaw model 'Saturating'" in err
        assert f"it was defined in law.py (SHA-256 {entry['sha256'][:12]}...)" in err
        assert "'electrovib --models law.py ...'" in err
        assert err.count("\n") == 1
    assert without["largest"] == pytest.approx(0.2082, rel=1e-3)  # its numbers stay readable


@pytest.mark.slow
def test_a_report_shows_the_signals_and_states_what_is_missing(folder, found):
    code, out, err = outcomes(folder, "reporter.py")
    assert (code, err) == (0, "")
    assert "warning: own is shown without its parameters: force: this Trace needs the ForceLaw model" in out


def test_the_list_of_own_models_is_written_as_text():
    law = {"model": "Saturating", "family": "ForceLaw", "file": "law.py", "sha256": "ab12"}
    typed = {"model": "Other", "family": "Material", "file": "", "sha256": ""}
    text = described(json.dumps([law, typed]))
    assert text == "ForceLaw Saturating, law.py (SHA-256 ab12); Material Other, without a file"
    for damaged in ("{", "[1]", '[{"model": "x"}]'):
        assert described(damaged) == damaged
