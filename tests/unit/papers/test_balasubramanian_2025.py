"""Slopes that were read; values at one speed that were not have no default."""

from __future__ import annotations

import inspect

import pytest

from electrovib.papers import balasubramanian_2025 as paper


@pytest.mark.parametrize(
    ("slope", "expected"),
    [(paper.CUT_OFF_SLOPE, 1104.0), (paper.MASS_SLOPE, 2.584e-3), (paper.STIFFNESS_SLOPE, 323.2)],
)
def test_from_20_to_100_mm_per_s(slope, expected):
    assert paper.change(slope=slope) == pytest.approx(expected, rel=1e-12)
    assert paper.change(slope=slope) != pytest.approx(expected * 1.001, rel=1e-12)


def test_one_mm_per_s():
    found = paper.at_speed(speed=0.051, slope=paper.CUT_OFF_SLOPE, known_at=0.05, known=500.0)
    assert found == pytest.approx(513.8, rel=1e-12)


def test_the_value_at_one_speed_has_to_be_given():
    parameters = inspect.signature(paper.at_speed).parameters
    assert all(parameter.default is inspect.Parameter.empty for parameter in parameters.values())
    with pytest.raises(TypeError, match="known"):
        paper.at_speed(speed=0.05, slope=paper.CUT_OFF_SLOPE)


def test_nothing_can_be_run():
    assert "not\nread" in paper.NOT_READ or "not read" in paper.NOT_READ
    assert not hasattr(paper, "scenarios")
