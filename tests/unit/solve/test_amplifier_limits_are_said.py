"""An amplifier that limits says so, with what the plate sees and what was asked, at every door that prints its numbers."""

import math

import pytest
from typer.testing import CliRunner

import electrovib as ev
from electrovib.apps.cli import app
from electrovib.core.diagnostics import diagnostics_of
from electrovib.solve.quantities.answer import validity

FIG6 = "vezzoli_2014/fig6"
PULSE = {"model": "Trapezium", "high": 100.0, "rise": 1e-5, "hold": 1e-3, "fall": 1e-5}
SLOW = {"source_current": 100e-6, "stray_capacitance": 10e-9}
LEAK = {"model": "FieldConduction", "conductivity": 1e-9, "onset_field": 1e6}
TREMBLING = {"model": "TremblingDistance", "mean": 1e-5, "amplitude": 1e-6, "frequency": 10.0}


def scenario(amplifier, **changes):
    return ev.load(
        FIG6, changes={"drive": PULSE, "circuit.amplifier": amplifier, "time.duration": 2e-3} | changes
    )


def said(result):
    return [each for each in diagnostics_of(result) if each.name == "amplifier"]


@pytest.mark.parametrize(
    "changes",
    [{}, {"stack.insulator.leak": LEAK}, {"motion.distance": TREMBLING, "stack.gap.thickness": 1e-5}],
    ids=["modes", "leak", "moving gap"],
)
def test_a_largest_current_is_named_with_what_the_plate_sees(changes):
    """By hand: the current into stray capacitance and film, until the falling edge is at what the plate has reached."""
    trace = ev.simulate(scenario(SLOW, **changes))
    (found,) = said(trace)
    seen = float(trace.plate_voltage.max())
    assert seen == pytest.approx(100e-6 * 1.019e-3 / (10e-9 + 33e-12), rel=5e-3)
    assert (found.state, found.unit) == ("warning", "V")
    assert found.value == pytest.approx(100)
    assert found.limit == pytest.approx(seen, rel=5e-3)
    assert f"sees up to {found.limit:.3g} V of the 100 V that the drive asks for" in found.text
    assert "source_current = 100 uA of" in found.text


@pytest.mark.parametrize(
    ("amplifier", "seen", "asked", "named"),
    [
        ({"gain": -2.0, "saturation": 150.0}, 150, 200, "saturation = 150 V"),
        ({"bandwidth": 100.0}, 100 * (1 - math.exp(-2 * math.pi * 0.1)), 100, "bandwidth = 100 Hz"),
        ({"bandwidth": 700.0}, 98.8, 100, "bandwidth = 700 Hz"),
        (SLOW | {"sink_current": 1e-5}, 10.1, 100, "source_current = 100 uA and sink_current = 10 uA"),
        (SLOW | {"source_current": 1.0, "sink_current": 1e-2}, 100, 100, "sink_current = 10 mA"),
    ],
    ids=["saturation", "bandwidth", "1.2 % less", "both currents", "sink alone"],
)
def test_each_limit_is_named_with_both_voltages(amplifier, seen, asked, named):
    (found,) = said(ev.simulate(scenario(amplifier)))
    assert found.limit == pytest.approx(seen, rel=2e-2)
    assert found.value == pytest.approx(asked)
    assert f"that the drive asks for, with {named} of circuit.amplifier" in found.text
    assert ("follows late to the 100 V" in found.text) == (seen == asked)


@pytest.mark.parametrize(
    "amplifier",
    [
        {"gain": 2.0, "saturation": 200.0},
        {"source_current": 1.0, "stray_capacitance": 10e-9},
        {"bandwidth": 100e3},
        {"bandwidth": 850.0},  # 0.5 % are missing at the end of the hold
        {"stray_capacitance": 1e-6},
    ],
)
def test_an_amplifier_that_supplies_what_is_asked_says_nothing(amplifier):
    assert not said(ev.simulate(scenario(amplifier)))


def test_a_prescribed_current_passes_no_voltage_amplifier():
    sine = {"model": "CurrentSine", "amplitude": 1e-6, "frequency": 1e3}
    assert not [each for each in validity(scenario(SLOW, drive=sine)) if each.name == "amplifier"]


@pytest.mark.usefixtures("blank_pictures")
def test_it_is_said_at_every_door(tmp_path):
    limited, words = scenario(SLOW), "V of the 100 V that the drive asks for"
    file, page, table = (tmp_path / name for name in ("limited.toml", "page.html", "table.csv"))
    file.write_text(limited.to_toml(), encoding="utf-8")
    swept = ev.sweep(limited, {"drive.high": [1e-3, 100.0]}, quantity=["peak electrostatic_force"])
    space = {"load.normal_force": {"model": "Uniform", "low": 0.4, "high": 0.6}}
    assert words in swept.attrs["validity"]
    assert words in ev.study(limited, space, n=2, seed=1).attrs["validity"]
    for command in ("check", "run"):
        assert words in CliRunner().invoke(app, [command, str(file)]).output
    CliRunner().invoke(app, ["run", str(file), "--report", str(page), "-o", str(table)])
    assert words in page.read_text(encoding="utf-8")
    assert words in table.read_text(encoding="utf-8")
