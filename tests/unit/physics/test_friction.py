"""Frictions without memory, with a corner, with relaxations, and with bristles."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from electrovib.core.errors import InputError
from electrovib.core.model import read_model
from electrovib.papers.balasubramanian_2025 import CUT_OFF_SLOPE
from electrovib.physics.friction import (
    AdhesiveShear,
    Coulomb,
    Creep,
    Dahl,
    FirstOrderLag,
    Friction,
    LuGre,
    PowerLaw,
)

NONE = np.nan


def test_a_power_of_zero_is_coulomb():
    law = PowerLaw(coefficient=0.6, at_force=1.0, exponent=0.0)
    assert law.lateral_force(0.4, 0.3, NONE) == pytest.approx(
        Coulomb(coefficient=0.6).lateral_force(0.4, 0.3, NONE)
    )


def test_friction_on_aluminium_falls_by_46_percent_from_1_to_20_newton():
    """Seo 2009, abstract: the exponent of the docstring."""
    law = PowerLaw(coefficient=0.6, at_force=1.0, exponent=-0.206)
    assert law.lateral_force(20.0, 0.0, NONE) / 20 / 0.6 == pytest.approx(0.54, abs=0.002)


def test_adhesive_shear_is_of_the_area_alone():
    law = AdhesiveShear(shear_strength=5e6)
    assert law.needs_real_area
    assert law.lateral_force(7.0, 3.0, 2e-8) == pytest.approx(0.1)


def test_the_corner_rises_as_measured():
    """13.8 Hz for each mm/s."""
    law = FirstOrderLag(
        steady=Coulomb(coefficient=0.5), cut_off=100.0, at_speed=0.02, renewal_length=1 / CUT_OFF_SLOPE
    )
    assert law.corner(0.1) - law.corner(0.02) == pytest.approx(13.8 * 80)
    still = FirstOrderLag(steady=Coulomb(coefficient=0.5), cut_off=100.0)
    assert still.corner(0.1) == 100.0


@pytest.mark.parametrize(
    "relaxations",
    [
        [],
        [{"share": 0.6, "time": 1e-3}, {"share": 0.6, "time": 2e-3}],
        [{"share": 0.1, "time": 2e-3}, {"share": 0.1, "time": 1e-3}],
    ],
)
def test_relaxations_that_make_no_sense_are_refused(relaxations):
    with pytest.raises(InputError, match="relaxations"):
        read_model(
            Friction,
            {
                "model": "Creep",
                "steady": {"model": "Coulomb", "coefficient": 0.5},
                "relaxations": relaxations,
            },
        )


def test_relaxations_may_be_all_there_is():
    creep = Creep(steady=Coulomb(coefficient=0.5), relaxations=({"share": 1.0, "time": 1e-3},))
    assert creep.relaxations[0].share == 1.0


@given(speed=st.floats(1e-6, 1.0), strength=st.floats(1e-3, 10.0), direction=st.sampled_from([-1.0, 1.0]))
def test_lugre_slides_steadily_at_its_strength(speed, strength, direction):
    law = LuGre(
        steady=Coulomb(coefficient=0.5),
        stiffness=500.0,
        static_ratio=1.5,
        stribeck_speed=5e-3,
        viscous_damping=0.1,
    )
    limit = law.strength_at(speed, strength)
    deflection = direction * limit / law.stiffness
    rate = law.deflection_rate(deflection, direction * speed, strength, direction)
    assert abs(rate) <= 1e-12 * speed
    force = law.force(deflection, 0.0, direction * speed)
    assert force == pytest.approx(direction * (limit + 0.1 * speed))
    assert strength <= limit <= 1.5 * strength * (1 + 1e-12)


@given(
    deflection=st.floats(-5e-3, 5e-3),
    speed=st.floats(-0.5, 0.5),
    strength=st.floats(1e-3, 5.0),
    exponent=st.floats(0.5, 3),
)
def test_bristles_only_take_energy(deflection, speed, strength, exponent):
    """Force times speed is at least what the bristles store, at every instant."""
    direction = 1.0 if speed >= 0 else -1.0
    steady = Coulomb(coefficient=0.5)
    for law in (
        LuGre(steady=steady, stiffness=500.0, static_ratio=1.5, stribeck_speed=5e-3),
        Dahl(steady=steady, stiffness=500.0, exponent=exponent),
    ):
        rate = law.deflection_rate(deflection, speed, strength, direction)
        taken = law.force(deflection, rate, speed) * speed
        stored = law.stiffness * deflection * rate
        assert taken - stored >= -1e-12 * (abs(taken) + abs(stored))


def test_dahl_bends_as_an_exponential():
    """Exponent 1: dF/dx = stiffness (1 - F/strength)."""
    law = Dahl(steady=Coulomb(coefficient=0.5), stiffness=500.0)
    for force in (0.0, 0.1, 0.2, 0.25):
        slope = law.stiffness * law.deflection_rate(force / 500.0, 1e-3, 0.25, 1.0) / 1e-3
        assert slope == pytest.approx(500.0 * (1 - force / 0.25))


def test_a_friction_says_what_it_remembers_and_whether_it_deflects():
    steady = Coulomb(coefficient=0.5)
    lag = FirstOrderLag(steady=steady, cut_off=100.0)
    dahl = Dahl(steady=steady, stiffness=500.0)
    assert [each.has_memory for each in (steady, lag, dahl)] == [False, True, True]
    assert [each.deflects for each in (steady, lag, dahl)] == [False, False, True]
    assert [len(each.memory(0.03)) for each in (steady, lag, dahl)] == [0, 1, 0]
