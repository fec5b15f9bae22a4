"""The closed form of a resonant load cell compared with a numerical integration."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from electrovib.physics.resonance import release_seen_by_sensor


@pytest.mark.parametrize("quality", [0.6, 3.0, 30.0])
@pytest.mark.parametrize("fall_time", [1e-5, 3e-4, 5e-3])
def test_closed_form_solves_its_equation(quality, fall_time):
    time, start, natural = np.linspace(0, 12e-3, 300), 1e-3, 2 * np.pi * 350

    def slope(now, state):
        force = np.exp(-max(now - start, 0) / fall_time)
        return [state[1], natural**2 * (force - state[0]) - natural / quality * state[1]]

    after = time[time >= start]
    solved = solve_ivp(
        slope, (start, after[-1]), [1, 0], t_eval=after, rtol=1e-11, atol=1e-13, method="DOP853"
    )
    found = release_seen_by_sensor(time, start=start, fall_time=fall_time, frequency=350.0, quality=quality)
    # the integrator was asked for 1e-11 a step
    np.testing.assert_allclose(found[time >= start], solved.y[0], atol=1e-9)
    np.testing.assert_array_equal(found[time < start], 1.0)


def test_a_step_overshoots_as_in_a_textbook():
    time = np.linspace(0, 5e-3, 50_001)
    found = release_seen_by_sensor(time, start=0.0, fall_time=1e-9, frequency=350.0, quality=3.0)
    ratio = 1 / 6
    # exp(-pi zeta / sqrt(1 - zeta^2)); a fall in 1 ns moves it by 2e-6
    assert found.min() == pytest.approx(-np.exp(-np.pi * ratio / np.sqrt(1 - ratio**2)), rel=1e-5)
