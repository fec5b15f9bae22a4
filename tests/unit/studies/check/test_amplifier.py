"""What a drive asks of the amplifier: by hand from the capacitances, compared with what the amplifier has."""

import math

import pytest
from typer.testing import CliRunner

import electrovib as ev
from electrovib.apps.cli import app
from electrovib.core.errors import InputError
from electrovib.studies.check import cleared_for_output

FIG6 = "vezzoli_2014/fig6"
STRAY = 10e-9
STACK = 8.8541878128e-12 * 1e-4 / (90e-6 / 3.35)
"""Capacitance of the film under a finger that conducts; without the 1 kohm of the body."""
EDGE = 10e-6
PULSE = {"model": "Trapezium", "high": 100.0, "rise": EDGE, "hold": 1e-3, "fall": 2 * EDGE}
SLOPE = 100.0 / EDGE


def row(result, name):
    return next(each for each in result.rows if each.quantity == f"asked {name}")


def of(amplifier, **changes):
    own = {"circuit.amplifier": {"stray_capacitance": STRAY} | amplifier, "time.duration": 2e-3}
    return ev.check(PULSE, FIG6, set=own | changes)


def test_a_source_of_100_ua_before_10_nf_is_asked_for_a_thousand_times_more():
    result = of({"source_current": 100e-6})
    current, slew = row(result, "peak current"), row(result, "slew rate")
    assert current.value == pytest.approx((STRAY + STACK) * SLOPE, rel=1e-3)
    assert (current.limit, current.state, current.unit) == (100e-6, "fail", "A")
    assert current.source == "circuit.amplifier.source_current"
    assert slew.value == pytest.approx(SLOPE)
    assert slew.limit == pytest.approx(100e-6 / STRAY)
    assert slew.state == "fail"
    assert result.value("peak current") == pytest.approx(100e-6), "what flows is what the amplifier has"
    assert result.state == "fail"
    assert "asked peak current" in result.headline


def test_root_mean_square_and_apparent_power_of_what_is_asked():
    """Two edges of C dV/dt, and a trapezium of 100 V, over the time that was checked."""
    result = of({"source_current": 100e-6})
    total, end = STRAY + STACK, result.duration
    rms = total * SLOPE * math.sqrt((EDGE + 2 * EDGE / 4) / end)
    volts = 100 * math.sqrt((1e-3 + 3 * EDGE / 3) / end)
    assert result.value("asked rms current") == pytest.approx(rms, rel=2e-3)
    assert result.value("asked apparent power") == pytest.approx(rms * volts, rel=2e-3)
    units = {each.quantity: each.unit for each in result.numbers}
    assert units["asked apparent power"] == "VA"
    assert result.value("rms current") < 0.1 * rms


@pytest.mark.parametrize("sign", [1, -1])
def test_each_sign_of_the_current_has_its_own_limit(sign):
    """The rise asks twice the current of the fall; a limit of either sign is met by the edge of that sign."""
    drive = {"drive": PULSE | {"high": 100.0 * sign}}
    rise, fall = (STRAY + STACK) * SLOPE, (STRAY + STACK) * SLOPE / 2
    first, second = ("source", "sink")[::sign]
    found = ev.check(
        FIG6,
        set={
            "circuit.amplifier": {
                "stray_capacitance": STRAY,
                "source_current": 10.0,
                f"{first}_current": 1.1 * rise,
                f"{second}_current": 0.9 * fall,
            },
            **drive,
        },
    )
    current = row(found, "peak current")
    assert current.state == "fail"
    assert current.source == f"circuit.amplifier.{second}_current"
    assert current.limit == pytest.approx(0.9 * fall)
    assert current.value == pytest.approx(fall, rel=1e-2)


def test_a_saturation_is_compared_with_the_voltage_that_is_asked_not_with_what_it_leaves():
    result = of({"gain": 2.0, "saturation": 150.0})
    voltage = row(result, "peak voltage")
    assert (voltage.value, voltage.limit, voltage.state) == (200, 150, "fail")
    assert result.value("peak voltage") == 150
    within = of({"gain": 2.0, "saturation": 200.0})
    assert row(within, "peak voltage").state == "pass"
    assert not [each for each in within.rows if each.quantity == "asked peak current"]


def test_a_bandwidth_stays_and_makes_a_step_finite():
    """The current of one pole that follows a step, 2 pi f V (C_stray + C_stack), and no slew row before the pole."""
    changes = {"drive": {"model": "Step", "level": 100.0}}
    own = {"stray_capacitance": STRAY, "source_current": 1e-3}
    found = ev.check(FIG6, set={"circuit.amplifier": own | {"bandwidth": 1e3}} | changes)
    asked = 2 * math.pi * 1e3 * 100 * (STRAY + STACK)
    assert row(found, "peak current").value == pytest.approx(asked, rel=1e-2)
    assert not [each for each in found.rows if each.quantity == "asked slew rate"]
    sudden = ev.check(FIG6, set={"circuit.amplifier": own} | changes)
    assert row(sudden, "peak current").value == math.inf
    assert row(sudden, "peak current").state == row(sudden, "slew rate").state == "fail"
    assert sudden.value("asked apparent power") is None


def test_a_drive_without_an_amplifier_asks_for_one():
    result = ev.check(FIG6)
    assert not [each for each in result.rows if each.quantity.startswith("asked")]
    (line,) = [each for each in result.document.sentences if each.startswith("asked of")]
    assert line.startswith(
        "asked of an amplifier, without stray capacitance: peak voltage 1 kV, peak current "
    )
    power = result.value("rms voltage") * result.value("rms current")
    assert result.value("asked apparent power") == pytest.approx(power)
    short = CliRunner().invoke(app, ["check", FIG6]).output
    assert line in short


def test_a_prescribed_current_is_compared_with_no_limit_of_a_voltage_amplifier():
    sine = {"model": "CurrentSine", "amplitude": 1e-6, "frequency": 1e3}
    result = ev.check(sine, FIG6)
    assert not [each for each in result.rows if each.quantity.startswith("asked")]
    assert result.value("asked peak current") == pytest.approx(1e-6)
    assert result.value("asked slew rate") is None


def test_limits_of_the_amplifier_itself_refuse_no_file_and_those_of_the_set_up_do():
    """An amplifier that holds the current protects; what it leaves of the voltage is said, not refused."""
    own = {"circuit.amplifier": {"source_current": 100e-6, "stray_capacitance": STRAY}}
    scenario = ev.load(
        FIG6, changes={"drive": PULSE, "limits.voltage": 120.0, "limits.current": 250e-6, **own}
    )
    result = cleared_for_output(scenario)
    assert result.state == "fail"
    with pytest.raises(InputError, match="above 50 uA"):
        cleared_for_output(scenario, limits={"current": 50e-6})
