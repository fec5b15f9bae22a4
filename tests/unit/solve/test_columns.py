"""Numbers as columns of cases: stacks are those of each case alone."""

from dataclasses import fields, replace

import numpy as np
import pytest

from electrovib import load
from electrovib.physics.circuit import SeriesElement
from electrovib.physics.debye_sum import DebyeSum
from electrovib.solve.stack.modes import Slab, stack_modes
from electrovib.solve.stack.section import field_in_gap, modal_section
from electrovib.solve.stack.transfer import NotInArraysError

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
