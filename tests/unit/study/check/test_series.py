"""The series resistor that holds the body current."""

from __future__ import annotations

import math

import pytest

import electrovib as ev
from electrovib.core.errors import InputError
from electrovib.physics.series_resistor import (
    corner_frequency,
    largest_supply_voltage,
    resistor_power,
    smallest_series_resistance,
    stored_energy_behind,
)
from electrovib.view.checked import resistor_table

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


def test_a_resistor_that_is_not_there_allows_no_voltage_in_the_table():
    rows = {row[0]: row[1:] for row in resistor_table(ev.series_resistor(FIG6)).rows}
    assert "largest supply voltage with it" not in rows
    assert rows["present series resistance"] == ("none", "circuit.source_resistance of the scenario is 0")
    there = resistor_table(ev.series_resistor(FIG6, set={"circuit.source_resistance": "1 Mohm"})).rows
    assert [row[1] for row in there[-2:]] == ["1 Mohm", "250 V"], "250 uA times 1 Mohm"


def test_a_gap_counts_to_the_capacitance_behind_the_resistor():
    """A film of 90 um and 3 um of air in series store less than the film alone; the skin counts as a conductor."""
    found = ev.series_resistor(
        "vezzoli_2014/fig6_gap", set={"stack.gap.thickness": "3 um"}, limits={"current": 1e-3}
    )
    assert found.capacitance == pytest.approx(8.8541878128e-12 * 1e-4 / (90e-6 / 3.35 + 3e-6), rel=1e-9)


def test_limits_and_body_count():
    found = ev.series_resistor(
        FIG6,
        limits={"voltage": "500 V", "body_current": "100 uA"},
        set={"circuit.source_resistance": "1 Mohm", "circuit.amplifier": {"stray_capacitance": "100 pF"}},
        body_resistance=1e6,
    )
    assert found.resistance == pytest.approx(4e6)
    assert found.power == pytest.approx(500**2 / 4e6), "the body is not relied on for the rating"
    assert found.supply_voltage == pytest.approx(200)
    assert found.capacitance == pytest.approx(132.96e-12, rel=1e-3, abs=0)
    assert found.voltage_source == "limits.voltage of limits"


def test_what_is_missing_is_refused():
    with pytest.raises(InputError, match=r"limits\.body_current"):
        ev.series_resistor(ev.load(FIG6).replace({"limits": {}}))
    for wrong in (-1.0, math.nan, math.inf):
        with pytest.raises(InputError, match="body_resistance"):
            ev.series_resistor(FIG6, body_resistance=wrong)


def test_formulas():
    resistance = smallest_series_resistance(voltage=1000, current=1e-3, body_resistance=1e3)
    assert resistance == pytest.approx(999e3)
    assert largest_supply_voltage(resistance=resistance, current=1e-3, body_resistance=1e3) == pytest.approx(
        1000
    )
    assert smallest_series_resistance(voltage=0.5, current=1e-3, body_resistance=1e3) == 0
    assert resistor_power(voltage=10, resistance=3, body_resistance=2) == pytest.approx(3 * 4)
    assert resistor_power(voltage=10, resistance=0) == 0
    assert corner_frequency(resistance=0, capacitance=1) == math.inf
    assert stored_energy_behind(voltage=2, capacitance=3) == 6
