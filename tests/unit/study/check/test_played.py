"""What would hold a limit: the edge and the resistor that a refusal names, and those a little below them."""

import re

import numpy as np
import pytest

import electrovib as ev
from electrovib.core.errors import InputError
from electrovib.core.units import parse_quantity
from electrovib.study.check import cleared_as_played

SCENARIO = ev.load("vezzoli_2014/fig6").replace(
    {"stack.insulator.thickness": "10 um", "stack.insulator.breakdown_field": "10 GV/m", "limits": {}}
)
TIMES = np.arange(101) * 1e-4
LIMITS = {"voltage": 500, "current": 200e-6}


def played(edge, resistance=0.0, limits=LIMITS, scenario=SCENARIO):
    return cleared_as_played(
        scenario.replace({"circuit.source_resistance": resistance}),
        times=TIMES, voltages=100 * np.sin(np.pi * TIMES / TIMES[-1]) ** 2, edge=edge,
        limits=limits, what="it", name="the samples", declare="Declare it.",
    )  # fmt: skip


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
    named = re.search(
        f"at least {number}, such as one pole at {number} or below.* resistor of {number}", remedy
    )
    edge, pole, resistance = (
        parse_quantity(text, unit) for text, unit in zip(named.groups(), ("s", "Hz", "ohm"), strict=True)
    )
    assert played(edge).value("peak current") == pytest.approx(200e-6, rel=0.15)
    assert played(0.0, resistance).value("peak current") == pytest.approx(200e-6, rel=0.15)
    assert 0.85 / edge < 2 * np.pi * pole <= 1 / edge * (1 + 1e-9)
    refusal(0.85 * edge)
    refusal(0.0, resistance=0.85 * resistance)


def test_steps_are_taken_where_they_hold_the_limit():
    """At most 3.1 V a step, into the resistance of skin and body; the smooth samples take 2 uA."""
    assert 1e-3 < played(None, limits={"voltage": 500, "current": 1.0}).value("peak current") < 3.2e-3


def test_no_filter_is_named_where_the_samples_themselves_exceed_a_limit():
    assert len(refusal(None, limits={"voltage": 500, "current": 1e-7})) == 1
    assert all("filter" not in each for each in refusal(1e-5, limits={"voltage": 99, "current": 1.0}))


def test_a_resistor_is_not_named_where_the_stray_capacitance_takes_the_current():
    stray = SCENARIO.replace({"circuit.amplifier": {"stray_capacitance": 1e-9}})
    remedy = refusal(1e-8, scenario=stray)[-1]
    assert "filter in front of the plate" in remedy
    assert "resistor" not in remedy
