"""Drives of many fingers: what they share, records, formulas, means."""

import numpy as np
import pytest

import electrovib as ev
from electrovib.core.errors import InputError
from electrovib.core.model import read_model
from electrovib.physics.drive.base import Drive
from electrovib.solve.electrics.transient import ALONE
from electrovib.solve.population import Population
from electrovib.solve.population.arrays import of_factors, per_unit
from electrovib.solve.population.fingers import _agree
from electrovib.solve.stack.transfer import NotInArraysError, Transfer, integrated

SQUARE = {"model": "Square", "high": 100.0, "low": -50.0, "frequency": 60.0}
NONE = np.zeros(0)


def drive_of(model, **given):
    return read_model(Drive, {"model": model} | given)


def test_corners_that_two_drives_share_up_to_rounding_are_one(fingers):
    """Every third corner of one is a corner of the other; as two corners they would be two jumps of both."""
    drives = [SQUARE, SQUARE | {"frequency": 180.0}]
    member = ev.load("vezzoli_2014/fig6_gap").replace({"drive": {"model": "Sum", "drives": drives}})
    time = np.linspace(0.0, 0.2, 331)
    fingers.assert_together(member, ["stack.gap.thickness"], ["current", "field"], time=time)


FORMULA = {"model": "Chirp", "amplitude": 100.0, "first": 20.0, "last": 300.0, "length": 0.03}
BURST = {"model": "Burst", "amplitude": 30.0, "frequency": 200.0, "cycles": 2, "delay": 1e-3}
RECORD = {
    "model": "Sampled",
    "time_samples": np.linspace(0.0, 0.05, 301).tolist(),
    "voltage_samples": (90 * np.sin(np.arange(301) ** 2 / 1e3)).tolist(),
}


@pytest.mark.parametrize(
    "drive", [FORMULA, BURST, RECORD, {"model": "Sum", "drives": [SQUARE, FORMULA, BURST]}]
)
def test_formulas_records_and_sines_that_are_switched_within_the_outputs(fingers, drive):
    member = ev.load("vezzoli_2014/fig6_gap").replace({"drive": drive})
    free = ["stack.gap.thickness", "stack.stratum_corneum.material.conductivity", "contact.area"]
    for time in (np.linspace(0.0, 0.05, 151), np.array([2e-3]), np.geomspace(1e-5, 0.05, 90)):
        fingers.assert_together(member, free, time=time)


def test_the_amplitude_of_a_formula_may_differ(fingers):
    member = ev.load("vezzoli_2014/fig6_gap").replace({"drive": FORMULA})
    free = ["drive.amplitude", "stack.gap.thickness"]
    fingers.assert_together(member, free, time=np.linspace(0.0, 0.05, 61))


def test_a_long_record_is_computed_one_finger_after_the_other(fingers):
    member = ev.load("vezzoli_2014/fig6_gap")
    time = np.linspace(0.0, 0.2, ALONE)
    fingers.assert_together(member, ["stack.gap.thickness"], ["electrostatic_force", "field"], time=time)


def test_a_current_with_a_mean_has_no_periodic_state_in_arrays():
    """Two offsets that cancel beside the scenario, but not for every finger."""
    sines = [
        {"model": "Sine", "amplitude": amplitude, "offset": offset, "frequency": 50.0}
        for amplitude, offset in ((1.0, 0.0), (0.0, 0.5), (0.0, -0.5))
    ]
    command = {"command": {"model": "Sum", "drives": sines}}
    drive = {"model": "CurrentAmplifier", "sense_resistance": 1e6} | command
    free = ["drive.command.drives.1.offset", "drive.command.drives.2.offset"]
    member = ev.load("kim_2015/current").replace({"drive": drive})
    many = Population(member, free, ["interface_field"], np.linspace(0, 0.02, 5))
    assert "mean" in many.method
    with pytest.raises(InputError, match="mean"):
        many.signals({free[0]: np.array([0.5, 0.7]), free[1]: np.array([-0.5, -0.5])})


def test_a_drive_with_a_mean_is_not_integrated_for_ever():
    """The integral of a periodic drive is periodic only without a mean."""
    charge = integrated(Transfer(rates=NONE, gains=NONE, direct=2.0))
    drives = (drive_of("Square", frequency=50.0, high=1.0, low=low) for low in (-1.0, 0.0))
    even, uneven = ({"drive.low": each.parts()} for each in drives)
    time = np.linspace(0, 0.02, 41)
    unit = per_unit({"charge": charge}, even, time, settled=True)
    found = of_factors(unit, [np.array([[3.0]])])["charge"]
    assert np.max(found) == pytest.approx(2 * 3 * 0.01 / 2, rel=1e-12)
    with pytest.raises(NotInArraysError, match="mean"):
        per_unit({"charge": charge}, uneven, time, settled=True)


def test_fingers_agree_to_a_billionth_of_the_peak():
    expected = np.array([1.0, -2.0, 0.0])
    for other in ([1.0, -2.0, 0.0], [1.0, -2.0, 1e-9]):
        assert _agree(np.array(other), expected, 1e-9)
    for other in ([1.0, -2.0, 4e-9], [1.0, np.nan, 0.0], [1.0, -2.0]):
        assert not _agree(np.array(other), expected, 1e-9)
