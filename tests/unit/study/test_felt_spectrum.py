"""The spectrum from which perception is computed."""

from __future__ import annotations

import numpy as np
import pytest

from electrovib.study.felt_spectrum import lines


def of(values, before):
    return lines(np.asarray(values, dtype=float), span=1.0, before=before, signal="lateral_force", how="")


def test_the_swing_counts_from_the_value_just_before_a_window():
    """A step of the force from 0.2 N to between 1 and 1.5 N at the beginning of the window enters the swing in full."""
    values = 1.25 + 0.25 * np.sin(2 * np.pi * np.arange(64) / 64)
    assert of(values, before=0.2).swing == pytest.approx((1.5 - 0.2) / 2)
    assert of(-values, before=-0.2).swing == pytest.approx((1.5 - 0.2) / 2)


def test_the_swing_of_a_whole_period_is_its_own():
    values = 1.25 + 0.25 * np.sin(2 * np.pi * np.arange(64) / 64)
    assert of(values, before=values[-1]).swing == pytest.approx(0.25)
    assert of(values, before=1.3).swing == pytest.approx(0.25)
