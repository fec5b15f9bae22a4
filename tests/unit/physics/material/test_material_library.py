"""The library of materials: sourced values, found by name, and the strength that a layer is compared with."""

import numpy as np
import pytest

from electrovib.core.checks import STATUSES
from electrovib.core.errors import InputError
from electrovib.core.model import read_model
from electrovib.core.quantity import quantity_of
from electrovib.physics.material import Constant, Material
from electrovib.physics.material.library import (
    UNVERIFIED,
    BreakdownStrength,
    SourcedValue,
    find_substance,
    materials,
    nearest_substances,
)
from electrovib.physics.stack import Layer

ASKED_FOR = (
    "alumina alumina_ald aluminosilicate_glass fep hafnia p_vdf_trfe_cfe parylene_c"
    " pet polyimide ptfe pvdf silica soda_lime_glass su8"
)
BAND = np.logspace(-1, 9, 101)
each_material = pytest.mark.parametrize("substance", materials(), ids=lambda substance: substance.name)


def test_what_displays_are_built_of_is_there_once():
    assert " ".join(substance.name for substance in materials()) == ASKED_FOR
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


@pytest.mark.parametrize("word", ["silica", "SiO2", "sio2", "Silicon Dioxide", "silicon-dioxide"])
def test_found_by_any_of_its_names(word):
    assert find_substance(word).name == "silica"


@pytest.mark.parametrize(
    ("word", "told"),
    [
        ("silika", "no material 'silika'. Nearest: silica"),
        ("kaptan", "no material 'kaptan'. Nearest: polyimide"),
        ("parilene C", "no material 'parilene C'. Nearest: parylene_c"),
        ("qqqq", r"Known: alumina, alumina_ald, .*, su8"),  # like none of them
    ],
)
def test_a_misspelt_name_has_the_nearest_ones(word, told):
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
