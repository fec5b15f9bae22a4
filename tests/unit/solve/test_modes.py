"""Layers and stacks as modes: expansions, charge on interfaces, double modes, corners; columns of cases are those of each."""

from dataclasses import fields, replace

import numpy as np
import pytest

from electrovib import load
from electrovib.physics.circuit import SeriesElement
from electrovib.physics.debye_sum import DebyeSum
from electrovib.solve.stack.modes import Slab, merged_terms, slab_impedance, stack_modes
from electrovib.solve.stack.section import field_in_gap, modal_section
from electrovib.solve.stack.transfer import NotInArraysError

EPS0 = 8.8541878128e-12
AREA = 1e-4
FREQUENCY = np.geomspace(1e-3, 1e9, 61)
S = 2j * np.pi * FREQUENCY
ROUNDING = 1e-13
FILM = Slab(90e-6, DebyeSum(3.35), 0.0)
GAP = Slab(5e-6, DebyeSum(1.0), 0.0)
SKIN = Slab(200e-6, DebyeSum(60.0, (4000.0, 30.0), (1e-3, 1e-6)), 1e-6)
EQUAL = Slab(1e-4, DebyeSum(10.0), 1e-8)
OWN = 1e-8 / (EPS0 * 10)
NONE = SeriesElement()
BODY = SeriesElement(resistance=1e3, elastance=1e10)
KILOOHMS = SeriesElement(resistance=1e4)


def impedance(slab):
    return slab.thickness / (S * EPS0 * slab.debye.permittivity(FREQUENCY) + slab.conductivity)


def charged(slab, charge):
    return replace(slab, charge=charge)


def modes_of(*slabs, element=NONE, second=0.0):
    return stack_modes(slabs, area=AREA, element=element, second=second)


def free_over_frequency(modes, place):
    return np.sum(modes.fields[place].free / (S[:, None] + modes.rates), axis=1)


def test_equal_relaxations_add_and_empty_ones_go():
    rates, strengths = merged_terms(DebyeSum(1.0, (2.0, 0.0, 3.0, 5.0), (1e-3, 1.0, 1e-3, 1e-6)))
    assert np.array_equal(rates, [1e3, 1e6])
    assert np.array_equal(strengths, [5.0, 5.0])


@pytest.mark.parametrize(
    "slab",
    [
        FILM,
        SKIN,
        Slab(1e-6, DebyeSum(3.9), 1e-9),
        Slab(1e-3, DebyeSum(2.0, (1e5,), (10.0,)), 0.0),
        Slab(1e-3, DebyeSum(2.0, (1e5, 1e-3), (10.0, 1e-12)), 1.0),
        Slab(1e-3, DebyeSum(2.0, (5.0, 7.0), (1e-3, 1e-3)), 1e-6),
    ],
)
def test_slab(slab):
    """The sum over its poles is the impedance of the declared material; all residues are positive."""
    rates, residues = slab_impedance(slab)
    assert np.all(residues > 0)
    assert np.all(np.diff(rates) > 0)
    assert (rates[0] == 0) == (slab.conductivity == 0)
    found = np.sum(residues / (S[:, None] + rates), axis=1)
    assert np.max(np.abs(found / impedance(slab) - 1)) < ROUNDING


def test_one_capacitor_has_no_mode_and_one_behind_a_resistor_has_one():
    modes, slope = modes_of(FILM), pytest.approx(EPS0 * 3.35 / 90e-6, rel=1e-15)
    assert len(modes.rates) == modes.driven == 0
    assert modes.fields[0].direct == 1 / 90e-6
    assert modes.displacements[0].direct == slope
    assert modes.current_density.slope == slope
    assert modes.current_density.direct == 0
    modes = modes_of(FILM, element=SeriesElement(resistance=1e3))
    rate = 90e-6 / (EPS0 * 3.35 * AREA * 1e3)
    assert modes.rates == pytest.approx([rate], rel=1e-15)
    assert modes.fields[0].direct == 0
    assert modes.fields[0].gains == pytest.approx([1 / 90e-6], rel=1e-15)
    assert modes.current_density.direct == pytest.approx(1 / (1e3 * AREA), rel=1e-15)
    assert modes.current_density.gains == pytest.approx([-1 / (1e3 * AREA)], rel=1e-15)


@pytest.mark.parametrize("second", [0.0, 0.5])
@pytest.mark.parametrize("element", [NONE, KILOOHMS, SeriesElement(elastance=1e10, rate=3.0), BODY], ids=repr)
def test_layers_and_surroundings_share_the_drive(element, second):
    """At every frequency; and a constant voltage flows through the conductances."""
    slabs = [FILM, GAP, SKIN]
    modes = modes_of(*slabs, element=element, second=second)
    drops = np.array([impedance(slab) for slab in slabs])
    current = 1 / (drops.sum(axis=0) * (1 + second) + AREA * element.impedance(FREQUENCY))
    for slab, drop, field in zip(slabs, drops, modes.fields, strict=True):
        assert np.max(np.abs(field.at(FREQUENCY) * slab.thickness - drop * current)) < ROUNDING
    size = modes.current_density.direct + modes.current_density.slope * 2 * np.pi * FREQUENCY
    assert np.all(np.abs(modes.current_density.at(FREQUENCY) - current) < ROUNDING * size)
    if not element.elastance:
        leaky = [replace(FILM, conductivity=1e-9), SKIN]
        current = modes_of(*leaky, element=element, second=second).current_density
        expected = sum(slab.thickness / slab.conductivity for slab in leaky) * (1 + second)
        assert current.static == pytest.approx(1 / (expected + AREA * element.resistance), rel=1e-13)
        found = current.direct + current.gains.sum()
        assert found == pytest.approx(current.static, abs=1e-12 * current.direct)


def test_equal_layers_have_modes_that_only_charge_excites():
    """Two equal leaky layers: the drive sees one, charge between them decays with their own rate."""
    modes = modes_of(charged(EQUAL, 1e-6), EQUAL)
    assert modes.driven == 0
    assert modes.rates == pytest.approx([OWN], rel=1e-15)
    first, second = modes.fields
    assert first.direct * 1e-4 == second.direct * 1e-4 == 0.5
    half = 1e-6 / (2 * EPS0 * 10)
    assert first.free == pytest.approx([-half], rel=1e-14)  # lines end on the charge from both sides
    assert second.free == pytest.approx([half], rel=1e-14)


def test_charge_and_a_floating_body():
    """In the end charge on the film has two paths to ground: through the film, and over the skin through the body.

    Where it came from the body it goes back to it. Without charge on the layers, the body's charge is on its own capacitor
    and on the stack, in parallel to ground.
    """
    charge, film, body = 1e-5, FILM.thickness / (EPS0 * FILM.debye.high), AREA * BODY.elastance
    modes = modes_of(charged(FILM, charge), SKIN, element=BODY)
    kept = [field.free[modes.rates == 0].sum() for field in modes.fields]
    assert kept[0] * FILM.thickness == pytest.approx(-charge * film * body / (film + body), rel=1e-12)
    assert abs(kept[1]) < ROUNDING * abs(kept[0])  # the skin conducts

    modes = modes_of(charged(FILM, charge), SKIN, element=replace(BODY, charge=-charge * AREA))
    assert np.count_nonzero(modes.rates == 0) == 1
    for field in modes.fields:
        assert np.abs(field.free[modes.rates == 0].sum()) < ROUNDING * np.max(np.abs(field.free))
        assert np.max(np.abs(field.free)) > 0

    slabs = [FILM, SKIN]
    modes = modes_of(*slabs, element=replace(BODY, charge=2e-9))
    lengths = sum(slab.thickness / slab.debye.high for slab in slabs)
    across = sum(field.free.sum() * slab.thickness for field, slab in zip(modes.fields, slabs, strict=True))
    assert across == pytest.approx(-2e-9 / (1 / BODY.elastance + EPS0 * AREA / lengths), rel=1e-12)


@pytest.mark.parametrize("second", [0.0, 0.5])
@pytest.mark.parametrize("body", [0.0, 2e-9])
def test_no_current_flows_at_first(body, second):
    """The plate's image of all charges, that of the body among them, is such that the voltages of all parts add up to 0."""
    modes = modes_of(charged(FILM, 1e-5), SKIN, element=replace(BODY, charge=body), second=second)
    current = modes.current_density.free
    assert np.abs(current.sum()) < 1e-12 * np.abs(current).sum()


@pytest.mark.parametrize("second", [0.0, 0.5, 1.0])
@pytest.mark.parametrize(
    "slabs",
    [
        [charged(FILM, 1e-6), EQUAL],
        [charged(FILM, 1e-6), GAP, SKIN],
        [charged(FILM, 2e-6), charged(GAP, -1e-6), SKIN],
    ],
)
def test_charge_drives_a_current_through_what_lies_around_it(slabs, second):
    """The displacement before each layer is its charge and what flows, as the impedances say.

    A second contact of the same size has the same poles: the difference of both decays with the rate of a layer alone.
    """
    modes = modes_of(*slabs, element=KILOOHMS, second=second)
    drops, charges = [impedance(slab) for slab in slabs], modes.charges[:-1]  # the last is that of the body
    around = (1 + second) * sum(drops) + AREA * KILOOHMS.impedance(FREQUENCY)
    current = -sum(charge * drop for charge, drop in zip(charges, drops, strict=True)) / around
    for place, drop in enumerate(drops):
        expected = drop * (charges[place] + current) / slabs[place].thickness
        # towards zero frequency the modes of the film and the gap cancel down to what the skin conducts
        assert np.max(np.abs(free_over_frequency(modes, place) - expected)) < 1e-9 * np.max(np.abs(expected))
    assert np.diff(charges) == pytest.approx([slab.charge for slab in slabs[:-1]], rel=1e-9)
    if second == 1 and slabs[-1] is EQUAL:
        alone = modes.fields[1].free[np.isclose(modes.rates, OWN, rtol=1e-13)]
        assert alone == pytest.approx([charges[1] / 2 / (EPS0 * EQUAL.debye.high)], rel=1e-12)


def test_gauss_at_the_charge():
    """The displacement, conducted charge included, jumps by the charge: at first and for ever after."""
    slabs = [charged(FILM, 2e-5), charged(GAP, -1e-5), SKIN]
    modes = modes_of(*slabs, element=KILOOHMS)
    time = np.concatenate([[0.0], np.geomspace(1e-9, 10, 60)])
    decays = np.exp(-np.outer(time, modes.rates))
    fields = np.array([decays @ field.free for field in modes.fields])
    bound = np.array([decays @ displacement.free for displacement in modes.displacements])
    assert np.max(np.abs(bound[1] - bound[0] - 2e-5)) < ROUNDING * 2e-5  # film and gap do not conduct
    with np.errstate(invalid="ignore", divide="ignore"):
        decayed = -np.expm1(-np.outer(time, modes.rates)) / modes.rates
    spent = np.where(modes.rates > 0, decayed, time[:, None])
    conducted = SKIN.conductivity * spent @ modes.fields[2].free
    assert np.max(np.abs(bound[2] + conducted - bound[1] + 1e-5)) < ROUNDING * 2e-5
    # no drive: the layers hold what the resistance does not
    across = sum(field * slab.thickness for field, slab in zip(fields, slabs, strict=True))
    flow = decays @ modes.current_density.free
    assert np.max(np.abs(across + AREA * 1e4 * flow)) < ROUNDING * np.max(np.abs(across))
    assert np.max(np.abs(across)) > 0.1  # it compares something


def test_large_and_small_rates_live_together():
    """A gap full of sweat (0.7 ns) and a skin that relaxes in seconds: the slow rate keeps all its digits."""
    modes = modes_of(FILM, Slab(5e-6, DebyeSum(80.0), 1.0), Slab(200e-6, DebyeSum(1560.0), 1e-12))
    K, k = 90e-6 / (EPS0 * 3.35), 200e-6 / (EPS0 * 1560)
    # without the wet gap, whose share is 1e-12 of it: one capacitor and one leaky one
    alone = 1e-12 / (EPS0 * 1560) * K / (K + k)
    assert modes.rates.min() == pytest.approx(alone, rel=1e-11)
    assert modes.rates.max() / modes.rates.min() > 1e11
    modes = modes_of(SKIN)  # one leaky layer is not a mode of a voltage drive
    assert np.max(np.abs(modes.fields[0].at(FREQUENCY) * SKIN.thickness - 1)) < ROUNDING
    current = modes.current_density.at(FREQUENCY)
    assert np.max(np.abs(current * impedance(SKIN) - 1)) < 1e-10  # where conduction is 1e-3 of the terms


CASES = 4
FEW = np.geomspace(1e-2, 1e8, 31)
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
    its, values = alone.at(FEW), row(mine.at(FEW), case)
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
        size = current.direct + current.slope * 2 * np.pi * FEW
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
    around = ALONE | {"element": SeriesElement(resistance=1e6)}
    gap = {"thickness": 2e-6, "conductivity": 1e-9}
    layers, debye = film_and_skin(of_film, of_skin)
    found = field_in_gap(modal_section(layers, debye, **around), **gap).at(FEW)
    for case in range(CASES):
        mine = modal_section(*film_and_skin(of_film, of_case(of_skin, case)), **around)
        expected = field_in_gap(mine, **gap).at(FEW)
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
