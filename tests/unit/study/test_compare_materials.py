"""One scenario with several materials: attraction, field and margin of each."""

from __future__ import annotations

import math

import numpy as np
import pytest

import electrovib as ev
from electrovib.core.constants import eps0
from electrovib.core.errors import InputError
from electrovib.study.compare.materials import AS_IT_IS

FILM = {
    "drive": {"model": "Step", "level": 100.0},
    "force": {"model": "MaxwellStressInGap"},
    "circuit.return_path.resistance": 0.0,
    "stack": {"insulator": {"thickness": 10e-6, "material": {"model": "Constant", "permittivity": 3.0}}},
    "time.samples": 3,
}


@pytest.fixture(scope="module")
def scenario():
    return ev.load("vezzoli_2014/fig6_static").replace(FILM)


@pytest.fixture(scope="module")
def found(scenario):
    return ev.compare_materials(scenario, materials=["PTFE", "silica", "pvdf"])


def test_the_attraction_of_a_single_layer_is_that_of_its_displacement(found, scenario):
    """E = V/T in every material; the stress in a vanishing gap is (eps E)^2 eps0/2."""
    area = scenario.contact_area
    for entry in found.entries:
        assert entry.field == pytest.approx(1e7, rel=1e-6)
        if entry.name in {AS_IT_IS, "ptfe"}:
            assert entry.force == pytest.approx(eps0 * (entry.permittivity * 1e7) ** 2 / 2 * area, rel=1e-6)
        assert entry.margin == pytest.approx(entry.strength / 1e7, rel=1e-6)


def test_the_own_material_is_first_and_the_others_by_their_attraction(found):
    assert [entry.name for entry in found.entries] == [AS_IT_IS, "pvdf", "silica", "ptfe"]


def test_strengths_states_and_statuses_of_the_library(found):
    own, pvdf, silica, ptfe = found.entries
    assert (own.strength, own.status) == (118e6, "of the scenario")
    assert (pvdf.strength, pvdf.breakdown) == (80e6, "ok")
    assert pvdf.status == "derived: permittivity; full text: conductivity, strength"
    assert (silica.breakdown, ptfe.breakdown) == ("unknown", "ok")
    assert "a thickness that its source does not state" in silica.why
    assert silica.status == "full text: permittivity, conductivity; abstract: strength"
    assert silica.relaxation_time == pytest.approx(3.9 * eps0 / 1e-14, rel=1e-9)
    assert math.isinf(ptfe.relaxation_time)


def test_the_table_has_the_numbers_and_the_mark(found):
    table = found.tables[0]
    assert table.title == "Materials of the layer 'insulator', 10 um thick"
    row = dict(zip(table.headings, table.rows[2], strict=True))
    assert row["material"] == "silica"
    assert row["strength"] == "660 MV/m"
    assert row["margin"] == "66"
    assert "abstract: strength" in row["source status"]


def test_all_of_the_library_and_what_a_law_refuses():
    """The law of Vezzoli et al. 2014 has one permittivity of the insulator."""
    compared = ev.compare_materials("vezzoli_2014/fig6")
    assert {entry.name for entry in compared.entries} >= {AS_IT_IS, "pet", "silica", "hafnia"}
    assert set(compared.left_out) == {"parylene_c", "pvdf", "p_vdf_trfe_cfe"}
    assert "one permittivity" in compared.left_out["pvdf"]
    assert compared.tables[1].title == "Not in this comparison"


def test_a_layer_without_a_known_strength_has_no_margin(scenario):
    changed = scenario.replace({"stack.insulator.material.permittivity": 50.0})
    own, _ = ev.compare_materials(changed, materials=["pet"]).entries
    assert np.isnan([own.margin, own.strength, own.field]).all()
    assert own.breakdown == "unknown"
    assert ev.compare_materials(changed, materials=["pet"]).tables[0].rows[0][5:8] == (
        "not known",
        "not known",
        "unknown",
    )


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"materials": ["silika", "kaptan"]}, r"(?s)'silika'. Nearest: silica.*'kaptan'. Nearest: polyimide"),
        ({"materials": []}, "no material is named; known: alumina,"),
        ({"layer": "insulater", "materials": ["pet"]}, "layer 'insulater': .* Did you mean 'insulator'"),
    ],
)
def test_mistakes_are_answered(scenario, wrong, words):
    with pytest.raises(InputError, match=words):
        ev.compare_materials(scenario, **wrong)


def test_several_layers_of_the_plate_need_a_name(scenario):
    slab = FILM["stack"]["insulator"]
    two = scenario.replace({"stack": {name: slab | {"role": "plate"} for name in ("lower", "upper")}})
    with pytest.raises(InputError, match="has 2 layers of the plate: name the layer"):
        ev.compare_materials(two, materials=["pet"])
    compared = ev.compare_materials(two, layer="upper", materials=["pet"])
    assert compared.layer == "upper"
    assert len(compared.entries) == 2
