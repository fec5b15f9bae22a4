"""Coating, leaky gap, skin: the lower corner belongs to the leak, an interior maximum to the dispersion."""

import numpy as np
import pytest

from electrovib.core.discovery import papers
from electrovib.papers import palmar_1995
from electrovib.papers.aliabbasi_2022 import maximum, maximum_of
from electrovib.papers.aliabbasi_2024 import chain, corner, rises_to
from electrovib.solve.electrics.attraction import mean_force
from electrovib.solve.stack.expand import phasors

LEAKS = (1e9, 2e7, 1e6)
"""Resistivity of the gap [ohm m]."""
CORNERS = {1e6: 1415.0, 2e7: 71.0, 1e9: 1.4}
"""1/(2 pi R_g (C_g + C_i)) for 3 um on 1 um of 3.9, in Hz, two to four digits."""
MAXIMA = {
    "1963 impedance": (32.0, 1585.0, 31600.0),
    "palmar men 2 uS": (24.0, 1549.0, 29500.0),
    "Gabriel wet": (84.0, 9200.0, 82000.0),
}
"""Hz for each leak, without body."""


def skins():
    """Every published skin by its short name."""
    modules = [module for module in papers().values() if hasattr(module, "skins")]
    return {skin.name: skin.material for module in modules for skin in module.skins().values()}


def disperses(material):
    exact = material.debye()
    return exact is None or any(exact.strengths)


@pytest.mark.parametrize("leak", LEAKS)
def test_lower_corner_of_a_conducting_finger(leak):
    """Without skin: half the force, field at -3 dB, at the corner; nine tenths of it at three times that."""
    found = corner(gap=3e-6, gap_resistivity=leak)
    assert found == pytest.approx(CORNERS[leak], rel=2e-2)  # two digits
    bare = chain(gap_resistivity=leak, resistance=0.0)
    # interpolation between 722 points a decade
    assert rises_to(bare, share=0.5) == pytest.approx(found, rel=1e-4)
    assert rises_to(bare, share=0.9) == pytest.approx(3 * found, rel=1e-4)
    field = np.abs(phasors(bare, np.array([found, 1e9]))["gap"].field)
    assert 20 * np.log10(field[0] / field[1]) == pytest.approx(-3.01, abs=1e-2)


@pytest.mark.parametrize("leak", LEAKS)
def test_corner_with_every_skin_that_conducts(leak):
    """Slow leak: within 5 % on every skin; fast leak: the skin's own impedance shifts it, up to 1.8 times."""
    for name, material in skins().items():
        if material.conductivity > 0:
            edge = rises_to(chain(gap_resistivity=leak, skin=material), share=0.5)
            ratio = edge / corner(gap=3e-6, gap_resistivity=leak)
            assert (0.95 if leak == 1e9 else 0.9) < ratio < (1.0 if leak == 1e9 else 1.8), name
    bare = rises_to(chain(gap_resistivity=leak, skin=skins()["Gabriel wet"], resistance=0.0), share=0.5)
    assert bare == pytest.approx(corner(gap=3e-6, gap_resistivity=leak), rel=2.5e-2)  # thin electrically


@pytest.mark.parametrize(("name", "expected"), MAXIMA.items(), ids=MAXIMA)
def test_maxima_against_numbers_computed_apart(name, expected):
    skin = skins()[name]
    found = [maximum_of(gap_resistivity=leak, skin=skin) for leak in LEAKS]
    # two digits, on a maximum that is flat
    assert found == pytest.approx(expected, rel=2.5e-2)
    assert found[1] != pytest.approx(250.0, rel=0.5)


@pytest.mark.parametrize("resistance", [0.0, 1500.0])
@pytest.mark.parametrize("leak", LEAKS)
def test_dispersive_skins_have_an_interior_maximum(leak, resistance):
    dispersive = {name: material for name, material in skins().items() if disperses(material)}
    assert {"1963 impedance", "Gabriel dry", "Gabriel wet", "palmar men 2 uS"} <= set(dispersive)
    for name, material in dispersive.items():
        found = maximum(chain(gap_resistivity=leak, skin=material, resistance=resistance))
        assert found is not None, name
        assert corner(gap=3e-6, gap_resistivity=leak) < found < 5e5, name


def test_skin_without_dispersion_has_none_but_by_the_body_or_its_own_relaxation():
    skin = skins()["paper point"]
    assert not disperses(skin)
    for leak in (2e7, 1e6):
        assert maximum(chain(gap_resistivity=leak, skin=skin, resistance=0.0)) is None
    capacitor = skin.model_copy(update={"conductivity": 0.0})
    for leak in LEAKS:
        assert maximum(chain(gap_resistivity=leak, skin=capacitor, resistance=0.0)) is None
    by_body = maximum(chain(gap_resistivity=2e7, skin=skin, resistance=1500.0))
    assert by_body == pytest.approx(6600.0, rel=1e-2)
    # a leak slower than the skin's 21 Hz: below that the skin is a short and the gap has a little more
    slow = chain(gap_resistivity=1e9, skin=skin, resistance=0.0)
    assert maximum(slow) == pytest.approx(28.0, rel=2e-2)
    force = mean_force(slow, phasors(slow, np.array([28.0, 1e6])), amplitude=100.0)
    assert 1.0 < force[0] / force[1] < 1.08


def test_place_of_the_maximum_is_ill_conditioned_and_its_edge_is_not():
    """The 1963 set, 2e7 ohm m: above nine tenths from 300 Hz to 50 kHz, two decades and more."""
    scenario = chain(gap_resistivity=2e7, skin=skins()["1963 impedance"], resistance=0.0)
    frequency = np.geomspace(1, 1e6, 4001)
    force = mean_force(scenario, phasors(scenario, frequency), amplitude=100.0)
    flat = frequency[force > 0.9 * force.max()]
    assert flat[0] == pytest.approx(300.0, rel=2e-2)
    assert flat[-1] == pytest.approx(50e3, rel=2e-2)


def test_maximum_goes_with_the_leak_and_hardly_with_the_skin():
    """Three decades of leak move it 970 times, ten times the sweat 1.5 times: 250 Hz is a fit of the leak."""
    sweat = [palmar_1995.skins()[f"{word}_men"].material for word in ("dry", "moist")]
    by_skin = [maximum_of(gap_resistivity=2e7, skin=skin) for skin in sweat]
    by_leak = [maximum_of(gap_resistivity=leak, skin=skins()["1963 impedance"]) for leak in LEAKS]
    assert by_leak[2] / by_leak[0] == pytest.approx(1000.0, rel=0.05)
    assert by_skin[0] / by_skin[1] == pytest.approx(1.46, rel=2e-2)
