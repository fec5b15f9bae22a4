"""Signals over frequency."""

from __future__ import annotations

import numpy as np
import pytest

from electrovib.core.errors import InputError
from electrovib.view import plots


def test_frequency_response_is_the_mean_force(trace):
    ax = plots.frequency_response(trace)
    assert np.array_equal(ax.lines[0].get_ydata(), trace.mean_force.values)
    assert np.array_equal(ax.lines[0].get_xdata(), trace.frequency.values)
    assert ax.get_xscale() == "log"
    assert ax.get_ylim()[0] == 0
    assert ax.get_ylim()[1] > trace.mean_force.values.max()
    assert ax.get_xlabel() == "frequency $f$ [Hz]"


def test_a_wide_range_is_logarithmic(trace):
    wide = trace.assign(mean_force=trace.mean_force / trace.frequency)
    assert plots.frequency_response(wide).get_yscale() == "log"


def test_gain_is_that_of_the_effective_voltage_or_of_the_layers(trace, other):
    np.testing.assert_array_equal(
        plots.gain(other).lines[0].get_ydata(), np.abs(other.effective_voltage_gain.values)
    )
    layered = plots.gain(trace)
    assert len(layered.lines) == 3
    np.testing.assert_array_equal(
        layered.lines[1].get_ydata(), np.abs(trace.field_gain.sel(layer="gap").values)
    )


def test_phases_are_in_degrees(trace, other):
    shown = plots.impedance_phase(trace).lines[0].get_ydata()
    # a film blocks: nearly a capacitor in the middle of the band
    assert shown[len(shown) // 2] == pytest.approx(-90, abs=1)
    assert plots.impedance_phase(trace).get_ylabel().endswith("[°]")
    np.testing.assert_array_equal(
        plots.gain_phase(other).lines[0].get_ydata(), np.angle(other.effective_voltage_gain.values, deg=True)
    )


def test_impedance_falls_by_decades(trace):
    ax = plots.impedance(trace)
    assert (ax.get_xscale(), ax.get_yscale()) == ("log", "log")
    assert ax.get_ylabel() == "impedance $|Z|$ [Ω]"
    assert np.array_equal(ax.lines[0].get_ydata(), np.abs(trace.impedance.values))


def test_a_measurement_over_time_has_no_response(measured):
    with pytest.raises(InputError, match="mean_force"):
        plots.frequency_response(measured)
