"""What given derivatives determine."""

import math

import numpy as np
import pytest

from electrovib.recordings.fit.identifiability import identifiability

GRID = np.linspace(0, 1, 50)


def test_states_by_the_deviation_of_the_logarithm():
    # derivatives after a, b and c of orthogonal residuals; standard deviations 0.05, 0.5 and 5 of values 1
    found = identifiability(np.diag([20.0, 2.0, 0.2]), {"a": 1.0, "b": 1.0, "c": 1.0})
    assert found.states == {"a": "well", "b": "weakly", "c": "not"}
    assert np.sqrt(np.diag(found.covariance)) == pytest.approx([0.05, 0.5, math.inf])
    assert found.undetermined[0].deviation == pytest.approx(5.0)
    assert "the standard deviation 5," in found.undetermined[0].sentence


def test_the_scale_of_a_parameter_does_not_count():
    found = identifiability(np.diag([20e9, 2e-9]), {"a": 1e-9, "b": 1e9})
    assert found.states == {"a": "well", "b": "weakly"}


def test_only_a_product_is_determined():
    slope = 1e3 * np.column_stack([GRID / 2.0, GRID / 5.0, GRID**2])  # of a * b and of c
    found = identifiability(slope, {"a": 2.0, "b": 5.0, "c": 1.0})
    assert found.states == {"a": "not", "b": "not", "c": "well"}
    (worst,) = found.undetermined
    assert math.isinf(worst.deviation)
    assert sorted(worst.exponents.values()) == pytest.approx([-1.0, 1.0])
    assert worst.sentence.endswith("they determine a * b only") or worst.sentence.endswith("b * a only")
    assert np.isfinite(found.covariance[2, 2])


def test_powers_of_a_product_are_named():
    slope = 1e3 * np.column_stack([2 * GRID, GRID])  # of a^2 b
    found = identifiability(slope, {"a": 1.0, "b": 1.0})
    assert "a * b^0.5 only" in found.undetermined[0].sentence


def test_three_that_belong_together_ask_for_one_to_be_fixed():
    slope = 1e3 * np.column_stack([GRID, GRID**2, GRID + GRID**2])
    found = identifiability(slope, dict.fromkeys("abc", 1.0))
    assert "fix one of" in found.undetermined[0].sentence
    assert set(found.states.values()) == {"not"}


def test_a_zero_takes_information_and_is_lost_with_what_it_takes_it_from():
    slope = np.column_stack([100 * (1 + 1e-3 * GRID), np.ones(50)])
    alone = identifiability(slope[:, :1], {"a": 1.0})
    found = identifiability(slope, {"a": 1.0, "zero": 0.0}, zeros=["zero"])
    assert alone.states == {"a": "well"}
    assert found.states == {"a": "not", "zero": "not"}
    assert math.isinf(found.covariance[1, 1])


def test_a_zero_that_is_distinct_from_what_is_lost_is_known():
    # c has a small influence, so that only it is lost; the constant is another shape
    slope = np.column_stack([100 * GRID, 0.1 * GRID**2, np.ones(50)])
    values = {"a": 1.0, "c": 1.0, "zero": 0.0}
    found = identifiability(slope, values, zeros=["zero"])
    assert found.states == {"a": "well", "c": "not", "zero": "well"}
    assert np.sqrt(found.covariance[2, 2]) < 1


@pytest.mark.parametrize(("rise", "state"), [(0.3, "not"), (0.6, "well")])
def test_a_zero_is_lost_where_it_would_be_ten_times_as_uncertain(rise, state):
    """Data that rise by a share r are a constant to the share r/sqrt(12): ten times at r = 0.34, with some influence."""
    shape = 1 + rise * (GRID - 0.5)
    weak = 0.5 / np.linalg.norm(shape - shape.mean())  # the logarithm of a has the standard deviation 2
    found = identifiability(
        np.column_stack([weak * shape, np.ones(50)]), {"a": 1.0, "zero": 0.0}, zeros=["zero"]
    )
    assert found.states == {"a": "not", "zero": state}


def test_a_parameter_without_influence():
    found = identifiability(np.column_stack([GRID * 100, 0 * GRID]), {"a": 1.0, "b": 2.0})
    assert found.states == {"a": "well", "b": "not"}
    assert "the data do not determine b" in found.undetermined[0].sentence
