"""Dielectrics are passive from 0.1 Hz to 1 GHz, and tables carry their Kramers-Kronig residual."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from electrovib.core.checks import STATUSES
from electrovib.core.samples import Samples
from electrovib.physics.skin import Skin, time_constant

BAND = np.logspace(-1, 9, 201)
ROUNDING = 1e-13
"""Of |eps*|: below it the sign of a computed loss means nothing."""


def active(permittivity):
    """Largest Im eps* over |eps*|: above rounding the dielectric releases energy."""
    return float(np.max(permittivity.imag / np.abs(permittivity)))


@given(data=st.data())
@settings(max_examples=100)
def test_materials_are_passive(material_class, drawn, data):
    material = data.draw(drawn(material_class))
    permittivity = material.complex_permittivity(BAND)
    assert np.all(np.isfinite(permittivity))
    assert active(permittivity) <= ROUNDING
    assert active(material.bound_permittivity(BAND)) <= ROUNDING
    # conduction only adds loss, and nothing to the stored part
    assert np.all(permittivity.imag <= material.bound_permittivity(BAND).imag)


@given(data=st.data())
def test_a_stored_part_is_positive(material_class, drawn, data):
    assert np.all(data.draw(drawn(material_class)).bound_permittivity(BAND).real > 0)


@given(data=st.data())
def test_a_finite_sum_is_the_material(material_class, drawn, data):
    material = data.draw(drawn(material_class))
    exact = material.debye()
    if exact is None:
        return
    expected = material.bound_permittivity(BAND)
    assert np.max(np.abs(exact.permittivity(BAND) / expected - 1)) < 1e-12
    assert exact.high > 0
    assert min(exact.strengths, default=0.0) >= 0


def test_an_active_dielectric_is_noticed(material_class, build):
    """The other sign of the loss, by as little as a thousandth, is no longer passive."""
    permittivity = build(material_class).complex_permittivity(BAND)
    assert active(permittivity.conj() if np.any(permittivity.imag) else permittivity * (1 + 1e-3j)) > ROUNDING


def test_skins_are_passive(skin):
    assert active(skin.material.complex_permittivity(BAND)) <= ROUNDING
    assert active(skin.material.bound_permittivity(BAND)) <= ROUNDING


def test_skins_are_described(skin):
    assert isinstance(skin, Skin)
    assert skin.status in STATUSES
    assert len(skin.source) > 10
    assert len(skin.note) > 10
    relaxation = time_constant(skin.material, np.logspace(0, 6, 61))
    assert np.all(relaxation > 0)
    assert np.all(np.isfinite(relaxation))


def test_a_skin_that_conducts_nothing_predicts_no_force(skin):
    if skin.reproduces_force:
        assert skin.material.conductivity > 0


def test_skins_have_names_of_their_own(discovered):
    names = [skin.name for skin in discovered["skin"].values()]
    assert len(set(names)) == len(names)


def is_table(material_class):
    return any(field.annotation is Samples for field in material_class.model_fields.values())


def test_tables_carry_their_kramers_kronig_residual(material_class, build):
    if is_table(material_class):
        residual = build(material_class).kramers_kronig
        assert 0 <= residual < 0.02


def test_tables_are_found(discovered):
    assert any(is_table(kind) for kind in discovered["material_class"].values())


def test_a_table_that_breaks_the_relations_shows_it(material_class):
    """A stored part that rises with frequency cannot belong to its loss."""
    if is_table(material_class):
        rows = dict(material_class.example)
        rows["permittivity_samples"] = rows["permittivity_samples"][::-1]
        assert material_class.model_validate(rows).kramers_kronig > 0.1


@pytest.mark.parametrize("part", ["complex_permittivity", "bound_permittivity"])
def test_permittivity_is_complex_of_the_frequencys_shape(material_class, build, part):
    answer = getattr(build(material_class), part)(BAND.reshape(3, 67))
    assert answer.shape == (3, 67)
    assert np.iscomplexobj(answer)
