"""Wrong models of a user: each is refused in a sentence with its class and its file, at every door, and nothing is written."""

import json
import re
import subprocess
import sys

import pytest

pytestmark = pytest.mark.usefixtures("blank_pictures")

LAW = ("force", "ForceLaw", "def pressure(self, E):")
FRICTION = (
    "friction",
    "SteadyFriction",
    "def lateral_force(self, normal_force, electrostatic_force, real_contact_area):",
)
CONTACT = ("contact", "Contact", "def gross_area(self, normal_force=None):")
MEAN = "return normal_force / 1e-4"
MATERIAL = ("stack.insulator.material", "Material", "def bound_permittivity(self, frequency):")
DRIVE = ("drive", "Drive", "def parts(self):")
LOAD = ("load.time_profile", "TimeProfile", "def share(self, time):")
LEAK = ("stack.gap.leak", "Conduction", "def current_density(self, E):")
BACK = ("circuit.return_path", "ReturnPath", "def element(self):")
PIECES = "return (Linear(np.array([0.0, 1e-2]), np.array([0.0, {0}]), np.array([0.0, {0}])),)"
WRONG = {
    "HalfNaN": (*LAW, "p = E**2 * 4e-12; p[len(p) // 2:] = np.nan; return p"),
    "AllNaN": (*LAW, "return np.nan * E"),
    "OneInfinity": (*LAW, "p = E**2 * 4e-12; p[7] = np.inf; return p"),
    "ZeroOverZero": (*LAW, "return E**3 / E * 4e-12"),
    "RootOfNegative": (*LAW, "return np.sqrt(-(E**2) - 1.0)"),
    "Overflowing": (*LAW, "return np.exp(E)"),
    "ComplexPressure": (*LAW, "return E**2 * (4e-12 + 1e-12j)"),
    "NonePressure": (*LAW, "pass"),
    "TextPressure": (*LAW, "return 'large'"),
    "TextsPressure": (*LAW, "return ['a'] * len(E)"),
    "ShortPressure": (*LAW, "return E[1:] ** 2 * 4e-12"),
    "TurnedPressure": (*LAW, "return E[:, None] ** 2 * 4e-12"),
    "PairPressure": (*LAW, "return E**2, E"),
    "DictPressure": (*LAW, "return {'pressure': E**2}"),
    "RaggedPressure": (*LAW, "return [E, E[1:]]"),
    "RaisingPressure": (*LAW, "raise RuntimeError('not today')"),
    "KeyPressure": (*LAW, "return {}['E']"),
    "AssertingPressure": (*LAW, "assert False"),
    "SameEverywhere": (*LAW, "return E.missing"),
    "NoAmplitudes": ("force", "ForceLaw", "def amplitudes(self, section):", "return None"),
    "ListAmplitudes": ("force", "ForceLaw", "def amplitudes(self, section):", "return [1.0]"),
    "NaNFriction": (*FRICTION, "return np.where(electrostatic_force > 1e-3, np.nan, normal_force)"),
    "NegativeFriction": (*FRICTION, "return -0.5 * (normal_force + electrostatic_force)"),
    "ComplexFriction": (*FRICTION, "return (0.5 + 0.1j) * (normal_force + electrostatic_force)"),
    "SumFriction": (*FRICTION, "return [1.0, 2.0]"),
    "NoneFriction": (*FRICTION, "print(end='')"),
    "ArityFriction": ("friction", "SteadyFriction", "def lateral_force(self, normal_force):", "return normal_force"),
    "NegativeArea": (*CONTACT, "return -1e-4", f"def mean_pressure(self, normal_force): {MEAN}"),
    "NaNArea": (*CONTACT, "return float('nan')", f"def mean_pressure(self, normal_force): {MEAN}"),
    "TextArea": (*CONTACT, "return '1 cm2'", f"def mean_pressure(self, normal_force): {MEAN}"),
    "DivisionArea": (*CONTACT, "return 1 / 0", f"def mean_pressure(self, normal_force): {MEAN}"),
    "NaNPermittivity": (*MATERIAL, "return np.nan * frequency + 3j", "conductivity: float = 0.0"),
    "ActivePermittivity": (*MATERIAL, "return 3.0 + 0.1j + 0 * frequency", "conductivity: float = 0.0"),
    "NonePermittivity": (*MATERIAL, "return None", "conductivity: float = 0.0"),
    "ShortPermittivity": (*MATERIAL, "return np.array([3.0, 4.0, 5.0])", "conductivity: float = 0.0"),
    "NaNDrive": (*DRIVE, PIECES.format("np.nan"), "@property\n    def duration(self): return 0.1"),
    "NoDrive": (*DRIVE, "return None", "@property\n    def duration(self): return 0.1"),
    "NumbersDrive": (*DRIVE, "return (0.0, 1.0)", "@property\n    def duration(self): return 0.1"),
    "TextDuration": (*DRIVE, PIECES.format("1.0"), "@property\n    def duration(self): return '0.1 s'"),
    "NaNLoad": (*LOAD, "return np.full(np.shape(time), np.nan)", "def corners(self): return ((0.0, 1.0), (1.0, 2.0))"),
    "NegativeLoad": (*LOAD, "return np.full(np.shape(time), -1.0)", "def corners(self): return ((0.0, 1.0), (1.0, 2.0))"),
    "NaNCorners": ("load.time_profile", "TimeProfile", "def corners(self):", "return ((0.0, float('nan')),)"),
    "NaNLeak": (*LEAK, "return np.nan * E", "def slope(self, E): return np.ones_like(E) * 1e-9"),
    "NoneElement": (*BACK, "return None"),
    "TextElement": (*BACK, "return '1 kohm'"),
}  # fmt: skip
HEAD = """import numpy as np
from electrovib.physics.circuit import ReturnPath
from electrovib.physics.conduction import Conduction
from electrovib.physics.contact import Contact
from electrovib.physics.drive.base import Drive
from electrovib.physics.drive.parts import Linear
from electrovib.physics.force import ForceLaw
from electrovib.physics.friction import SteadyFriction
from electrovib.physics.material import Material
from electrovib.physics.time_profile import TimeProfile
"""
GAP = ["--set", "stack.gap.thickness=5um"]
DRIVER = """
import contextlib, io, json, pathlib, sys, traceback
from electrovib.apps.cli import main

def call(*arguments):
    sys.argv = ["electrovib", *arguments]
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            main()
            code = 0
        except SystemExit as stop:
            code = stop.code or 0
        except BaseException:
            code = "traceback"
            traceback.print_exc()
    return code, out.getvalue(), err.getvalue(), [each.name for each in pathlib.Path().glob("o*")]

cases = json.load(open("cases.json"))
print(json.dumps({name: call("--models", "mine.py", *words) for name, words in cases.items()}))
"""
FIG6 = "vezzoli_2014/fig6"
DOORS = {
    "run": ["run", FIG6, "--over", "drive.high=100V:200V:3", "-o", "o.csv"],
    "study": ["study", FIG6, "--space", "fingers", "-n", "20", "--seed", "1", "-o", "o.zarr"],
    "check": ["check", FIG6],
    "fit": ["fit", FIG6, "good.nc", "--free", "stack.gap.thickness", "-o", "o.csv"],
    "find-value": ["find-value", FIG6, "--want", "mean electrostatic_force = 1 mN", "--free", "drive.high"],
}


def words_of(name):
    path = WRONG[name][0]
    return [*GAP, "--set", f"{path}.model={name}"]


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    folder = tmp_path_factory.mktemp("wrong")
    text = HEAD
    for name, (_, family, method, body, *more) in WRONG.items():
        extra = "".join(f"    {each}\n" for each in more)
        text += f"\nclass {name}({family}):\n    {method}\n        {body}\n{extra}"
    (folder / "mine.py").write_text(text)
    (folder / "driver.py").write_text(DRIVER)
    cases = {"good": ["run", FIG6, *GAP, "-o", "good.nc"]}
    cases |= {name: ["run", *words_of(name), "-o", "o.nc"] for name in WRONG}
    for own in ("HalfNaN", "NaNPermittivity"):
        cases |= {f"{door} {own}": [*words, *words_of(own)] for door, words in DOORS.items()}
    cases["study NaNFriction"] = [*DOORS["study"], *words_of("NaNFriction"), "--quantity", "lateral_force"]
    cases["compared HalfNaN"] = ["compare", FIG6, *GAP, "--models", "MaxwellStressInGap,HalfNaN"]
    (folder / "cases.json").write_text(json.dumps(cases))
    done = subprocess.run(
        [sys.executable, "driver.py"], cwd=folder, capture_output=True, text=True, check=False, timeout=300
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout.splitlines()[-1])


@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_model_is_named_with_its_file(found, name):
    code, out, err, files = found[name]
    assert code == 2, (code, out, err)
    assert re.search(rf"{name}\b", err), err
    assert "mine.py" in err
    assert "Traceback" not in err
    assert err.count("\n") == 1
    assert files == []


def test_every_door(found):
    for name, (code, out, err, files) in found.items():
        if " " in name:
            named = rf"{name.split()[1]}\.\w+ \(mine\.py, line \d+\)"
            assert code == 2 or name == "compared HalfNaN", (name, code, out, err)
            assert re.search(named, out + err), (name, out, err)
            assert files == [], name
