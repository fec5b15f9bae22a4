"""Laws of users in arrays over fingers; `test_together` runs this file in a process of its own."""

import importlib.util
from pathlib import Path

import numpy as np

import electrovib as ev
from electrovib.physics.force import ForceLaw

_SPEC = importlib.util.spec_from_file_location("fingers_of", Path(__file__).with_name("fingers_of.py"))
fingers_of = importlib.util.module_from_spec(_SPEC)
_SPEC.loader.exec_module(fingers_of)
difference = fingers_of.difference

EQUAL = 1e-12
GAP = "vezzoli_2014/fig6_gap"


class MixesFingers(ForceLaw):
    """A law whose formula takes the largest of all fields, which in arrays is that of another finger."""

    evaluation_surface = "gap"

    def pressure(self, E):
        return 1e-12 * E**2 / (1 + 1e-14 * np.max(np.abs(E)) ** 2)


def test_a_law_that_would_mix_fingers_is_found_out():
    member = ev.load(GAP).replace({"force": {"model": "MixesFingers"}})
    found, method = difference(member, ["stack.gap.thickness"], ["electrostatic_force"])
    assert "differs from that of one finger" in method
    assert found == 0


class ThresholdLaw(ForceLaw):
    """A law that is quadratic up to a field that is not reached before."""

    evaluation_surface = "gap"

    def pressure(self, E):
        return np.where(np.abs(E) < 3e8, 4e-12 * E**2, 0.0)


def test_a_law_that_is_quadratic_up_to_a_limit_is_not_quadratic():
    member = ev.load(GAP).replace({"force": {"model": "ThresholdLaw"}})
    assert difference(member, ["stack.gap.thickness"])[0] < EQUAL
