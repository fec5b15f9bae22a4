"""The gain of the force at a carrier, compared with the simulated force, currents and voltages of a sine."""

from __future__ import annotations

import numpy as np
import pytest

import electrovib as ev
from electrovib.core.errors import InputError
from electrovib.physics.limits import Limits
from electrovib.study.design.gain import carrier_gain

FIG6, GAP = "vezzoli_2014/fig6", "vezzoli_2014/fig6_gap"
SINE = {"model": "Sine", "amplitude": 7.0, "frequency": 3000.0}
CURRENT = {"model": "CurrentSine", "amplitude": 1e-5, "frequency": 3000.0}
AMPLIFIER = {"stray_capacitance": "200 pF", "bandwidth": "5 kHz", "gain": 100.0}
MEAN = "mean electrostatic_force"


@pytest.mark.parametrize(
    ("name", "drive", "changes"),
    [
        (FIG6, SINE, {}),
        ("vezzoli_2014/fig7", SINE, {"force": {"model": "MaxwellStressInInsulator"}}),
        (GAP, SINE, {"circuit.amplifier": AMPLIFIER}),
        (GAP, SINE, {"circuit.source_resistance": "20 Mohm"}),
        (GAP, CURRENT, {}),
    ],
)
def test_gain_is_that_of_the_simulated_sine_in_its_steady_state(name, drive, changes):
    settled = {"drive": drive, "time": {"initial_state": {"model": "PeriodicState"}}}
    scenario = ev.load(name, changes=settled | changes)
    amplified = "circuit.amplifier" in changes
    voltage = "peak plate_voltage" if amplified else "peak stack_voltage"
    current = "peak amplifier_current" if amplified else "peak current"
    names = list({MEAN: 0, voltage: 0, current: 0, "peak current": 0})
    found = ev.prepare(scenario, free=["load.normal_force"], quantities=names)([scenario.load.normal_force])
    gain, peak = carrier_gain(scenario, [3000.0]), drive["amplitude"]
    exact = 1e-3 if name.endswith("fig7") else 1e-9
    assert gain.force[0] * peak**2 == pytest.approx(found[MEAN], rel=exact)
    assert gain.current[0] * peak == pytest.approx(found[current], rel=1e-3)
    assert gain.body_current[0] * peak == pytest.approx(found["peak current"], rel=1e-3)
    if amplified or drive is CURRENT:
        assert gain.voltage[0] * peak == pytest.approx(found[voltage], rel=1e-3)


def test_largest_force_is_that_of_the_limit_that_binds():
    """Equation (1) of Vezzoli et al. 2014 on the finger alone: 250 uA at 3 kHz is 404 V and 4.6 mN."""
    gain = carrier_gain(ev.load("vezzoli_2014/fig6_static"), [30.0, 3000.0])
    limits = Limits(voltage=1000.0, current=250e-6)
    volts = gain.largest_amplitude(limits)
    assert volts[0] == 1000.0
    assert volts[1] == pytest.approx(404, rel=2e-3)
    assert gain.largest_force(limits)[1] == pytest.approx(4.623e-3, rel=1e-3)
    assert gain.amplitude(gain.largest_force(limits)) == pytest.approx(volts, rel=1e-12)
    assert gain.largest_amplitude(limits, slew=1e6)[1] == pytest.approx(1e6 / (2 * np.pi * 3000))
    assert gain.largest_amplitude(Limits(body_current=1e-6))[1] == pytest.approx(volts[1] / 250)
    assert gain.largest_amplitude(Limits())[0] == np.inf
    assert gain.amplitude(0.0) == pytest.approx([0.0, 0.0])


def test_gain_falls_below_the_leak_of_the_skin():
    """The force of the law of Vezzoli et al. 2014 is filtered by tau s/(1 + tau s): a half at 1/(2 pi tau)."""
    gains = carrier_gain(ev.load(FIG6), [20.67, 1e5]).force
    assert gains[0] / gains[1] == pytest.approx(0.5, rel=0.01)


GROWING = {"model": "GrowingArea", "area": 1e-4, "at_force": 0.5, "exponent": 2 / 3}
ROUGH = {"model": "PerssonSurface", "modulus": 2e7, "rms_slope": 1.0, "rms_gap": 2e-5}
ROUGH |= {"pressure_factor": 0.5, "decay_factor": 0.5}
CLOSING = {"model": "FixedArea", "area": 1e-4, "surface": ROUGH, "closing": {"damping": 1e6}}
SLIDING = {"speed": 0.03, "renews_film": True}
REFUSED = {
    "leak": ("kaczmarek_2006/gap_positive", {}, r"stack\.\w+\.leak: the conduction is not ohmic"),
    "tremor": ("vezzoli_2014/fig2_tremor", {}, r"motion\.distance: the gap changes"),
    "area": (
        GAP,
        {"contact": GROWING},
        "MaxwellStressInGap on GrowingArea is not proportional to the square",
    ),
    "surface": (GAP, {"contact": CLOSING}, "the gap follows load and attraction"),
    "film": (FIG6, {"motion": SLIDING}, "the sliding film leaves the contact with its charge"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_scenarios_without_a_gain_are_refused(case):
    name, changes, words = REFUSED[case]
    with pytest.raises(InputError, match=words):
        carrier_gain(ev.load(name, changes=changes), [1e3])


@pytest.mark.parametrize("wrong", [0.0, -1.0, np.nan, [[1.0]]])
def test_frequencies_are_above_0(wrong):
    with pytest.raises(InputError, match="above 0 Hz"):
        carrier_gain(ev.load(FIG6), wrong)
