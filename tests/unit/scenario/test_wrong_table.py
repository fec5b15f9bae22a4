"""A table of another kind is one sentence a reason, not one a name; seeds are checked at every door."""

from __future__ import annotations

import pytest

import electrovib as ev
from electrovib.core.errors import InputError
from electrovib.scenario.space import read_space
from electrovib.study.check.declared import limits_from

SCENARIO = ev.load("vezzoli_2014/fig6_gap")


def test_a_scenario_in_place_of_limits_is_one_sentence():
    with pytest.raises(InputError) as found:
        limits_from({name: {} for name in ("drive", "force", "stack", "load", "circuit")})
    (only,) = found.value.problems
    assert only.startswith(
        "limits: unknown parameters 'drive', 'force', 'stack', 'load', 'circuit' of Limits. Known: "
    )


def test_a_scenario_in_place_of_a_space_is_one_sentence():
    with pytest.raises(InputError) as found:
        read_space(SCENARIO, {"space": {}, "drive": {}, "force": {}, "circuit": {}})
    assert "drive, force, circuit: unknown part of a space. Known: " in str(found.value)


def test_what_a_table_lacks_is_one_sentence():
    with pytest.raises(InputError) as found:
        ev.load({"title": "nothing"})
    assert found.value.problems == (
        "missing: 'drive', 'force', 'friction', 'contact', 'load', 'circuit', 'stack' of Scenario",
    )


def test_a_bench_refuses_a_seed_below_zero():
    with pytest.raises(InputError, match="seed = -1: expected a whole number from 0"):
        ev.run_bench(SCENARIO, simulate=True, seed=-1)
