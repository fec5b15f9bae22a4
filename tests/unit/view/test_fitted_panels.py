"""Figures of a fit as data: colours that keep the data apart from the model."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np

from electrovib.study.reproduction import REFERENCE
from electrovib.view.fitted import fit_panels


def residuals(recording: str) -> SimpleNamespace:
    """Return what a figure needs of the residuals of one recording of a force."""
    x = np.linspace(0.0, 1.0, 50)
    observed = SimpleNamespace(signal="lateral_force", axis="time", parts=1, x=x, y=x, scale=1.0)
    return SimpleNamespace(observed=observed, recording=recording, predicted=x, values=0 * x, noise=1.0)


def looks(*recordings: str) -> dict[str, int]:
    """Return the place in the palette of each curve of the first figure."""
    panel = fit_panels([residuals(name) for name in recordings])[0]
    return {curve.label: curve.look for curve in panel.curves}


def test_data_of_one_recording_are_grey_beside_the_coloured_model():
    assert looks("a.nc") == {"a.nc, data": REFERENCE, "a.nc, model": 0}


def test_data_of_several_recordings_have_the_colour_of_their_model():
    assert looks("a.nc", "b.nc") == {"a.nc, data": 0, "a.nc, model": 0, "b.nc, data": 1, "b.nc, model": 1}
