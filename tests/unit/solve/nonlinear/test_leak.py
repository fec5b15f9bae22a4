"""A leak beside one layer: the linear answer to it against impedances, its scalar equation, its march and the error of it."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from electrovib.core.errors import InputError
from electrovib.physics.circuit import SeriesElement
from electrovib.physics.conduction import FieldConduction, PolarityConduction
from electrovib.physics.material import Constant, Debye, DebyeTerm, Prony
from electrovib.physics.stack import Layer
from electrovib.solve.electrics import leaks, steps
from electrovib.solve.electrics.leaks import (
    field_under_leak,
    follow,
    leak_alone,
    leak_section,
    leaking_slab,
    leaking_slabs,
    leaky_response,
)
from electrovib.solve.electrics.transient import transient
from electrovib.solve.stack.expand import current_section, linearised
from electrovib.solve.stack.keys import FieldOf
from electrovib.solve.stack.section import modal_section

EPS0 = 8.8541878128e-12
AREA = 1e-4
AGREEMENT = 1e-11
"""Of the sum of all modes' sizes at the frequency, which is what their rounding is made of."""
FREQUENCY = np.geomspace(1e-2, 1e7, 60)
RECTIFYING = PolarityConduction(conductivity_positive=3e-6, conductivity_negative=1e-6)
GROWING = FieldConduction(conductivity=2e-6, onset_field=1e4)
LEAKS = {"polarity": RECTIFYING, "field": GROWING}
OHMIC = PolarityConduction(conductivity_positive=3e-6, conductivity_negative=3e-6)
TERMS = (DebyeTerm(strength=50.0, relaxation_time=1e-6), DebyeTerm(strength=900.0, relaxation_time=1e-2))


def random_layers(random):
    """Two to four layers, some of one material, some blocking."""
    shared, layers = Constant(permittivity=3.0), {}
    for index in range(int(random.integers(2, 5))):
        blocks = random.random() < 0.4
        conducts = {"conductivity": 0.0 if blocks else float(10 ** random.uniform(-12, -4))}
        kinds = (
            shared,
            Constant(permittivity=float(random.uniform(1, 2000)), **conducts),
            Debye(permittivity_high=5.0, strength=300.0, relaxation_time=1e-4, **conducts),
            Prony(permittivity_high=10.0, terms=TERMS, **conducts),
        )
        thickness, material = float(10 ** random.uniform(-6, -3.5)), kinds[int(random.integers(len(kinds)))]
        layers[f"layer_{index}"] = Layer(thickness=thickness, role="plate", material=material)
    return layers, {name: layer.material.debye() for name, layer in layers.items()}


def agrees(transfer, expected):
    s = 2j * np.pi * FREQUENCY[:, None]
    parts = np.abs(transfer.gains * transfer.rates / (s + transfer.rates)).sum(axis=1) + abs(transfer.direct)
    assert np.max(np.abs(transfer.at(FREQUENCY) - expected) / (parts + np.abs(expected))) < AGREEMENT


ELEMENTS = {
    "nothing": SeriesElement(),
    "resistor": SeriesElement(resistance=1e5),
    "floating": SeriesElement(resistance=0.0, elastance=1 / 150e-12),
    "leaking body": SeriesElement(resistance=1e3, elastance=1 / 150e-12, rate=20.0),
}


@pytest.mark.parametrize("around", ELEMENTS)
@pytest.mark.parametrize("seed", range(12))
def test_the_answer_to_a_leak(seed, around):
    random, element = np.random.default_rng(seed), ELEMENTS[around]
    layers, debye = random_layers(random)
    leaking = list(layers)[int(random.integers(len(layers)))]
    section = modal_section(layers, debye, area=AREA, element=element, second=0.0)
    answer = leak_section(section, layers, leaking, area=AREA, element=element)
    drops = {name: layer.impedance(FREQUENCY) for name, layer in layers.items()}
    whole = sum(drops.values()) + AREA * element.impedance(FREQUENCY)
    for name, layer in layers.items():
        expected = drops[name] * drops[leaking] / whole
        if name == leaking:  # minus the layer beside all the others
            expected = -drops[leaking] * (whole - drops[leaking]) / whole
        agrees(answer[name].field * layer.thickness, expected)
        polarisation = EPS0 * layer.material.bound_permittivity(FREQUENCY) / layer.thickness
        agrees(answer[name].displacement, polarisation * expected)
    agrees(answer.current_density, drops[leaking] / whole)
    own = answer[leaking].field
    assert own.direct == 0
    # a passive answer: the largest part of each sign tells rounding from physics
    parts = own.gains * own.rates
    assert np.max(parts, initial=0) <= 1e-14 * np.max(np.abs(parts), initial=0)


def test_under_a_current_the_leak_takes_from_its_own_layer():
    layers, debye = random_layers(np.random.default_rng(3))
    answer = leak_alone(current_section(layers, debye, area=AREA), layers, "layer_1", area=AREA)
    for name, layer in layers.items():
        expected = -layer.impedance(FREQUENCY) * (name == "layer_1")
        np.testing.assert_allclose(answer[name].field.at(FREQUENCY) * layer.thickness, expected, rtol=1e-12)
    assert np.all(answer.current_density.at(FREQUENCY) == 0)


def test_a_leak_is_found_and_pieces_of_one_slab_are_one_leak():
    plain, leaky = Layer(thickness=1e-6), Layer(thickness=1e-6, leak=RECTIFYING)
    charged = leaky.model_copy(update={"initial_charge": 1e-6})
    other = leaky.model_copy(update={"material": Constant(permittivity=9.0)})
    assert leaking_slab({"gap": plain}, second=0.5) == ()
    assert leaking_slab({"insulator": plain, "gap": leaky}, second=0.0) == ("gap",)
    assert leaking_slab({"a": leaky, "b": leaky, "c": plain}, second=0.0) == ("a", "b")
    assert leaking_slabs({"a": leaky, "b": plain, "c": leaky}) == [("a",), ("c",)]
    assert leaking_slabs({"a": charged, "b": leaky}) == [("a",), ("b",)]
    with pytest.raises(InputError, match=r"stack\.gap\.leak and stack\.skin\.leak"):
        leaking_slab({"gap": leaky, "skin": other}, second=0.0)
    with pytest.raises(InputError, match="second electrode"):
        leaking_slab({"gap": leaky}, second=0.5)


def test_a_vanishing_sine_sees_a_conductivity():
    material = Constant(permittivity=3.0, conductivity=1e-6)
    layers = {
        "film": Layer(thickness=1e-6),
        "gap": Layer(thickness=1e-6, material=material, leak=RECTIFYING),
        "skin": Layer(thickness=1e-6, leak=FieldConduction(conductivity=4e-6, onset_field=1e5)),
    }
    found = linearised(layers)
    assert found["film"] is layers["film"]
    assert found["gap"].material.conductivity == pytest.approx(3e-6, rel=1e-15)
    assert found["skin"].material.conductivity == pytest.approx(4e-6, rel=1e-15)
    assert all(layer.leak is None for layer in found.values())
    assert layers["gap"].leak is RECTIFYING


@given(
    known=st.floats(-1e9, 1e9, allow_subnormal=False).filter(lambda field: field == 0 or abs(field) > 1e-200),
    weight=st.just(0.0) | st.floats(-3, 20).map(lambda power: 10.0**power),
    name=st.sampled_from(sorted(LEAKS)),
    share=st.one_of(st.none(), st.floats(-1, 2)),
)
def test_the_scalar_equation_is_solved(known, weight, name, share):
    leak, guess = LEAKS[name], None if share is None else share * known
    field = field_under_leak(leak, known=known, weight=weight, guess=guess)
    if known == 0 or weight == 0:
        assert field == known
    drop, slope = weight * float(leak.current_density(field)), 1 + weight * float(leak.slope(field))
    assert min(0.0, known) <= field <= max(0.0, known)
    # the residue as a distance of the field, and the rounding of what is subtracted in it
    assert abs(field + drop - known) / slope <= 1e-14 * abs(field) + 1e-15 * abs(known) / slope


CONTROL = FieldOf("stratum_corneum")


@pytest.fixture
def answers(finger):
    """Field in the skin over the drive and over the leak; a conductivity in the place of an ohmic leak is exact."""

    def fields(element="bare"):
        skin = Debye(permittivity_high=300, strength=1200, relaxation_time=2e-3, conductivity=0.0)
        names = ["insulator", "stratum_corneum"]
        blocking, conducting = (
            finger(element, names=names, skin=skin.replace({"conductivity": value})) for value in (0.0, 3e-6)
        )
        leaking = blocking.leaking("stratum_corneum")["stratum_corneum"].field
        return blocking.wanted[CONTROL], leaking, conducting.wanted[CONTROL]

    return fields


def orders(errors):
    return np.log2(np.array(errors[:-1]) / np.array(errors[1:]))


@pytest.mark.parametrize("name", ["trapezium", "square"])
def test_second_order_against_the_linear_solver(name, answers, drive):
    """The drive's jump ends a step, so that nothing is smeared over it."""
    driven, leaking, exact = answers()
    errors = []
    for count in (60, 120, 240, 480):
        grid = np.linspace(0, 30e-3, count + 1)
        field = follow(driven, leaking, drive(name), grid, leak=OHMIC).field
        errors.append(np.max(np.abs(field.after - transient({"E": exact}, drive(name), grid)["E"])))
    assert orders(errors) == pytest.approx(2, abs=0.1)
    largest = np.max(np.abs(field.after))
    if name == "square":
        assert np.max(np.abs(field.after - field.before)[1:]) > 0.1 * largest
    else:
        assert errors[-1] < 3e-4 * largest  # 200 steps in the time constant


def test_second_order_of_a_leak_that_grows_with_the_field(answers, drive):
    driven, leaking, _ = answers()

    def at_a_few(count):
        grid = np.linspace(0, 30e-3, 30 * count + 1)
        return follow(driven, leaking, drive("trapezium"), grid, leak=GROWING).field.after[::count]

    reference = at_a_few(512)
    errors = [np.max(np.abs(at_a_few(count) - reference)) for count in (4, 8, 16, 32)]
    assert orders(errors) == pytest.approx(2, abs=0.1)


@pytest.mark.parametrize("element", ["bare", "body", "floating"])
@pytest.mark.parametrize("name", ["trapezium", "square"])
def test_the_stated_error_bounds_the_error(name, element, answers, drive, monkeypatch):
    """Steps that cannot be halved further leave a larger error, and it is told."""
    driven, leaking, exact = answers(element)
    time, given_ = np.linspace(0, 30e-3, 7), {"leak": OHMIC, "control": CONTROL}
    found = leaky_response({CONTROL: driven}, {CONTROL: leaking}, drive(name), time, **given_)
    times = time, np.linspace(0, 30e-3, 3001)
    expected, whole = (transient({"E": exact}, drive(name), each)["E"] for each in times)
    stated = found.errors["step_error"]
    assert stated < leaks.TOLERANCE
    # stated of the last steps; the field returned is that of steps without length, as far as the march is of second order
    assert np.max(np.abs(found.found[CONTROL] - expected)) < 0.04 * stated * np.max(np.abs(whole))
    assert f"{found.steps} steps" in found.reason
    monkeypatch.setattr(steps, "MOST_HALVINGS", 1)
    monkeypatch.setattr(leaks, "TOLERANCE", 1e-12)
    found = leaky_response({CONTROL: driven}, {CONTROL: leaking}, drive(name), time, **given_)
    assert found.errors["step_error"] > 1e-8


def test_an_instant_is_the_instant_of_switching_on(answers, drive):
    driven, leaking, _ = answers()
    given_ = {"leak": GROWING, "control": CONTROL}
    step = drive({"model": "Step", "level": 5})
    found = leaky_response({CONTROL: driven}, {CONTROL: leaking}, step, np.zeros(1), **given_)
    assert found.found[CONTROL] == pytest.approx([5 * driven.direct])
