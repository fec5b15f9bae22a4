"""The linear answer of a stack to a leak beside one layer, against the algebra of impedances."""

from __future__ import annotations

import numpy as np
import pytest

from electrovib.core.errors import InputError
from electrovib.physics.circuit import SeriesElement
from electrovib.physics.conduction import FieldConduction, PolarityConduction
from electrovib.physics.material import Constant, Debye, DebyeTerm, Prony
from electrovib.physics.stack import Layer
from electrovib.solve.electrics.leaks import leak_alone, leak_section, leaking_slab, leaking_slabs
from electrovib.solve.stack.expand import current_section, linearised
from electrovib.solve.stack.section import modal_section

EPS0 = 8.8541878128e-12
AREA = 1e-4
AGREEMENT = 1e-11
"""Of the sum of all modes' sizes at the frequency, which is what their rounding is made of."""
FREQUENCY = np.geomspace(1e-2, 1e7, 60)
LEAK = PolarityConduction(conductivity_positive=3e-6, conductivity_negative=1e-6)


def random_layers(random):
    """Two to four layers, some of one material, some blocking."""
    shared = Constant(permittivity=3.0)
    layers = {}
    for index in range(int(random.integers(2, 5))):
        conductivity = 0.0 if random.random() < 0.4 else float(10 ** random.uniform(-12, -4))
        kinds = (
            shared,
            Constant(permittivity=float(random.uniform(1, 2000)), conductivity=conductivity),
            Debye(permittivity_high=5.0, strength=300.0, relaxation_time=1e-4, conductivity=conductivity),
            Prony(
                permittivity_high=10.0,
                terms=(
                    DebyeTerm(strength=50.0, relaxation_time=1e-6),
                    DebyeTerm(strength=900.0, relaxation_time=1e-2),
                ),
                conductivity=conductivity,
            ),
        )
        material = kinds[int(random.integers(len(kinds)))]
        thickness = float(10 ** random.uniform(-6, -3.5))
        layers[f"layer_{index}"] = Layer(thickness=thickness, role="plate", material=material)
    return layers


def agrees(transfer, expected):
    s = 2j * np.pi * FREQUENCY[:, None]
    parts = np.abs(transfer.gains * transfer.rates / (s + transfer.rates)).sum(axis=1) + abs(transfer.direct)
    assert np.max(np.abs(transfer.at(FREQUENCY) - expected) / (parts + np.abs(expected))) < AGREEMENT


ELEMENTS = (
    SeriesElement(),
    SeriesElement(resistance=1e5),
    SeriesElement(resistance=0.0, elastance=1 / 150e-12),
    SeriesElement(resistance=1e3, elastance=1 / 150e-12, rate=20.0),
)


@pytest.mark.parametrize("element", ELEMENTS, ids=["nothing", "resistor", "floating", "leaking body"])
@pytest.mark.parametrize("seed", range(12))
def test_the_answer_to_a_leak(seed, element):
    random = np.random.default_rng(seed)
    layers = random_layers(random)
    names = list(layers)
    leaking = names[int(random.integers(len(names)))]
    debye = {name: layer.material.debye() for name, layer in layers.items()}
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
    assert np.max(own.gains * own.rates, initial=0) <= 1e-14 * np.max(
        np.abs(own.gains * own.rates), initial=0
    )


def test_under_a_current_the_leak_takes_from_its_own_layer():
    random = np.random.default_rng(3)
    layers = random_layers(random)
    debye = {name: layer.material.debye() for name, layer in layers.items()}
    answer = leak_alone(current_section(layers, debye, area=AREA), layers, "layer_1", area=AREA)
    for name, layer in layers.items():
        expected = -layer.impedance(FREQUENCY) * (name == "layer_1")
        np.testing.assert_allclose(answer[name].field.at(FREQUENCY) * layer.thickness, expected, rtol=1e-12)
    assert np.all(answer.current_density.at(FREQUENCY) == 0)


def test_a_leak_is_found():
    plain, leaky = Layer(thickness=1e-6), Layer(thickness=1e-6, leak=LEAK)
    assert leaking_slab({"gap": plain}, second=0.5) == ()
    assert leaking_slab({"insulator": plain, "gap": leaky}, second=0.0) == ("gap",)


def test_pieces_of_one_slab_are_one_leak():
    leaky, plain = Layer(thickness=1e-6, leak=LEAK), Layer(thickness=1e-6)
    charged = leaky.model_copy(update={"initial_charge": 1e-6})
    assert leaking_slab({"a": leaky, "b": leaky, "c": plain}, second=0.0) == ("a", "b")
    assert leaking_slabs({"a": leaky, "b": plain, "c": leaky}) == [("a",), ("c",)]
    assert leaking_slabs({"a": charged, "b": leaky}) == [("a",), ("b",)]


def test_two_leaks_are_refused():
    leaky, skin = Layer(thickness=1e-6, leak=LEAK), Constant(permittivity=9.0)
    other = leaky.model_copy(update={"material": skin})
    with pytest.raises(InputError, match=r"stack\.gap\.leak and stack\.stratum_corneum\.leak"):
        leaking_slab({"gap": leaky, "stratum_corneum": other}, second=0.0)


def test_a_leak_below_two_electrodes_is_refused():
    with pytest.raises(InputError, match="second electrode"):
        leaking_slab({"gap": Layer(thickness=1e-6, leak=LEAK)}, second=0.5)


def test_a_vanishing_sine_sees_a_conductivity():
    material = Constant(permittivity=3.0, conductivity=1e-6)
    layers = {
        "film": Layer(thickness=1e-6),
        "gap": Layer(thickness=1e-6, material=material, leak=LEAK),
        "skin": Layer(thickness=1e-6, leak=FieldConduction(conductivity=4e-6, onset_field=1e5)),
    }
    found = linearised(layers)
    assert found["film"] is layers["film"]
    assert found["gap"].material.conductivity == pytest.approx(3e-6, rel=1e-15)
    assert found["skin"].material.conductivity == pytest.approx(4e-6, rel=1e-15)
    assert all(layer.leak is None for layer in found.values())
    assert layers["gap"].leak is LEAK
