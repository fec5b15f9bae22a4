"""Laws of conduction: current of the sign of the field, which does not decrease with it, beside a conductivity."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from electrovib.core.discovery import find_members
from electrovib.core.errors import InputError
from electrovib.core.model import read_model
from electrovib.physics.conduction import Conduction, FieldConduction, PolarityConduction
from electrovib.physics.stack import Layer
from electrovib.scenario import load

FIELDS = np.concatenate([-np.geomspace(1e9, 1e-9, 200), [0.0], np.geomspace(1e-9, 1e9, 200)])


@pytest.fixture(params=sorted(find_members(Conduction)))
def law(request):
    kind = find_members(Conduction)[request.param]
    return read_model(kind, dict(kind.example))


def test_a_layer_only_loses_energy(law):
    density = law.current_density(FIELDS)
    assert law.current_density(0.0) == 0
    assert np.all(np.diff(density) > 0)
    assert np.all(density * FIELDS >= 0)
    assert np.all(law.slope(FIELDS) > 0)


def test_the_slope_is_the_derivative(law):
    fields = FIELDS[np.abs(FIELDS) > 0]
    step = 1e-6 * np.abs(fields)
    numeric = (law.current_density(fields + step) - law.current_density(fields - step)) / (2 * step)
    # a cubic's third derivative leaves 1e-12 of the slope, rounding 1e-16/1e-6
    np.testing.assert_allclose(law.slope(fields), numeric, rtol=1e-8)


@given(positive=st.floats(0, 1e3), negative=st.floats(0, 1e3), field=st.floats(-1e9, 1e9))
def test_polarity_takes_the_conductivity_of_the_sign(positive, negative, field):
    law = PolarityConduction(conductivity_positive=positive, conductivity_negative=negative)
    mirrored = PolarityConduction(conductivity_positive=negative, conductivity_negative=positive)
    assert law.current_density(field) == (negative if field < 0 else positive) * field
    assert law.current_density(field) == -mirrored.current_density(-field)
    assert law.small_signal == pytest.approx((positive + negative) / 2, rel=1e-15, abs=0)


def test_the_mean_conductivity_is_that_of_the_fundamental():
    """The `small_signal` conductivity of a rectifying layer holds for a sine of any amplitude."""
    law = PolarityConduction(conductivity_positive=3e-6, conductivity_negative=1e-6)
    angle = 2 * np.pi * (np.arange(4096) + 0.5) / 4096
    density = law.current_density(1e5 * np.sin(angle))
    fundamental = 2 * np.mean(density * np.sin(angle))
    assert fundamental / 1e5 == pytest.approx(law.small_signal, rel=1e-12)


def test_the_onset_field_doubles_the_conductivity():
    law = FieldConduction(conductivity=2e-6, onset_field=1e5)
    assert law.current_density(1e5) / 1e5 == pytest.approx(4e-6, rel=1e-15)
    assert law.small_signal == pytest.approx(2e-6, rel=1e-15)
    assert law.current_density(-3e4) == -law.current_density(3e4)


def test_a_layer_has_no_leak_by_default():
    layer = Layer(thickness=1e-6)
    assert layer.leak is None
    told = layer.replace({"leak": {"model": "FieldConduction", **FieldConduction.example}})
    assert isinstance(told.leak, FieldConduction)
    assert told != layer
    assert told.digest() != layer.digest()


def test_a_leak_is_a_parameter_like_others():
    leak = {"model": "PolarityConduction", **PolarityConduction.example}
    scenario = load("vezzoli_2014/fig6").replace({"stack.stratum_corneum.leak": leak})
    changed = scenario.replace({"stack.stratum_corneum.leak.conductivity_negative": "1 uS/m"})
    assert changed.stack.layers["stratum_corneum"].leak.conductivity_negative == 1e-6
    with pytest.raises(InputError, match="conductivity_positve"):
        scenario.replace({"stack.stratum_corneum.leak.conductivity_positve": 1e-6})
    with pytest.raises(InputError, match="PolarityConduction"):
        scenario.replace({"stack.stratum_corneum.leak": {"model": "PolarityConducton"}})
