"""A periodic state that takes hours to reach is marked, and others are not."""

from __future__ import annotations

import pytest

import electrovib as ev
from electrovib.core.constants import eps0
from electrovib.solve.diagnostics.assumptions import settled_charge

CONDUCTIVITY = "stack.insulator.material.conductivity"


@pytest.fixture(scope="module")
def offset():
    """A sine of 100 V on 200 V over a film of permittivity 3.35, in the periodic state."""
    return ev.load("kang_2017/offset")


def test_a_film_that_relaxes_in_hours_is_marked(offset):
    (found,) = settled_charge(offset.replace({CONDUCTIVITY: 1e-14}))
    assert (found.state, found.value) == ("warning", pytest.approx(3.35 * eps0 / 1e-14, rel=1e-9))
    assert "the mean of 200 V has been held" in found.text
    assert "stack.insulator.material.conductivity = 0" in found.text


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {CONDUCTIVITY: 1e-12},  # 30 s
        {CONDUCTIVITY: 1e-14, "time.initial_state.model": "AtRest"},
        {CONDUCTIVITY: 1e-14, "drive.level": 0.0},
        {CONDUCTIVITY: 0.0, "stack.gap.material.conductivity": 1e-14},
    ],
)
def test_others_are_not(offset, changes):
    assert settled_charge(offset.replace(changes)) == []


@pytest.mark.parametrize(("conductivity", "count"), [(2.9e-13, 1), (3.0e-13, 0)])
def test_the_limit_is_a_hundred_seconds(offset, conductivity, count):
    assert len(settled_charge(offset.replace({CONDUCTIVITY: conductivity}))) == count


def test_a_held_voltage_counts_as_its_mean(offset):
    held = {"drive": {"model": "Step", "level": -50.0}, CONDUCTIVITY: 1e-14}
    assert "the mean of -50 V" in settled_charge(offset.replace(held))[0].text


def test_a_run_and_a_comparison_carry_it(offset):
    trace = ev.simulate(offset.replace({"stack.insulator.material": "silica"}))
    assert "settled charge" in trace.attrs["validity"]
    found = ev.compare_materials(offset, materials=["silica", "pet"])
    assert {entry.name: bool(entry.caution) for entry in found.entries} == {
        "as it is": False,
        "silica": True,
        "pet": False,
    }
    assert found.tables[1].title == "The attraction is reached only after a long time"
