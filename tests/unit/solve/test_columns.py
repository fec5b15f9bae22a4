"""Numbers as columns of cases: stacks and transfer functions are those of each case alone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from electrovib import load
from electrovib.physics.circuit import SeriesElement
from electrovib.physics.debye_sum import DebyeSum
from electrovib.solve.population.response import some_of
from electrovib.solve.stack.expand import current_section
from electrovib.solve.stack.modes import Slab, blocked, slots, stack_modes
from electrovib.solve.stack.section import field_in_gap, modal_section
from electrovib.solve.stack.secular import secular_roots
from electrovib.solve.stack.transfer import (
    INTEGRATING,
    NotInArraysError,
    Transfer,
    integral_weight,
    integrated,
    resting,
    without_integrators,
)

EPS0 = 8.8541878128e-12
CASES = 4
FREQUENCY = np.geomspace(1e-2, 1e8, 31)
TIME = np.concatenate([[0.0], np.geomspace(1e-8, 10.0, 40)])
SAME = 1e-12
"""Largest difference over the largest value of a row."""


def of_case(number, case):
    """Return the number of one case."""
    return float(number[case, 0]) if isinstance(number, np.ndarray) else number


def slab_of(slab, case):
    """Return a layer of one case."""
    debye = DebyeSum(
        of_case(slab.debye.high, case),
        tuple(of_case(each, case) for each in slab.debye.strengths),
        tuple(of_case(each, case) for each in slab.debye.relaxation_times),
    )
    thickness, *rest = (of_case(each, case) for each in (slab.thickness, slab.conductivity, slab.charge))
    return Slab(thickness, debye, *rest)


def element_of(element, case):
    """Return the series element of one case."""
    names = ("resistance", "elastance", "rate", "charge")
    return SeriesElement(**{name: of_case(getattr(element, name), case) for name in names})


def row(values, case):
    """Return the values of one case of an array, which may have no axis of cases."""
    return values[case] if values.ndim == 2 else values


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
        mine = [slab_of(slab, case) for slab in slabs]
        alone = stack_modes(
            mine,
            area=of_case(surroundings["area"], case),
            element=element_of(surroundings["element"], case),
            second=of_case(surroundings["second"], case),
        )
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
        sign = float(self.random.choice([-1.0, 1.0]))
        return Slab(
            self.number(1e-6, 3e-4),
            DebyeSum(self.number(1.0, 80.0), strengths, times),
            self.maybe(1e-9, 1e-4),
            sign * self.maybe(1e-7, 1e-5),
        )

    def surroundings(self):
        """Return what is in series with the layers."""
        element = SeriesElement(
            resistance=self.maybe(1e2, 1e6),
            elastance=self.maybe(1e9, 1e11),
            rate=self.maybe(1.0, 1e3),
            charge=self.maybe(1e-11, 1e-9),
        )
        if not np.any(element.elastance):
            element = replace(element, rate=0.0, charge=0.0)
        return {"area": self.number(1e-5, 3e-4), "element": element, "second": self.maybe(0.1, 3.0)}


@pytest.mark.parametrize("seed", range(60))
def test_modes_with_columns_are_those_of_each_case(seed):
    draws = Draws(seed)
    slabs = [draws.slab() for _ in range(int(draws.random.integers(1, 5)))]
    slabs[-1] = replace(slabs[-1], charge=0.0)
    assert_same_modes(slabs, draws.surroundings())


def column(*values):
    """Return numbers as a column."""
    return np.array(values)[:, np.newaxis]


CONDUCTIVITY = column(1e-8, 3e-8, 1e-7, 4e-7)
ALONE = {"area": 1e-4, "element": SeriesElement(), "second": 0.0}
FILM = Slab(90e-6, DebyeSum(3.35), 0.0)


@pytest.mark.parametrize("resistance", [0.0, 1e4])
def test_two_layers_with_the_same_rates_in_every_case(resistance):
    """Equal columns of rates keep slots of their own, at the same place; charge between the layers relaxes there."""
    skin = DebyeSum(10.0, (30.0,), (column(1e-3, 2e-3, 3e-3, 4e-3),))
    slabs = [
        replace(FILM, charge=1e-6),
        Slab(1e-4, skin, CONDUCTIVITY, column(1e-6, 2e-6, 3e-6, 4e-6)),
        Slab(column(1e-4, 2e-4, 3e-4, 1e-4), skin, CONDUCTIVITY),
    ]
    surroundings = ALONE | {"element": SeriesElement(resistance=resistance)}
    assert_same_modes(slabs, surroundings)
    assert_same_modes(slabs[1:], surroundings)


def test_rates_that_are_equal_in_one_case_only():
    gap = Slab(5e-6, DebyeSum(1.0), column(1e-9, 1e-9, 1e-9, 1e-9))
    skin = Slab(2e-4, DebyeSum(10.0), column(2e-8, 1e-8, 5e-9, 1e-7))  # the second has the rate of the gap
    for layers in ([FILM, replace(gap, charge=1e-6), skin], [FILM, replace(skin, charge=1e-6), gap]):
        assert_same_modes(layers, ALONE | {"element": SeriesElement(resistance=1e4)})
        assert_same_modes(layers, ALONE)


def test_a_second_contact_doubles_the_poles_of_every_layer():
    """A charge in one contact relaxes with the own rate of its layer, which the drive does not excite."""
    slabs = [replace(FILM, charge=1e-6), Slab(column(1e-4, 2e-4, 3e-4, 1e-4), DebyeSum(10.0), 1e-8)]
    modes = stack_modes(slabs, **ALONE | {"second": 0.5})
    own = 1e-8 / (EPS0 * 10)
    assert np.count_nonzero(np.isclose(modes.rates[0], own, rtol=1e-12)) == 1
    assert_same_modes(slabs, ALONE | {"second": column(0.5, 1.0, 2.0, 0.1)})


def test_a_number_that_is_0_in_some_cases_is_refused():
    some = column(0.0, 1e-8, 1e-8, 1e-8)
    with pytest.raises(NotInArraysError, match="fewer modes"):
        stack_modes([FILM, Slab(1e-4, DebyeSum(10.0), some)], **ALONE)
    with pytest.raises(NotInArraysError, match="fewer modes"):
        stack_modes([FILM], **ALONE | {"element": SeriesElement(resistance=some)})


def test_nodes_of_a_column_are_beside_those_that_all_cases_share():
    moving = column(5.0, 1.0, 3.0, 7.0) * np.array([[0.0, 1.0, 2.0]])
    nodes, places = slots([np.array([0.0, 2.0]), moving, np.array([2.0, 4.0])])
    assert nodes.shape == (CASES, 5)
    assert [each.tolist() for each in places] == [[0, 1], [0, 3, 4], [1, 2]]
    for rates, where in zip([np.array([0.0, 2.0]), moving], places, strict=False):
        assert np.array_equal(nodes[:, where], np.broadcast_to(rates, (CASES, len(where))))
    assert blocked(moving).tolist() == [True, False, False]
    assert blocked(np.array([[0.0, 0.0], [0.0, 3.0]])).tolist() == [True, False]


@pytest.mark.parametrize("constant", [0.0, 2.0, column(1.0, 2.0, 3.0, 4.0)])
@pytest.mark.parametrize("count", [1, 2, 5])
def test_roots_of_nodes_in_any_order(count, constant):
    random = np.random.default_rng(count)
    nodes = 10 ** random.uniform(-3, 6, (CASES, count))
    weights = 10 ** random.uniform(-3, 3, (CASES, count))
    found = secular_roots(nodes, weights, constant=constant)
    differences = found.differences()
    for case in range(CASES):
        order = np.argsort(nodes[case])
        level = of_case(constant, case)
        alone = secular_roots(nodes[case, order], weights[case, order], constant=level)
        assert np.allclose(found.values[case], alone.values, rtol=SAME, atol=0)
        assert np.allclose(found.slope[case], alone.slope, rtol=SAME, atol=0)
        assert np.array_equal(found.origin[case], order[alone.origin])
        assert np.allclose(differences[case][:, order], alone.differences(), rtol=SAME, atol=0)


@pytest.mark.parametrize("seed", range(20))
def test_sections_per_ampere_with_columns_are_those_of_each_case(seed):
    draws, layers, debye = Draws(seed), load("vezzoli_2014/fig6_gap").stack.layers, {}
    some, area = {}, draws.number(1e-5, 3e-4)
    for place, (name, layer) in enumerate(layers.items()):
        slab = draws.slab()
        debye[name] = slab.debye
        material = layer.material.model_copy(update={"conductivity": slab.conductivity})
        charge = slab.charge if place < len(layers) - 1 else 0.0
        some[name] = layer.model_copy(
            update={"thickness": slab.thickness, "material": material, "initial_charge": charge}
        )
    together = current_section(some, debye, area=area)
    around = draws.surroundings() | {"area": area}
    per_volt = modal_section(some, debye, **around)
    for case in range(CASES):
        mine, its = {}, {}
        for name, layer in some.items():
            slab = slab_of(
                Slab(layer.thickness, debye[name], layer.material.conductivity, layer.initial_charge), case
            )
            its[name] = slab.debye
            material = layer.material.model_copy(update={"conductivity": slab.conductivity})
            mine[name] = layer.model_copy(
                update={"thickness": slab.thickness, "material": material, "initial_charge": slab.charge}
            )
        alone = current_section(mine, its, area=of_case(area, case))
        for name in some:
            assert_same(together[name].field, alone[name].field, case)
            assert_same(together[name].displacement, alone[name].displacement, case)
        assert_same(together.voltage, alone.voltage, case)
        assert_same(together.current_density, alone.current_density, case)
        single = {"area": of_case(area, case), "second": of_case(around["second"], case)}
        volt = modal_section(mine, its, element=element_of(around["element"], case), **single)
        assert_same(per_volt.voltage, volt.voltage, case)
        whole, part = per_volt.interface_displacement, volt.interface_displacement
        assert_same(whole, part, case)


def film_and_skin(film, skin, charge=0.0):
    """Return the layers of a scenario without a gap, with other conductivities."""
    found = {}
    for (name, layer), conductivity in zip(
        load("vezzoli_2014/fig6").stack.layers.items(), (film, skin), strict=True
    ):
        material = layer.material.model_copy(update={"conductivity": conductivity})
        on_face = charge if name == "insulator" else 0.0
        found[name] = layer.model_copy(update={"material": material, "initial_charge": on_face})
    return found, {name: layer.material.debye() for name, layer in found.items()}


def test_the_displacement_at_the_interface_begins_with_what_leaves_the_charge_for_the_finger():
    layers, debye = film_and_skin(0.0, 1e-7, charge=1e-5)
    skin = layers["stratum_corneum"]
    layers["stratum_corneum"] = skin.model_copy(update={"initial_charge": 3e-6})
    layers["tissue"], debye["tissue"] = skin.model_copy(update={"role": "finger"}), debye["stratum_corneum"]
    around = ALONE | {"element": SeriesElement(resistance=1e4)}
    section = modal_section(layers, debye, **around)
    begin = section["stratum_corneum"].displacement.free.sum()
    assert begin - section["insulator"].displacement.free.sum() == pytest.approx(1e-5, rel=SAME)
    assert section.interface_displacement.free.sum() == pytest.approx(begin, rel=SAME)


def test_a_gap_beside_the_layers_with_columns_is_that_of_each_case():
    of_skin, of_film = column(1e-8, 1e-7, 4e-6, 3e-7), 1e-10
    layers, debye = film_and_skin(of_film, of_skin)
    around = ALONE | {"element": SeriesElement(resistance=1e6)}
    found = field_in_gap(modal_section(layers, debye, **around), thickness=2e-6, conductivity=1e-9)
    for case in range(CASES):
        mine, its = film_and_skin(of_film, of_case(of_skin, case))
        alone = field_in_gap(modal_section(mine, its, **around), thickness=2e-6, conductivity=1e-9)
        expected = alone.at(FREQUENCY)
        assert np.max(np.abs(found.at(FREQUENCY)[case] - expected)) < 1e-11 * np.max(np.abs(expected))


def test_a_gap_beside_layers_with_equal_rates_in_one_case_is_refused():
    """There the drive excites one mode less, at a rate of both factors: their product would divide by 0."""
    of_skin, of_film = column(1e-8, 1e-7, 4e-6, 3e-7), 1e-10
    _, debye = film_and_skin(of_film, of_skin)
    of_skin[1, 0] = of_film * debye["stratum_corneum"].high / debye["insulator"].high
    section = modal_section(
        *film_and_skin(of_film, of_skin), **ALONE | {"element": SeriesElement(resistance=1e6)}
    )
    with pytest.raises(NotInArraysError, match="fewer modes"):
        field_in_gap(section, thickness=2e-6, conductivity=1e-9)


def test_a_filter_stays_clear_of_the_modes_of_every_case():
    layers, debye = film_and_skin(0.0, 1e-7)
    debye["stratum_corneum"] = DebyeSum(60.0, (1000.0, 30.0), (1e-3, 1e-6))
    section, names = modal_section(layers, debye, **ALONE), tuple(layers)
    one = section.inverse_root_thickness(names).rates
    taken = np.array([[1e-3, 1e9], one[[0, -1]]])
    other = replace(section, modes=replace(section.modes, rates=taken), _roots={})
    assert np.min(np.abs(other.inverse_root_thickness(names).rates[:, np.newaxis] / one[[0, -1]] - 1)) > 1e-6


def random_transfer(seed, count=3, *, static=False, is_filter=False, shared=False):
    """Return a transfer function of columns, and that of each case."""
    random = np.random.default_rng(seed)
    lead = () if shared else (CASES,)
    rates, gains = 10 ** random.uniform(-2, 6, (*lead, count)), random.normal(size=(*lead, count))
    free = np.zeros(count) if is_filter else random.normal(size=(*lead, count))
    one = 1 if shared else (CASES, 1)
    direct = random.normal(size=one)
    slope = 0.0 if is_filter else 1e-9 * random.normal(size=one)
    if shared:
        direct, slope = float(direct[0]), float(np.ravel(slope)[0])
    level = direct + gains.sum(axis=-1, keepdims=not shared) if static else None
    if shared and static:
        level = float(level)
    whole = Transfer(rates=rates, gains=gains, direct=direct, slope=slope, free=free, static=level)
    return whole, [case_of(whole, case) for case in range(CASES)]


def case_of(transfer, case):
    """Return the transfer function of one case."""
    return Transfer(
        rates=row(transfer.rates, case),
        gains=row(transfer.gains, case),
        direct=of_case(transfer.direct, case),
        slope=of_case(transfer.slope, case),
        free=row(transfer.free, case),
        static=None if transfer.static is None else of_case(transfer.static, case),
    )


FACTOR = column(2.0, -3.0, 0.5, 7.0)


@pytest.mark.parametrize("static", [False, True])
@pytest.mark.parametrize("shared", [False, True])
def test_sums_and_multiples_with_columns(shared, static):
    one, ones = random_transfer(1, static=static)
    other, others = random_transfer(2, shared=shared)
    for case in range(CASES):
        factor = float(FACTOR[case, 0])
        mine, its = ones[case], others[case]
        for found, expected in (
            (one + other, mine + its),
            (one - other, mine - its),
            (other - one, its - mine),
            (one + one * FACTOR, mine + mine * factor),
            (FACTOR * one, factor * mine),
            (one / FACTOR, mine * (1 / factor)),
            (one * FACTOR / FACTOR, mine),
            (other * FACTOR, its * factor),
            (-one, mine * -1.0),
        ):
            assert_same(found, expected, case)
        assert of_case((one + other).at_rest(), case) == pytest.approx((mine + its).at_rest(), rel=SAME)
        values = mine.at(FREQUENCY) / factor
        assert np.max(np.abs((one / FACTOR).at(FREQUENCY)[case] / values - 1)) < SAME
    assert (one + one * FACTOR).rates is one.rates  # modes in common stay common


@pytest.mark.parametrize("static", [False, True])
@pytest.mark.parametrize("shared", [False, True])
def test_products_with_columns(shared, static):
    signal, signals = random_transfer(3, static=static)
    signal = replace(signal, slope=0.0)
    for count in (0, 2):
        gain, gains = random_transfer(4, count, is_filter=True, shared=shared)
        for case in range(CASES):
            mine = replace(signals[case], slope=0.0)
            expected = mine.at(FREQUENCY) * gains[case].at(FREQUENCY)
            for product in (signal * gain, gain * signal):
                values = row(product.at(FREQUENCY), case)
                assert np.max(np.abs(values - expected)) < SAME * np.max(np.abs(expected))
                assert_same(product, gains[case] * mine, case)
                level = of_case(product.at_rest(), case)
                assert level == pytest.approx(mine.at_rest() * gains[case].at_rest(), rel=1e-10)


@pytest.mark.parametrize("static", [False, True])
def test_integrals_with_columns(static):
    one, ones = random_transfer(5, static=static)
    start = column(0.0, 1.0, -2.0, 3.0)
    found = integrated(one, start=start)
    weight = integral_weight(found)
    for case in range(CASES):
        expected = integrated(ones[case], start=float(start[case, 0]))
        s = 2j * np.pi * FREQUENCY
        values = ones[case].at(FREQUENCY) / s
        assert np.max(np.abs(found.at(FREQUENCY)[case] / values - 1)) < 1e-9
        assert_same(found, expected, case)
        assert weight[case, 0] == pytest.approx(ones[case].at_rest(), rel=SAME)
        mine, its = without_integrators(found), without_integrators(expected)
        assert_same(mine, its, case)
        assert free_in_time(found, case)[0] == pytest.approx(float(start[case, 0]), abs=1e-12)
    assert np.count_nonzero(found.rates[0] == INTEGRATING) == 1


def test_rest_is_nothing_where_the_modes_of_the_case_cancel():
    """What is rounding beside the modes of one case may be a response beside those of another."""
    gains = np.array([[1.0, -1.0 + 1e-15], [1e-9, -1e-9 + 1e-15], [1.0, 2.0], [0.0, 0.0]])
    whole = Transfer(rates=np.array([1.0, 2.0]), gains=gains)
    found = resting(whole)
    for case in range(CASES):
        assert found[case, 0] == resting(case_of(whole, case))
    assert found[0, 0] == 0
    assert found[1, 0] == pytest.approx(1e-15, rel=1e-6)


def test_a_mode_that_one_case_does_not_drive_responds_in_the_others():
    gains = np.array([[0.0, 1.0], [2.0, 1.0], [3.0, 0.0], [4.0, 1.0]])
    whole = Transfer(rates=np.array([3.0, 40.0]), gains=gains)
    for case in range(CASES):
        assert_same(whole, case_of(whole, case), case)


def test_some_cases_keep_modes_in_common():
    one, _ = random_transfer(6)
    found = some_of({"first": one, "second": one * FACTOR}, slice(1, 3))
    assert found["first"].rates is found["second"].rates
    assert np.array_equal(found["first"].rates, one.rates[1:3])
    assert np.array_equal(found["second"].direct, one.direct[1:3] * FACTOR[1:3])
