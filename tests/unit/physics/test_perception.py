"""Weights of the channels, the skin's compliance, and what a perception may be."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from electrovib.core.discovery import find_members
from electrovib.core.errors import InputError
from electrovib.core.model import read_model
from electrovib.physics.perception import (
    Channel,
    ElasticSkin,
    ElasticViscousSkin,
    NonPacinian,
    Pacinian,
    Perception,
    decibels,
    felt_amplitude,
    strongest,
)

orders = st.floats(0.2, 5)


@given(best=st.floats(20, 1000), below=orders, above=orders, frequency=st.floats(0.1, 1e5))
def test_the_pacinian_weight_is_highest_at_the_best_frequency(best, below, above, frequency):
    channel = Pacinian(best_frequency=best, order_below=below, order_above=above)
    assert channel.best() == best
    assert float(channel.weight(best)) == pytest.approx(1.0, rel=1e-12)
    assert float(channel.weight(frequency)) <= 1 + 1e-12


def test_the_two_channels_are_alike_near_40_hz():
    """An abstract has their thresholds alike at 40 Hz; -27 dB and 12 dB an octave put it within 1.2 dB of that."""
    level = decibels(Pacinian().weight(40.0)) - decibels(NonPacinian().weight(40.0))
    assert abs(level) < 1.25
    assert decibels(Pacinian().weight(30.0)) < -27 < decibels(Pacinian().weight(40.0))
    assert float(Pacinian().weight(0.0)) == 0.0


def test_the_band_has_its_ends_and_its_best_frequency():
    weight = NonPacinian(sensitivity=-20, low=10, high=100).weight([9.99, 10, 50, 100, 100.01])
    np.testing.assert_allclose(weight, [0, 0.1, 0.1, 0.1, 0], rtol=1e-12)
    assert NonPacinian(low=0, high=100).best() == pytest.approx(50.0)
    weight = NonPacinian().weight
    assert float(weight(NonPacinian().best())) == weight(np.geomspace(1, 5e3, 4001)).max()


def test_powers_add_inside_a_channel_and_the_highest_channel_counts():
    frequency, amplitude = np.array([250.0, 30.0]), np.array([3e-6, 4e-6])
    flat = NonPacinian(sensitivity=0, low=1, high=1000)
    assert felt_amplitude(flat, frequency, amplitude) == pytest.approx(5e-6, rel=1e-12)
    person = Perception(channels=(Pacinian(), flat))
    assert strongest(person, frequency, amplitude) == pytest.approx(5e-6, rel=1e-12)
    alone = Perception(channels=(Pacinian(),))
    assert strongest(alone, frequency, amplitude) == pytest.approx(3e-6, rel=1e-3)  # 4 um at -31 dB add 7e-4
    np.testing.assert_allclose(decibels([1, 10, 0.1]), [0, 20, -20], atol=1e-12)
    assert decibels(0.0) == -np.inf
    assert np.shape(decibels(np.ones((2, 3)))) == (2, 3)


def test_recalled_numbers_are_no_defaults():
    for skin in (ElasticSkin, ElasticViscousSkin):
        with pytest.raises(InputError, match="missing"):
            read_model(skin, {})
    person = Perception()
    assert (person.compliance, person.threshold, person.threshold_uncertainty) == (None, None, None)
    for kind in find_members(Channel).values():
        assert kind.status
        assert len(kind.reference) > 20


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"threshold": "0.1 um"}, "threshold_uncertainty"),
        ({"threshold_uncertainty": 3}, "threshold_uncertainty"),
        ({"channels": []}, "at least one"),
        ({"threshold": "2 V"}, "expected a length"),
        ({"difference_threshold": 0}, "must lie between"),
        ({"channels": [{"model": "Pacinain"}]}, "Did you mean 'Pacinian'"),
        ({"channels": [{"model": "NonPacinian", "low": 200}]}, "low must be below high"),
    ],
)
def test_a_perception_that_is_none_is_refused(changes, sentence):
    with pytest.raises(InputError, match=sentence):
        Perception().replace(changes)
