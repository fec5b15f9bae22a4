"""Modes under straight pieces at very many times: as at few times and by hand, with a jump at the last of them."""

import numpy as np
import pytest

import electrovib as ev
from electrovib.core.model import read_model
from electrovib.physics.drive.base import Drive
from electrovib.physics.drive.parts import Linear
from electrovib.solve.electrics.straight import MANY_SAMPLES, SharedModes

LOW, HIGH, PERIOD = -50.0, 100.0, 1e-2
SQUARE = {"model": "Square", "low": LOW, "high": HIGH, "frequency": 1 / PERIOD}
RATES = np.array([30.0, 2e3, 5e6])
GAINS = np.array([[0.3, -0.2, 0.4], [0.3, -0.2, 0.4]])
DIRECT = np.array([0.7, 0.7])
MANY = np.linspace(0.0, 10 * PERIOD, 2 * MANY_SAMPLES + 1)


@pytest.mark.parametrize("state", [np.zeros(3), None], ids=["rest", "periodic"])
def test_every_kind_of_output_follows_the_jump_as_the_closed_form_does(state):
    """One output sums the states of the modes, the other how far they lag behind the drive."""
    (part,) = read_model(Drive, SQUARE).parts()
    modes = SharedModes(rates=RATES, gains=GAINS, direct=DIRECT, lag=np.array([False, True]))
    many, few = (np.array(modes.straight(part, time, state)) for time in (MANY, MANY[-200:]))
    np.testing.assert_allclose(many[:, -200:], few, rtol=1e-9)
    jumped = many[:, -1] - many[:, -2]
    expected = [DIRECT[0] * (HIGH - LOW), (DIRECT[1] - GAINS[0].sum()) * (HIGH - LOW)]
    assert jumped == pytest.approx(expected, rel=1e-3)


def test_the_current_after_the_jump_is_the_step_over_the_series_resistance():
    changes = {"drive": SQUARE, "time.duration": float(MANY[-1]), "time.samples": len(MANY)}
    trace = ev.simulate(ev.load("vezzoli_2014/fig6", changes=changes))
    current = trace.current.values
    resistance = ev.load("vezzoli_2014/fig6").circuit.return_path.resistance
    assert current[-1] == pytest.approx((HIGH - LOW) / resistance, rel=1e-6)
    assert abs(current[-2]) < 1e-6 * current[-1]
    assert trace.drive_voltage.values[-2:].tolist() == [LOW, HIGH]


@pytest.mark.parametrize("state", [np.zeros(3), None], ids=["rest", "periodic"])
@pytest.mark.parametrize("edge", [0.3, 1e-3, 1e-5], ids=str)
@pytest.mark.parametrize("rates", [[3.0, 2e3, 5e6], [1e-9, 2e3, 4e4]], ids=str)
def test_one_exponential_of_each_mode_is_each_time_by_itself(rates, edge, state):
    """To rounding, for fast and for slow modes, for gentle and for steep pieces, of the modes and of their lags."""
    bent = np.array([0.0, edge * PERIOD, PERIOD])
    part = Linear(bent, np.array([0.0, HIGH, LOW]), np.array([LOW, HIGH, LOW]), PERIOD)
    modes = SharedModes(np.array(rates), GAINS, DIRECT, np.array([False, True]))
    many = np.sort(np.random.default_rng(1).uniform(0, 3 * PERIOD, 9001))
    whole = np.array(modes.straight(part, many, state))
    for first in (0, 4000, 8990):
        few = np.array(modes.straight(part, many[first : first + 11], state))
        scale = np.abs(whole).max(axis=1, keepdims=True)
        assert np.max(np.abs(whole[:, first : first + 11] - few) / scale) < 1e-12
