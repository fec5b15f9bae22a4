"""Calibration lines with their covariance, and what they are for a signal."""

import numpy as np
import pytest

import electrovib as ev
from electrovib.core.errors import InputError
from electrovib.recordings.fit.measured import MeasuredTrace
from electrovib.recordings.recording import CalibrationError


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


FORCE = "lateral_force_measured"
READINGS = 0.1 + 0.4 * np.arange(5) + [2e-3, -1e-3, 1e-3, -3e-3, 1e-3]
LINE = "reading [mV];F [N]\n" + "".join(f"{1e3 * at:.6g};{f}\n" for f, at in enumerate(READINGS))


def calibrated(tmp_path, by=LINE, **options):
    """A record that is calibrated by a file of readings or by a line."""
    if isinstance(by, str):
        (tmp_path / "cal.csv").write_text(by, encoding="utf-8")
        options["calibration"] = {FORCE: tmp_path / "cal.csv"}
    else:
        options["scale"] = {FORCE: by}
    rows = "\n".join(f"{at * 1e-3:.3f},{0.1 + 0.4 * (at % 4):.4f}" for at in range(40))
    (tmp_path / "a.csv").write_text("t [s],u [V]\n" + rows, encoding="utf-8")
    return ev.import_file(tmp_path / "a.csv", {FORCE: "u"}, **options)


def error_of(trace):
    return MeasuredTrace(trace=trace).calibration_of(FORCE)


@pytest.mark.parametrize("by", ["file", "line"])
def test_the_covariance_of_a_calibration_goes_with_the_signal(tmp_path, by):
    line = ev.calibrate(READINGS, np.arange(5.0))
    given = LINE if by == "file" else line
    trace = calibrated(tmp_path, given)
    force, found = trace[FORCE].values, error_of(trace)
    np.testing.assert_allclose(force[:4], line.value(0.1 + 0.4 * np.arange(4)), rtol=1e-9)
    # the variance of each value by zero and scale is that by the line, at every reading
    by_parts = found.zero**2 + 2 * force * found.covariance + (force * found.gain) ** 2
    by_line = line.standard_uncertainty(0.1 + 0.4 * (np.arange(40) % 4)) ** 2
    np.testing.assert_allclose(by_parts, by_line, rtol=1e-9)
    assert found.gain == pytest.approx(np.sqrt(line.covariance[1, 1]) / line.sensitivity)
    assert "standard uncertainty is at most" in trace.attrs["history"]
    ev.save(trace, tmp_path / "a.nc")
    assert error_of(ev.open_trace(tmp_path / "a.nc")) == found
    for option in ({"baseline": {FORCE: "0 s..5 ms"}}, {"detrend": [FORCE]}):
        # and no zero
        assert error_of(calibrated(tmp_path, given, **option)) == CalibrationError(gain=found.gain)
    assert found.zero > 0


ROWS = "0;1\n1;2\n2;3\n"


@pytest.mark.parametrize(
    ("by", "options", "words"),
    [
        ("a [V];b [N];c [V]\n0;1;2\n1;2;3\n2;3;4\n", {}, "two columns, the reading and the known value"),
        ("a;b [N]\n" + ROWS, {}, "column 'a' needs a unit that is known"),
        ("a [V];b [m]\n" + ROWS, {}, "column 'b' needs a unit of N in its heading"),
        ("a [V];b [N]\n0;1\n0;2\n0;3\n", {}, "all readings are equal"),
        ("a [V];b [N]\n" + ROWS, {"scale": {FORCE: "1 N/V"}}, "a scale is given too"),
        (
            ev.calibrate(READINGS, np.arange(5.0)),
            {"offset": {FORCE: "1 V"}},
            "offset is part of the calibration",
        ),
    ],
)
def test_what_is_no_calibration_is_refused(tmp_path, by, options, words):
    with pytest.raises(InputError, match=words):
        calibrated(tmp_path, by, **options)


@pytest.mark.parametrize("pairs", [([0, 1], [0, 1]), ([1, 1, 1], [0, 1, 2]), ([0, 1, np.nan], [0, 1, 2])])
def test_what_determines_no_line_is_refused(pairs):
    with pytest.raises(InputError, match="calibrate: "):
        ev.calibrate(*pairs)
