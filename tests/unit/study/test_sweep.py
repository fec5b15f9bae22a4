"""Sweeps: one dimension for each parameter."""

from __future__ import annotations

import json

import numpy as np
import pytest

from electrovib.core.errors import InputError
from electrovib.solve.scenario import load, scenario_of
from electrovib.solve.simulate import simulate
from electrovib.study.sweep import parse_over, sweep

SCENARIO = load("vezzoli_2014/fig6")


def test_each_point_of_a_sweep_is_the_simulation_at_that_point():
    trace = sweep(
        SCENARIO, {"drive.high": [100.0, 1000.0], "stack.insulator.thickness": [10e-6, 90e-6, 100e-6]}
    )
    assert trace.electrostatic_force.dims == ("drive.high", "stack.insulator.thickness", "time")
    alone = simulate(SCENARIO.replace({"drive.high": 100.0, "stack.insulator.thickness": 10e-6}))
    np.testing.assert_array_equal(trace.electrostatic_force[0, 0], alone.electrostatic_force)
    assert trace["stack.insulator.thickness"].attrs["units"] == "m"


def test_force_goes_as_the_square_of_the_voltage():
    trace = sweep(SCENARIO, {"drive.high": np.linspace(100, 1000, 4)})
    peak = trace.electrostatic_force.max("time").values
    np.testing.assert_allclose(peak / peak[0], np.linspace(1, 10, 4) ** 2, rtol=1e-12)


def test_a_swept_time_of_the_drive_shares_the_longest_grid():
    trace = sweep(SCENARIO, {"drive.rise": [1e-3, 100e-3]})
    assert float(trace.time[-1]) == pytest.approx(0.1 + 0.2 + 0.036)


def test_a_swept_trace_carries_scenario_and_axes():
    trace = sweep(SCENARIO, {"drive.high": [100.0, 200.0]})
    assert scenario_of(trace) == SCENARIO
    assert json.loads(trace.attrs["over"]) == {"drive.high": [100.0, 200.0]}


def test_lamps_of_a_sweep_are_the_worst():
    def state(trace):
        return {lamp["name"]: lamp["state"] for lamp in json.loads(trace.attrs["lamps"])}["electrowetting"]

    assert state(sweep(SCENARIO, {"drive.high": [100.0, 200.0]})) == "ok"
    assert state(sweep(SCENARIO, {"drive.high": [100.0, 1000.0]})) == "warning"


def test_ranges_are_read_with_units():
    found = parse_over(SCENARIO, ["drive.rise=1ms:100ms:3log", "drive.high=0:1 kV:5"])
    np.testing.assert_allclose(found["drive.rise"], [1e-3, 1e-2, 1e-1], rtol=1e-12)
    np.testing.assert_allclose(found["drive.high"], [0, 250, 500, 750, 1000])


def test_all_wrong_ranges_are_told_at_once():
    with pytest.raises(InputError) as error:
        parse_over(
            SCENARIO,
            ["drive.rise=1ms:2ms", "drive.rize=1ms:2ms:3", "drive.high=1 m:2 m:3", "time.duration=1:2:3"],
        )
    assert len(error.value.problems) == 4


def test_a_value_out_of_range_is_refused():
    with pytest.raises(InputError, match=r"stack\.insulator\.thickness"):
        sweep(SCENARIO, {"stack.insulator.thickness": [-1e-6, 1e-6]})


def test_progress_counts():
    seen = []
    sweep(SCENARIO, {"drive.high": [1.0, 2.0, 3.0]}, progress=lambda done, total: seen.append((done, total)))
    assert seen == [(0, 3), (1, 3), (2, 3)]
