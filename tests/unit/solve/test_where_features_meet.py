"""Where two features of a scenario meet: what the product of all of them has found wrong, each by its closed form."""

from __future__ import annotations

import numpy as np
import pytest

from electrovib.core.constants import VACUUM_PERMITTIVITY as eps0
from electrovib.core.errors import InputError
from electrovib.solve.scenario import load
from electrovib.solve.simulate import simulate

RELIEF = {"contact.surface": {"model": "LinearSpring", "stiffness": 1e9, "free_gap": "10 um"}}
CLOSES = RELIEF | {"contact.closing": {"damping": 1e6}, "stack.stratum_corneum.material.conductivity": 0.0}
BARE = {"circuit.return_path.resistance": 0.0}


@pytest.fixture(scope="module")
def suspended():
    return load("vezzoli_2014/fig2")


@pytest.fixture(scope="module")
def founding():
    return load("vezzoli_2014/fig6_gap")


def test_bridges_take_their_share_of_the_pull_that_closes_a_gap(suspended):
    """At rest the relief carries load and attraction, the attraction that the Trace reports."""
    bridged = {"stack.gap.material": {"model": "BridgedAir", "bridged_share": 0.4, "spot_conductivity": 0.0}}
    held = {"drive": {"model": "Constant", "level": 800.0}, "load.normal_force": 0.5}
    trace = simulate(suspended.replace(CLOSES | bridged | held), time=np.linspace(0, 0.05, 11))
    carried = 1e9 * (10e-6 - trace.gap.values[-1]) * 1e-4
    pull = float(trace.electrostatic_force[-1])
    assert pull > 0.02
    assert carried == pytest.approx(0.5 + pull, rel=1e-9)


def test_a_closing_gap_draws_its_current_on_every_stretch_of_the_drive(suspended):
    """Without resistance the current is the rate of change of the charge, before the last break of the drive too."""
    steps = {"drive": {"model": "Trapezium", "high": 600.0, "rise": 4e-3, "hold": 3e-3, "fall": 1e-3}}
    time = np.linspace(0, 12e-3, 1201)
    trace = simulate(suspended.replace(CLOSES | BARE | steps | {"load.normal_force": 0.5}), time=time)
    charge = trace.displacement.sel(layer="insulator").values * 1e-4
    mean = (charge[2:] - charge[:-2]) / (time[2:] - time[:-2])
    found = trace.current.values[1:-1]
    smooth = np.min(np.abs(time[1:-1, None] - np.array([4e-3, 7e-3, 8e-3])), axis=1) > 2e-5
    assert np.max(np.abs(found - mean)[smooth]) < 1e-4 * np.max(np.abs(found))


def test_two_contacts_do_not_close_as_one(suspended):
    second = {"circuit.return_path": {"model": "SecondElectrode", "area": "0.5 cm2"}}
    with pytest.raises(InputError, match=r"contact\.closing: .*use Grounded or Floating"):
        simulate(suspended.replace(CLOSES | second))


def test_an_amplifier_that_just_cannot_follow_does_not_chatter(founding):
    """A chirp that needs the largest current at one moment, within rounding: it used to change without end."""
    changes = {
        "drive": {"model": "Chirp", "amplitude": 60.0, "first": 50.0, "last": 500.0, "length": 7e-3},
        "stack.insulator.thickness": 2e-6,
        "stack.gap": {"thickness": 2e-6},
        "stack.stratum_corneum.material": {
            "model": "Debye",
            "permittivity_high": 100.0,
            "strength": 900.0,
            "relaxation_time": 0.5e-3,
            "conductivity": 1e-5,
        },
        "circuit.amplifier": {"gain": 1.5, "source_current": 15e-6, "stray_capacitance": 5e-11},
        "circuit.return_path.resistance": 2e4,
    }
    trace = simulate(founding.replace(changes), time=np.linspace(0, 8e-3, 81))
    assert "16 changes" in trace.attrs["solver_reason"]
    assert float(np.abs(trace.amplifier_current).max()) <= 15e-6 * (1 + 1e-9)


@pytest.mark.parametrize("end", [2e-3, 2.3e-3])
def test_the_last_time_of_a_record_is_like_any_other(founding, end):
    """Behind a limit, the current at the end of a record is that of a longer one."""
    changes = BARE | {
        "drive": {"model": "Sine", "amplitude": 60.0, "frequency": 200.0},
        "circuit.amplifier": {"saturation": 50.0, "stray_capacitance": 5e-11},
    }
    time = np.array([0.0, 1e-3, end])
    ends, goes_on = (
        simulate(founding.replace(changes), time=each) for each in (time, np.append(time, 2 * end))
    )
    for name in ("current", "amplifier_current", "plate_voltage"):
        size = float(np.abs(goes_on[name]).max())
        np.testing.assert_allclose(ends[name].values, goes_on[name].values[:3], rtol=0, atol=1e-3 * size)
    assert abs(float(ends.current[-1])) > 0.01 * float(np.abs(goes_on.current).max())
