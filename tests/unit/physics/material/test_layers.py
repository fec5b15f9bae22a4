"""The library of materials, and what layers are made of beside a permittivity: Debye sums, leaks, moisture, roles."""

import numpy as np
import pytest

from electrovib.core.citation import STATUSES
from electrovib.core.discovery import find_members
from electrovib.core.errors import InputError
from electrovib.core.model import read_model
from electrovib.core.quantity import quantity_of
from electrovib.physics.conduction import Conduction, FieldConduction, PolarityConduction
from electrovib.physics.debye_sum import DebyeSum
from electrovib.physics.finger import Moisture
from electrovib.physics.force import needed_layer, wanted_layer
from electrovib.physics.material import Constant, Material
from electrovib.physics.material.library import (
    UNVERIFIED,
    BreakdownStrength,
    SourcedValue,
    find_substance,
    materials,
    nearest_substances,
)
from electrovib.physics.stack import IMPLIED, ORDER, Layer, beside_interface, interface_place, roles_of

BAND = np.logspace(-1, 9, 101)
each_material = pytest.mark.parametrize("substance", materials(), ids=lambda substance: substance.name)


def test_what_displays_are_built_of_is_there_once():
    """An insulator of screens, one of chips and one of films is found by its formula or trade name; no word means two."""
    assert {find_substance(word).name for word in ("SiO2", "HfO2", "Mylar")} == {"silica", "hafnia", "pet"}
    words = [word.lower() for substance in materials() for word in (substance.name, *substance.aliases)]
    assert len(words) == len(set(words))


@each_material
def test_every_substance_is_sourced_and_passive_and_no_strength_from_memory_counts_beside_a_read_one(
    substance,
):
    others = [substance.conductivity, substance.conductivity_bound]
    for value in filter(None, [*substance.permittivity, *others, *substance.strengths]):
        assert value.status in STATUSES
        assert len(value.source) > 10
    strength = quantity_of(Layer, "breakdown_field")
    assert substance.strengths
    for each in substance.strengths:
        assert each.unit == "V/m"
        assert strength.low < each.value < strength.high
        assert each.thickness is None or 1e-9 <= each.thickness[0] <= each.thickness[1] <= 1e-3
    assert {value.unit for value in substance.permittivity} == {"1"}
    read = [each for each in substance.strengths if each.status != UNVERIFIED]
    judged = [substance.strength_of(thickness) for thickness in np.geomspace(1e-9, 1e-3, 61)]
    assert {each.status == UNVERIFIED for each in judged} <= {not read}
    material = Material.from_offer(substance)
    assert material.substance == substance.name
    assert np.all(material.complex_permittivity(BAND).imag <= 1e-13)
    at_one_kilohertz = float(material.bound_permittivity(np.array(1e3)).real)
    assert at_one_kilohertz == pytest.approx(substance.permittivity[0].value, rel=0.08)


def test_dispersion_and_loss_are_those_of_the_sources():
    found = (
        Material.from_offer(find_substance("parylene")).bound_permittivity(np.array([60.0, 1e3, 1e6])).real
    )
    assert found == pytest.approx([3.15, 3.10, 2.95], rel=4e-3)
    assert found[1] == pytest.approx(3.10, rel=1e-12)
    permittivity = Material.from_offer(find_substance("PVDF")).bound_permittivity(np.array(1e3))
    assert float(-permittivity.imag / permittivity.real) == pytest.approx(0.02, rel=1e-9)


def test_conductivities_and_strengths_in_si():
    conductivities = {
        "silica": 1e-14,  # 1e16 ohm cm
        "parylene_c": 1 / 8.8e14,
        "polyimide": 1 / 1.5e15,
        "soda_lime_glass": 10**-10.4,
        "alumina_ald": 1.79e-8 / 1e-4 / 1e8,  # A/m2 over V/m
    }
    found = {name: Material.from_offer(find_substance(name)).conductivity for name in conductivities}
    assert found == pytest.approx(conductivities, rel=1e-12)
    assert find_substance("ptfe").strengths[0].value == pytest.approx(165.35e6, rel=1e-4)  # 4200 V/mil
    assert find_substance("parylene_c").strengths[0].value == pytest.approx(220.5e6, rel=1e-3)  # 5600 V/mil


@pytest.mark.parametrize(
    ("word", "told"),
    [
        ("silika", "no material 'silika'. Nearest: silica"),
        ("kaptan", "no material 'kaptan'. Nearest: polyimide"),
        ("parilene C", "no material 'parilene C'. Nearest: parylene_c"),
        ("qqqq", r"Known: alumina, alumina_ald, .*, su8"),  # like none of them
    ],
)
def test_any_name_finds_it_and_a_misspelt_one_has_the_nearest(word, told):
    names = ("silica", "SiO2", "sio2", "Silicon Dioxide", "silicon-dioxide")
    assert {find_substance(name).name for name in names} == {"silica"}
    assert len(nearest_substances("alumina oxide glass")) <= 3
    with pytest.raises(InputError, match=told):
        read_model(Layer, {"thickness": 1e-6, "material": word})


def test_a_material_of_ones_own_names_its_substance():
    own = read_model(Material, {"model": "Constant", "permittivity": 3.35, "substance": "Mylar"})
    assert (own.substance, own.permittivity) == ("pet", 3.35)
    with pytest.raises(InputError, match="Nearest: pet"):
        read_model(Material, {"model": "Constant", "permittivity": 3.35, "substance": "petx"})
    assert Constant(permittivity=2.0).substance is None


@pytest.mark.parametrize(
    ("name", "thickness", "strength", "measured", "layer_is"),
    [
        ("polyimide", 90e-6, 118e6, 127e-6, "same"),
        ("polyimide", 20e-6, 236e6, 25.4e-6, "same"),
        ("polyimide", 3e-6, 118e6, 7.6e-6, "thinner"),
        ("polyimide", 254e-6, 118e6, 127e-6, "same"),
        ("polyimide", 255e-6, 118e6, 127e-6, "thicker"),
        ("silica", 30e-9, 1e9, 50e-9, "same"),
        ("silica", 100e-9, 700e6, 100e-9, "same"),
        ("silica", 1e-6, 660e6, None, "unknown"),
        ("pvdf", 20e-6, 80e6, 9e-6, "same"),
        ("su8", 20e-6, 440e6, None, "unknown"),
    ],
)
def test_the_strength_of_a_layer_is_of_the_next_thicker_one(name, thickness, strength, measured, layer_is):
    found = find_substance(name).strength_of(thickness)
    assert found.value == pytest.approx(strength, rel=1e-3)
    assert (found.thickness or (None,))[0] == (measured and pytest.approx(measured, rel=1e-9))
    assert found.compared_with(thickness) == layer_is


def test_origins_have_source_status_and_conditions():
    glass = find_substance("soda_lime_glass")
    assert glass.origin("conductivity") == (
        "Corning code 0080, from memory: log10 of the resistivity in ohm cm 12.4 (unverified; 25 C)",
        "unverified",
    )
    assert glass.origin("permittivity")[1] == "full text"
    assert find_substance("hafnia").origin("conductivity") == ("not found; taken as 0", "unknown")
    text, status = find_substance("ptfe").origin("conductivity")
    assert text.startswith("below 0.1 fS/m, taken as 0")
    assert status == "full text"
    assert find_substance("parylene_c").origin("exponent")[1] == "derived"


def test_the_material_states_which_of_its_values_are_doubtful():
    (told,) = Material.from_offer(find_substance("polyimide")).diagnostics("film")
    assert (told.name, told.state) == ("material, film", "unknown")
    assert "cited from memory, unverified: permittivity, conductivity" in told.text
    own = read_model(Material, {"model": "Constant", "permittivity": 3.5, "substance": "polyimide"})
    assert own.diagnostics("film") == ()  # its values are not those of the library
    (told,) = Material.from_offer(find_substance("hafnia")).diagnostics("film")
    assert "not found in a source and taken as 0: conductivity" in told.text
    assert Material.from_offer(find_substance("ptfe")).diagnostics("film") == ()
    assert Constant(permittivity=3.4).diagnostics("film") == ()


@pytest.mark.parametrize("wrong", [{"status": "read somewhere"}, {"source": ""}])
def test_a_value_without_source_or_status_is_refused(wrong):
    right = {"value": 1.0, "unit": "1", "conditions": "", "source": "a page", "status": "derived"}
    SourcedValue(**right)
    with pytest.raises(TypeError, match="needs a source and a status"):
        SourcedValue(**right | wrong)
    with pytest.raises(TypeError, match="needs a source and a status"):
        BreakdownStrength(**right | wrong, thickness=None)


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


def test_a_layer_has_no_leak_by_default_and_one_counts():
    told = SLAB.replace({"leak": {"model": "PolarityConduction", **PolarityConduction.example}})
    assert SLAB.leak is None
    assert (told != SLAB, told.digest() != SLAB.digest()) == (True, True)
    with pytest.raises(InputError, match="PolarityConduction"):
        SLAB.replace({"leak": {"model": "PolarityConducton"}})


def test_moisture_is_read_as_it_is_written_and_what_no_source_gives_has_to_be_given():
    wet = read_model(Moisture, dict(Moisture.example) | {"level": 1, "wet_skin_conductance": "20 uS/cm**2"})
    # 20 uS for each cm2 over 200 um
    assert wet.skin_conductivity(200e-6) == pytest.approx(20e-6 / 1e-4 * 200e-6, rel=1e-14)
    for name in GIVEN:
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
