"""A measurement beside a prediction."""

import numpy as np
import pytest

from electrovib.core.trace import make_trace
from electrovib.recordings.importing.beside import residuals

TIME = np.linspace(0, 1, 101)
STATED = {"file_sha256": "0"}


def test_residuals_are_measured_less_predicted_where_both_are_known():
    predicted = make_trace({"lateral_force": (("time",), 2 * TIME)}, {"time": TIME}, {})
    at = np.array([-0.5, 0.255, 0.5, 0.75, 1.5])
    measured = make_trace(
        {"lateral_force_measured": (("time",), 2 * at + np.array([0, 0.3, -0.1, np.nan, 0]))},
        {"time": at},
        STATED,
    )
    (found,) = residuals(predicted, measured)
    np.testing.assert_allclose(found.axis, [0.255, 0.5])
    np.testing.assert_allclose(found.residual, [0.3, -0.1])
    assert found.rms == pytest.approx(np.sqrt(0.05))
    assert found.mean == pytest.approx(0.1)
    assert found.relative_rms == pytest.approx(np.sqrt(0.05) / np.sqrt((0.81**2 + 0.9**2) / 2))
    assert (found.name, found.predicted_name) == ("lateral_force_measured", "lateral_force")


def test_a_sensor_that_is_modelled_is_preferred():
    signals = {"lateral_force": (("time",), TIME), "lateral_force_measured": (("time",), 0.5 * TIME)}
    predicted = make_trace(signals, {"time": TIME}, {})
    measured = make_trace({"lateral_force_measured": (("time",), TIME)}, {"time": TIME}, STATED)
    assert residuals(predicted, measured)[0].predicted_name == "lateral_force_measured"


def test_impedances_are_compared_as_complex_numbers():
    grid = np.array([10.0, 100, 1000])
    predicted = make_trace({"impedance": (("frequency",), 1 + 1j * grid)}, {"frequency": grid}, {})
    measured = make_trace(
        {"impedance": (("frequency",), 1 + 1j * grid + 3 + 4j)}, {"frequency": grid}, STATED
    )
    (found,) = residuals(predicted, measured)
    np.testing.assert_allclose(found.residual, 3 + 4j)
    assert found.rms == pytest.approx(5)


def test_nothing_in_common_is_no_residual():
    predicted = make_trace({"lateral_force": (("time",), TIME)}, {"time": TIME}, {})
    later = make_trace({"lateral_force": (("time",), TIME)}, {"time": TIME + 5}, STATED)
    other = make_trace({"drive_voltage": (("time",), TIME)}, {"time": TIME}, STATED)
    assert residuals(predicted, later) == residuals(predicted, other) == []
