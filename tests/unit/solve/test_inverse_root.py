"""The expansion of K^(-1/2) against its complex value, for the shipped skins and for random sums."""

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from electrovib.core.discovery import papers
from electrovib.physics.debye_sum import DebyeSum
from electrovib.solve.stack.expand import reduce_material
from electrovib.solve.stack.section import CLEARANCE, TOLERANCE, inverse_root_thickness

FREQUENCY = np.geomspace(1e-2, 1e9, 441)
SKINS = {
    f"{author_year} {name}": skin.material
    for author_year, module in papers().items()
    if hasattr(module, "skins")
    for name, skin in module.skins().items()
}
INSULATORS = {"film": (90e-6, 3.35), "thin coating": (0.3e-6, 3.9)}


def exact(slabs):
    return sum(thickness / debye.permittivity(FREQUENCY) for thickness, debye in slabs) ** -0.5


def error(slabs, **options):
    root = inverse_root_thickness(slabs, **options)
    assert np.all(root.gains > 0)
    assert np.all(root.rates > 0)
    assert root.slope == 0
    assert not np.any(root.free)
    return np.max(np.abs(root.at(FREQUENCY) / exact(slabs) - 1))


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
    assert np.max(np.abs(root.at(FREQUENCY) / exact(slabs) - 1)) < 1e-10


def exponents(low, high):
    return st.floats(low, high).map(lambda power: 10.0**power)


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
