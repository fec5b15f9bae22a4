"""Numbers as columns of cases: stacks and transfer functions are those of each case alone."""

from dataclasses import fields, replace

import numpy as np
import pytest

from electrovib import load
from electrovib.physics.circuit import SeriesElement
from electrovib.physics.debye_sum import DebyeSum
from electrovib.solve.population.response import some_of
from electrovib.solve.stack.modes import Slab, stack_modes
from electrovib.solve.stack.section import field_in_gap, modal_section
from electrovib.solve.stack.transfer import (
    INTEGRATING,
    NotInArraysError,
    Transfer,
    integral_weight,
    integrated,
    resting,
    without_integrators,
)

CASES = 4
FREQUENCY = np.geomspace(1e-2, 1e8, 31)
TIME = np.concatenate([[0.0], np.geomspace(1e-8, 10.0, 40)])
SAME = 1e-12
"""Largest difference over the largest value of a row."""


def of_case(value, case):
    """Return a number, or all numbers of a layer, an element or a permittivity, of one case."""
    if isinstance(value, np.ndarray):
        return float(value[case, 0])
    if isinstance(value, tuple):
        return tuple(of_case(each, case) for each in value)
    if isinstance(value, Slab | DebyeSum | SeriesElement):
        return replace(
            value, **{each.name: of_case(getattr(value, each.name), case) for each in fields(value)}
        )
    return value


def row(values, case):
    """Return the values of one case of an array, which may have no axis of cases."""
    return values[case] if values.ndim == 2 else values


def transfer_of(whole, case):
    """Return the transfer function of one case."""
    rows = {name: row(getattr(whole, name), case) for name in ("rates", "gains", "free")}
    return Transfer(
        **rows, **{name: of_case(getattr(whole, name), case) for name in ("direct", "slope", "static")}
    )


def free_in_time(transfer, case=0):
    """Return the free part of one case over time."""
    return np.exp(-np.outer(TIME, row(transfer.rates, case))) @ row(transfer.free, case)


def assert_same(mine, alone, case, *, scale=None, of_charge=0.0):
    """Compare one case of a transfer function with columns with that of the case alone."""
    its, values = alone.at(FREQUENCY), row(mine.at(FREQUENCY), case)
    size = np.max(np.abs(its), initial=0.0) if scale is None else scale
    assert np.max(np.abs(values - its) / size) < SAME
    left, whole = free_in_time(alone), free_in_time(mine, case)
    assert np.max(np.abs(whole - left)) <= SAME * max(np.max(np.abs(left)), of_charge)


def current_of_charge(modes, slabs):
    """Return the size of the terms that cancel in the current that charge and its image leave [A/m2]."""
    largest, positive = np.max(np.abs(modes.charges)), modes.rates[modes.rates > 0]
    shares = [slab.thickness * np.abs(each.gains) for slab, each in zip(slabs, modes.fields, strict=True)]
    slowest = np.min(positive) if positive.size else 0.0
    return largest * (np.sum(shares, axis=0) @ modes.rates + slowest)


def assert_same_modes(slabs, surroundings):
    """Compare the modes of all cases with those of each."""
    together = stack_modes(slabs, **surroundings)
    for case in range(CASES):
        mine = [of_case(slab, case) for slab in slabs]
        alone = stack_modes(mine, **{name: of_case(each, case) for name, each in surroundings.items()})
        for place in range(len(slabs)):
            assert_same(together.fields[place], alone.fields[place], case)
            assert_same(together.displacements[place], alone.displacements[place], case)
        current, found = alone.current_density, together.current_density
        size = current.direct + current.slope * 2 * np.pi * FREQUENCY
        assert_same(found, current, case, scale=size, of_charge=current_of_charge(alone, mine))
        assert of_case(found.direct, case) == pytest.approx(current.direct, rel=SAME)
        assert of_case(found.static, case) == pytest.approx(current.static, rel=SAME)
        held = row(together.charges, case)
        assert np.max(np.abs(held - alone.charges)) <= SAME * np.max(np.abs(alone.charges))


class Draws:
    """Random numbers, shared by all cases or columns."""

    def __init__(self, seed):
        self.random = np.random.default_rng(seed)

    def number(self, low, high):
        """Return a number between bounds, on a logarithmic scale."""
        many = np.exp(self.random.uniform(np.log(low), np.log(high), (CASES, 1)))
        return many if self.random.random() < 0.6 else float(many[0, 0])

    def maybe(self, low, high):
        """Return a number or 0."""
        return self.number(low, high) if self.random.random() < 0.6 else 0.0

    def slab(self):
        """Return a layer that conducts or blocks, with up to two relaxations."""
        count = int(self.random.integers(0, 3))
        strengths = tuple(self.number(1.0, 1e3) for _ in range(count))
        times = tuple(self.number(1e-6, 1e-2) for _ in range(count))
        sign, thickness = float(self.random.choice([-1.0, 1.0])), self.number(1e-6, 3e-4)
        debye = DebyeSum(self.number(1.0, 80.0), strengths, times)
        return Slab(thickness, debye, self.maybe(1e-9, 1e-4), sign * self.maybe(1e-7, 1e-5))

    def surroundings(self):
        """Return what is in series with the layers."""
        bounds = {
            "resistance": (1e2, 1e6),
            "elastance": (1e9, 1e11),
            "rate": (1.0, 1e3),
            "charge": (1e-11, 1e-9),
        }
        element = SeriesElement(**{name: self.maybe(*between) for name, between in bounds.items()})
        if not np.any(element.elastance):
            element = replace(element, rate=0.0, charge=0.0)
        return {"area": self.number(1e-5, 3e-4), "element": element, "second": self.maybe(0.1, 3.0)}


@pytest.mark.parametrize("seed", range(40))
def test_modes_with_columns_are_those_of_each_case(seed):
    draws = Draws(seed)
    slabs = [draws.slab() for _ in range(int(draws.random.integers(1, 5)))]
    slabs[-1] = replace(slabs[-1], charge=0.0)
    assert_same_modes(slabs, draws.surroundings())


def column(*values):
    """Return numbers as a column."""
    return np.array(values)[:, np.newaxis]


ALONE = {"area": 1e-4, "element": SeriesElement(), "second": 0.0}
WITH_RESISTANCE = ALONE | {"element": SeriesElement(resistance=1e4)}
FILM = Slab(90e-6, DebyeSum(3.35), 0.0)
THICKNESS, CHARGE = column(1e-4, 2e-4, 3e-4, 1e-4), column(1e-6, 2e-6, 3e-6, 4e-6)


@pytest.mark.parametrize("around", [ALONE, WITH_RESISTANCE], ids=["alone", "resistance"])
def test_rates_that_layers_have_in_common(around):
    """In every case: equal columns of rates keep slots of their own, where charge between the layers relaxes; or in one."""
    relaxing = DebyeSum(10.0, (30.0,), (column(1e-3, 2e-3, 3e-3, 4e-3),))
    conductivity = column(1e-8, 3e-8, 1e-7, 4e-7)
    equal = [Slab(1e-4, relaxing, conductivity, CHARGE), Slab(THICKNESS, relaxing, conductivity)]
    assert_same_modes([replace(FILM, charge=1e-6), *equal], around)
    assert_same_modes(equal, around)
    gap = Slab(5e-6, DebyeSum(1.0), column(1e-9, 1e-9, 1e-9, 1e-9))
    skin = Slab(2e-4, DebyeSum(10.0), column(2e-8, 1e-8, 5e-9, 1e-7))  # the second has the rate of the gap
    assert_same_modes([FILM, replace(gap, charge=1e-6), skin], around)
    assert_same_modes([FILM, replace(skin, charge=1e-6), gap], around)


def test_a_number_that_is_0_in_some_cases_is_refused():
    some = column(0.0, 1e-8, 1e-8, 1e-8)
    for slabs, element in (
        ([FILM, Slab(1e-4, DebyeSum(10.0), some)], SeriesElement()),
        ([FILM], SeriesElement(resistance=some)),
    ):
        with pytest.raises(NotInArraysError, match="fewer modes"):
            stack_modes(slabs, **ALONE | {"element": element})


def film_and_skin(film, skin, charge=0.0):
    """Return the layers of a scenario without a gap, with other conductivities."""
    found = {}
    layers = load("vezzoli_2014/fig6").stack.layers
    for (name, layer), conductivity in zip(layers.items(), (film, skin), strict=True):
        material = layer.material.model_copy(update={"conductivity": conductivity})
        on_face = charge if name == "insulator" else 0.0
        found[name] = layer.model_copy(update={"material": material, "initial_charge": on_face})
    return found, {name: layer.material.debye() for name, layer in found.items()}


def test_the_displacement_at_the_interface_begins_with_what_leaves_the_charge_for_the_finger():
    layers, debye = film_and_skin(0.0, 1e-7, charge=1e-5)
    skin = layers["stratum_corneum"]
    layers["stratum_corneum"] = skin.model_copy(update={"initial_charge": 3e-6})
    layers["tissue"], debye["tissue"] = skin.model_copy(update={"role": "finger"}), debye["stratum_corneum"]
    section = modal_section(layers, debye, **WITH_RESISTANCE)
    begin = section["stratum_corneum"].displacement.free.sum()
    assert begin - section["insulator"].displacement.free.sum() == pytest.approx(1e-5, rel=SAME)
    assert section.interface_displacement.free.sum() == pytest.approx(begin, rel=SAME)


def test_a_gap_beside_the_layers_with_columns_is_that_of_each_case():
    """Refused where rates are equal in one case: the drive excites one mode less, and their product would divide by 0."""
    of_skin, of_film = column(1e-8, 1e-7, 4e-6, 3e-7), 1e-10
    around, gap = (
        ALONE | {"element": SeriesElement(resistance=1e6)},
        {"thickness": 2e-6, "conductivity": 1e-9},
    )
    layers, debye = film_and_skin(of_film, of_skin)
    found = field_in_gap(modal_section(layers, debye, **around), **gap).at(FREQUENCY)
    for case in range(CASES):
        mine = modal_section(*film_and_skin(of_film, of_case(of_skin, case)), **around)
        expected = field_in_gap(mine, **gap).at(FREQUENCY)
        assert np.max(np.abs(found[case] - expected)) < 1e-11 * np.max(np.abs(expected))
    of_skin[1, 0] = of_film * debye["stratum_corneum"].high / debye["insulator"].high
    with pytest.raises(NotInArraysError, match="fewer modes"):
        field_in_gap(modal_section(*film_and_skin(of_film, of_skin), **around), **gap)


def test_a_filter_stays_clear_of_the_modes_of_every_case():
    layers, debye = film_and_skin(0.0, 1e-7)
    debye["stratum_corneum"] = DebyeSum(60.0, (1000.0, 30.0), (1e-3, 1e-6))
    section, names = modal_section(layers, debye, **ALONE), tuple(layers)
    one = section.inverse_root_thickness(names).rates
    taken = np.array([[1e-3, 1e9], one[[0, -1]]])
    other = replace(section, modes=replace(section.modes, rates=taken), _roots={})
    assert np.min(np.abs(other.inverse_root_thickness(names).rates[:, np.newaxis] / one[[0, -1]] - 1)) > 1e-6


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


def as_filter(transfer):
    return replace(transfer, free=np.zeros(transfer.rates.shape[-1]), slope=0.0)


FACTOR = column(2.0, -3.0, 0.5, 7.0)


def operations(one, other, factor):
    """Return what can be made of two transfer functions and a number."""
    still, gain, integral = replace(one, slope=0.0), as_filter(other), integrated(one, start=factor)
    return {
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
        "integral": integral,
        "without integrators": without_integrators(integral),
    }


@pytest.mark.parametrize("static", [False, True])
@pytest.mark.parametrize("shared", [False, True])
@pytest.mark.parametrize("operation", operations(random_transfer(1), random_transfer(2), FACTOR))
def test_operations_on_columns_are_those_on_each_case(operation, shared, static):
    one = random_transfer(1, static=static)
    for count in (0, 3):
        other = random_transfer(2, count, shared=shared)
        found = operations(one, other, FACTOR)[operation]
        for case in range(CASES):
            its = other if shared else transfer_of(other, case)
            expected = operations(transfer_of(one, case), its, float(FACTOR[case, 0]))[operation]
            assert_same(found, expected, case)
            assert of_case(found.at_rest(), case) == pytest.approx(expected.at_rest(), rel=1e-10)


def test_modes_in_common_stay_common_and_an_integral_has_its_own():
    one, start = random_transfer(6), column(0.0, 1.0, -2.0, 3.0)
    assert (one + one * FACTOR).rates is one.rates
    found = some_of({"first": one, "second": one * FACTOR}, slice(1, 3))
    assert found["first"].rates is found["second"].rates
    assert np.array_equal(found["first"].rates, one.rates[1:3])
    assert np.array_equal(found["second"].direct, one.direct[1:3] * FACTOR[1:3])
    integral = integrated(one, start=start)
    assert np.count_nonzero(integral.rates[0] == INTEGRATING) == 1
    assert np.allclose(integral_weight(integral), one.at_rest(), rtol=SAME, atol=0)
    for case in range(CASES):
        assert free_in_time(integral, case)[0] == pytest.approx(float(start[case, 0]), abs=1e-12)
        values = transfer_of(one, case).at(FREQUENCY) / (2j * np.pi * FREQUENCY)
        assert np.max(np.abs(integral.at(FREQUENCY)[case] / values - 1)) < 1e-9


def test_modes_that_cancel_or_are_not_driven_in_one_case_respond_in_the_others():
    """What is rounding beside the modes of one case may be a response beside those of another."""
    gains = np.array([[1.0, -1.0 + 1e-15], [1e-9, -1e-9 + 1e-15], [1.0, 2.0], [0.0, 0.0]])
    whole = Transfer(rates=np.array([1.0, 2.0]), gains=gains)
    found = resting(whole)
    assert found[:, 0].tolist() == [resting(transfer_of(whole, case)) for case in range(CASES)]
    assert found[0, 0] == 0
    assert found[1, 0] == pytest.approx(1e-15, rel=1e-6)
    gains = np.array([[0.0, 1.0], [2.0, 1.0], [3.0, 0.0], [4.0, 1.0]])
    whole = Transfer(rates=np.array([3.0, 40.0]), gains=gains)
    for case in range(CASES):
        assert_same(whole, transfer_of(whole, case), case)
