"""Every shipped scenario is asked which drive gives 0.64 times its own force, and the answer is put back."""

from __future__ import annotations

import pytest

import electrovib as ev
from electrovib.core.discovery import offers, paper_names
from electrovib.core.errors import InputError
from electrovib.core.paths import quantity_at, value_at
from electrovib.study.design import parameter

NAMES = [name for paper in paper_names() for name in offers(("scenarios",), of=paper)]
MEAN = "mean electrostatic_force"
DRIVEN_BY = ("drive.amplitude", "drive.level", "drive.high", "drive.drives.0.high")


def free_of(scenario):
    """The first of these paths that the scenario has."""
    for path in DRIVEN_BY:
        try:
            quantity_at(scenario, path)
        except InputError:
            continue
        return path
    raise AssertionError


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_the_value_that_is_found_gives_what_is_wanted(name, monkeypatch):
    scenario = ev.load(name)
    if parameter.is_long(scenario):  # elasticities take most of the time, and are the same code for all
        monkeypatch.setattr(parameter, "inputs_of", lambda *_: ())
    free = free_of(scenario)
    begin = value_at(scenario, free)
    prepared = ev.prepare(scenario, free=[free], quantities=[MEAN])
    wanted = prepared([0.8 * begin])[MEAN]
    ends = sorted([0.3 * begin, 1.5 * begin])
    found = ev.design(scenario, want={MEAN: wanted}, free=free, between=ends)
    assert found.solutions
    assert any(each.value == pytest.approx(0.8 * begin, rel=1e-6) for each in found.solutions)
    for each in found.solutions:
        back = ev.sweep(scenario.replace({free: each.value}), {}, quantities=[MEAN])
        assert back[MEAN].item() == pytest.approx(wanted, rel=1e-6)


def test_there_are_presets():
    assert len(NAMES) > 35
