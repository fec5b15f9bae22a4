"""A gap bridged in places: leak and pull in parallel, against closed forms; and what a homogeneous leak does instead."""

from __future__ import annotations

import numpy as np
import pytest
from scenario_parts import AREA, EPS0, constant, grounded, layer, model, step

from electrovib.physics.bridged_air import BridgedAir
from electrovib.scenario import Scenario
from electrovib.solve.simulate import simulate

VOLTAGE = 300.0
FILM, FILM_PERMITTIVITY, GAP = 90e-6, 3.35, 5e-6
CASES = [(1e-3, 1e-6), (0.05, 2e-8), (0.4, 1e-7)]
"""Share of the area that is bridged, and conductivity of the bridges; those that insulate take their share only."""


def bridged(share, conductivity, **changes):
    material = model("BridgedAir", bridged_share=share, spot_conductivity=conductivity)
    content = dict(Scenario.example) | {
        "drive": step(VOLTAGE),
        "contact": model("FixedArea", area=AREA),
        "circuit": {"return_path": grounded()},
        "stack": {"insulator": layer(FILM, constant(FILM_PERMITTIVITY)), "gap": layer(GAP, material)},
    }
    return Scenario.model_validate(content).replace(changes)


def closed_form(share, conductivity, time):
    """Charge on the open part's capacitor beside the bridges, in series with the film; the pull on the open part."""
    film, air = EPS0 * FILM_PERMITTIVITY / FILM, EPS0 / GAP * (1 - share)
    bridge = share * conductivity / GAP
    voltage = VOLTAGE * film / (film + air) * np.exp(-time * bridge / (film + air))
    return (1 - share) * AREA * EPS0 * (voltage / GAP) ** 2 / 2


@pytest.mark.parametrize(("share", "conductivity"), CASES)
def test_force_decays_through_the_bridges(share, conductivity):
    film, air = EPS0 * FILM_PERMITTIVITY / FILM, EPS0 / GAP * (1 - share)
    decay = (film + air) / (share * conductivity / GAP)
    trace = simulate(bridged(share, conductivity, **{"time.duration": 4 * decay, "time.samples": 401}))
    expected = closed_form(share, conductivity, trace.time.values)
    np.testing.assert_allclose(trace.electrostatic_force, expected, rtol=1e-10, atol=1e-12 * expected[0])
    insulated = simulate(bridged(share, 0.0))
    expected = closed_form(share, 0.0, insulated.time.values)
    np.testing.assert_allclose(insulated.electrostatic_force, expected, rtol=1e-12)
    # by whichever of the two the share is left out, it shows
    assert abs(expected[0] / (1 - share) / float(trace.electrostatic_force[0]) - 1) > 0.9 * share


def test_a_homogeneous_leak_is_another_medium():
    """The same conductance everywhere pulls on all of the area, and its capacitance is larger: another force, another time."""
    share, conductivity = 0.4, 1e-7
    same = {"stack.gap.material": constant(1.0, share * conductivity)}
    homogeneous = bridged(share, conductivity, **same)
    time = {"time.duration": 1e-4, "time.samples": 11}
    mixed = simulate(bridged(share, conductivity).replace(time)).electrostatic_force
    alone = simulate(homogeneous.replace(time)).electrostatic_force
    assert abs(float(alone[0] / mixed[0]) - 1) > 0.2
    assert abs(float(alone[-1] / alone[0]) - float(mixed[-1] / mixed[0])) > 0.01


def test_a_leak_on_bridges_is_kept():
    air = BridgedAir(bridged_share=0.1, spot_conductivity=1e-6)
    more = air.conducting(3e-7)
    assert air.conductivity == pytest.approx(1e-7, rel=1e-15)
    assert more.conductivity == pytest.approx(3e-7, rel=1e-15)
    assert more.pulling_share == air.pulling_share == 0.9
