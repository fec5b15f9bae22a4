"""What a user sets counts, or is refused, or a diagnostic says that it does not count."""

from __future__ import annotations

import json

import numpy as np
import pytest

from electrovib.core.errors import InputError
from electrovib.core.model import read_model
from electrovib.physics.amplifier import Amplifier
from electrovib.physics.motion import Motion
from electrovib.scenario import load
from electrovib.solve.simulate import simulate

COULOMB = {"model": "Coulomb", "coefficient": 0.5}
PRESS = {"model": "Press", "begin": 0.05, "rise": 0.05}
MOIST = {
    "level": 0.5,
    "dry_gap_resistivity": 1e12,
    "wet_gap_resistivity": 1e6,
    "dry_coefficient": 0.4,
    "wet_coefficient": 0.8,
}
PERSSON = {
    "model": "PerssonSurface",
    "modulus": 2e7,
    "rms_slope": 1.0,
    "rms_gap": 2e-5,
    "pressure_factor": 0.5,
    "decay_factor": 0.5,
}


@pytest.fixture(scope="module")
def gap():
    return load("vezzoli_2014/fig6_gap")


def diagnostics(trace):
    return {diagnostic["name"]: diagnostic for diagnostic in json.loads(trace.attrs["validity"])}


def test_a_sink_alone_would_not_limit():
    with pytest.raises(InputError, match="source_current beside it"):
        read_model(Amplifier, {"sink_current": "2 uA"})


def test_a_programme_of_no_speed():
    with pytest.raises(InputError, match="time_profile scales the speed and needs one"):
        read_model(Motion, {"time_profile": {"model": "Press", "rise": 0.1}})


def test_a_press_has_no_periodic_state_behind_a_memory(gap):
    """Without memory it is exact: the attraction repeats, the load does not."""
    sine = {"drive": {"model": "Sine", "amplitude": 100.0, "frequency": 50.0}, "load.time_profile": PRESS}
    settled = sine | {"time.initial_state": {"model": "PeriodicState"}}
    time = np.linspace(0, 0.2, 201)
    trace = simulate(gap.replace(settled), time=time)
    np.testing.assert_allclose(trace.normal_force.values[-1], 0.5)
    lag = {"friction": {"model": "FirstOrderLag", "steady": COULOMB, "cut_off": 100.0}}
    with pytest.raises(InputError, match=r"load\.time_profile = Press occurs once"):
        simulate(gap.replace(settled | lag), time=time)


def test_a_closing_gap_without_a_load_begins_as_declared(gap):
    """A Persson surface topography carries no load only endlessly far away."""
    closing = {
        "stack.gap.material.conductivity": 0.0,
        "contact.surface": PERSSON,
        "contact.closing": {"damping": 1e6},
        "load.time_profile": PRESS,
    }
    trace = simulate(gap.replace(closing), time=np.linspace(0, 0.2, 41))
    assert trace.gap.values[0] == gap.stack.layers["gap"].thickness
    carried = 0.5e7 * 2 * np.exp(-trace.gap.values[-1] / 1e-5) * 1e-4
    assert carried == pytest.approx(float(trace.normal_force[-1] + trace.electrostatic_force[-1]), rel=0.02)


def test_a_share_of_ridges_that_no_law_knows_is_refused(gap):
    with pytest.raises(InputError, match="ridge_share"):
        gap.replace({"contact.ridge_share": 0.6})


def test_the_current_that_a_stray_capacitance_takes_is_not_said_to_enter_the_finger(gap):
    stray = {"circuit.amplifier": {"gain": 1.0, "bandwidth": 1e5, "stray_capacitance": 1e-8}}
    trace = simulate(gap.replace(stray))
    assert float(np.abs(trace.amplifier_current).max()) > 10 * float(np.abs(trace.current).max())
    assert "into plate, stray capacitance and finger" in diagnostics(trace)["current"]["text"]
    assert "into the contact" in diagnostics(simulate(gap))["current"]["text"]


def test_moisture_says_what_it_sets_and_what_it_finds_nothing_for(gap):
    moist = gap.replace({"moisture": MOIST})
    diagnostic = diagnostics(simulate(moist))["moisture"]
    assert diagnostic["state"] == "ok"
    assert "friction.coefficient = 0.6" in diagnostic["text"]
    shear = {"friction": {"model": "AdhesiveShear", "shear_strength": 1e6}, "contact.surface": PERSSON}
    diagnostic = diagnostics(simulate(gap.replace(shear | {"moisture": MOIST})))["moisture"]
    assert diagnostic["state"] == "warning"
    assert "no parameter of friction that moisture sets" in diagnostic["text"]
    with pytest.raises(InputError, match=r"friction\.coefficient: is set by moisture"):
        moist.replace({"friction.coefficient": 0.7})
    assert moist.replace({"moisture": None, "friction.coefficient": 0.7}).friction.coefficient == 0.7


def test_a_load_on_a_finger_held_off_is_told():
    held = load("vezzoli_2014/fig2_tremor")
    time = np.linspace(0, 0.05, 11)
    assert "load off the plate" not in diagnostics(simulate(held, time=time))
    pressed = simulate(held.replace({"load.normal_force": 0.5}), time=time)
    assert diagnostics(pressed)["load off the plate"]["state"] == "warning"


def test_a_current_in_an_edge_between_two_times_is_not_missed(gap):
    """C dV/dt of the edge, whatever the output times: 3 us between times 5 ms apart."""
    square = {"drive": {"model": "Square", "high": 300.0, "frequency": 20.0, "edge": 3e-6}}
    coarse, fine = (
        simulate(gap.replace(square), time=time) for time in (np.arange(13) * 5e-3, np.linspace(0, 6e-6, 601))
    )
    assert float(np.abs(fine.current).max()) > 250e-6 > 100 * float(np.abs(coarse.current).max())
    assert diagnostics(coarse)["current"]["state"] == diagnostics(fine)["current"]["state"] == "warning"


def test_a_quantity_that_is_not_known_is_named_in_words(tmp_path):
    rows = ["frequency,permittivity,loss", "10,2000,1800", "100,1600,1200", "1000,1200,900", "100000,700,300"]
    (tmp_path / "skin.csv").write_text("\n".join(rows), encoding="utf-8")
    table = {"model": "Tabulated", "file": str(tmp_path / "skin.csv"), "conductivity": 1e-6}
    changes = {"stack.stratum_corneum.material": table, "force": {"model": "MaxwellStressInGap"}}
    text = diagnostics(simulate(load("vezzoli_2014/fig6", changes=changes)))["memory"]["text"]
    assert "; the field of 'stratum_corneum' is not known to 1 % of its remaining amplitude from" in text
