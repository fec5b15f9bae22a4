"""A limit that is declared and computed in four lines is obeyed by every search, none of which knows its name."""

import json
import subprocess
import sys

import pytest

pytestmark = pytest.mark.slow  # a process of its own, which imports everything and searches
POWER = """\
    power: Annotated[
        Number | None, LimitedQuantity("W", 1e-15, 1e6, "largest power of the amplifier", order=2)
    ] = None
"""
ADDED = {
    "electrovib.core.units": ('    "V/s": (', '    "W": ("a power", "1 mW"),\n'),
    "electrovib.physics.limits": ("    slew_rate: Annotated[", POWER),
    "electrovib.solve.diagnostics.peaks": (
        '        rows["charge"] =',
        '        rows["power"] = rows["voltage"] * rows["current"]\n',
    ),
}
"""Module, the line before which lines are added, and those: they declare and compute a limit of power, and name its unit."""
SCRIPT = """
import importlib.machinery, importlib.util, json, sys

added = json.loads(sys.argv[1])


class WithPower(importlib.machinery.SourceFileLoader):
    def get_code(self, name):
        before, lines = added[name]
        source = self.get_source(name)
        assert source.count(before) == 1
        return compile(source.replace(before, lines + before), self.path, "exec")


class Finder(importlib.machinery.PathFinder):
    @classmethod
    def find_spec(cls, name, path=None, target=None):
        spec = super().find_spec(name, path, target)
        if name in added:
            spec.loader = WithPower(name, spec.origin)
        return spec


sys.meta_path.insert(0, Finder)
import electrovib as ev

STATIC, MEAN, VOLTS = ev.load("bau_2010/sine"), "mean electrostatic_force", "drive.amplitude"
power = ev.check(STATIC, limits={"power": 1.0}).value("power")
limits = {"power": power / 4}  # half of the amplitude of 100 V
asked = {"want": f"{MEAN} = 1 N", "free": VOLTS, "limits": limits}
space = {"contact.area": {"model": "Uniform", "low": "0.9 cm2", "high": "1 cm2"}}
within = ev.value_for_share(STATIC, **asked | {"want": f"{MEAN} = 50 mN"}, space=space, share=0.9, seed=1, n=20)
plate = ev.plan_plate(STATIC, {VOLTS: [40.0, 49.9, 50.1, 60.0]}, limits=limits, refine=0)
found = {
    "find_value": ev.find_value(STATIC, **asked).obtainable.value / 50,
    "value_for_share": max(row.value / row.limit for row in within.failed),
    "plan_plate": [each.forbidden_by for each in plate.candidates],
}
for method, more in (("carrier", {"carrier": "1 kHz"}), ("dc", {"rate": 2e3})):
    drive = {"target": "constant 1 mN for 20 ms", "method": method} | more
    held = {"power": ev.drive_for_force(STATIC, **drive).check.value("power") / 4}
    designed = ev.drive_for_force(STATIC, **drive, limits=held)
    found[method] = designed.check.value("power") / held["power"], designed.binding
print(json.dumps(found))
"""


@pytest.fixture(scope="module")
def found():
    call = [sys.executable, "-c", SCRIPT, json.dumps(ADDED)]
    return json.loads(subprocess.run(call, capture_output=True, text=True, check=True).stdout)


def test_a_value_a_share_and_a_plate_are_held_by_a_limit_of_power(found):
    """Power grows with the square of the voltage, so that a quarter of it leaves a half of the amplitude."""
    assert found["find_value"] == pytest.approx(1, rel=1e-6)
    assert found["find_value"] <= 1
    assert found["value_for_share"] > 1
    assert found["plan_plate"] == [[], [], ["power"], ["power"]]


@pytest.mark.parametrize("method", ["carrier", "dc"])
def test_a_drive_is_held_by_a_limit_of_power(found, method):
    reached, binding = found[method]
    assert 0.9 < reached <= 1
    assert binding == ["power"]
