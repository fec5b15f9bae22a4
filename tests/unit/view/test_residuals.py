"""A measurement stands beside a prediction, with what is left."""

import numpy as np
import pytest

from electrovib.core.signals import make_trace
from electrovib.view.report import compare, rms

TIME = np.linspace(0, 1, 101)


def of(axis, **signals):
    """A Trace over time, or over frequency if it is an impedance."""
    dimension = "frequency" if "impedance" in signals else "time"
    return make_trace(
        {name: ((dimension,), values) for name, values in signals.items()}, {dimension: axis}, {}
    )


def residuals(predicted, measured):
    found = compare({"model": predicted, "record": measured.assign_attrs(file_sha256="0")})
    assert all((each.measurement, each.prediction) == ("record", "model") for each in found)
    return found


def test_residuals_are_measured_less_predicted_where_both_are_known():
    at = np.array([-0.5, 0.255, 0.5, 0.75, 1.5])
    measured = of(at, lateral_force_measured=2 * at + np.array([0, 0.3, -0.1, np.nan, 0]))
    (found,) = residuals(of(TIME, lateral_force=2 * TIME), measured)
    np.testing.assert_allclose(found.axis, [0.255, 0.5])
    np.testing.assert_allclose(found.residual, [0.3, -0.1])
    assert rms(found.residual) == pytest.approx(np.sqrt(0.05))
    assert rms(found.measured) == pytest.approx(np.sqrt((0.81**2 + 0.9**2) / 2))
    assert found.mean == pytest.approx(0.1)
    assert found.signal == "lateral force measured (predicted: lateral force)"
    # a sensor that is modelled is preferred
    predicted = of(TIME, lateral_force=TIME, lateral_force_measured=0.5 * TIME)
    assert residuals(predicted, measured)[0].predicted_name == "lateral_force_measured"


def test_impedances_are_compared_as_complex_numbers_and_nothing_in_common_is_no_residual():
    grid = np.array([10.0, 100, 1000])
    (found,) = residuals(of(grid, impedance=1 + 1j * grid), of(grid, impedance=4 + 1j * grid + 4j))
    np.testing.assert_allclose(found.residual, 3 + 4j)
    assert rms(found.residual) == pytest.approx(5)
    predicted = of(TIME, lateral_force=TIME)
    assert residuals(predicted, of(TIME + 5, lateral_force=TIME)) == []
    assert residuals(predicted, of(TIME, drive_voltage=TIME)) == []
    assert compare({"model": predicted, "other": predicted}) == []
