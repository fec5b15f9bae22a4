"""A finger on a plate, built in one line."""

import functools
from types import SimpleNamespace

import pytest
from scenario_parts import AREA, COULOMB, constant, grounded, layer, model

from electrovib.core.discovery import find_members, papers
from electrovib.core.model import read_model
from electrovib.physics.circuit import SeriesElement
from electrovib.physics.debye_sum import DebyeSum
from electrovib.physics.material import Material
from electrovib.scenario import Scenario
from electrovib.solve.stack.modes import Slab


def film(thickness=90e-6, permittivity=3.35):
    return layer(thickness, constant(permittivity))


def constant_skin(permittivity=1560.0, conductivity=0.0, thickness=200e-6):
    return layer(thickness, constant(permittivity, conductivity))


def gap(thickness, conductivity=0.0):
    return layer(thickness, constant(1.0, conductivity))


def build(
    *, drive, stack, force="MaxwellStressInGap", resistance=0.0, return_path=None, settled=False, **more
):
    content = {
        "drive": drive,
        "force": model(force),
        "friction": COULOMB,
        "contact": model("FixedArea", area=AREA),
        "load": {"normal_force": 0.5},
        "circuit": {"return_path": return_path or grounded(resistance)},
        "stack": stack,
        "time": {"initial_state": model("PeriodicState" if settled else "AtRest")},
    }
    return read_model(Scenario, content | more)


def random_stack(random) -> list[Slab]:
    """One to five layers, up to three Debye terms each, resistivity 1 to 1e15 ohm m or infinite."""
    slabs = []
    for _ in range(int(random.integers(1, 6))):
        terms = int(random.integers(0, 4))
        strengths, times = 10 ** random.uniform(-1, 5, terms), 10 ** random.uniform(-12, 1, terms)
        debye = DebyeSum(float(10 ** random.uniform(0, 2)), tuple(strengths.tolist()), tuple(times.tolist()))
        conductivity = 0.0 if random.random() < 0.3 else float(10 ** -random.uniform(0, 15))
        slabs.append(Slab(float(10 ** random.uniform(-7, -3)), debye, conductivity))
    return slabs


def random_element(random) -> SeriesElement:
    """Nothing, a resistance, or a floating body with and without resistance and leak."""
    resistance = 0.0 if random.random() < 0.4 else float(10 ** random.uniform(1, 7))
    if random.random() < 0.5:
        return SeriesElement(resistance=resistance)
    leak = 0.0 if random.random() < 0.5 else float(10 ** random.uniform(-3, 4))
    return SeriesElement(resistance=resistance, elastance=float(10 ** random.uniform(8, 11)), rate=leak)


@pytest.fixture(scope="session")
def finger():
    """Layers and scenarios of Vezzoli et al. 2014's finger, by name."""
    parts = {"film": film, "skin": constant_skin, "gap": gap, "build": build}
    return SimpleNamespace(AREA=AREA, **parts, random_stack=random_stack, random_element=random_element)


@functools.cache
def materials():
    """Every shipped kind of material, and every skin of a paper, by name."""
    found = {name: read_model(kind, kind.example) for name, kind in find_members(Material).items()}
    for author_year, module in papers().items():
        if hasattr(module, "skins"):
            found |= {f"{author_year} {name}": skin.material for name, skin in module.skins().items()}
    return found


def pytest_generate_tests(metafunc):
    """Run a test that takes `shipped_material`, `paper_skin` or `conducting_paper_skin` once for each of them."""
    kinds = {name: one for name, one in materials().items() if " " not in name}
    skins = {name.replace(" ", "-"): one for name, one in materials().items() if " " in name}
    conducting = {name: one for name, one in skins.items() if one.conductivity > 0}
    asked = {"shipped_material": kinds, "paper_skin": skins, "conducting_paper_skin": conducting}
    for wanted, found in asked.items():
        if wanted in metafunc.fixturenames:
            metafunc.parametrize(wanted, found.values(), ids=found)
