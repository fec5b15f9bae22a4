"""One dielectric: the unverified law is the Maxwell stress in the insulator, which depends on the peak voltage."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from electrovib.core.constants import eps0
from electrovib.papers import strong_1970
from electrovib.solve.simulate import simulate


@given(
    thickness=st.floats(1e-7, 1e-3),
    permittivity=st.floats(1, 100),
    area=st.floats(1e-6, 1e-3),
    voltage=st.floats(1, 1e4),
)
def test_the_law_is_the_insulator_plane_of_one_layer(thickness, permittivity, area, voltage):
    changes = {
        "drive": {"model": "Step", "level": voltage},
        "stack.insulator.thickness": thickness,
        "stack.insulator.material.permittivity": permittivity,
        "contact.area": area,
    }
    scenario = strong_1970.scenarios()["display"].replace(changes)
    force = simulate(scenario, time=np.array([0.0, 10.0])).electrostatic_force[-1]
    unverified = strong_1970.static_force(
        thickness=thickness, permittivity=permittivity, area=area, voltage=voltage
    )
    by_hand = eps0 * permittivity * area * voltage**2 / (2 * thickness**2)
    assert unverified / by_hand == pytest.approx(1.0, rel=1e-12)  # rounding
    # the body's resistance still charges the plate: e^(-10 s/RC), RC at most 1e-3 s
    assert float(force) / unverified == pytest.approx(1.0, rel=1e-9)
    assert 1.001 * float(force) / unverified != pytest.approx(1.0, rel=1e-9)


@pytest.mark.parametrize(
    "drive",
    [
        {"model": "Sine", "amplitude": 1000.0, "frequency": 100.0},
        {"model": "Square", "high": 1000.0, "low": -1000.0, "frequency": 100.0},
        {"model": "PulseTrain", "high": -1000.0, "width": 1e-3, "frequency": 100.0},
        {
            "model": "AmplitudeModulation",
            "amplitude": 500.0,
            "carrier": 3000,
            "modulation": 100,
            "depth": 1.0,
        },
    ],
    ids=lambda drive: drive["model"],
)
def test_drives_of_one_peak_pull_alike_at_their_peak(drive):
    scenario = strong_1970.scenarios()["display"].replace({"drive": drive})
    trace = simulate(scenario, time=np.arange(4001) * 1e-5)
    static = strong_1970.attraction("MaxwellStressInInsulator", voltage=1000.0)
    # the peak of a sine of 3 kHz may lie half a sample of 10 us away, 1 - cos(0.1)^2 = 0.9 %
    assert float(trace.electrostatic_force.max()) == pytest.approx(static, rel=1e-2)


def test_skin_in_series_takes_half_a_percent_of_the_voltage():
    """The film of Vezzoli et al. 2014 and skin, Maxwell stress in the insulator: 181.4 mN, four digits."""
    base = strong_1970.scenarios()["display"].replace({"drive": {"model": "Step", "level": 1000.0}})
    layers = base.stack.to_dict() | {
        "stratum_corneum": {"thickness": 200e-6, "material": {"model": "Constant", "permittivity": 1560.0}}
    }
    trace = simulate(base.replace({"stack": layers}), time=np.array([0.0, 1e-3]))
    assert float(trace.electrostatic_force[-1]) == pytest.approx(181.4e-3, rel=5e-4)


def test_current_grows_while_attraction_stays():
    force, current = strong_1970.against_frequency(low=100.0, high=1e3)
    assert force == pytest.approx(1.0, abs=1e-6)
    assert current == pytest.approx(10.0, rel=1e-6)
