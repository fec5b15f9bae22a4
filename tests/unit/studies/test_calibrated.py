"""Calibrated predictions: a planted constant of proportionality, closed forms of the posterior, and what is not possible."""

import csv
import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import tomlkit

import electrovib as ev
from electrovib.core.discovery import find_members
from electrovib.core.errors import InputError
from electrovib.physics.force import ForceLaw
from electrovib.studies.evidence import Measurement
from electrovib.studies.evidence.calibrated import LEAST, calibrated_predictions
from electrovib.studies.evidence.measurement import AT_LEAST
from electrovib.studies.evidence.predicted import predict
from electrovib.studies.evidence.standing import DECADE

VOLTAGES = (50.0, 100.0, 200.0)
GAP = {"model": "LogUniform", "low": 1e-6, "high": 4e-6, "choice": "a range of this test"}
FILM = {"model": "LogUniform", "low": 1e-6, "high": 1e-5, "choice": "a decade, of this test"}
TRUE = 2e-6
LAW = "MaxwellStressInGap"
OTHERS = tuple(name for name in find_members(ForceLaw) if name != LAW)
"""Laws that are left out, as if they had been made from the numbers."""


def step():
    drive = {"model": "Step", "level": 100.0}
    changes = {"drive": drive, "load.normal_force": 0.0, "time.duration": 1e-3}
    return ev.load("vezzoli_2014/fig6_gap", changes=changes)


def per_gap(scenario):
    """A constant of proportionality that nothing but the gap changes."""
    return TRUE / scenario.stack.layers["gap"].thickness


def square(scenario):
    return per_gap(scenario) * scenario.drive.level**2


def square_on_film(scenario):
    return square(scenario) * scenario.stack.layers["insulator"].thickness / 3e-6


def measured(quantity=square, spread=0.1, **more):
    content = {
        "title": "made up", "source": "this test", "scenario": step(), "quantity": quantity, "unit": "N",
        "values": tuple(each**2 for each in VOLTAGES), "spread": (spread,) * len(more.get("values", VOLTAGES)),
        "spread_of": "repeats", "group": "nobody", "how": "printed", "status": "full text", "over": "drive.level", "at": VOLTAGES,
        "unknown": {"stack.gap.thickness": GAP}, "made": OTHERS,
    }  # fmt: skip
    return Measurement(**content | more)


def constant(spread=0.1, value=1.0, **more):
    """The constant alone, measured without a voltage."""
    return measured(per_gap, values=(value,), spread=spread, over="", at=(), **more)


def calibrated(each, n=64, seed=0):
    (result,) = calibrated_predictions({"m": each}, {"m": predict(each, n=n, seed=seed)[0]}, n=n, seed=seed)
    return result


def weighted_quantile(values, weights, share):
    order = np.argsort(values)
    return values[order][np.searchsorted(np.cumsum(weights[order]), share)]


def test_one_voltage_predicts_the_others_as_weighted_quantiles_of_the_same_draws_do():
    """Within 1.5 %: draws are some 0.5 % apart, and 256 of them have steps of 0.4 % in probability."""
    for seed in (0, 5):
        found = calibrated(measured(calibrated_at=(100.0,)), n=256, seed=seed)
        gaps = ev.read_space(step(), {"space": {"stack.gap.thickness": GAP}}).draw(seed, 0, found.draws)
        c = TRUE / gaps["stack.gap.thickness"]
        weights = np.exp(-0.5 * np.log(c) ** 2 / math.log1p(0.1**2))
        weights /= weights.sum()
        assert found.effective == pytest.approx(1 / np.sum(weights**2), rel=1e-9)
        for place, share in enumerate((0.05, 0.5, 0.95)):
            expected = weighted_quantile(c, weights, share) * np.array([50.0, 200.0]) ** 2
            np.testing.assert_allclose(found.score.band[place], expected, rtol=0.015)
        assert found.score.covered == 1
        assert found.by == "m at 100 V"


def test_a_calibrated_width_is_that_of_the_measurement_and_the_factor_is_one():
    """The range is wide against the spread, so that the posterior is log-normal: tolerance of some 60 effective draws."""
    found = calibrated(measured(calibrated_at=(100.0,)), n=256)
    width = 2 * 1.6449 * math.sqrt(math.log1p(0.1**2)) / DECADE
    assert found.score.width == pytest.approx(width, rel=0.25)
    assert found.prior.width == pytest.approx(0.9 * math.log10(4), rel=0.05)
    assert found.score.ratio == pytest.approx(1.0, abs=0.05)
    assert found.score.score > found.prior.score + 1.0
    wrong = calibrated(
        measured(lambda scenario: per_gap(scenario) * 100 * scenario.drive.level, calibrated_at=(100.0,))
    )
    assert (
        wrong.score.covered == 0
    )  # a law with another exponent, 2 times too high at 50 V and too low at 200 V
    assert wrong.score.score < wrong.prior.score


def test_what_both_have_carries_over_and_anything_else_keeps_its_range():
    """The film has a decade, of which 90 % are 0.9; the gap, known to 2 %, adds nothing that 128 draws show."""
    film = {"stack.gap.thickness": GAP, "stack.insulator.thickness": FILM}
    other = constant(0.02, unknown={"stack.gap.thickness": GAP, "load.normal_force": {
        "model": "Uniform", "low": 0.1, "high": 1.0, "choice": "of this test"}})  # fmt: skip
    each = measured(square_on_film, unknown=film, calibrated_by={"lab/constant": other})
    found = calibrated(each, n=128)
    assert found.by == "lab/constant"
    assert found.score.width == pytest.approx(0.9, abs=0.05)
    assert found.prior.width > found.score.width + 0.1
    only_film = replace(each, unknown={"stack.insulator.thickness": FILM})
    apart = calibrated(only_film, n=16)
    assert (apart.score, apart.why) == (
        None,
        "no range of what is not printed is the same as in what calibrates",
    )
    wider = {"stack.gap.thickness": {**GAP, "high": 5e-6}}
    assert calibrated(replace(each, unknown=wider), n=16).why == apart.why
    closed = calibrated(replace(each, calibrated_by={"lab/constant": replace(other, unknown={})}), n=16)
    assert "nothing is open" in closed.why
    made = calibrated(replace(each, calibrated_by={"lab/constant": replace(other, made=(LAW,))}), n=16)
    assert "made from the numbers that calibrate" in made.why


def test_a_calibration_that_contradicts_every_draw_or_that_too_few_reach_is_not_possible():
    lost = calibrated(measured(calibrated_by={"c": constant(value=100.0)}))
    assert lost.score is None
    off = math.log(100.0 / 2.0) / math.sqrt(math.log1p(0.01))  # the smallest gap gives 2
    assert lost.why == f"it contradicts all 256 draws: the closest is {off:.2g} deviations off"
    few = calibrated(measured(calibrated_by={"c": constant(0.005)}), n=4)
    assert few.score is None
    assert few.draws == 256
    assert few.effective < LEAST
    assert "effective of 256 draws are too few to be trusted" in few.why
    enough = calibrated(measured(calibrated_by={"c": constant(0.005)}), n=64)
    assert enough.effective > LEAST
    assert enough.score.ratio == pytest.approx(1.0, abs=0.01)


def test_points_that_share_their_errors_calibrate_as_one():
    line = measured(error_of="line", calibrated_at=(50.0, 100.0))
    one = calibrated(replace(line, error_of="", calibrated_at=(100.0,)), n=256)
    assert calibrated(line, n=256).effective == pytest.approx(one.effective, rel=1e-9)
    apart = calibrated(replace(line, error_of=""), n=256)
    assert apart.effective == pytest.approx(
        one.effective / math.sqrt(2), rel=0.1
    )  # deviations of twice the weight


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ({"calibrated_at": (70.0,)}, "calibrated_at: expected some of at (50, 100, 200), but not all, and no bounds"),
        ({"calibrated_at": VOLTAGES}, "calibrated_at: expected some of at (50, 100, 200), but not all"),
        ({"calibrated_at": (50.0,), "bound": AT_LEAST}, "calibrated_at: expected some of at"),
        ({"calibrated_by": {"c": constant(bound=AT_LEAST)}}, "calibrated_by: 'c' has bounds"),
        ({"calibrated_by": {"c": constant(judges="contact")}}, "'c' has bounds, or judges another model than that at force"),
    ],
)  # fmt: skip
def test_what_cannot_calibrate_is_refused(more, words):
    with pytest.raises(InputError, match=re.escape(words)):
        measured(**more)


def test_a_file_declares_what_calibrates_and_the_evidence_reports_both(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    points = {"over": "drive.level", "at": ["50 V", "100 V"], "values": ["1.1 mN", "4.4 mN"]}
    content = {
        "schema": 1, "source": "this test", "group": "nobody", "scenario": "vezzoli_2014/fig6_gap", "spread": "10 %",
        "spread_of": "repeats", "quantity": "peak electrostatic_force", "title": "made up", "made": list(OTHERS),
        "changes": {"drive": {"model": "Step", "level": "100 V"}, "time.duration": "1 ms"},
        "unknown": {"stack.gap.thickness": {**GAP, "high": 1e-4}},
        "measurements": {
            "one": {"values": "4.4 mN"},
            "over": {**points, "calibrated_by": ["one"], "calibrated_at": "50 V"},
        },
    }  # fmt: skip
    path = Path("lab.toml")
    path.write_text(tomlkit.dumps(content), encoding="utf-8")
    found = ev.measurements("lab.toml")
    assert found["lab/over"].calibrated_at == (50.0,)
    assert list(found["lab/over"].calibrated_by) == ["lab/one"]
    assert found["lab/over"].calibrated_by["lab/one"].values == found["lab/one"].values
    result = ev.evidence("lab.toml", n=8)
    assert {each.by for each in result.calibrated} == {"lab/one", "lab/over at 50 V"}
    (said,) = (each for each in result.document.sentences if each.startswith("Calibrated on a part"))
    assert f"of {len(result.calibrated)} predictions are possible" in said
    table = next(each for each in result.document.pages if each.title == "Calibrated predictions")
    assert len(table.rows) == len(result.calibrated)
    lines = [each for each in result.content("calibrated.csv").splitlines() if not each.startswith("#")]
    rows = list(csv.DictReader(lines))
    (row,) = (each for each in rows if (each["model"], each["by"]) == (LAW, "lab/one"))
    assert float(row["width_after"]) < 0.3 < float(row["width_before"])
    content["measurements"]["over"]["calibrated_by"] = ["on"]
    path.write_text(tomlkit.dumps(content), encoding="utf-8")
    expected = (
        "lab.toml: measurements.over.calibrated_by = on: no measurement of this file. Did you mean 'one'?"
    )
    with pytest.raises(InputError, match=re.escape(expected)):
        ev.measurements("lab.toml")
    without = ev.evidence({"one": found["lab/one"]}, n=4)
    assert without.calibrated == ()
    assert not [each for each in without.document.sentences if each.startswith("Calibrated on a part")]
