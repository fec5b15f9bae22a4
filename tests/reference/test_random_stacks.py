"""Modes of random stacks against long arithmetic and phasors, and what reducing the shipped skins to Debye terms costs."""

import mpmath
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scenario_parts import AREA, EPS0, largest, layer, powers, step
from scipy.optimize import brentq

from electrovib.core.discovery import find_members
from electrovib.papers.palmar_1995 import skins
from electrovib.physics.circuit import SeriesElement
from electrovib.physics.debye_sum import DebyeSum
from electrovib.physics.force import ForceLaw
from electrovib.solve.simulate import simulate
from electrovib.solve.stack.expand import modes, phasors, reductions
from electrovib.solve.stack.modes import Slab, slab_impedance, stack_modes
from electrovib.solve.stack.section import inverse_root_thickness

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


@pytest.mark.parametrize("seed", [1, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (0, 2))])
def test_rates_of_a_batch(finger, seed):
    random = np.random.default_rng(seed)
    for _ in range(20):
        assert check_rates(finger.random_stack(random), finger.random_element(random)) < 1e-12


any_slab = st.builds(
    lambda thickness, high, terms, conductivity: Slab(
        thickness, DebyeSum(high, tuple(s for s, _ in terms), tuple(t for _, t in terms)), conductivity
    ),
    powers(-8, -3),
    powers(0, 3),
    st.lists(st.tuples(powers(-3, 6), powers(-12, 1)), max_size=3),
    st.one_of(st.just(0.0), powers(-15, 0)),
)
surroundings = st.builds(
    SeriesElement,
    resistance=st.one_of(st.just(0.0), powers(0, 9)),
    elastance=st.one_of(st.just(0.0), powers(6, 12)),
    rate=st.one_of(st.just(0.0), powers(-4, 5)),
)


def apart(numbers):
    numbers = np.sort(numbers)
    return bool(np.all(np.diff(numbers) > 1e-6 * numbers[:-1]))


@pytest.mark.slow
@settings(max_examples=100, deadline=None)
@given(slabs=st.lists(any_slab, min_size=1, max_size=5), element=surroundings)
def test_rates_of_any_stack(slabs, element):
    """The same for stacks that a search puts together, corners of every range among them."""
    nodes = np.concatenate([slab_impedance(slab)[0] for slab in slabs] + [[element.rate]])
    # equal layers make double roots of the polynomial: they have a test of their own
    assume(apart(nodes[nodes > 0]))
    assume(all(apart(slab.debye.relaxation_times) for slab in slabs))
    assert check_rates(slabs, element) < 1e-12


@settings(max_examples=100, deadline=None)
@given(
    slabs=st.lists(any_slab, min_size=1, max_size=5),
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


# ------------------------------------------------------------------ skins of papers, reduced


ALLOWED = 1e-3  # stated: below 0.1 % of eps_pol and of the transfer over 1 Hz to 1 MHz
BAND = np.geomspace(1, 1e6, 997)  # not the grid of the fit, nor of its own check
INSULATORS = {"film": (90e-6, 3.35), "coating": (1e-6, 3.9)}


def stack(finger, skin, insulator="film", *, gap=False, resistance=1000.0, **more):
    between = {"gap": finger.gap(1e-6, 1e-9)} if gap else {}
    layers = {
        "insulator": finger.film(*INSULATORS[insulator]),
        **between,
        "stratum_corneum": layer(200e-6, skin),
    }
    return finger.build(drive=step(1), stack=layers, resistance=resistance, **more)


def test_factors_with_a_rate_in_common_are_moved_apart(finger):
    """A source resistance that puts a rate of the stack exactly on a node of the expansion of K^(-1/2)."""
    skin = skins()["dry_men"].material

    def section(resistance):
        return modes(stack(finger, skin, "coating", resistance=resistance))[0]

    names = ["insulator", "stratum_corneum"]
    plain = inverse_root_thickness([(section(1e3)[n].thickness, section(1e3).debye[n]) for n in names])
    slow, fast = (section(resistance).modes.rates for resistance in (1e9, 1.0))
    crossing = np.argwhere((plain.rates[:, None] > slow) & (plain.rates[:, None] < fast))
    node, mode = crossing[len(crossing) // 2]  # this rate passes this node as the resistance changes
    power = brentq(lambda x: np.log(section(10.0**x).modes.rates[mode] / plain.rates[node]), 0, 9, xtol=1e-14)
    meeting = section(10.0**power)
    assert np.min(np.abs(plain.rates[:, None] / meeting.modes.rates - 1)) < 1e-12
    product = meeting.inverse_root_thickness(names) * meeting.voltage
    expected = plain.at(BAND) * meeting.voltage.at(BAND)
    assert np.max(np.abs(product.at(BAND) - expected)) < 1e-11 * np.max(np.abs(expected))


@pytest.mark.parametrize("insulator", INSULATORS)
def test_transfer(finger, paper_skin, insulator):
    scenario = stack(finger, paper_skin, insulator, gap=True)
    layers = scenario.stack.layers
    section, _ = modes(scenario)
    truth = phasors(scenario, BAND)
    for name, kind in find_members(ForceLaw).items():
        law = kind.model_validate(dict(kind.example))
        if not law.causal or set(getattr(kind, "replaces", ())) & set(layers):
            continue
        reduced, declared = law.amplitudes(section), law.amplitudes(truth)
        for quantity, exact in declared.items():
            error = np.max(np.abs(reduced[quantity].at(BAND) - exact)) / np.max(np.abs(exact))
            assert error < ALLOWED, (name, quantity)


def test_the_trace_tells_both_errors(finger, paper_skin):
    scenario = stack(finger, paper_skin, resistance=0.0, force="Vezzoli2014Causal")
    trace = simulate(scenario)
    assert trace.attrs["reduction_error"] == reductions(scenario)["stratum_corneum"].largest_error
    # of the value at each time, down to 1e-4 of the peak; right at the step it is that of infinite frequency
    later = simulate(scenario, time=trace.time.values[1:])
    assert 0 <= later.attrs["transfer_error"] < 10 * ALLOWED
    assert trace.attrs["transfer_error"] >= later.attrs["transfer_error"]
