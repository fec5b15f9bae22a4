"""Transfers: operations against arithmetic on values and free parts, and the expansion of K^(-1/2) against its complex value."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from electrovib.core.discovery import papers
from electrovib.physics.debye_sum import DebyeSum
from electrovib.solve.population.arrays import some_of
from electrovib.solve.stack.expand import reduce_material
from electrovib.solve.stack.section import CLEARANCE, TOLERANCE, inverse_root_thickness
from electrovib.solve.stack.transfer import (
    INTEGRATING,
    Transfer,
    integral_weight,
    integrated,
    resting,
    without_integrators,
)

CASES = 4
FREQUENCY = np.geomspace(1e-2, 1e8, 31)
S = 2j * np.pi * FREQUENCY
TIME = np.concatenate([[0.0], np.geomspace(1e-8, 10.0, 40)])
FACTOR = np.array([[2.0], [-3.0], [0.5], [7.0]])


def transfer(rates, gains, *rest):
    given = dict(zip(("direct", "slope", "free", "static"), rest, strict=False))
    return Transfer(rates=np.array(rates, float), gains=np.array(gains, float), **given)


def random_transfer(seed, count=3, *, static=False, shared=False):
    """Return a transfer function of columns, or one that all cases share."""
    random = np.random.default_rng(seed)
    lead = () if shared else (CASES,)
    rates, gains = 10 ** random.uniform(-2, 6, (*lead, count)), random.normal(size=(*lead, count))
    direct, slope = random.normal(size=(2, CASES, 1))
    if shared:
        direct, slope = float(direct[0, 0]), float(slope[0, 0])
    level = direct + gains.sum(axis=-1, keepdims=not shared) if static else None
    free = random.normal(size=(*lead, count))
    return Transfer(rates=rates, gains=gains, direct=direct, slope=1e-9 * slope, free=free, static=level)


def of_case(whole, case):
    """Return the transfer function, or the number, of one case."""
    if isinstance(whole, Transfer):
        rows = {name: getattr(whole, name) for name in ("rates", "gains", "free")}
        rows = {name: values[case] if values.ndim == 2 else values for name, values in rows.items()}
        return Transfer(
            **rows, **{name: of_case(getattr(whole, name), case) for name in ("direct", "slope", "static")}
        )
    return float(whole[case, 0]) if isinstance(whole, np.ndarray) else whole


def as_filter(one):
    return replace(one, free=np.zeros(one.rates.shape[-1]), slope=0.0)


def operations(one, other, factor):
    """Return what can be made of two transfer functions and a number."""
    still, gain = replace(one, slope=0.0), as_filter(other)
    return {
        "itself": one,
        "sum": one + other,
        "difference": one - other,
        "other way round": other - one,
        "modes in common": one + one * factor,
        "multiple": factor * one,
        "multiple of the other": other * factor,
        "share": one / factor,
        "negative": -one,
        "product": still * gain,
        "product, filter first": gain * still,
        "integral": integrated(one, start=factor),
    }


def in_time(one):
    return np.exp(-np.outer(TIME, one.rates)) @ one.free


def through(gain, one):
    """Return sum f exp(-r t) from time 0 behind a filter: convolution with each of its modes, in closed form."""
    found = gain.direct * in_time(one)
    for rate, share in zip(gain.rates, gain.gains, strict=True):
        for free, slow in zip(one.free, one.rates, strict=True):
            decayed = np.exp(-slow * TIME) - np.exp(-rate * TIME)
            found = found + share * rate * free * decayed / (rate - slow)
    return found


def by_arithmetic(one, other, factor):
    """Return the values over frequency and the free parts in time of all that."""
    still, gain = replace(one, slope=0.0), as_filter(other)
    values, others, free, of_other = one.at(FREQUENCY), other.at(FREQUENCY), in_time(one), in_time(other)
    product = still.at(FREQUENCY) * gain.at(FREQUENCY), through(gain, one)
    spent = factor + -np.expm1(-np.outer(TIME, one.rates)) / one.rates @ one.free
    by_hand = one.direct + one.slope * S + (one.gains * one.rates / (S[:, None] + one.rates)).sum(axis=1)
    return {
        "itself": (by_hand, free),
        "sum": (values + others, free + of_other),
        "difference": (values - others, free - of_other),
        "other way round": (others - values, of_other - free),
        "modes in common": (values * (1 + factor), free * (1 + factor)),
        "multiple": (values * factor, free * factor),
        "multiple of the other": (others * factor, of_other * factor),
        "share": (values / factor, free / factor),
        "negative": (-values, -free),
        "product": product,
        "product, filter first": product,
        "integral": (values / S, spent),
    }


@pytest.mark.parametrize("static", [False, True])
@pytest.mark.parametrize("shared", [False, True])
@pytest.mark.parametrize("operation", operations(random_transfer(1), random_transfer(2), FACTOR))
def test_operations_are_arithmetic_on_values_and_on_free_parts_of_each_case(operation, shared, static):
    one = random_transfer(1, static=static)
    for count in (0, 3):
        other = random_transfer(2, count, shared=shared)
        found = operations(one, other, FACTOR)[operation]
        for case in range(CASES):
            mine, its, factor = (of_case(each, case) for each in (one, other, FACTOR))
            values, free = by_arithmetic(mine, its, factor)[operation]
            alone = operations(mine, its, factor)[operation]
            for each in (alone, of_case(found, case)):
                # rounding of the sum of modes at low frequency, over s
                allowed = 1e-9 * np.abs(values) if operation == "integral" else 1e-12 * np.max(np.abs(values))
                assert np.all(np.abs(each.at(FREQUENCY) - values) <= allowed)
                assert np.max(np.abs(in_time(each) - free)) <= 1e-12 * np.max(np.abs(free))
                assert each.at_rest() == pytest.approx(alone.at_rest(), rel=1e-10)


def test_modes_in_common_stay_common_and_an_integral_has_its_own():
    one = random_transfer(6)
    assert (one + one * FACTOR).rates is one.rates
    found = some_of({"first": one, "second": one * FACTOR}, slice(1, 3))
    assert found["first"].rates is found["second"].rates
    assert np.array_equal(found["first"].rates, one.rates[1:3])
    assert np.array_equal(found["second"].direct, one.direct[1:3] * FACTOR[1:3])
    integral = integrated(one, start=FACTOR)
    assert np.count_nonzero(integral.rates[0] == INTEGRATING) == 1
    assert np.allclose(integral_weight(integral), one.at_rest(), rtol=1e-12, atol=0)
    kept = without_integrators(integral)
    assert np.array_equal(
        np.sort(kept.gains[kept.rates != INTEGRATING]), np.sort(integral.gains[integral.rates != INTEGRATING])
    )
    assert not np.any(kept.gains[kept.rates == INTEGRATING])


def test_modes_that_cancel_or_are_not_driven_in_one_case_respond_in_the_others():
    """What is rounding beside the modes of one case may be a response beside those of another."""
    gains = np.array([[1.0, -1.0 + 1e-15], [1e-9, -1e-9 + 1e-15], [1.0, 2.0], [0.0, 0.0]])
    whole = Transfer(rates=np.array([1.0, 2.0]), gains=gains)
    found = resting(whole)
    assert found[:, 0].tolist() == [resting(of_case(whole, case)) for case in range(CASES)]
    assert found[0, 0] == 0
    assert found[1, 0] == pytest.approx(1e-15, rel=1e-6)
    whole = Transfer(
        rates=np.array([3.0, 40.0]), gains=np.array([[0.0, 1.0], [2.0, 1.0], [3.0, 0.0], [4.0, 1.0]])
    )
    for case in range(CASES):
        assert np.allclose(whole.at(FREQUENCY)[case], of_case(whole, case).at(FREQUENCY), rtol=1e-12, atol=0)
    assert transfer([0.0], [0.0], 0.0, 0.0, np.array([3.0])).at(0.0) == 0  # trapped charge is not driven


FILTER = transfer([5.0, 7e4], [0.3, 2.0], 0.1)
SIGNAL = transfer([0.0, 2.0, 300.0], [0.0, 1.5, -0.4], 0.2, 1e-9, np.array([0.7, 0.1, -0.3]))


def test_a_known_static_value_keeps_the_digits_of_a_small_response():
    """A current: 1/(R (1 + 1/(s tau))) at a frequency 1e-12 of its rate, where direct and gain cancel."""
    rate, expected = 1e9, S / (S + 1e9)
    current = transfer([rate], [-1.0], 1.0, 0.0, np.zeros(1), 0.0)
    assert np.max(np.abs(current.at(FREQUENCY) / expected - 1)) < 1e-14
    assert np.max(np.abs(transfer([rate], [-1.0], 1.0).at(FREQUENCY) / expected - 1)) > 1e-9
    assert current.at(0.0) == current.at_rest() == 0
    assert FILTER.at_rest() == pytest.approx(2.4, rel=1e-15)
    current = transfer([1e9, 30.0], [-1.0, -2.0], 3.0 + 1e-20, 0.0, np.zeros(2), 1e-20)
    combined = [current + current, current - current * 0.5, -4.0 * current, FILTER * current]
    combined.append(current + FILTER)
    assert [each.static for each in combined] == pytest.approx(
        [2e-20, 0.5e-20, -4e-20, 2.4e-20, 2.4], rel=1e-14
    )
    assert SIGNAL.at(FREQUENCY.reshape(1, -1)).shape == (1, 31)
    assert SIGNAL.at(FREQUENCY).dtype == complex


def exponents(low, high):
    return st.floats(low, high).map(lambda power: 10.0**power)


modes = st.lists(
    st.tuples(exponents(-3, 9), st.floats(-5, 5)), min_size=1, max_size=6, unique_by=lambda m: m[0]
)


@settings(max_examples=100, deadline=None)
@given(both=st.tuples(modes, modes), directs=st.tuples(st.floats(-2, 2), st.floats(-2, 2)))
def test_product(both, directs):
    first, second = (
        transfer(*zip(*some, strict=True), each) for some, each in zip(both, directs, strict=True)
    )
    apart = np.abs(np.log(first.rates[:, None] / second.rates[None, :]))
    if apart.min() < 1e-3:  # a rate in common is outside what a product promises
        return
    sizes = [np.abs(one.gains).sum() + abs(one.direct) for one in (first, second)]
    for product in (first * second, second * first):
        expected = first.at(FREQUENCY) * second.at(FREQUENCY)
        # close rates amplify by their inverse distance
        scale = (np.prod(sizes) + 1e-300) / min(apart.min(), 1)
        assert np.max(np.abs(product.at(FREQUENCY) - expected)) < 1e-12 * scale
        assert product.direct == directs[0] * directs[1]


@pytest.mark.parametrize(("first", "second"), [(SIGNAL, SIGNAL), (FILTER, SIGNAL), (SIGNAL, FILTER)])
def test_products_of_two_free_parts_or_with_a_slope_have_no_meaning(first, second):
    with pytest.raises(ValueError, match="free part"):
        first * second


FINE = np.geomspace(1e-2, 1e9, 441)
SKINS = {
    f"{author_year} {name}": skin.material
    for author_year, module in papers().items()
    if hasattr(module, "skins")
    for name, skin in module.skins().items()
}
INSULATORS = {"film": (90e-6, 3.35), "thin coating": (0.3e-6, 3.9)}


def exact(slabs):
    return sum(thickness / debye.permittivity(FINE) for thickness, debye in slabs) ** -0.5


def error(slabs, **options):
    root = inverse_root_thickness(slabs, **options)
    assert np.all(root.gains > 0)
    assert np.all(root.rates > 0)
    assert root.slope == 0
    assert not np.any(root.free)
    return np.max(np.abs(root.at(FINE) / exact(slabs) - 1))


@pytest.mark.parametrize("insulator", INSULATORS)
@pytest.mark.parametrize("skin", SKINS.values(), ids=SKINS)
def test_skins_of_fourteen_terms(skin, insulator):
    thickness, permittivity = INSULATORS[insulator]
    slabs = [(thickness, DebyeSum(permittivity)), (200e-6, reduce_material(skin).debye)]
    assert error(slabs) < 1e-11  # what is aimed at; 1e-8 is asked for


def test_the_factor_at_low_and_high_frequency_and_without_dispersion():
    root = inverse_root_thickness([(1e-6, DebyeSum(3.9)), (200e-6, DebyeSum(60.0, (4000.0,), (1e-3,)))])
    assert root.at(0.0) == pytest.approx((1e-6 / 3.9 + 200e-6 / 4060) ** -0.5, rel=1e-10)
    assert root.direct == pytest.approx((1e-6 / 3.9 + 200e-6 / 60) ** -0.5, rel=1e-15)
    root = inverse_root_thickness([(90e-6, DebyeSum(3.35)), (200e-6, DebyeSum(1560.0))])
    assert len(root.rates) == 0
    assert root.direct == pytest.approx((90e-6 / 3.35 + 200e-6 / 1560) ** -0.5, rel=1e-15)


def test_tolerance_buys_nodes():
    slabs = [(1e-6, DebyeSum(3.9)), (200e-6, DebyeSum(4.0, (1100.0,), (32e-9,)))]
    errors = [error(slabs, tolerance=tolerance) for tolerance in (1e-3, 1e-6, 1e-9)]
    counts = [len(inverse_root_thickness(slabs, tolerance=t).rates) for t in (1e-3, 1e-6, 1e-9)]
    assert counts == sorted(set(counts))
    for found, aimed in zip(errors, (1e-3, 1e-6, 1e-9), strict=True):
        assert 0.01 * aimed < found < 10 * aimed


def test_rates_keep_clear_of_those_of_the_other_factor():
    slabs = [(1e-6, DebyeSum(3.9)), (200e-6, DebyeSum(60.0, (4000.0, 50.0), (1e-3, 1e-6)))]
    taken = inverse_root_thickness(slabs).rates[[1, -2]] * (1 + 1e-9)
    root = inverse_root_thickness(slabs, avoid=taken)
    residues = root.gains * root.rates / root.direct
    assert np.min(np.abs(root.rates[:, None] - taken) / residues[:, None]) > CLEARANCE
    assert np.max(np.abs(root.at(FINE) / exact(slabs) - 1)) < 1e-10


slab = st.tuples(
    exponents(-8, -3),
    st.builds(
        lambda high, terms: DebyeSum(high, tuple(s for s, _ in terms), tuple(t for _, t in terms)),
        exponents(0, 3),
        st.lists(st.tuples(exponents(-6, 5), exponents(-12, 2)), max_size=4),
    ),
)


@settings(max_examples=100, deadline=None)
@given(slabs=st.lists(slab, min_size=1, max_size=3))
@example([(1e-3, DebyeSum(1.0, (177.82794100389228, 2e-4), (1.0, 1.00000885578148)))])  # a cut of 1e-11
def test_random_sums(slabs):
    """Also where two cuts almost touch."""
    assert error(slabs) < 100 * TOLERANCE


@pytest.mark.parametrize("faint", [1e-2, 1e-4, 1e-6, 1e-8])
def test_a_faint_relaxation_inside_a_strong_one(faint):
    """It cuts the strong one's interval in two that almost touch: graded angles keep all digits."""
    strong = DebyeSum(2.0, (500.0, faint), (1e-3, 1e-4))
    slabs = [(1e-6, DebyeSum(3.9)), (200e-6, strong)]
    assert error(slabs) < 10 * TOLERANCE
    assert len(inverse_root_thickness(slabs).rates) < 500  # even angles would need up to 1e5
