"""The fingertip: its formulas, and how it grows with sliding speed."""

from __future__ import annotations

import numpy as np
import pytest

from electrovib.core.errors import InputError
from electrovib.papers import balasubramanian_2025
from electrovib.physics.finger import Finger, GrowthWithSpeed, MassSpringDamper

FINGER = MassSpringDamper(mass="0.15 g", stiffness="1 kN/m", damping="1 N s/m")


def test_no_value_is_assumed():
    required = {name for name, field in MassSpringDamper.model_fields.items() if field.is_required()}
    assert required == {"mass", "stiffness", "damping"}


def test_orders_of_magnitude_as_recalled():
    """Overdamped; elastic at low frequency, damped at a few hundred hertz, massive far above."""
    assert FINGER.natural_frequency() == pytest.approx(410.94, rel=1e-4)  # sqrt(1000/1.5e-4)/(2 pi)
    assert FINGER.damping_ratio() == pytest.approx(1.2910, rel=1e-4)
    low, high = FINGER.compliance(1.0), FINGER.compliance(1e5)
    assert low == pytest.approx(1e-3, rel=1e-2)
    assert high == pytest.approx(-1 / (1.5e-4 * (2e5 * np.pi) ** 2), rel=2e-2)
    assert np.angle(FINGER.compliance(FINGER.natural_frequency())) == pytest.approx(-np.pi / 2)


def test_compliance_is_the_resonance_on_the_spring():
    frequency = np.geomspace(0.1, 1e5, 50)
    scaled = FINGER.compliance_at_rest() * FINGER.resonance().at(frequency)
    assert np.abs(scaled / FINGER.compliance(frequency) - 1).max() < 1e-13


def test_growth_with_sliding_speed():
    """Slopes of the abstract: per mm/s 3.23e-5 kg and 4.04 N/m; nothing else moves."""
    growing = FINGER.replace({"growth": GrowthWithSpeed(known_at="50 mm/s")})
    faster = growing.at_speed(0.060)
    assert faster.mass == pytest.approx(1.5e-4 + 10 * 3.23e-5)
    assert faster.stiffness == pytest.approx(1000 + 10 * 4.04)
    assert faster.damping == FINGER.damping
    assert faster.growth is None
    assert growing.at_speed(0.050).mass == growing.mass
    assert FINGER.at_speed(0.3) is FINGER


def test_slopes_are_those_of_the_paper():
    growth = GrowthWithSpeed(known_at=0.05)
    assert growth.mass_slope == balasubramanian_2025.MASS_SLOPE
    assert growth.stiffness_slope == balasubramanian_2025.STIFFNESS_SLOPE


def test_a_mass_that_would_vanish_is_refused():
    """0.15 g at 50 mm/s falls to nothing 4.6 mm/s below."""
    growing = FINGER.replace({"growth": GrowthWithSpeed(known_at="50 mm/s")})
    growing.at_speed(0.0455)
    with pytest.raises(InputError, match="must stay positive"):
        growing.at_speed(0.045)


def test_a_growth_that_leaves_the_range_is_told():
    growth = {"known_at": 0.02, "mass_slope": 0.0, "stiffness_slope": 1e6}
    finger = MassSpringDamper(mass=1e-4, stiffness=1e3, damping=1.0, growth=growth)
    with pytest.raises(InputError, match=r"finger\.growth: at 100 m/s stiffness = .* must lie between"):
        finger.at_speed(100.0)


def test_any_resonance_has_a_mass_a_spring_and_a_damper():
    """What a skin without a formula of its own takes to a friction whose contact deflects."""
    assert Finger.lumped(FINGER) == pytest.approx(FINGER.lumped(), rel=1e-13)
    assert Finger.at_speed(FINGER, None) is FINGER


def test_a_growth_needs_a_speed():
    growing = FINGER.replace({"growth": GrowthWithSpeed(known_at="50 mm/s")})
    with pytest.raises(InputError, match=r"finger\.growth needs motion\.speed"):
        growing.at_speed(None)
