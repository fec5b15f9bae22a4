"""Roots of sums of poles against long arithmetic, closed forms and eigenvalues; those of many cases are those of each."""

from fractions import Fraction
from itertools import product

import mpmath
import numpy as np
import pytest

from electrovib.core.errors import InputError
from electrovib.scenario import load
from electrovib.solve.simulate import simulate
from electrovib.solve.stack.secular import Roots, secular_roots

# rounding of the sums, 2e-16, times the worst conditioning that is left to 53 bits, with room
TOLERANCE = 1e-13
# terms of 1e50 may cancel down to 1e-50 and less: the reference needs more digits than all of that
DIGITS = 200


def balance(nodes, weights, constant, origin, offset):
    """Give the sum minus the constant at ``nodes[origin] + offset``, and minus its derivative."""
    place = mpmath.mpf(float(nodes[origin])) + offset
    apart = [place - mpmath.mpf(float(node)) for node in nodes]
    weights = [mpmath.mpf(float(weight)) for weight in weights]
    value = mpmath.fsum(weight / step for weight, step in zip(weights, apart, strict=True)) - constant
    slope = mpmath.fsum(weight / step**2 for weight, step in zip(weights, apart, strict=True))
    return value, slope


def brackets_root(case, origin, offset, tolerance=TOLERANCE):
    """Say whether the sum, which falls, changes sign within ``tolerance`` of the offset."""
    near = balance(*case, origin, mpmath.mpf(float(offset)) * (1 - mpmath.mpf(tolerance)))[0]
    far = balance(*case, origin, mpmath.mpf(float(offset)) * (1 + mpmath.mpf(tolerance)))[0]
    return bool((near - far) * np.sign(offset) > 0 and near * far < 0)


def check(case) -> Roots:
    """Compare every number of the answer with long arithmetic on the same inputs."""
    nodes, weights, constant = case
    roots = secular_roots(*case[:2], constant=case[2])
    count = len(nodes) - (constant == 0)
    assert roots.values.shape == roots.origin.shape == roots.offset.shape == roots.slope.shape == (count,)
    differences = roots.differences()
    assert differences.shape == (count, len(nodes))
    with mpmath.workdps(DIGITS):
        for row, (origin, offset) in enumerate(zip(roots.origin, roots.offset, strict=True)):
            assert origin == row if offset > 0 else origin == row + 1
            exact = [mpmath.mpf(float(nodes[origin])) + mpmath.mpf(float(offset)) - float(n) for n in nodes]
            assert exact[row] > 0
            assert row + 1 == len(nodes) or exact[row + 1] < 0
            # with the bracket known, the change of sign is a proof: the sum falls from pole to pole
            assert brackets_root(case, origin, offset)
            assert all(abs(d / e - 1) < TOLERANCE for d, e in zip(differences[row], exact, strict=True))
            slope = balance(*case, origin, mpmath.mpf(float(offset)))[1]
            assert abs(roots.slope[row] / slope - 1) < TOLERANCE
            value = mpmath.mpf(float(nodes[origin])) + mpmath.mpf(float(offset))
            assert abs(roots.values[row] / value - 1) < 1e-15  # a single rounding
        if constant > 0:  # -1/f has residues 1/slope at the roots, which add up to those at infinity
            expected = mpmath.fsum(float(w) for w in weights) / mpmath.mpf(constant) ** 2
            total = mpmath.fsum(1 / mpmath.mpf(float(slope)) for slope in roots.slope)
            assert abs(total / expected - 1) < TOLERANCE
    assert_interlacing(roots, nodes)
    return roots


def assert_interlacing(roots, nodes):
    count = len(roots.values)
    assert (roots.values >= nodes[:count]).all()
    assert (roots.values[: len(nodes) - 1] <= nodes[1:]).all()
    gap = np.diff(nodes)
    assert (np.abs(roots.offset[: len(gap)]) <= gap / 2 * (1 + 1e-14)).all()  # from the nearer end


def distinct(nodes):
    nodes = np.unique(nodes)
    return nodes[np.concatenate([[True], np.diff(nodes) >= 1e-30])]


def hard_nodes(random, count):
    kind = random.integers(5)
    if kind == 0:
        return 10.0 ** random.uniform(-12, 16, count)
    if kind == 1:
        return 10.0 ** random.uniform(-3, 3, count)
    if kind == 2:  # clusters of neighbours one to a few roundings apart
        centre = 10.0 ** random.uniform(-12, 16, 3)[random.integers(3, size=count)]
        return centre * (1 + 2.3e-16 * random.integers(0, 40, count))
    if kind == 3:
        return np.arange(count) * 1.0
    half = 10.0 ** random.uniform(-12, 16, (count + 1) // 2)
    return np.concatenate([half, np.nextafter(half, np.inf)])


def hard_case(random, longest=14):
    nodes = distinct(hard_nodes(random, int(random.integers(1, longest + 1))))
    if random.random() < 0.3:
        nodes[0] = 0
    decades = random.choice([0, 1, 10, 40])
    weights = 10.0 ** random.uniform(-decades, decades, nodes.size)
    return nodes, weights, float(random.choice([0, 1, 10.0 ** random.uniform(-40, 40)]))


@pytest.mark.parametrize("seed", range(10))
def test_hard_sets(seed):
    random = np.random.default_rng(seed)
    for _ in range(10):
        check(hard_case(random))


FAINT = (1e-3, 1e-10, 1e-17, 1e-25, 1e-40)
SPECIAL = [
    # strong poles cancel exactly where a faint one sits, so 53 bits see nothing of the root beside it
    *[([0, 1, 2], [1, faint, 1], 0) for faint in FAINT],
    *[([0, 1, 3], [1, faint, faint], 1) for faint in FAINT],
    *[([0, 1], [1, faint], 1) for faint in FAINT],
    ([0, 1, 2, 3], [1, 1e-30, 1e-30, 1], 0),  # a root in the middle
    ([1, 2], [1e-40, 1], 0),  # closer to its node than rounding
    *[([node], [3], constant) for node in (0, 1e-12, 3, 1e16) for constant in (0, 7)],
    *product(
        [(0, 1e6), (1e3, 1e3 + 1e-6), (1e-5, 7)], [(1, 1e9), (1e9, 1), (2, 3), (1e-3, 5e6)], [0, 3e-9, 1, 2e7]
    ),
    *[(np.geomspace(1e-12, 1e16, 80), np.roll(np.geomspace(10.0**-d, 10.0**d, 80), 37), 1) for d in (1, 40)],
]


@pytest.mark.parametrize("case", SPECIAL)
def test_special_sets(case):
    nodes, weights, constant = case
    check((np.array(nodes, float), np.array(weights, float), float(constant)))


def test_balance_decides_on_which_side_of_the_middle():
    """Between two faint neighbours all strong poles cancel to rounding: 53 bits may take the wrong end."""
    random = np.random.default_rng(3)
    nodes = np.array([0, 0.25, 0.5, 0.75, 1, np.nextafter(1, 2)])
    middle = Fraction(1) + Fraction(float(np.spacing(1.0))) / 2
    for _ in range(20):
        weights = np.append(random.uniform(1, 2, 4), [1e-30, 1e-30])
        terms = [Fraction(w) / (middle - Fraction(n)) for n, w in zip(nodes, weights, strict=True)]
        check((nodes, weights, float(sum(terms))))


def test_limits_raise_no_floating_point_error():
    random = np.random.default_rng(11)
    with np.errstate(all="raise"):
        for _ in range(60):
            nodes = distinct(10.0 ** random.integers(-29, 21, 30))
            weights = 10.0 ** random.choice([-50, 0, 50], nodes.size)
            for constant in (0.0, 1e-50, 1.0, 1e50):
                roots = secular_roots(nodes, weights, constant=constant)
                assert (roots.slope > 0).all()
                assert (roots.offset != 0).all()
                assert_interlacing(roots, nodes)


@pytest.mark.parametrize(
    ("nodes", "weights", "constant", "named"),
    [
        ([1, 1], [1, 1], 0.0, "merge equal nodes"),
        ([2, 1], [1, 1], 0.0, "strictly increasing"),
        ([-1, 1], [1, 1], 0.0, "nodes"),
        ([0, np.nan], [1, 1], 0.0, "nodes"),
        ([0, 1e21], [1, 1], 0.0, "nodes"),
        ([0, 1], [1, 0], 0.0, "weights"),
        ([0, 1], [1, -1], 0.0, "weights"),
        ([0, 1], [1, 1e51], 0.0, "weights"),
        ([0, 1], [1, 1], -1.0, "constant"),
        ([0, 1], [1, 1], np.nan, "constant"),
        ([0, 1], [1, 1], 1e-60, "constant"),
    ],
)
def test_refuses(nodes, weights, constant, named):
    with pytest.raises(ValueError, match=named):
        secular_roots(nodes, weights, constant=constant)


def test_the_check_refuses_a_shifted_offset_and_the_answer_is_frozen():
    case = (np.array([0.0, 1, 2]), np.array([1.0, 2, 3]), 1.0)
    roots = secular_roots(*case[:2], constant=case[2])
    with mpmath.workdps(DIGITS):
        for origin, offset in zip(roots.origin, roots.offset, strict=True):
            assert brackets_root(case, origin, offset)
            assert not brackets_root(case, origin, offset * (1 + 3 * TOLERANCE))
            assert not brackets_root(case, origin, offset * (1 - 3 * TOLERANCE))
    assert case[0].flags.writeable
    assert not any(getattr(roots, name).flags.writeable for name in ("nodes", "values", "offset", "slope"))


def test_a_stack_beyond_reach_is_told_in_a_sentence():
    skin = {"model": "Debye", "permittivity_high": 1.0, "strength": 1e6, "relaxation_time": 1e-15}
    changes = {"stack.stratum_corneum.material": skin | {"conductivity": 1e-6}}
    words = r"stack: the rates .* too far apart.*longer relaxation times.*1e\+21"
    with pytest.raises(InputError, match=words):
        simulate(load("vezzoli_2014/fig6").replace(changes))


def assert_those_of_each(nodes, weights, constant):
    """Roots of many cases, whose columns need not be sorted, are those of each, with as many digits."""
    with np.errstate(divide="ignore"):  # one node and a constant of 0: no root
        found = secular_roots(nodes, weights, constant=constant[:, None])
    apart = found.differences()
    for case, level in enumerate(constant.tolist()):
        order = np.argsort(nodes[case])
        count = len(order) - (level == 0)
        assert np.isinf(found.offset[case, count:]).all()
        if count:
            alone = secular_roots(nodes[case, order], weights[case, order], constant=level)
            assert np.array_equal(found.origin[case, :count], order[alone.origin])
            for name in ("values", "offset", "slope"):
                assert np.allclose(
                    getattr(found, name)[case, :count], getattr(alone, name), rtol=1e-12, atol=0
                )
            assert np.allclose(apart[case][:count, order], alone.differences(), rtol=1e-12, atol=0)
    return found


@pytest.mark.parametrize("count", [1, 2, 3, 12])
@pytest.mark.parametrize("decades", [1, 10, 40])
def test_roots_of_many_cases_are_those_of_each(decades, count):
    random = np.random.default_rng(count)
    drawn = [distinct(hard_nodes(random, count)) for _ in range(80)]
    nodes = np.array([random.permutation(each) for each in drawn if len(each) == count])
    weights = 10.0 ** random.uniform(-decades, decades, nodes.shape)
    constant = 10.0 ** random.uniform(-decades, decades, len(nodes)) * (random.random(len(nodes)) < 0.7)
    assert len(nodes) > 20
    found = assert_those_of_each(nodes, weights, constant)
    with np.errstate(divide="ignore"):
        for part in (slice(0, 1), slice(7, 20)):  # whatever the company
            some = secular_roots(nodes[part], weights[part], constant=constant[part, None])
            np.testing.assert_array_equal(some.offset, found.offset[part])


def test_a_root_that_rounding_would_move_is_computed_with_more_digits():
    """Strong distant poles and the constant cancel between two weak poles: rounding moves the root by a part in 1e10."""
    nodes, weights = np.array([0.0, 1e6, 1e6 + 1, 3e6]), np.array([1.0, 1e-15, 1e-15, 1.0])
    constants = 1 / 1000000.3 - 1 / 1999999.7 + np.array([0.0, 1e-13, -3e-13])
    assert_those_of_each(np.tile(nodes, (3, 1)), np.tile(weights, (3, 1)), constants)


def test_one_of_many_cases_that_cannot_be_resolved_is_refused():
    with pytest.raises(InputError, match="weights"):
        secular_roots(np.array([[0.0, 1.0]]), np.array([[0.0, 1.0]]), constant=np.array([[0.0]]))
