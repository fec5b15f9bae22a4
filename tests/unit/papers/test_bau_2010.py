"""What a difference threshold of 1.21 dB means in volts and newtons, and that no number cited from memory is used."""

from __future__ import annotations

import inspect

import numpy as np
import pytest

from electrovib.papers import bau_2010
from electrovib.solve.simulate import simulate


def test_difference_threshold_in_volts_and_newtons():
    assert bau_2010.just_noticeable_ratio() == pytest.approx(1.149, abs=5e-4)  # three digits
    assert bau_2010.force_change(ratio=2.0) == pytest.approx(40 * np.log10(2), rel=1e-12)
    assert bau_2010.force_change(ratio=1.149) != pytest.approx(1.21, abs=0.1)


def test_a_sine_is_felt_at_twice_its_frequency():
    assert bau_2010.order_of_the_force() == 2
    trace = simulate(bau_2010.scenarios()["sine"])
    assert float(trace.electrostatic_force.min()) >= 0


def test_recalled_thresholds_are_nowhere():
    text = inspect.getsource(bau_2010)
    assert not any(word in text for word in ("1.16", "270.0", "180.0", "11-25"))
    assert "not read" in bau_2010.NOT_READ
