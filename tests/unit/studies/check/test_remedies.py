"""What would hold a limit: the series resistor, and the edge and the resistor that a refusal names."""

import math
import re

import numpy as np
import pytest

import electrovib as ev
from electrovib.core.errors import InputError
from electrovib.core.units import parse_quantity
from electrovib.physics.safety import (
    corner_frequency,
    largest_supply_voltage,
    resistor_power,
    smallest_series_resistance,
    stored_energy_behind,
)
from electrovib.studies.check import cleared_as_played

FIG6 = "vezzoli_2014/fig6"


def test_resistance_power_and_what_remains_behind():
    """1 kV and 250 uA need 4 Mohm, 0.25 W; 32.96 pF charge with 132 us and hold 16.5 uJ."""
    found = ev.series_resistor(FIG6)
    assert found.resistance == pytest.approx(4e6)
    assert found.power == pytest.approx(0.25)
    assert found.capacitance == pytest.approx(32.96e-12, rel=1e-3, abs=0)
    assert found.time_constant == pytest.approx(4e6 * found.capacitance)
    assert found.stored_energy == pytest.approx(found.capacitance * 1e6 / 2)
    assert found.corner == pytest.approx(1 / (2 * math.pi * found.time_constant))
    assert found.supply_voltage is None, "no resistor is there that could allow a voltage"
    rows = {row[0]: row[1:] for row in found.document.tables[0].rows}
    assert "largest supply voltage with it" not in rows
    assert rows["present series resistance"] == ("none", "circuit.source_resistance of the scenario is 0")
    there = ev.series_resistor(FIG6, set={"circuit.source_resistance": "1 Mohm"}).document.tables[0].rows
    assert [row[1] for row in there[-2:]] == ["1 Mohm", "250 V"], "250 uA times 1 Mohm"


def test_gap_and_limits_count_and_the_body_does_not():
    """A film of 90 um and 3 um of air in series store less than the film alone; the skin counts as a conductor."""
    gap = {"stack.gap.thickness": "3 um"}
    found = ev.series_resistor("vezzoli_2014/fig6_gap", set=gap, limits={"current": 1e-3})
    assert found.capacitance == pytest.approx(8.8541878128e-12 * 1e-4 / (90e-6 / 3.35 + 3e-6), rel=1e-9)
    amplifier = {"circuit.amplifier": {"stray_capacitance": "100 pF"}}
    own = {"circuit.source_resistance": "1 Mohm"} | amplifier
    limits = {"voltage": "500 V", "body_current": "100 uA"}
    found = ev.series_resistor(FIG6, limits=limits, set=own)
    assert found.resistance == pytest.approx(5e6)
    assert found.power == pytest.approx(500**2 / 5e6)
    assert found.supply_voltage == pytest.approx(100)
    assert found.capacitance == pytest.approx(132.96e-12, rel=1e-3, abs=0)
    assert found.voltage_source == "limits.voltage of limits"


def test_formulas_of_a_series_resistor_and_what_is_refused():
    with pytest.raises(InputError, match=r"limits\.body_current"):
        ev.series_resistor(ev.load(FIG6).replace({"limits": {}}))
    assert smallest_series_resistance(voltage=1000, current=1e-3) == pytest.approx(1e6)
    assert largest_supply_voltage(resistance=1e6, current=1e-3) == pytest.approx(1000)
    assert resistor_power(voltage=10, resistance=4) == pytest.approx(25)
    assert resistor_power(voltage=10, resistance=0) == 0
    assert corner_frequency(resistance=0, capacitance=1) == math.inf
    assert stored_energy_behind(voltage=2, capacitance=3) == 6


STRONG = {"stack.insulator.thickness": "10 um", "stack.insulator.breakdown_field": "10 GV/m", "limits": {}}
SCENARIO = ev.load(FIG6).replace(STRONG)
TIMES = np.arange(101) * 1e-4
VOLTAGES = 100 * np.sin(np.pi * TIMES / TIMES[-1]) ** 2


def played(edge, resistance=0.0, current=200e-6, voltage=500, scenario=SCENARIO):
    asked = {"what": "it", "name": "the samples", "declare": "Declare it.", "edge": edge}
    behind = scenario.replace({"circuit.source_resistance": resistance})
    limits = {"voltage": voltage, "current": current}
    return cleared_as_played(behind, times=TIMES, voltages=VOLTAGES, limits=limits, **asked)


def refusal(edge, **options):
    with pytest.raises(InputError) as caught:
        played(edge, **options)
    return caught.value.problems


def test_a_refusal_names_the_edge_and_the_resistor_that_would_hold_the_limit():
    exceeded, remedy = refusal(None)
    assert "above 200 uA" in exceeded
    assert "no edge is declared" in remedy
    assert "the declared edge takes 1 us" in refusal(1e-6)[1]
    assert remedy.endswith("Declare it.")
    number = r"([\d.]+ \w+)"
    words = f"at least {number}, such as one pole at {number} or below.* resistor of {number}"
    named = zip(re.search(words, remedy).groups(), ("s", "Hz", "ohm"), strict=True)
    edge, pole, resistance = (parse_quantity(text, unit) for text, unit in named)
    assert played(edge).value("peak current") == pytest.approx(200e-6, rel=0.15)
    assert played(0.0, resistance).value("peak current") == pytest.approx(200e-6, rel=0.15)
    assert 0.85 / edge < 2 * np.pi * pole <= 1 / edge * (1 + 1e-9)
    refusal(0.85 * edge)
    refusal(0.0, resistance=0.85 * resistance)


def test_a_remedy_is_named_only_where_it_helps():
    """At most 3.1 V a step, into the resistance of skin and body, take 3 mA; the smooth samples take 2 uA."""
    assert 1e-3 < played(None, current=1.0).value("peak current") < 3.2e-3
    assert len(refusal(None, current=1e-7)) == 1, "the samples themselves exceed the limit"
    assert all("filter" not in each for each in refusal(1e-5, voltage=99, current=1.0))
    stray = SCENARIO.replace({"circuit.amplifier": {"stray_capacitance": 1e-9}})
    remedy = refusal(1e-8, scenario=stray)[-1]
    assert "filter in front of the plate" in remedy
    assert "resistor" not in remedy, "it would not hold the current into the stray capacitance"
