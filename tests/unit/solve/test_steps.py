"""Steps of a march: every output and every break ends one, and they are fine after a jump."""

import numpy as np
import pytest

from electrovib.core.model import read_model
from electrovib.physics.conduction import PolarityConduction
from electrovib.physics.drive.base import Drive
from electrovib.solve.electrics.steps import STEPS, STEPS_PER_PERIOD, halved, jump_heights, step_grid
from electrovib.solve.stack.transfer import Transfer

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
