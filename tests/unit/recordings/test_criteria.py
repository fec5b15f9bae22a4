"""The criteria by which models are compared, against their formulas by hand."""

import math

import pytest

from electrovib.recordings.fit.least_squares import aicc, bic


def test_criteria_by_hand():
    assert aicc(10.0, counted=3, data=20) == pytest.approx(10 + 6 + 24 / 16, rel=1e-15)
    assert bic(10.0, counted=3, data=20) == pytest.approx(10 + 3 * math.log(20), rel=1e-15)


def test_the_correction_has_no_meaning_with_as_many_parameters_as_data():
    assert aicc(10.0, counted=3, data=4) == math.inf
    assert math.isfinite(aicc(10.0, counted=3, data=5))
