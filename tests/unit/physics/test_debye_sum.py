"""The Debye sum as a formula and as a checked record."""

from __future__ import annotations

import numpy as np
import pytest

from electrovib.core.errors import InputError
from electrovib.physics.debye_sum import DebyeSum


def test_value_at_the_relaxation_frequency():
    one = DebyeSum(4.0, (10.0,), (1e-3,))
    # At w tau = 1 a relaxation gives half its strength in phase and half in quadrature.
    assert one.permittivity(1 / (2 * np.pi * 1e-3)) == pytest.approx(9 - 5j, rel=1e-14)


def test_limits_and_shape():
    two = DebyeSum(4.0, (10.0, 100.0), (1e-3, 1.0))
    values = two.permittivity([[0.0, 1e12], [1.0, 10.0]])
    assert values.shape == (2, 2)
    assert values[0, 0] == 114
    # At w tau = 6e9 what is left of the fastest loss is 10/6e9 of 4, below 1e-9.
    assert values[0, 1] == pytest.approx(4.0, rel=1e-8)
    assert two.permittivity(1.0).shape == ()


def test_no_term_is_a_constant():
    assert np.array_equal(DebyeSum(3.35).permittivity([1.0, 1e6]), [3.35, 3.35])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((0.0,), "high = 0.0"),
        ((float("inf"),), "high = inf"),
        ((1.0, (1.0,), ()), "1 strengths but 0 relaxation_times"),
        ((1.0, (1.0, -1e-9), (1.0, 1.0)), r"strengths\[1\] = -1e-09"),
        ((1.0, (1.0,), (0.0,)), r"relaxation_times\[0\] = 0.0"),
    ],
)
def test_refuses_what_is_no_dielectric(arguments, message):
    with pytest.raises(InputError, match=message):
        DebyeSum(*arguments)


def test_names_all_problems_at_once():
    with pytest.raises(InputError) as caught:
        DebyeSum(-1.0, (-1.0,), (-1.0,))
    assert len(caught.value.problems) == 3


def test_terms_that_are_columns_give_the_permittivity_of_each_finger():
    columns = np.array([[2.0], [3.0]]), np.array([[9.0], [5.0]]), np.array([[1e-4], [2e-3]])
    frequency = np.geomspace(1.0, 1e6, 7)
    found = DebyeSum(columns[0], (columns[1],), (columns[2],)).permittivity(frequency)
    for row, high, strength, time in zip(found, *(each[:, 0] for each in columns), strict=True):
        np.testing.assert_allclose(row, high + strength / (1 + 2j * np.pi * frequency * time), rtol=1e-14)
    for wrong in (np.array([[1e-4], [0.0]]), np.array([[1e-4], [np.nan]])):
        with pytest.raises(InputError, match="relaxation_times"):
            DebyeSum(columns[0], (columns[1],), (wrong,))
    with pytest.raises(InputError, match="strengths"):
        DebyeSum(columns[0], (-columns[1],), (columns[2],))
