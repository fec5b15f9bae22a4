"""The slopes that an uncertainty is made of, against differences of the model they are slopes of."""

from dataclasses import replace

import numpy as np
import pytest

from electrovib.recordings.release.least_squares import Release
from electrovib.recordings.release.uncertainty import Uncertainty, _jacobian

STAMPS = np.linspace(-2e-3, 10e-3, 150)
AT = Release(
    start=0.3e-3,
    fall_time=0.2e-3,
    frequency=350.0,
    quality=3.0,
    held=0.7,
    after=0.05,
    misfit=0.0,
    model=np.zeros(0),
    residual=np.zeros(0),
)
CHANGES = (
    {"start": 1e-6},
    {"frequency": 0.3},
    {"quality": 3e-3},
    {"held": 1e-3},
    {"after": 1e-3},
    {"fall_time": 1e-6, "start": -1e-6},  # a longer fall at the same mean delay
)


def force(release):
    return release.after + (release.held - release.after) * release.shape(STAMPS)


@pytest.mark.parametrize("place", range(6))
def test_a_slope_is_the_change_of_the_force(place):
    columns = _jacobian(STAMPS, AT, of_fall=True)[:, [0, 1, 2, 4, 5, 3]]
    change = CHANGES[place]
    moved = replace(AT, **{name: getattr(AT, name) + by for name, by in change.items()})
    difference = (force(moved) - force(AT)) / next(iter(change.values()))
    # one-sided difference of 0.1 %
    np.testing.assert_allclose(columns[:, place], difference, rtol=0, atol=5e-3 * np.max(np.abs(difference)))
    assert np.max(np.abs(difference)) > 0


def test_components_add_as_squares():
    assert Uncertainty({"noise": 3.0, "window": 4.0}).total == 5
    assert Uncertainty({"noise": 3.0, "window": 4.0}).to_dict() == {"noise": 3.0, "window": 4.0, "total": 5.0}
