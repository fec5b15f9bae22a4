"""Dielectrics are passive from 0.1 Hz to 1 GHz, and tables carry their Kramers-Kronig residual."""

import numpy as np
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
def test_materials_are_passive_and_a_finite_sum_is_the_material(material_class, drawn, data):
    material = data.draw(drawn(material_class))
    permittivity, bound = material.complex_permittivity(BAND), material.bound_permittivity(BAND)
    assert np.all(np.isfinite(permittivity))
    assert active(permittivity) <= ROUNDING
    assert active(bound) <= ROUNDING
    assert np.all(bound.real > 0)
    # conduction only adds loss, and nothing to the stored part
    assert np.all(permittivity.imag <= bound.imag)
    exact = material.debye()
    if exact is not None:
        assert np.max(np.abs(exact.permittivity(BAND) / bound - 1)) < 1e-12
        assert exact.high > 0
        assert min(exact.strengths, default=0.0) >= 0


def test_an_active_dielectric_is_noticed_and_permittivity_has_the_frequencys_shape(material_class, build):
    """The other sign of the loss, by as little as a thousandth, is no longer passive."""
    material = build(material_class)
    permittivity = material.complex_permittivity(BAND)
    assert active(permittivity.conj() if np.any(permittivity.imag) else permittivity * (1 + 1e-3j)) > ROUNDING
    for answer in (material.complex_permittivity, material.bound_permittivity):
        assert answer(BAND.reshape(3, 67)).shape == (3, 67)
        assert np.iscomplexobj(answer(BAND))


def test_skins_are_passive_and_described(skin):
    assert active(skin.material.complex_permittivity(BAND)) <= ROUNDING
    assert active(skin.material.bound_permittivity(BAND)) <= ROUNDING
    assert isinstance(skin, Skin)
    assert skin.status in STATUSES
    assert len(skin.source) > 10
    assert len(skin.note) > 10
    relaxation = time_constant(skin.material, np.logspace(0, 6, 61))
    assert np.all(relaxation > 0)
    assert np.all(np.isfinite(relaxation))
    if skin.reproduces_force:  # one that conducts nothing predicts none
        assert skin.material.conductivity > 0


def test_skins_have_names_of_their_own(discovered):
    names = [skin.name for skin in discovered["skin"].values()]
    assert len(set(names)) == len(names)


def test_tables_carry_their_kramers_kronig_residual(discovered, build):
    kinds = discovered["material_class"].values()
    tables = [
        kind for kind in kinds if any(field.annotation is Samples for field in kind.model_fields.values())
    ]
    assert tables
    for kind in tables:
        assert 0 <= build(kind).kramers_kronig < 0.006  # the law behind it has 0.0035; rounding adds the rest
        # a stored part that rises with frequency cannot belong to its loss
        rows = dict(kind.example)
        rows["permittivity_samples"] = rows["permittivity_samples"][::-1]
        assert kind.model_validate(rows).kramers_kronig > 0.1
