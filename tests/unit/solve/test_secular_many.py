"""Roots for many fingers against those for one finger, which are compared with long arithmetic."""

import numpy as np
import pytest

from electrovib.core.errors import InputError
from electrovib.solve.stack.secular import secular_roots

TOLERANCE = 1e-12


def solved(nodes, weights, constant):
    """Offsets and origins of each problem, (problems, nodes)."""
    column = np.asarray(constant, float)[:, None]
    with np.errstate(divide="ignore"):  # one node and a constant of 0: no root
        found = secular_roots(np.asarray(nodes, float), np.asarray(weights, float), constant=column)
    return found.offset, found.origin


def stacks(kind, random, fingers, count):
    """Nodes, weights and constants of fingers, from easy to badly scaled."""
    if kind == "skin":
        nodes = 10 ** (np.linspace(0, 5, count) + random.normal(0, 0.2, (fingers, count)))
        weights = nodes * random.lognormal(0, 1, (fingers, count))
        constant = np.where(random.random(fingers) < 0.5, 0.0, random.lognormal(0, 2, fingers))
    elif kind == "wide":
        nodes = 10 ** random.uniform(-12, 15, (fingers, count))
        weights = 10 ** random.uniform(-10, 10, (fingers, count))
        constant = 10 ** random.uniform(-10, 10, fingers)
    elif kind == "clusters":
        centre = 10 ** random.uniform(-3, 9, (fingers, 1 + count // 4))
        chosen = random.integers(0, centre.shape[1], (fingers, count))
        nodes = np.take_along_axis(centre, chosen, 1) * (
            1 + 1e-12 * random.integers(1, 10**6, (fingers, count))
        )
        weights = 10 ** random.uniform(-3, 3, (fingers, count))
        constant = np.where(random.random(fingers) < 0.3, 0.0, 1.0)
    else:
        nodes = np.arange(count) + np.zeros((fingers, 1))
        weights = 10 ** random.uniform(-40, 40, (fingers, count))
        constant = 10 ** random.uniform(-40, 40, fingers)
    nodes = np.sort(nodes, axis=1)
    apart = (np.diff(nodes, axis=1) > 1e-15 * nodes[:, 1:]).all(axis=1)
    return nodes[apart], weights[apart], constant[apart]


@pytest.mark.parametrize("count", [1, 2, 3, 12])
@pytest.mark.parametrize("kind", ["skin", "wide", "clusters", "weights"])
def test_roots_are_those_of_each_finger(kind, count):
    nodes, weights, constant = stacks(kind, np.random.default_rng(count), 60, count)
    offsets, origins = solved(nodes, weights, constant)
    assert len(nodes) > 20
    for finger in range(len(nodes)):
        expected_count = count - (constant[finger] == 0)
        assert np.isinf(offsets[finger, expected_count:]).all()
        if not expected_count:
            continue
        expected = secular_roots(nodes[finger], weights[finger], constant=float(constant[finger]))
        assert np.array_equal(origins[finger, :expected_count], expected.origin)
        assert np.max(np.abs(offsets[finger, :expected_count] / expected.offset - 1)) < TOLERANCE


def test_roots_do_not_depend_on_the_company():
    nodes, weights, constant = stacks("skin", np.random.default_rng(9), 200, 12)
    whole = solved(nodes, weights, constant)
    for part in (slice(0, 1), slice(7, 20), slice(60, 70), slice(197, 200)):
        offsets, origins = solved(nodes[part], weights[part], constant[part])
        np.testing.assert_array_equal(offsets, whole[0][part])
        np.testing.assert_array_equal(origins, whole[1][part])


def test_two_nodes_in_closed_form():
    """w1/x + w2/(x - 1) = 0 at x = w1/(w1 + w2)."""
    weights = np.array([[1.0, 3.0], [3.0, 1.0]])
    offsets, origins = solved([[0.0, 1.0]] * 2, weights, [0.0, 0.0])
    assert np.allclose(offsets[:, 0], [0.25, -0.25], rtol=1e-14)
    assert origins[:, 0].tolist() == [0, 1]
    assert np.isinf(offsets[:, 1]).all()


def test_what_cannot_be_resolved_is_refused():
    with pytest.raises(InputError, match="weights"):
        solved([[0.0, 1.0]], [[0.0, 1.0]], [0.0])


def test_a_root_that_rounding_would_move_is_computed_with_more_digits():
    """Strong distant poles and the constant cancel between two weak poles: rounding moves the root by a part in 1e10."""
    nodes, weights = np.array([0.0, 1e6, 1e6 + 1, 3e6]), np.array([1.0, 1e-15, 1e-15, 1.0])
    constants = 1 / 1000000.3 - 1 / 1999999.7 + np.array([0.0, 1e-13, -3e-13])
    offsets, origins = solved(np.tile(nodes, (3, 1)), np.tile(weights, (3, 1)), constants)
    for finger, constant in enumerate(constants.tolist()):
        expected = secular_roots(nodes, weights, constant=constant)
        assert np.array_equal(origins[finger], expected.origin)
        assert np.max(np.abs(offsets[finger] / expected.offset - 1)) < TOLERANCE
