"""What numba compiles has the same numbers without it: through the doors that users take, in a process that cannot import it."""

import subprocess
import sys

import numpy as np
import pytest

from electrovib.solve.recursion.compiling import inner, is_compiled, outer

WITHOUT = "import sys\nsys.modules['numba'] = None\n"
STICK_SLIP = """
import numpy as np, electrovib as ev
finger = {"model": "MassSpringDamper", "mass": "0.15 g", "stiffness": "1 kN/m", "damping": "0.02 N s/m"}
steady = {"model": "Coulomb", "coefficient": 0.5}
bristles = {"model": "LuGre", "steady": steady, "stiffness": "50 kN/m", "static_ratio": 1.5, "stribeck_speed": "10 mm/s",
            "bristle_damping": "0.5 N s/m"}
motion = {"speed": "10 mm/s", "time_profile": {"model": "Press", "rise": "5 ms"}}
given = {"finger": finger, "friction": bristles, "motion": motion, "force.model": "MaxwellStressInGap"}
scenario = ev.load("vezzoli_2014/fig6_static").replace(given)
print(*ev.simulate(scenario, time=np.linspace(0, 0.002, 51)).lateral_force.values)
"""
STUDY = """
import numpy as np, electrovib as ev
found = ev.study("vezzoli_2014/fig6", "fingers", n=70, seed=1)
names = ["percentile", "mean", "variance"]
sizes = [np.ravel(found[f"electrostatic_force_{name}"].values) for name in names]
print(*np.concatenate([each / each.max() for each in sizes]))
"""
UNEVEN = """
import numpy as np
from electrovib.solve.recursion import march
some = np.random.default_rng(1)
steps, drive, poles = some.uniform(0.5, 1.5, 30_000), some.normal(size=30_001), -np.geomspace(1e-4, 1e3, 40)
print(*march(poles, np.ones((1, 40)), [0.0], drive[:-1], drive[1:], steps, np.zeros(40))[0][0, ::100])
"""


def test_without_numba_functions_stay_as_they_are(monkeypatch):
    assert is_compiled()
    monkeypatch.setitem(sys.modules, "numba", None)
    assert not is_compiled()
    assert inner(abs) is abs
    assert outer(abs) is abs


@pytest.mark.parametrize("program", [STICK_SLIP, STUDY, UNEVEN], ids=["bristles", "study", "uneven record"])
def test_the_same_numbers(program):
    found = []
    for begin in ("", WITHOUT):
        command = [sys.executable, "-c", begin + program]
        printed = subprocess.run(command, capture_output=True, text=True, check=True, timeout=300).stdout
        found.append(np.array(printed.split(), float))
    assert found[0].size > 50
    assert np.ptp(found[0]) > 0
    assert np.max(np.abs(found[0] - found[1])) <= 1e-9 * np.max(np.abs(found[0]))
