"""Calibration lines with their covariance."""

import numpy as np
import pytest

import electrovib as ev
from electrovib.core.errors import InputError


def test_a_line_has_the_covariance_of_linear_regression():
    reading = np.array([0.0, 1, 2, 4])
    known = np.array([0.5, 1.6, 2.4, 4.6])
    found = ev.calibrate(reading, known)
    matrix = np.column_stack([np.ones(4), reading])
    best, residual, *_ = np.linalg.lstsq(matrix, known)
    np.testing.assert_allclose([found.intercept, found.sensitivity], best, rtol=1e-12)
    np.testing.assert_allclose(found.covariance, residual / 2 * np.linalg.inv(matrix.T @ matrix), rtol=1e-10)
    expected = np.sqrt([row @ found.covariance @ row for row in matrix])
    np.testing.assert_allclose(found.standard_uncertainty(reading), expected, rtol=1e-10)


def test_the_uncertainty_covers_the_truth_as_often_as_it_should():
    random = np.random.default_rng(4)
    reading = np.linspace(0, 5, 12)
    off = []
    for _ in range(400):
        line = ev.calibrate(reading, 2 + 3 * reading + random.normal(0, 0.1, 12))
        off.append((line.value(4.0) - 14) / line.standard_uncertainty(4.0))
    assert np.std(off) == pytest.approx(np.sqrt(10 / 8), rel=0.1)  # Student's t with 10 degrees of freedom


def test_a_calibration_is_a_scale(tmp_path):
    (tmp_path / "a.csv").write_text("t [s],u [mV]\n0,0\n1,1000\n2,2000\n", encoding="utf-8")
    line = ev.calibrate([0, 1, 2, 3], [1.0, 3.1, 4.9, 7.0])
    found = ev.import_file(tmp_path / "a.csv", {"normal_force": "u"}, scale={"normal_force": line})
    np.testing.assert_allclose(found["normal_force"], line.value([0, 1, 2]))
    assert "standard uncertainty is at most" in found.attrs["history"]
    with pytest.raises(InputError, match="offset is part of the calibration"):
        ev.import_file(
            tmp_path / "a.csv",
            {"normal_force": "u"},
            scale={"normal_force": line},
            offset={"normal_force": "1 V"},
        )


@pytest.mark.parametrize("pairs", [([0, 1], [0, 1]), ([1, 1, 1], [0, 1, 2]), ([0, 1, np.nan], [0, 1, 2])])
def test_what_determines_no_line_is_refused(pairs):
    with pytest.raises(InputError, match="calibrate: "):
        ev.calibrate(*pairs)
