"""What a user sets counts, or is refused, or a diagnostic says that it does not count."""

from __future__ import annotations

import numpy as np
import pytest

import electrovib as ev
from electrovib.core.constants import eps0
from electrovib.core.diagnostics import diagnostics_of
from electrovib.core.errors import InputError
from electrovib.core.model import read_model
from electrovib.physics.amplifier import Amplifier
from electrovib.physics.motion import Motion
from electrovib.solve.diagnostics.assumptions import settled_charge
from electrovib.solve.simulate import simulate

COULOMB = {"model": "Coulomb", "coefficient": 0.5}
PRESS = {"model": "Press", "begin": 0.05, "rise": 0.05}
GAPS = {"dry_gap_resistivity": 1e12, "wet_gap_resistivity": 1e6}
MOIST = {"moisture": {"level": 0.5, "dry_coefficient": 0.4, "wet_coefficient": 0.8} | GAPS}
FACTORS = {"pressure_factor": 0.5, "decay_factor": 0.5}
PERSSON = {"model": "PerssonSurface", "modulus": 2e7, "rms_slope": 1.0, "rms_gap": 2e-5} | FACTORS


@pytest.fixture(scope="module")
def gap():
    return ev.load("vezzoli_2014/fig6_gap")


def told(scenario, changes=None, **how):
    return {each.name: each for each in diagnostics_of(simulate(scenario.replace(changes or {}), **how))}


def test_what_nothing_would_follow_is_refused(gap):
    with pytest.raises(InputError, match="source_current beside it"):
        read_model(Amplifier, {"sink_current": "2 uA"})
    with pytest.raises(InputError, match="time_profile scales the speed and needs one"):
        read_model(Motion, {"time_profile": {"model": "Press", "rise": 0.1}})
    with pytest.raises(InputError, match="ridge_share"):
        gap.replace({"contact.ridge_share": 0.6})  # which no law knows


def test_a_press_has_no_periodic_state_behind_a_memory(gap):
    """Without memory it is exact: the attraction repeats, the load does not."""
    sine = {"drive": {"model": "Sine", "amplitude": 100.0, "frequency": 50.0}, "load.time_profile": PRESS}
    settled, time = (
        gap.replace(sine | {"time.initial_state": {"model": "PeriodicState"}}),
        np.linspace(0, 0.2, 201),
    )
    np.testing.assert_allclose(simulate(settled, time=time).normal_force.values[-1], 0.5)
    lag = {"friction": {"model": "FirstOrderLag", "steady": COULOMB, "cut_off": 100.0}}
    with pytest.raises(InputError, match=r"load\.time_profile = Press occurs once"):
        simulate(settled.replace(lag), time=time)


def test_a_closing_gap_without_a_load_begins_as_declared(gap):
    """A Persson surface topography carries no load only endlessly far away."""
    closing = {"contact.surface": PERSSON, "contact.closing": {"damping": 1e6}, "load.time_profile": PRESS}
    scenario = gap.replace(closing | {"stack.gap.material.conductivity": 0.0})
    trace = simulate(scenario, time=np.linspace(0, 0.2, 41))
    assert trace.gap.values[0] == gap.stack.layers["gap"].thickness
    carried = 0.5e7 * 2 * np.exp(-trace.gap.values[-1] / 1e-5) * 1e-4
    assert carried == pytest.approx(float(trace.normal_force[-1] + trace.electrostatic_force[-1]), rel=0.02)


def test_the_current_that_a_stray_capacitance_takes_is_not_said_to_enter_the_finger(gap):
    stray = {"circuit.amplifier": {"gain": 1.0, "bandwidth": 1e5, "stray_capacitance": 1e-8}}
    assert "into plate, stray capacitance and finger" in told(gap, stray)["current"].text
    assert "into the contact" in told(gap)["current"].text


def test_moisture_says_what_it_sets_and_what_it_finds_nothing_for(gap):
    found = told(gap, MOIST)["moisture"]
    assert found.state == "ok"
    assert "friction.coefficient = 0.6" in found.text
    shear = {"friction": {"model": "AdhesiveShear", "shear_strength": 1e6}, "contact.surface": PERSSON}
    found = told(gap, shear | MOIST)["moisture"]
    assert found.state == "warning"
    assert "no parameter of friction that moisture sets" in found.text
    coefficient, moist = {"friction.coefficient": 0.7}, gap.replace(MOIST)
    with pytest.raises(InputError, match=r"friction\.coefficient: is set by moisture"):
        moist.replace(coefficient)
    assert moist.replace({"moisture": None} | coefficient).friction.coefficient == 0.7


def test_a_load_on_a_finger_held_off_is_told():
    held, time = ev.load("vezzoli_2014/fig2_tremor"), np.linspace(0, 0.05, 11)
    assert "load off the plate" not in told(held, time=time)
    assert told(held, {"load.normal_force": 0.5}, time=time)["load off the plate"].state == "warning"


def test_a_current_in_an_edge_between_two_times_is_not_missed(gap):
    """C dV/dt of the edge, whatever the output times: 3 us between times 5 ms apart."""
    square = {"drive": {"model": "Square", "high": 300.0, "frequency": 20.0, "edge": 3e-6}}
    for time, largest in ((np.arange(13) * 5e-3, (0, 2.5e-6)), (np.linspace(0, 6e-6, 601), (250e-6, np.inf))):
        trace = simulate(gap.replace(square), time=time)
        assert largest[0] < float(np.abs(trace.current).max()) < largest[1]
        assert [each.state for each in diagnostics_of(trace) if each.name == "current"] == ["warning"]


def test_a_quantity_that_is_not_known_is_named_in_words(tmp_path):
    rows = ["frequency,permittivity,loss", "10,2000,1800", "100,1600,1200", "1000,1200,900", "100000,700,300"]
    (tmp_path / "skin.csv").write_text("\n".join(rows), encoding="utf-8")
    table = {"model": "Tabulated", "file": str(tmp_path / "skin.csv"), "conductivity": 1e-6}
    changes = {"stack.stratum_corneum.material": table, "force": {"model": "MaxwellStressInGap"}}
    text = told(ev.load("vezzoli_2014/fig6"), changes)["memory"].text
    assert "; the field of 'stratum_corneum' is not known to 1 % of its remaining amplitude from" in text


CONDUCTIVITY = "stack.insulator.material.conductivity"


@pytest.fixture(scope="module")
def offset():
    """A sine of 100 V on 200 V over a film of permittivity 3.35, in the periodic state."""
    return ev.load("kang_2017/offset")


@pytest.mark.parametrize(
    ("changes", "mean"),
    [
        ({CONDUCTIVITY: 1e-14}, "200 V"),
        ({CONDUCTIVITY: 2.9e-13}, "200 V"),  # just above a hundred seconds
        ({CONDUCTIVITY: 3.0e-13}, None),
        ({CONDUCTIVITY: 1e-14, "drive": {"model": "Step", "level": -50.0}}, "-50 V"),
        ({}, None),
        ({CONDUCTIVITY: 1e-14, "time.initial_state.model": "AtRest"}, None),
        ({CONDUCTIVITY: 1e-14, "drive.level": 0.0}, None),
        ({CONDUCTIVITY: 0.0, "stack.gap.material.conductivity": 1e-14}, None),
    ],
)
def test_a_periodic_state_that_takes_hours_to_reach_is_marked(offset, changes, mean):
    found = settled_charge(offset.replace(changes))
    assert bool(found) == bool(mean)
    for each in found:
        assert (each.state, each.value) == (
            "warning",
            pytest.approx(3.35 * eps0 / changes[CONDUCTIVITY], rel=1e-9),
        )
        assert f"the mean of {mean} has been held" in each.text
        assert "stack.insulator.material.conductivity = 0" in each.text


def test_a_run_and_a_comparison_carry_it(offset):
    assert "settled charge" in told(offset, {"stack.insulator.material": "silica"})
    found = ev.compare_materials(offset, materials=["silica", "pet"])
    cautions = {entry.name: bool(entry.caution) for entry in found.entries}
    assert cautions == {"as it is": False, "silica": True, "pet": False}
    assert found.tables[1].title == "The attraction is reached only after a long time"
