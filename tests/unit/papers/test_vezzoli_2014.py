"""The reproduction of the founding paper against numbers computed apart from this code."""

from __future__ import annotations

import json

import numpy as np
import pytest

from electrovib.core.discovery import paper
from electrovib.core.errors import InputError
from electrovib.papers.vezzoli_2014 import compute, numbers
from electrovib.study.reproduction import Row


@pytest.fixture(scope="module")
def reproduction():
    return paper("vezzoli_2014").reproduce()


@pytest.fixture(scope="module")
def rows(reproduction) -> dict[str, Row]:
    return {row.id: row for row in reproduction.rows}


def test_every_number_the_paper_states_has_a_row(rows):
    wanted = {"C_i", "C_sc", "static_force_1000V", "tau_giraud", "trapezium_force", "falling_edge_asymmetry"}
    assert wanted | {"suspended_force_constant", "fig7_saturation"} <= set(rows)
    for name in ("tau_giraud", "trapezium_force", "falling_edge_asymmetry", "fig7_saturation"):
        assert rows[name].verdict == "open"
    assert {row.id for row in rows.values() if row.verdict == "reproduced"} == {"C_i", "C_sc"}


@pytest.mark.parametrize(
    ("name", "expect", "digits"),
    [
        ("C_i", 32.96, 0.005),
        ("C_sc", 6.906, 0.0005),
        ("static_force_1000V", 56.55, 0.005),
        ("equation_3", 1.004772, 1e-6),
        # by hand: K = 90 um/3.35 + T/1560, law (1) goes as 1/(K (T + 90 um)), the gap plane as 1/K^2
        ("thickness_spread_law_1", 2.5974, 5e-5),
        ("thickness_spread_gap", 1.0143, 5e-5),
    ],
)
def test_single_numbers(rows, name, expect, digits):
    # half of the last digit of a number computed apart from this code
    assert rows[name].ours == pytest.approx(expect, abs=digits)
    assert rows[name].ours != pytest.approx(expect + 3 * digits, abs=digits)


@pytest.mark.parametrize(
    ("name", "low", "high"),
    [
        ("tau_giraud", 0.0503, 6.63),  # Gabriel dry, constant phase 0.85
        ("return_path_film", 0.567, 0.854),
        ("return_path_coat", 0.00173, 0.0219),
        ("causality_residual", 0.0843, 0.281),  # Gabriel wet, palmar 20 uS: printed bounds 8 to 30 %
    ],
)
def test_ranges(rows, name, low, high):
    ours = rows[name].ours
    assert isinstance(ours, tuple)
    assert ours == pytest.approx((low, high), rel=5e-3)  # three digits


@pytest.mark.parametrize(
    ("case", "ramp"),
    [
        ("paper point", 36.5e-3),
        ("palmar men 2 uS", 37.5e-3),
        ("palmar women 2 uS", 30e-3),
        ("1963 impedance", 6.5e-3),
        ("palmar women 10 uS", 4.1e-3),
        ("palmar men 20 uS", 1.8e-3),
        ("Gabriel wet", 5.6e-3),
        ("gap plane, leaky gap 5 um", 101e-3),
    ],
)
def test_ramp_that_gives_the_printed_force(case, ramp):
    # two digits, computed apart; 3 % covers their rounding
    assert compute.ramp_for(compute.figure_6_cases()[case], 2.5e-3) == pytest.approx(ramp, rel=3e-2)


@pytest.mark.parametrize(
    ("skin", "rise", "word"),
    [
        ("paper point", 1 / 0.981, "open, flat"),
        ("Gabriel wet", 1 / 0.25, "consistent"),
        ("Gabriel dry", 1 / 0.003, "open, still rising"),
        ("palmar men 20 uS", 1 / 0.15, "consistent"),
        ("palmar women 20 uS", 1 / 0.13, "consistent"),
        ("palmar men 10 uS", 1 / 0.41, "open, peaks"),
        ("palmar men 2 uS", 1 / 1.31, "open, falls"),
        ("1963 impedance", 1 / 0.56, "open, peaks"),
    ],
)
def test_figure_7_by_skin(skin, rise, word):
    found = compute.rise_and_saturation(compute.force_skins()[skin].material)
    # two digits of the reciprocal, of 0.003 one
    assert found[0] == pytest.approx(rise, rel=0.15 if skin == "Gabriel dry" else 0.04)
    assert numbers.verdict(*found).startswith(word)


def test_causality_residual_is_rounding_without_dispersion():
    skins = compute.force_skins()
    assert compute.causality_residual(skins["paper point"].material) < 1e-8
    assert compute.causality_residual(skins["palmar men 2 uS"].material) == pytest.approx(0.24, rel=0.1)


def test_suspended_finger_keeps_its_force_only_without_leak(rows):
    assert rows["suspended_force_constant"].ours == pytest.approx(1.0, abs=1e-3)
    assert rows["suspended_force_leaky"].ours < 1e-6


def test_rows_are_plain_json_and_panels_are_finite(reproduction):
    for row in reproduction.rows:
        again = json.loads(json.dumps(row.to_dict()))
        assert set(again) == {"id", "what", "paper", "ours", "unit", "verdict", "note"}
        assert np.all(np.isfinite(np.atleast_1d(again["ours"])))
    for panel in reproduction.panels:
        for curve in panel.curves:
            assert len(curve.x) == len(curve.y)
            drawn = curve.y[~np.isnan(curve.y)] if panel.id in {"fig6", "falling_edge"} else curve.y
            assert np.all(np.isfinite(drawn))


def test_a_verdict_that_a_row_does_not_bear_is_refused():
    with pytest.raises(ValueError, match="only a printed number"):
        Row("x", "x", None, 1.0, "1", "reproduced", "")
    with pytest.raises(ValueError, match="needs a note"):
        Row("x", "x", None, 1.0, "1", "open", "")


@pytest.fixture
def skin_table(tmp_path):
    path = tmp_path / "skin.csv"
    rows = [(100, 2000, 1e5), (300, 1800, 7e4), (1000, 1500, 4e4), (3000, 1200, 2e4), (10000, 900, 1e4)]
    lines = ["frequency [Hz],permittivity,resistivity [ohm m]", *(f"{f},{e},{r}" for f, e, r in rows)]
    path.write_text("\n".join(lines))
    return path, np.array(rows)


def test_a_table_of_ones_own_is_drawn_as_its_rows(skin_table):
    """A point is a measured one: nothing between the rows is drawn as if it had been measured."""
    path, rows = skin_table
    panels = {panel.id: panel for panel in paper("vezzoli_2014").reproduce(skin=str(path)).panels}
    (drawn,) = [curve for curve in panels["fig4"].curves if curve.label == "your table"]
    assert drawn.kind == "points"
    assert np.array_equal(drawn.x, rows[:, 0])
    assert drawn.y == pytest.approx(8.8541878128e-12 * rows[:, 1] * rows[:, 2], rel=1e-12)


def test_faults_of_ones_own_table_name_the_option_and_the_file(skin_table):
    path, _ = skin_table
    path.write_text(path.read_text().replace("70000.0", "-1"))
    with pytest.raises(InputError) as caught:
        paper("vezzoli_2014").reproduce(skin=str(path))
    assert str(caught.value).startswith(
        f"skin = {path}: row 1 (first is 0), 300 Hz: resistivity = -1 must be"
    )
    with pytest.raises(InputError) as caught:
        paper("vezzoli_2014").reproduce(skin=str(path.with_name("none.csv")))
    assert str(caught.value).startswith(f"skin = {path.with_name('none.csv')}: there is no such file.")


def test_figure_6_draws_nothing_below_its_floor(reproduction):
    (panel,) = [panel for panel in reproduction.panels if panel.id == "fig6"]
    drawn = np.concatenate([curve.y for curve in panel.curves])
    assert np.nanmin(drawn) >= 1e-7
    assert np.isnan(drawn).any()
