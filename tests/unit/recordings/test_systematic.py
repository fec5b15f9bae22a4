"""Systematic errors of estimates by the calibration of the signals, compared with fits of changed data."""

import numpy as np
import pytest
from twins import GAP, LEAK, exact, noisy, plate

import electrovib as ev
from electrovib.core.errors import InputError
from electrovib.recordings.fit import CalibrationError, MeasuredTrace, fit_scenario
from electrovib.recordings.fit.result import parameter_table, systematic_deviations

FORCE = "electrostatic_force"
PLATE = plate()
FREE = [GAP, LEAK]


@pytest.fixture(scope="module")
def step():
    return noisy(exact(PLATE, "step"), np.random.default_rng(1), noise=0.003)


def changed(trace, *, gain=0.0, zero=0.0):
    found = trace.copy(deep=True)
    found[FORCE].values[:] = found[FORCE].values * (1 + gain) + zero
    return found


def fitted(trace, error=None, **more):
    given = {} if error is None else {"calibration": {FORCE: error}}
    return fit_scenario(PLATE, MeasuredTrace(trace=trace, **given, **more), free=FREE)


@pytest.mark.parametrize("error", [{"gain": 1e-3}, {"zero": 1e-6}])
def test_it_is_the_change_of_a_fit_to_changed_data(step, error):
    plain, moved = fitted(step, CalibrationError(**error)), fitted(changed(step, **error))
    found = systematic_deviations(plain)
    for name in FREE:
        change = abs(moved.estimate.values[name] - plain.estimate.values[name])
        assert found[name] == pytest.approx(change, rel=0.02)
    row = parameter_table(plain)[0]
    assert row.systematic == found[GAP]
    assert row.systematic_ends[1] - row.value == pytest.approx(1.96 * found[GAP], rel=1e-3)


def test_gain_and_zero_combine_with_their_covariance(step):
    gain, zero = {"gain": 1e-3}, {"zero": 1e-6}
    one, other, both, opposed = (
        systematic_deviations(fitted(step, CalibrationError(**each)))[GAP]
        for each in (gain, zero, gain | zero, gain | zero | {"covariance": -1e-9})
    )
    assert both == pytest.approx(np.hypot(one, other), rel=1e-6)
    assert opposed == pytest.approx(abs(one - other), rel=1e-6)


def test_an_unknown_zero_takes_the_zero_error_up(step):
    found = systematic_deviations(fitted(step, CalibrationError(zero=1e-6), offsets=[FORCE]))
    plain = systematic_deviations(fitted(step, CalibrationError(zero=1e-6)))
    assert found[GAP] < 1e-6 * plain[GAP]


def test_recordings_and_sessions_share_the_error_of_a_sensor(step):
    error = CalibrationError(gain=0.01)
    alone = systematic_deviations(fitted(step, error))[LEAK]
    data = [MeasuredTrace(trace=step, name=name, session=name, calibration={FORCE: error}) for name in "abc"]
    together = systematic_deviations(fit_scenario(PLATE, data, free=FREE, varying=[LEAK]))
    assert together[LEAK] == pytest.approx(alone, rel=1e-3)  # of the mean: it does not average out
    assert together[f"{LEAK} [a]"] == pytest.approx(alone, rel=1e-3)
    different = [
        MeasuredTrace(trace=step, name=name, calibration={FORCE: CalibrationError(gain=gain)})
        for name, gain in (("a", 0.01), ("b", 0.0100001))
    ]
    two = systematic_deviations(fit_scenario(PLATE, different, free=FREE))
    assert two[LEAK] == pytest.approx(alone / np.sqrt(2), rel=1e-3)  # two sensors are independent


def test_it_is_unknown_without_a_statement(step):
    found = fitted(step)
    assert systematic_deviations(found) == {}
    assert np.isnan(parameter_table(found)[0].systematic)
    with pytest.raises(InputError, match="0 or more"):
        CalibrationError(gain=-0.1)
    with pytest.raises(InputError, match="product of both"):
        CalibrationError(gain=0.1, zero=1.0, covariance=0.2)


def test_an_imported_calibration_line_states_it(tmp_path):
    """Readings of 0 to 1 V with 1 mV of noise, and a line of 4.5 N/V that passes 0.2 N at 0 V."""
    rng = np.random.default_rng(2)
    reading = np.linspace(0, 1, 9)
    line = ev.calibrate(reading, 0.2 + 4.5 * reading + 0.01 * rng.normal(size=9))
    (tmp_path / "a.csv").write_text("t (s),Ch1 (V)\n0,0.1\n0.1,0.2\n0.2,0.4\n")
    trace = ev.import_file(
        tmp_path / "a.csv", {"lateral_force_measured": "Ch1"}, scale={"lateral_force_measured": line}
    )
    error = MeasuredTrace(trace=trace).calibration_of("lateral_force_measured")
    for at in (0.1, 0.4):
        value = line.value(at)
        variance = error.zero**2 + (error.gain * value) ** 2 + 2 * error.covariance * value
        assert np.sqrt(variance) == pytest.approx(line.standard_uncertainty(at), rel=1e-9)
    ev.save(trace, tmp_path / "a.nc")
    again = MeasuredTrace(trace=ev.open_trace(tmp_path / "a.nc"))
    assert again.calibration_of("lateral_force_measured") == error
