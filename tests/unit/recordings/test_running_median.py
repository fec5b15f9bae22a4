"""Running medians against the median of each window, also where a window is longer than the record."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from electrovib.recordings.running_median import running_median


@given(count=st.integers(1, 40), half=st.integers(0, 40), seed=st.integers(0, 2**32 - 1))
@pytest.mark.parametrize("beyond", ["edge", "symmetric"])
def test_each_window_has_its_own_median(beyond, count, half, seed):
    values = np.random.default_rng(seed).chisquare(1, count)
    places = np.arange(count)[:, None] + np.arange(-half, half + 1)
    if beyond == "edge":
        places = np.clip(places, 0, count - 1)
    else:
        places %= 2 * count
        places = np.where(places < count, places, 2 * count - 1 - places)
    expected = np.median(values[places], axis=1)
    assert np.array_equal(running_median(values, 2 * half + 1, beyond=beyond), expected)


def test_a_single_wrong_sample_is_left_out():
    assert running_median(np.array([1.0, 2, 90, 4, 5]), 3, beyond="edge").tolist() == [1, 2, 4, 5, 5]
