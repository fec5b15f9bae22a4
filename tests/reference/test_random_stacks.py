"""Random stacks of passive dispersive layers against long arithmetic and against phasors."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scenario_parts import AREA, EPS0, largest

from electrovib.physics.circuit import SeriesElement
from electrovib.physics.debye_sum import DebyeSum
from electrovib.solve.stack.modes import Slab, slab_impedance, stack_modes

DIGITS = 80  # residues of layers 1e-12 to 10 s apart multiply: 50 digits and room for what cancels


def times(first, second):
    """Multiply polynomials, lowest power first."""
    product = [mpmath.mpf(0)] * (len(first) + len(second) - 1)
    for i, a in enumerate(first):
        for j, b in enumerate(second):
            product[i + j] += a * b
    return product


def plus(first, second):
    longer, shorter = sorted([first, second], key=len, reverse=True)
    return [a + (shorter[i] if i < len(shorter) else 0) for i, a in enumerate(longer)]


def product_of(polynomials):
    total = [mpmath.mpf(1)]
    for one in polynomials:
        total = times(total, one)
    return total


def admittivity(slab):
    """Numerator and denominator of s eps0 eps(s) + sigma."""
    pairs = zip(slab.debye.strengths, slab.debye.relaxation_times, strict=True)
    terms = [(mpmath.mpf(s), mpmath.mpf(t)) for s, t in pairs]
    factors = [[mpmath.mpf(1), t] for _, t in terms]
    denominator = product_of(factors)
    numerator = times([mpmath.mpf(slab.conductivity), mpmath.mpf(EPS0) * slab.debye.high], denominator)
    for index, (strength, _) in enumerate(terms):
        rest = product_of(factors[:index] + factors[index + 1 :])
        numerator = plus(numerator, times([mpmath.mpf(0), EPS0 * strength], rest))
    return numerator, denominator


def whole_impedance(slabs, element):
    """Numerator of the sum of all impedances, as a polynomial in s."""
    parts = []
    for slab in slabs:
        numerator, denominator = admittivity(slab)
        parts.append(([mpmath.mpf(slab.thickness) * each for each in denominator], numerator))
    if element.elastance:
        parts.append(([mpmath.mpf(AREA) * element.elastance], [mpmath.mpf(element.rate), mpmath.mpf(1)]))
    if element.resistance:
        parts.append(([mpmath.mpf(AREA) * element.resistance], [mpmath.mpf(1)]))
    total = [mpmath.mpf(0)]
    for index, (numerator, _) in enumerate(parts):
        others = [below for place, (_, below) in enumerate(parts) if place != index]
        total = plus(total, times(numerator, product_of(others)))
    return total


def exact_rates(slabs, element):
    """Give minus the zeros of the impedance, which are the poles of every field, and how many are 0."""
    polynomial = whole_impedance(slabs, element)
    zero = 0
    while polynomial and polynomial[0] == 0:
        polynomial, zero = polynomial[1:], zero + 1
    while polynomial[-1] == 0:
        polynomial = polynomial[:-1]
    if len(polynomial) < 2:
        return [], zero
    roots = mpmath.polyroots(polynomial, asc=True, maxsteps=400, extraprec=400)
    assert all(abs(root.imag) < abs(root) * mpmath.mpf(10) ** -50 for root in roots)
    rates = sorted(-root.real for root in roots)
    assert rates[0] > 0
    return rates, zero


def capacitors(slabs, element):
    """Count what does not conduct."""
    body = element.elastance > 0 and element.rate == 0
    return sum(slab.conductivity == 0 for slab in slabs) + body


def check_rates(slabs, element) -> float:
    """Compare all rates with the roots of the polynomial; give the largest relative error."""
    found = stack_modes(slabs, area=AREA, element=element)
    assert np.all(found.rates >= 0)
    with mpmath.workdps(DIGITS):
        exact, zero = exact_rates(slabs, element)
        assert zero == max(capacitors(slabs, element) - 1, 0)
        moving = np.sort(found.rates[found.rates > 0])
        assert len(moving) == len(exact)
        assert found.driven == len(exact)
        assert np.any(found.rates == 0) == (zero > 0)
        errors = [abs(mpmath.mpf(float(rate)) / root - 1) for rate, root in zip(moving, exact, strict=True)]
        return float(max(errors, default=0))


@pytest.mark.parametrize("seed", [pytest.param(0, marks=pytest.mark.slow), *range(1, 6)])
def test_rates_of_a_batch(finger, seed):
    random = np.random.default_rng(seed)
    for _ in range(20):
        assert check_rates(finger.random_stack(random), finger.random_element(random)) < 1e-12


def exponents(low, high):
    return st.floats(low, high).map(lambda power: 10.0**power)


layer = st.builds(
    lambda thickness, high, terms, conductivity: Slab(
        thickness, DebyeSum(high, tuple(s for s, _ in terms), tuple(t for _, t in terms)), conductivity
    ),
    exponents(-8, -3),
    exponents(0, 3),
    st.lists(st.tuples(exponents(-3, 6), exponents(-12, 1)), max_size=3),
    st.one_of(st.just(0.0), exponents(-15, 0)),
)
surroundings = st.builds(
    SeriesElement,
    resistance=st.one_of(st.just(0.0), exponents(0, 9)),
    elastance=st.one_of(st.just(0.0), exponents(6, 12)),
    rate=st.one_of(st.just(0.0), exponents(-4, 5)),
)


def apart(numbers):
    numbers = np.sort(numbers)
    return bool(np.all(np.diff(numbers) > 1e-6 * numbers[:-1]))


@pytest.mark.slow
@settings(max_examples=100, deadline=None)
@given(slabs=st.lists(layer, min_size=1, max_size=5), element=surroundings)
def test_rates_of_any_stack(slabs, element):
    """The same for stacks that a search puts together, corners of every range among them."""
    nodes = np.concatenate([slab_impedance(slab)[0] for slab in slabs] + [[element.rate]])
    # equal layers make double roots of the polynomial: they have a test of their own
    assume(apart(nodes[nodes > 0]))
    assume(all(apart(slab.debye.relaxation_times) for slab in slabs))
    assert check_rates(slabs, element) < 1e-12


@settings(max_examples=100, deadline=None)
@given(
    slabs=st.lists(layer, min_size=1, max_size=5),
    element=surroundings,
    charges=st.lists(st.floats(-1e-3, 1e-3), min_size=4, max_size=4),
)
def test_trapped_charge(slabs, element, charges):
    """A zero pole is not driven; charge on an interface excites it."""
    quiet = stack_modes(slabs, area=AREA, element=element)
    for field in quiet.fields:
        assert np.all(field.gains[quiet.rates == 0] == 0)
        assert np.all(field.free == 0)
    check_charges(slabs, element, charges)


def check_charges(slabs, element, charges):
    """In the end the fields are those of a chain of capacitors with the charge between them."""
    placed = [*charges[: len(slabs) - 1], 0.0]
    pairs = list(zip(slabs, placed, strict=True))
    charged = [Slab(slab.thickness, slab.debye, slab.conductivity, charge) for slab, charge in pairs]
    modes = stack_modes(charged, area=AREA, element=element)
    held = np.concatenate([[0.0], np.cumsum(placed)[:-1]])  # up to each layer
    static = [EPS0 * (slab.debye.high + sum(slab.debye.strengths)) for slab in slabs]
    blocks = [slab.conductivity == 0 for slab in slabs]
    elastance = np.array([slab.thickness for slab in slabs]) / static * blocks
    body = AREA * element.elastance if element.rate == 0 else 0.0
    total = elastance.sum() + body
    drawn = elastance @ held + body * sum(placed)  # the body is neutral
    final = elastance * (held - drawn / total) if total else np.zeros(len(slabs))
    found = [field.free[modes.rates == 0].sum() for field in modes.fields]
    found = np.array(found) * [slab.thickness for slab in slabs]
    scale = np.max(np.abs(held)) * np.max(elastance) if total else 0.0
    assert np.max(np.abs(found - final)) <= 1e-12 * scale


FREQUENCY = np.geomspace(1, 1e6, 61)
PRECISION = (
    1e-10  # demanded, of the largest value in the band; fields reach 3e-11 where they nearly vanish in it
)
OF_THE_DRIVE = 1e-13  # voltage of a layer over that of the drive: roundings of up to 25 modes


def by_impedance(slabs, element, second, frequency):
    """Give field and displacement of each layer, current density and voltage of the rest, per volt."""
    s = 2j * np.pi * frequency
    permittivity = np.array([slab.debye.permittivity(frequency) for slab in slabs])
    conductivity, thickness = np.array([[slab.conductivity, slab.thickness] for slab in slabs]).T[:, :, None]
    drops = thickness / (s * EPS0 * permittivity + conductivity)
    outside = AREA * element.impedance(frequency)
    current = 1 / (drops.sum(axis=0) * (1 + second) + outside)
    fields = drops * current / thickness
    return fields, EPS0 * permittivity * fields, current, outside


@pytest.mark.parametrize("seed", range(4))
def test_fields_displacements_and_current_out_of_modes_are_those_of_impedances(finger, seed):
    random = np.random.default_rng(1000 + seed)
    for _ in range(75):
        slabs, element = finger.random_stack(random), finger.random_element(random)
        second = 0.0 if random.random() < 0.7 else float(random.uniform(0.2, 3))
        found = stack_modes(slabs, area=AREA, element=element, second=second)
        fields, displacements, current, outside = by_impedance(slabs, element, second, FREQUENCY)
        across = 0
        for k, slab in enumerate(slabs):
            field, displacement = found.fields[k].at(FREQUENCY), found.displacements[k].at(FREQUENCY)
            assert largest(field - fields[k]) * slab.thickness < OF_THE_DRIVE
            assert largest(field - fields[k]) < PRECISION * largest(fields[k])
            assert largest(displacement - displacements[k]) < PRECISION * largest(displacements[k])
            across = across + field * slab.thickness * (1 + second)
        flow = found.current_density.at(FREQUENCY)
        assert largest(flow / current - 1) < OF_THE_DRIVE  # of itself at every frequency
        assert largest(across + outside * flow - 1) < OF_THE_DRIVE
