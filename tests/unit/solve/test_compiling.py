"""What numba compiles has the same numbers without it: through the doors that users take, in a process that cannot import it."""

import json
import subprocess
import sys

import numba
import numpy as np
import pytest

from electrovib.solve.recursion.compiling import inner, is_compiled, outer

STICK_SLIP = """
import numpy as np, electrovib as ev
finger = {"model": "MassSpringDamper", "mass": "0.15 g", "stiffness": "1 kN/m", "damping": "0.02 N s/m"}
steady = {"model": "Coulomb", "coefficient": 0.5}
bristles = {"model": "LuGre", "steady": steady, "stiffness": "50 kN/m", "static_ratio": 1.5, "stribeck_speed": "10 mm/s",
            "bristle_damping": "0.5 N s/m"}
motion = {"speed": "10 mm/s", "time_profile": {"model": "Press", "rise": "5 ms"}}
given = {"finger": finger, "friction": bristles, "motion": motion, "force.model": "MaxwellStressInGap"}
scenario = ev.load("vezzoli_2014/fig6_static").replace(given)
found = ev.simulate(scenario, time=np.linspace(0, 0.001, 51)).lateral_force.values
"""
UNEVEN = """
import numpy as np
from electrovib.solve.recursion import march
some = np.random.default_rng(1)
steps, drive, poles = some.uniform(0.5, 1.5, 10_000), some.normal(size=10_001), -np.geomspace(1e-4, 1e3, 40)
found = march(poles, np.ones((1, 40)), [0.0], drive[:-1], drive[1:], steps, np.zeros(40))[0][0, ::100]
"""
PROGRAMS = {"bristles": STICK_SLIP, "uneven record": UNEVEN}
WITHOUT = """
import json, sys
sys.modules["numba"] = None
names = {}
exec(sys.stdin.read(), names)
print(json.dumps(names["found"].tolist()))
"""


def test_without_numba_functions_stay_as_they_are(monkeypatch):
    assert is_compiled()
    monkeypatch.setitem(sys.modules, "numba", None)
    assert not is_compiled()
    assert inner(abs) is abs
    assert outer(abs) is abs


def test_without_a_folder_compiled_code_is_not_kept(monkeypatch):
    asked = []

    def njit(function, **options):
        asked.append(options.get("cache", False))
        if asked[-1]:
            raise RuntimeError("cannot cache function: no locator available")
        return function

    monkeypatch.setattr(numba, "njit", njit)
    assert outer(abs) is abs
    assert asked == [True, False]


@pytest.mark.parametrize("name", [pytest.param("bristles", marks=pytest.mark.slow), "uneven record"])
def test_the_same_numbers(name):
    """Each in a process that cannot import numba; that of bristles takes their loop step by step."""
    command = [sys.executable, "-c", WITHOUT]
    done = subprocess.run(
        command, input=PROGRAMS[name], capture_output=True, text=True, check=True, timeout=300
    )
    plain, names = json.loads(done.stdout), {}
    exec(PROGRAMS[name], names)
    found = names["found"]
    assert found.size > 50
    assert np.ptp(found) > 0
    assert np.max(np.abs(found - plain)) <= 1e-9 * np.max(np.abs(found))
