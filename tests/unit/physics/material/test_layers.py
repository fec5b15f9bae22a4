"""What layers are made of beside their permittivity: Debye sums, leaks, moisture, and their role at the interface."""

import numpy as np
import pytest

from electrovib.core.discovery import find_members
from electrovib.core.errors import InputError
from electrovib.core.model import read_model
from electrovib.physics.conduction import Conduction, FieldConduction, PolarityConduction
from electrovib.physics.debye_sum import DebyeSum
from electrovib.physics.force import needed_layer, wanted_layer
from electrovib.physics.interface import IMPLIED, ORDER, beside_interface, interface_place, roles_of
from electrovib.physics.moisture import Moisture
from electrovib.physics.stack import Layer
from electrovib.scenario import load

FIELDS = np.concatenate([-np.geomspace(1e9, 1e-9, 200), [0.0], np.geomspace(1e-9, 1e9, 200)])
SLAB = Layer(thickness=1e-6)
GIVEN = {name: value for name, value in Moisture.example.items() if name != "level"}


def test_a_debye_sum_at_its_relaxation_frequency_and_far_from_it():
    # At w tau = 1 a relaxation gives half its strength in phase and half in quadrature.
    one = DebyeSum(4.0, (10.0,), (1e-3,))
    assert one.permittivity(1 / (2 * np.pi * 1e-3)) == pytest.approx(9 - 5j, rel=1e-14)
    two = DebyeSum(4.0, (10.0, 100.0), (1e-3, 1.0))
    values = two.permittivity([[0.0, 1e12], [1.0, 10.0]])
    assert (values.shape, two.permittivity(1.0).shape) == ((2, 2), ())
    # At w tau = 6e9 what is left of the fastest loss is 10/6e9 of 4, below 1e-9.
    assert values[0] == pytest.approx([114, 4.0], rel=1e-8)
    assert np.array_equal(DebyeSum(3.35).permittivity([1.0, 1e6]), [3.35, 3.35])


@pytest.mark.parametrize(
    ("arguments", "messages"),
    [
        ((0.0,), ["high = 0.0"]),
        ((float("inf"),), ["high = inf"]),
        ((1.0, (1.0,), ()), ["1 strengths but 0 relaxation_times"]),
        ((-1.0, (1.0, -1e-9), (1.0, 0.0)), ["high", "strengths[1] = -1e-09", "relaxation_times[1] = 0.0"]),
    ],
)
def test_what_is_no_dielectric_is_refused_with_every_reason(arguments, messages):
    with pytest.raises(InputError) as caught:
        DebyeSum(*arguments)
    assert len(caught.value.problems) == len(messages)
    assert all(word in said for word, said in zip(messages, caught.value.problems, strict=True))


def test_terms_that_are_columns_give_the_permittivity_of_each_finger():
    high, strength, time = np.array([[2.0], [3.0]]), np.array([[9.0], [5.0]]), np.array([[1e-4], [2e-3]])
    frequency = np.geomspace(1.0, 1e6, 7)
    found = DebyeSum(high, (strength,), (time,)).permittivity(frequency)
    expected = high + strength / (1 + 2j * np.pi * frequency * time)
    np.testing.assert_allclose(found, expected, rtol=1e-14)
    for wrong in (np.array([[1e-4], [0.0]]), np.array([[1e-4], [np.nan]])):
        with pytest.raises(InputError, match="relaxation_times"):
            DebyeSum(high, (strength,), (wrong,))
    with pytest.raises(InputError, match="strengths"):
        DebyeSum(high, (-strength,), (time,))


@pytest.mark.parametrize("name", sorted(find_members(Conduction)))
def test_a_leak_only_loses_energy_and_its_slope_is_the_derivative(name):
    kind = find_members(Conduction)[name]
    law = read_model(kind, dict(kind.example))
    density = law.current_density(FIELDS)
    assert law.current_density(0.0) == 0
    assert np.all(np.diff(density) > 0)
    assert np.all(density * FIELDS >= 0)
    assert np.all(law.slope(FIELDS) > 0)
    fields = FIELDS[FIELDS != 0]
    step = 1e-6 * np.abs(fields)
    numeric = (law.current_density(fields + step) - law.current_density(fields - step)) / (2 * step)
    # a cubic's third derivative leaves 1e-12 of the slope, rounding 1e-16/1e-6
    np.testing.assert_allclose(law.slope(fields), numeric, rtol=1e-8)


def test_the_small_signal_conductivity():
    """Of a rectifying layer it is that of the fundamental of a sine of any amplitude; the onset field doubles another's."""
    law = PolarityConduction(conductivity_positive=3e-6, conductivity_negative=1e-6)
    angle = 2 * np.pi * (np.arange(4096) + 0.5) / 4096
    fundamental = 2 * np.mean(law.current_density(1e5 * np.sin(angle)) * np.sin(angle))
    assert fundamental / 1e5 == pytest.approx(law.small_signal, rel=1e-12)
    onset = FieldConduction(conductivity=2e-6, onset_field=1e5)
    assert onset.current_density(1e5) / 1e5 == pytest.approx(4e-6, rel=1e-15)
    assert onset.small_signal == pytest.approx(2e-6, rel=1e-15)


def test_a_leak_is_a_parameter_like_others_and_none_by_default():
    leak = {"model": "PolarityConduction", **PolarityConduction.example}
    assert SLAB.leak is None
    told = SLAB.replace({"leak": leak})
    assert (told != SLAB, told.digest() != SLAB.digest()) == (True, True)
    scenario = load("vezzoli_2014/fig6").replace({"stack.stratum_corneum.leak": leak})
    changed = scenario.replace({"stack.stratum_corneum.leak.conductivity_negative": "1 uS/m"})
    assert changed.stack.layers["stratum_corneum"].leak.conductivity_negative == 1e-6
    with pytest.raises(InputError, match="PolarityConduction"):
        scenario.replace({"stack.stratum_corneum.leak": {"model": "PolarityConducton"}})


def test_moisture_is_one_number_between_dry_and_wet():
    dry, half, wet = (Moisture(level=level, **GIVEN) for level in (0, 0.5, 1))
    assert dry.gap_resistivity() == GIVEN["dry_gap_resistivity"]
    # the middle is geometric, and the mean for friction
    assert half.gap_resistivity() == pytest.approx(1e9, rel=1e-12)
    assert wet.gap_resistivity() == pytest.approx(GIVEN["wet_gap_resistivity"], rel=1e-14)
    assert [each.coefficient() for each in (dry, half, wet)] == pytest.approx([0.4, 0.6, 0.8], rel=1e-14)
    # 2 and 20 uS for each cm2 over 200 um
    conductivities = [each.skin_conductivity(200e-6) for each in (dry, half, wet)]
    assert conductivities == pytest.approx([4e-6, np.sqrt(4e-6 * 40e-6), 40e-6], rel=1e-14)
    written = read_model(Moisture, dict(Moisture.example) | {"wet_skin_conductance": "20 uS/cm**2"})
    assert written.wet_skin_conductance == pytest.approx(0.2, rel=1e-14)
    for name in GIVEN:  # no source gives it
        with pytest.raises(InputError, match=name):
            read_model(Moisture, {"level": 0.5} | {k: v for k, v in GIVEN.items() if k != name})


def test_a_known_name_implies_its_role_and_others_declare_it():
    layers = {"glass": SLAB.replace({"role": "plate"}), "insulator": SLAB, "stratum_corneum": SLAB}
    roles = roles_of(layers | {"dermis": SLAB.replace({"role": "finger"})})
    assert list(roles.values()) == ["plate", "plate", "finger", "finger"]
    assert set(IMPLIED.values()) == set(ORDER)
    sides = [beside_interface(roles, role) for role in ("plate", "gap", "finger")]
    assert sides == ["insulator", None, "stratum_corneum"]
    assert interface_place(roles.values()) == 2
    assert beside_interface(roles_of({"insulator": SLAB, "gap": SLAB}), "gap") == "gap"
    assert interface_place(roles_of({"stratum_corneum": SLAB}).values()) == 0
    with pytest.raises(InputError) as caught:
        roles_of({"glass": SLAB, "insulator": SLAB.replace({"role": "gap"}), "skin": SLAB})
    paths = [f"stack.{name}.role" for name in ("glass", "insulator", "skin")]
    assert [problem.split(":")[0] for problem in caught.value.problems] == paths


def test_a_law_reads_the_layer_nearest_to_the_interface_or_one_by_name():
    roles = dict.fromkeys(["insulator", "coating"], "plate") | {"gap": "gap"}
    roles |= dict.fromkeys(["sweat", "stratum_corneum"], "finger")
    wanted = {"plate": "coating", "gap": "gap", "finger": "sweat", "insulator": "insulator", "oil": None}
    assert {name: needed_layer(roles, name) for name in wanted} == wanted
    assert needed_layer({"insulator": "plate"}, "finger") is None
    assert wanted_layer("gap") == "a layer 'stack.gap', or one of another name with role = 'gap'"
    assert wanted_layer("oil") == "a layer 'stack.oil'"
