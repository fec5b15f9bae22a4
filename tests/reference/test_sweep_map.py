"""A map of 900 cases on a dispersive skin, against the response over frequency, which is solved another way."""

from __future__ import annotations

import numpy as np
import pytest

import electrovib as ev
from electrovib.papers import palmar_1995
from electrovib.solve.electrics.attraction import mean_force
from electrovib.solve.stack.expand import phasors

pytestmark = pytest.mark.slow


def test_a_map_of_coating_and_frequency_agrees_with_phasors():
    skin = palmar_1995.skins()["dry_men"].material
    scenario = ev.load("vezzoli_2014/fig6").replace(
        {
            "stack.stratum_corneum.material": skin.to_dict(),
            "drive": {"model": "Sine", "amplitude": 100.0, "frequency": 100.0},
            "time.initial_state": {"model": "PeriodicState"},
        }
    )
    over = {
        "stack.insulator.thickness": np.geomspace(1e-6, 1e-4, 30),
        "drive.frequency": np.geomspace(10, 1e4, 30),
    }
    names = ["mean electrostatic_force", "swing lateral_force", "peak current"]
    found = ev.sweep(scenario, over, quantities=names)
    assert dict(found.sizes) == {"stack.insulator.thickness": 30, "drive.frequency": 30}
    for place, thickness in enumerate(over["stack.insulator.thickness"]):
        case = scenario.replace({"stack.insulator.thickness": float(thickness)})
        section = phasors(case, over["drive.frequency"])
        force = mean_force(case, section, amplitude=100.0)
        current = 100.0 * np.abs(section.current_density) * case.contact_area
        at = found.isel({"stack.insulator.thickness": place})
        # what is left is the reduction to Debye terms; the error that the sweep states is that of an amplitude
        missed = 2.1 * found.attrs["transfer_error"] * np.sqrt(force * force.max())
        assert np.all(np.abs(at[names[0]].values - force) < missed)
        np.testing.assert_allclose(at[names[2]], current, rtol=2 * found.attrs["reduction_error"])
        np.testing.assert_array_less(at[names[1]], 2 * scenario.friction.coefficient * force * 1.01)
