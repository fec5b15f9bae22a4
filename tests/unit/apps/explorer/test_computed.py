"""What the page computes is what the library returns."""

from __future__ import annotations

import numpy as np
import pytest
import xarray

import electrovib as ev
from electrovib.apps.explorer.computed import compute
from electrovib.core.diagnostics import read_diagnostics


@pytest.mark.parametrize("preset", ["vezzoli_2014/fig6_gap", "vardar_2017/sine"])
def test_a_trace_is_made_as_simulate_returns_it(preset):
    scenario = ev.load(preset)
    found, expected = compute(scenario), ev.simulate(scenario)
    xarray.testing.assert_identical(found.trace, expected)
    assert found.diagnostics == read_diagnostics(expected.attrs["validity"])
    for name in map(str, expected.variables):
        assert np.array_equal(
            found.values(name), expected[name].values, equal_nan=expected[name].dtype.kind in "fc"
        )
        if name in expected.data_vars:
            assert found.has(name)
            assert found.dimensions(name) == expected[name].dims
    assert not found.has("voltage_of_nothing")
