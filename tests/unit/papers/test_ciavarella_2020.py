"""Friction under load and attraction: the trends of the abstract."""

from __future__ import annotations

import numpy as np
import pytest

from electrovib.core.errors import InputError
from electrovib.core.model import read_model
from electrovib.papers import ciavarella_2020


def test_what_was_not_read_is_not_remembered_either():
    """The form is there, the number in front of it is the user's; no scenario pretends to be the paper's."""
    with pytest.raises(InputError, match="prefactor"):
        read_model(ciavarella_2020.BearingArea, {"modulus": 1e7, "rms_height": 1e-5, "rms_slope": 1.0})
    assert all(field.is_required() for field in ciavarella_2020.BearingArea.model_fields.values())
    assert ciavarella_2020.BearingArea.status == "unverified"
    assert not hasattr(ciavarella_2020, "scenarios")
    assert not hasattr(ciavarella_2020, "skins")
    assert "equation not read" in ciavarella_2020.NOT_READ
    assert {check.status for check in ciavarella_2020.CHECKS} <= {"abstract", "derived"}


def test_no_coefficient_is_remembered():
    """The factor of the bearing-area form is no value of the package."""
    numbers = {name for name, thing in vars(ciavarella_2020).items() if isinstance(thing, (int, float))}
    assert numbers <= {"eps0"}


def test_friction_without_voltage_is_on_the_plateau():
    load = np.geomspace(1.0, 1e4, 5)
    plateau = ciavarella_2020.friction_coefficient(load, pull=0.0, modulus=1e7, slope=1.0)
    np.testing.assert_allclose(plateau, 1.0, rtol=1e-5)  # p/(E* h') is 1e-3 at most
    pulled = ciavarella_2020.friction_coefficient(load, pull=1e3, modulus=1e7, slope=1.0)
    np.testing.assert_allclose(pulled, (load + 1e3) / load, rtol=1e-5)


def test_the_trend_can_be_missed(monkeypatch):
    monkeypatch.setattr(ciavarella_2020, "friction_coefficient", lambda pressure, **_: pressure)
    assert ciavarella_2020.decays_to_a_plateau() == 0
