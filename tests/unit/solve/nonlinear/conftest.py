"""A finger over a plate, what it is driven with and its return path, as all files of this folder take them."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pytest

from electrovib.core.model import read_model
from electrovib.physics.circuit import SeriesElement
from electrovib.physics.drive.base import Drive
from electrovib.physics.material import Constant, Debye
from electrovib.physics.stack import Layer
from electrovib.solve.electrics.leaks import leak_section
from electrovib.solve.stack.expand import reduce_material
from electrovib.solve.stack.keys import DisplacementOf, FieldOf
from electrovib.solve.stack.layer_states import stack_states
from electrovib.solve.stack.section import modal_section

AREA = 1e-4
SINE = {"model": "Sine", "amplitude": 100, "frequency": 60}
SQUARE = {"model": "Square", "high": 50, "low": -20, "frequency": 50}
DRIVES = {
    "trapezium": {"model": "Trapezium", "high": 100, "rise": 10e-3, "hold": 10e-3, "fall": 10e-3},
    "square": SQUARE,
    "sine": SINE,
    "burst": {"model": "Burst", "amplitude": 80, "frequency": 100, "cycles": 2, "delay": 3e-3},
    "chirp": {"model": "Chirp", "amplitude": 90, "first": 20, "last": 200, "length": 25e-3},
    "both": {"model": "Sum", "drives": [SINE, SQUARE | {"high": 30}]},
    "held": {"model": "Step", "level": 100},
    "current": {"model": "CurrentSine", "amplitude": 1e-6, "frequency": 100},
}
ELEMENTS = {
    "bare": SeriesElement(),
    "body": SeriesElement(resistance=1e3),
    "floating": SeriesElement(resistance=1e5, elastance=1e10, rate=5.0),
    "floating without resistance": SeriesElement(resistance=0.0, elastance=1e10, rate=0.0),
}
SKIN = Debye(permittivity_high=300, strength=1200, relaxation_time=2e-3, conductivity=3e-6)


@dataclass(frozen=True)
class Finger:
    """Layers on a return path: as modes, as states of the general solver, and the signals that are asked for."""

    layers: dict
    element: SeriesElement
    second: float = 0.0
    moving: str | None = None

    @cached_property
    def debye(self):
        layers = self.layers.items()
        reduced = {name: reduce_material(layer.material, low=1.0, high=1e4) for name, layer in layers}
        return {name: found.debye for name, found in reduced.items()}

    @cached_property
    def section(self):
        return modal_section(self.layers, self.debye, area=AREA, element=self.element, second=self.second)

    @cached_property
    def space(self):
        more = {"second": self.second, "moving": self.moving}
        return stack_states(self.layers, self.debye, area=AREA, element=self.element, **more)

    @cached_property
    def wanted(self):
        return self.signals(self.section)

    def leaking(self, name):
        return leak_section(self.section, self.layers, name, area=AREA, element=self.element)

    def signals(self, section):
        found = {"stack_voltage": section.voltage, "current": section.current_density * AREA}
        for name in section.names:
            found[FieldOf(name)] = section[name].field
            found[DisplacementOf(name)] = section[name].displacement
        return found


@pytest.fixture(scope="session")
def drive():
    """Read one of the drives above, or a table."""
    return lambda table: read_model(Drive, DRIVES[table] if isinstance(table, str) else table)


@pytest.fixture(scope="session")
def finger():
    """Lay film, air and skin, or some of them, on one of the return paths above."""

    def laid(
        element="bare",
        *,
        names=None,
        charge=0.0,
        gap=1e-9,
        height=3e-6,
        skin=SKIN,
        leak=None,
        gap_leak=None,
        **more,
    ):
        air, film = Constant(permittivity=1.0, conductivity=gap), Constant(permittivity=3.35)
        layers = {
            "insulator": Layer(thickness=90e-6, material=film, initial_charge=charge),
            "gap": Layer(thickness=height, material=air, leak=gap_leak),
            "stratum_corneum": Layer(thickness=200e-6, material=skin, leak=leak),
        }
        chosen = {name: layers[name] for name in names or layers}
        return Finger(chosen, ELEMENTS[element] if isinstance(element, str) else element, **more)

    return laid


@pytest.fixture(scope="session")
def worst():
    """Return the largest error over the largest value, of the worst signal."""

    def error(expected, found):
        rows = {name: row for name, row in expected.items() if np.any(row)}
        return max(np.max(np.abs(found[name] - row)) / np.max(np.abs(row)) for name, row in rows.items())

    return error
