"""Marches: smooth drives against closed forms and long arithmetic (chirps are in test_transient), and where steps end."""

import mpmath
import numpy as np
import pytest

from electrovib.core.model import read_model
from electrovib.physics.conduction import PolarityConduction
from electrovib.physics.drive.base import Drive
from electrovib.physics.drive.parts import Smooth
from electrovib.physics.drive.sines import Chirp
from electrovib.solve.electrics.formulas import smooth_states
from electrovib.solve.electrics.steps import STEPS, STEPS_PER_PERIOD, halved, jump_heights, step_grid
from electrovib.solve.stack.transfer import Transfer

AMPLITUDE, FIRST, LAST, LENGTH = 100.0, 10.0, 800.0, 0.1
(CHIRP,) = read_model(Chirp, {"amplitude": AMPLITUDE, "first": FIRST, "last": LAST, "length": LENGTH}).parts()
RATES = np.array([0.1, 30.0, 2e3, 5e4, 1e8])
PRECISION = 1e-9  # demanded, of the amplitude; measured 3e-12


def test_times_asked_for_do_not_matter_and_modes_fade_after_the_end():
    few = np.array([0.013, 0.061, 0.087, LENGTH, LENGTH + 1e-4, LENGTH + 1e-2])
    many = np.union1d(np.linspace(0, 0.12, 3001), few)
    found = smooth_states(CHIRP, RATES, many)[:, np.searchsorted(many, few)]
    alone = smooth_states(CHIRP, RATES, few)
    assert np.max(np.abs(found - alone)) < PRECISION * AMPLITUDE
    fading = alone[:3, 3:4] * np.exp(-np.outer(RATES[:3], few[3:] - LENGTH))
    assert np.max(np.abs(alone[:3, 3:] - fading)) < 1e-13 * AMPLITUDE
    late = smooth_states(CHIRP, RATES, np.array([0.08]))
    alone = smooth_states(CHIRP, RATES, np.array([0.0, 0.08]))[:, 1:]
    assert np.max(np.abs(late - alone)) < 1e-12 * AMPLITUDE
    assert np.all(smooth_states(CHIRP, RATES, np.array([0.0])) == 0)


@pytest.mark.parametrize("z", [1e-12, 1e-3, 1.0, 15.99, 16.01, 1e3, 1e12])
def test_polynomials_are_exact(z):
    """A drive that is a polynomial of the sixth degree, in one step of any length against the decay."""
    rate = z
    part = Smooth(lambda t: (t - 0.3) ** 6 + t, lambda t: 6 * (t - 0.3) ** 5 + 1, 0.0, 1.0, 1e-3)
    found = smooth_states(part, np.array([rate]), np.array([1.0]))[0, 0]
    with mpmath.workdps(40):
        decay = mpmath.mpf(rate)
        pieces = [0, *sorted({max(0, 1 - k / decay) for k in (100, 30, 10, 3, 1)}), 1]
        expected = mpmath.quad(
            lambda u: decay * mpmath.exp(-decay * (1 - u)) * ((u - mpmath.mpf(0.3)) ** 6 + u), pieces
        )
    assert found == pytest.approx(float(expected), rel=1e-11)


def test_switched_on_later_and_off_before_the_last_output():
    part = Smooth(np.ones_like, np.zeros_like, 0.3, 0.6, 1.0)
    time = np.array([0.1, 0.3, 0.45, 0.6, 1.0])
    found = smooth_states(part, np.array([2.0]), time)[0]
    on = -np.expm1(-2 * np.clip(time - 0.3, 0, 0.3))
    expected = on * np.exp(-2 * np.maximum(time - 0.6, 0))
    assert found == pytest.approx(expected, abs=1e-12)


def test_a_long_march_goes_on_where_a_stretch_ends():
    """50 cycles make 1047 steps; 400 cycles of the same sine 8378, more than are held at once."""
    rates, period, times = np.array([3.0, 200.0, 1e5]), 1e-3, np.linspace(0, 0.4, 161)
    angular = 2 * np.pi / period

    def slope(time):
        return angular * np.cos(angular * time)

    sine = Smooth(lambda time: np.sin(angular * time), slope, 0.0, 1.0, 1 / period)
    response = rates[:, None] / (rates[:, None] + 1j * angular)
    closed = np.imag(response * np.exp(1j * angular * times))
    closed -= np.imag(response) * np.exp(-rates[:, None] * times)
    assert smooth_states(sine, rates, times) == pytest.approx(closed, abs=PRECISION)


DRIVEN = Transfer(rates=np.array([1e7, 50.0]), gains=np.array([1e4, -5e3]))
LEAKING = Transfer(rates=np.array([1e7, 50.0]), gains=np.array([-1e3, -1e5]))
LEAK = PolarityConduction(conductivity_positive=3e-6, conductivity_negative=1e-6)
SQUARE = {"model": "Square", "high": 10, "low": -10, "frequency": 300}
SUM = [SQUARE | {"high": 1, "low": 0, "frequency": 200}, {"model": "Step", "level": -1}]
DRIVES = {
    "trapezium": {"model": "Trapezium", "high": 10, "rise": 0, "hold": 2e-3, "fall": 1e-3, "delay": 1e-3},
    "square": SQUARE,
    "ramped": SQUARE | {"edge": 1e-4},
    "burst": {"model": "Burst", "amplitude": 10, "frequency": 2e3, "cycles": 4, "delay": 1e-3},
    "sum": {"model": "Sum", "drives": SUM},
    "sine": {"model": "Sine", "amplitude": 10, "frequency": 1e3},
    "chirp": {"model": "Chirp", "amplitude": 10, "first": 100, "last": 3e3, "length": 5e-3},
}
TIME = np.linspace(0, 8e-3, 101)


def grid_of(name, time=TIME):
    drive = read_model(Drive, DRIVES[name])
    return drive, step_grid(drive, time, DRIVEN, LEAKING, leak=LEAK)


@pytest.mark.parametrize("name", DRIVES)
def test_outputs_and_breaks_end_a_step_and_jumps_have_their_height(name):
    drive, grid = grid_of(name)
    assert grid[0] == 0
    assert grid[-1] == TIME[-1]
    assert np.all(np.diff(grid) > 0)
    assert np.all((grid[:-1] + grid[1:]) / 2 > grid[:-1])  # every step can be halved
    missed = np.min(np.abs(TIME[:, None] - grid), axis=1)
    assert np.all(missed <= 1e-13 * TIME)
    assert len(grid) > STEPS
    found = np.where(grid > 0, drive.voltage(grid) - drive.voltage(grid - 1e-10), 0.0)
    steepest = np.max(np.abs(drive.slope(grid)))
    np.testing.assert_allclose(jump_heights(drive, grid), found, rtol=0, atol=3e-10 * steepest + 1e-12)


@pytest.mark.parametrize("name", ["trapezium", "square"])
def test_steps_are_fine_after_a_jump(name):
    drive, grid = grid_of(name)
    heights = jump_heights(drive, grid)
    for place in np.flatnonzero(heights)[:-1]:
        assert grid[place + 1] - grid[place] < 0.02 / 1e7  # the fastest rate
        grown = grid[place : place + 40]
        assert np.all(np.diff(grown, 2) > -1e-15)
    if name == "trapezium":
        assert grid[heights != 0] == pytest.approx([1e-3])
        assert heights[heights != 0] == [10.0]


def test_oscillations_are_followed_and_a_single_instant_has_no_step():
    _, grid = grid_of("sine", np.array([0.0, 0.1]))
    assert np.max(np.diff(grid)) < 1.01e-3 / STEPS_PER_PERIOD
    np.testing.assert_array_equal(grid_of("sine", np.zeros(1))[1], [0.0])


@pytest.mark.parametrize("order", [2, 3])
def test_the_error_of_halved_steps_is_that_of_the_finer_ones(order):
    def march(grid):
        return np.full(len(grid), 1 + (grid[1] - grid[0]) ** order)

    grid, fine, coarse, error = halved(np.linspace(0, 1, 5), march, np.asarray, order=order, tolerance=2e-3)
    assert (len(grid), len(fine)) == (2 * len(coarse) - 1, 2 * len(coarse) - 1)
    assert error * fine[0] == pytest.approx(fine[0] - 1, rel=1e-9)
    assert error < 2e-3 < 2**order * error
