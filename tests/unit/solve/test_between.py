"""A costly force as cubics between its corners."""

import numpy as np
import pytest

from electrovib.solve.mechanics.between import Between, Cubics


def kinked(time):
    """A jump of 1 at 0.3, a kink at 0.5, smooth elsewhere."""
    return np.sin(7 * time) + (time >= 0.3) + 2 * np.maximum(time - 0.5, 0)


def test_it_is_the_force_to_its_stated_error():
    between, time = Between(kinked, np.array([0.0, 1.0]), np.array([0.3, 0.5])), np.linspace(0, 1, 7919)
    off = np.abs(between(time) - kinked(time))[np.abs(time - 0.3) > 2e-9]
    assert np.max(off) < 2e-8  # the value 1e-9 s before a corner stands for that just before it
    assert between.error() < 1e-8
    assert between(0.3) == pytest.approx(kinked(np.array(0.3)), abs=1e-9)
    assert between(0.3 - 1e-6) == pytest.approx(kinked(np.array(0.3 - 1e-6)), abs=1e-8)
    assert isinstance(between(0.25), float)
    # a corner that is not named is seen in the error
    assert Between(kinked, np.array([0.0, 1.0]), np.array([]), once=True).error() > 1e-3


@pytest.mark.parametrize("count", [401, 334, 1201])
def test_an_output_time_that_is_an_even_time_but_for_rounding_gives_no_slope_of_rounding(count):
    times = np.linspace(0.0, 0.02, count)
    between = Between(lambda time: np.sin(754 * time) ** 2, times, np.array([]))
    beside = (times[1:-1] + np.array([[-1e-8], [1e-8]])).ravel()
    np.testing.assert_allclose(between(beside), np.sin(754 * beside) ** 2, rtol=0, atol=2e-8)
    assert np.max(np.abs(between.pieces.slopes)) < 754 * (1 + 1e-3)


def test_a_cubic_is_its_own_interpolation():
    knots, time = np.array([0.0, 0.3, 1.0]), np.linspace(0, 0.999, 50)
    pieces = Cubics(knots, 2 * knots**3 - knots**2 + 1, 6 * knots**2 - 2 * knots)
    found = pieces.at(np.searchsorted(knots, time, side="right") - 1, time)
    np.testing.assert_allclose(found, 2 * time**3 - time**2 + 1, rtol=1e-14)


def test_it_asks_once():
    asked = []
    between = Between(
        lambda time: asked.append(1) or np.cos(time), np.linspace(0, 2, 11), np.array([0.7]), once=True
    )
    between(np.linspace(0, 2, 100))
    between.error()
    assert len(asked) == 1


def test_pulses_shorter_than_a_billionth_of_the_whole_time():
    """Falling within each pulse of 1 us, from 2 to 1, over 1000 s."""
    begins = np.array([100.0, 500.0, 900.0])

    def pulses(time):
        since = np.asarray(time)[..., np.newaxis] - begins
        return np.sum(np.where((since >= 0) & (since < 1e-6 - 1e-12), 2 - since / 1e-6, 0.0), axis=-1)

    between = Between(pulses, np.array([0.0, 1000.0]), np.concatenate([begins, begins + 1e-6]))
    for share in (0.0, 0.25, 0.9):
        assert between(begins + share * 1e-6) == pytest.approx(2 - share, abs=1e-4)
    for beside in (-1e-6, 2e-6):
        assert between(begins + beside) == pytest.approx(0.0, abs=1e-12)
