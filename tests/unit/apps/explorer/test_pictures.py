"""Plots of the page: the numbers of the Trace, in the unit of the axis."""

from __future__ import annotations

import json
import math
import re

import numpy as np
import pytest

import electrovib as ev
from electrovib.apps.explorer.computed import compute
from electrovib.apps.explorer.drawing import drawing
from electrovib.apps.explorer.further import FELT, FREQUENCY, LAWS, SAFETY, Further, slices
from electrovib.apps.explorer.limits import SHOWN_SAMPLES
from electrovib.apps.explorer.page.words import (
    felt_words,
    judged_words,
    kept_words,
    law_words,
    safety_words,
    verdict_words,
)
from electrovib.apps.explorer.pictures.axis import Axis
from electrovib.apps.explorer.pictures.felt import detection, felt, laws, recorded
from electrovib.apps.explorer.pictures.figure import PlottedCurve, figure, thinned
from electrovib.apps.explorer.pictures.over_frequency import over_frequency
from electrovib.apps.explorer.pictures.over_time import over_time
from electrovib.apps.explorer.state import presets
from electrovib.physics.perception import NonPacinian, Pacinian, Perception


@pytest.fixture(scope="module")
def shown():
    return compute(ev.load("vezzoli_2014/fig6_gap"))


def title(plot):
    return plot["layout"]["title"]["text"]


def known_further(tab, shown):
    known = Further()
    for each in slices(tab, shown):
        known = each(known)
    return known


def test_a_curve_holds_the_numbers_of_the_trace_in_the_unit_of_its_axis(shown):
    plot = next(each for each in over_time(shown) if title(each) == "Electrostatic force")
    assert plot["layout"]["yaxis"]["title"]["text"] == "force [mN]"
    assert plot["layout"]["xaxis"]["title"]["text"] == "time [ms]"
    force = shown.trace.electrostatic_force.values
    assert max(plot["data"][0]["y"]) == pytest.approx(1e3 * force.max(), rel=1e-4)
    x, y = np.array(plot["data"][0]["x"]) / 1e3, np.array(plot["data"][0]["y"]) / 1e3
    np.testing.assert_allclose(
        y, np.interp(x, shown.trace.time.values, force), rtol=0, atol=1e-3 * force.max()
    )


def test_the_voltages_of_the_layers_add_up_to_that_of_the_stack():
    shown = compute(ev.load("rauf_2025/relaxor"))
    plot = next(each for each in over_time(shown) if title(each) == "Voltage across each layer")
    assert plot["layout"]["yaxis"]["title"]["text"] == "voltage [V]"
    assert plot["layout"]["xaxis"]["title"]["text"] == "time [ms]"
    total = sum(np.interp(0.5, line["x"], line["y"]) for line in plot["data"])
    assert total == pytest.approx(float(shown.trace.stack_voltage.interp(time=5e-4)), rel=1e-3)
    assert total > 140


def test_voltages_of_layers_that_differ_by_much_are_relative_to_their_largest(shown):
    plot = over_time(shown)[-1]
    assert title(plot) == "Voltage across each layer over its largest"
    gap = shown.trace.field.sel(layer="gap").values * shown.scenario.stack.layers["gap"].thickness
    line = next(each for each in plot["data"] if each["name"].startswith("gap"))
    assert line["name"] == "gap (1 is 7.87 V)"
    assert np.abs(gap).max() == pytest.approx(7.87, abs=0.005)
    wanted = np.interp(0.06, shown.trace.time.values, gap) / np.abs(gap).max()
    assert np.interp(60, line["x"], line["y"]) == pytest.approx(wanted, rel=5e-3)
    dashes = [each["line"]["dash"] for each in plot["data"]]
    assert len(set(dashes)) == len(dashes) == 3  # of two that coincide both are visible


def test_the_time_constant_is_permittivity_over_conductivity(shown):
    plot = over_frequency(shown)[1]
    assert title(plot).startswith("Time constant of each layer")
    assert plot["layout"]["yaxis"]["title"]["text"] == "time constant [ms]"
    by_name = {line["name"]: line["y"] for line in plot["data"]}
    skin = shown.scenario.stack.layers["stratum_corneum"].material
    expected = 8.8541878128e-12 * skin.permittivity / skin.conductivity
    assert by_name["stratum corneum"][0] == pytest.approx(1e3 * expected, rel=1e-4)
    assert "insulator" not in by_name  # it does not conduct


def test_the_whole_impedance_is_visible(shown):
    plot = over_frequency(shown)[-1]
    low, high = plot["layout"]["yaxis"]["range"]
    size = np.abs(shown.trace.impedance.values)
    assert 10**low < size.min() < size.max() < 10**high


@pytest.mark.parametrize(
    ("low", "unit", "ticks"),
    [(1e-3, "mN", [1, 2, 5]), (3e-5, "mN", [1]), (1e-9, "N", None)],
)
def test_a_logarithmic_axis_of_few_decades_has_plain_numbers(low, unit, ticks):
    curve = PlottedCurve([1, 2], [low, 0.02], "a")
    axis = figure("t", Axis("x", "s"), Axis("force", "N", is_logarithmic=True), [curve])["layout"]["yaxis"]
    assert axis["title"]["text"] == f"force [{unit}]"
    assert [each for each in axis.get("tickvals", []) if 1 <= each < 10] == (ticks or [])
    assert ("dtick" in axis) == (ticks is None)


def test_a_band_lies_between_its_edges(shown):
    known = known_further(FREQUENCY, shown)
    assert known.problems == ()
    assert np.all(known.band["low"] <= known.band["middle"])
    assert np.all(known.band["middle"] <= known.band["high"])
    lower, upper, line = over_frequency(shown, band=known.band)[0]["data"]
    assert upper["fill"] == "tonexty"
    assert all(low <= high for low, high in zip(lower["y"], upper["y"], strict=True))
    assert line["name"] == "mean force of the scenario"
    edges = over_frequency(shown, band=known.band)[0]["layout"]["yaxis"]["range"]
    assert 10 ** edges[0] < min(lower["y"])


def test_what_a_population_draws_is_stated(shown):
    known = known_further(FREQUENCY, shown)
    assert "which differ in thickness of the stratum corneum, permittivity of" in known.drawn
    assert "does not take it: level of the moisture" in known.drawn
    bands = ev.study(shown.scenario, "fingers", n=200, seed=1, signal="mean_force").mean_force_percentile
    np.testing.assert_array_equal(known.band["high"], bands.sel(percentile=95).values)


def test_a_finger_without_skin_has_a_band_of_the_parameters_that_it_has():
    shown = compute(ev.load("strong_1970/display"))
    known = known_further(FREQUENCY, shown)
    assert known.problems == ()
    assert "area of the contact" in known.drawn.partition("Not drawn")[0]
    assert "thickness of the stratum corneum" in known.drawn.partition("Not drawn")[2]
    assert np.all(known.band["low"] < known.band["high"])


def test_kept_curves_are_dashed(shown):
    other = compute(shown.scenario.replace({"drive.high": "500 V"}))
    lines = next(each for each in over_time(shown, [other]) if title(each) == "Electrostatic force")["data"]
    assert [line["line"]["dash"] for line in lines] == ["solid", "dash"]
    assert [line["name"] for line in lines] == ["attraction", "attraction, kept 1"]
    assert [line["showlegend"] for line in lines] == [True, False]
    text = kept_words(["a <b>", "c"])
    assert "kept 1: a &lt;b&gt;" in text
    assert text.count("<line") == 2
    assert max(lines[0]["y"]) == pytest.approx(4 * max(lines[1]["y"]), rel=1e-3)


def test_every_other_law_is_run_or_left_out_with_a_reason(shown):
    known = known_further(LAWS, shown)
    assert {"MaxwellStressInInsulator", "EffectiveMedium"} <= set(known.laws)
    assert "Vezzoli2014PerFrequency" in known.left_out
    assert known.left_out["Persson2018RoughGap"].startswith(
        "it needs force.mean_gap and force.rms_gap: choose"
    )
    plots = laws(shown, known.laws)
    assert len(plots) == 2
    assert plots[0]["data"][0]["name"] == "MaxwellStressInGap"
    text = law_words(shown, known)
    assert "cannot run here" in text
    one = ev.simulate(shown.scenario.replace({"force": {"model": "MaxwellStressInInsulator"}}))
    ratio = one.electrostatic_force.values.max() / shown.trace.electrostatic_force.values.max()
    assert f"<td>{ratio:.3g}</td>" in text


def test_felt_and_safety(shown):
    percept = known_further(FELT, shown).percept
    assert percept.answer.partition(",")[2] in verdict_words(percept)
    assert f"{percept.channels[0].level:.1f}".replace("-", "−") in felt_words(percept)
    (plot,) = felt(percept, shown.scenario)
    largest = percept.spectrum.amplitude[percept.spectrum.frequency >= 1].max()
    assert max(plot["data"][0]["y"]) == pytest.approx(largest * 1e3, rel=1e-6)
    low, high = plot["layout"]["yaxis"]["range"]
    assert 10**low < max(plot["data"][0]["y"]) < 10**high
    text = safety_words(known_further(SAFETY, shown).check)
    assert "hardware has to limit the current" in text
    assert "250 µA" in text


def test_without_a_calibration_the_curve_is_the_middle_of_the_published_thresholds(shown):
    """At 250 Hz: 19.1 to 122 nm at weight 1, and skins of 323.2 N/m without and with 3.95 N s/m."""
    percept = known_further(FELT, shown).percept
    level, name = detection(percept, shown.scenario)
    frequency = np.geomspace(1, 2000, len(level))
    weight, stiff = Pacinian().weight, np.abs(323.2 + 2j * np.pi * 3.95 * frequency)
    ends = 0.03e-6 * weight(150.0) * 323.2, 0.13e-6 * weight(300.0) * stiff
    high = frequency > 110  # where the other channel feels nothing
    expected = np.sqrt(ends[0] * ends[1]) / weight(frequency)
    np.testing.assert_allclose(level[high], expected[high], rtol=1e-6)
    assert name == "detection threshold of a single sine (published, middle)"
    nobody = Perception(channels=(NonPacinian(low=50.0),))  # its thresholds are below that band
    alone = shown.scenario.replace({"perception": nobody})
    level, name = detection(ev.perceive(alone), alone)
    assert "no threshold is known" in name
    alike = NonPacinian().weight(50.0) * np.nanmin(level)
    assert 20 * np.log10(alike) == pytest.approx(ev.perceive(alone).level, abs=1e-9)
    assert "felt or not: unknown without perception.threshold" in ev.perceive(alone).answer


def test_a_calibrated_threshold_is_the_detection_level_at_the_best_frequency():
    scenario = ev.load("vezzoli_2014/fig6_gap").replace(
        {
            "perception": {
                "threshold": "0.1 um",
                "threshold_uncertainty": 3,
                "compliance": {"model": "ElasticViscousSkin", "stiffness": 1000, "corner": 100},
            }
        }
    )
    percept = ev.perceive(scenario)
    level, name = detection(percept, scenario)
    frequency = np.geomspace(1, 2000, len(level))
    moved = np.abs(scenario.perception.compliance.compliance(frequency)) * level
    best = int(np.argmin(np.abs(frequency - 250)))
    assert moved[best] == pytest.approx(1e-7, rel=0.01)
    assert name == "detection threshold of a single sine (of the perception)"


def test_a_mistake_of_a_slice_becomes_a_sentence():
    shown = compute(ev.load("rauf_2025/relaxor"))  # a clutch: no population of fingers fits it
    known = known_further(FREQUENCY, shown)
    assert known.band is None
    assert known.problems[0].startswith(
        "The band of fingers is not shown: the contact has neither skin nor load"
    )
    earlier = Further(band={"low": np.zeros(1)}, drawn="of another scenario")
    for each in slices(FREQUENCY, shown):
        earlier = each(earlier)
    assert (earlier.band, earlier.drawn) == (None, "")


def test_the_drawing_is_to_scale_on_its_left(shown):
    text = drawing(shown)
    boxes = [
        (float(y), float(height))
        for x, y, height in re.findall(
            r'<rect x="([\d.]+)" y="([\d.]+)" width="[\d.]+" height="([\d.]+)"[^>]*fill-opacity', text
        )
        if float(x) < 10
    ]
    thicknesses = [layer.thickness for layer in shown.scenario.stack.layers.values()]
    heights = [height for _, height in boxes]
    assert heights[2] / heights[0] == pytest.approx(thicknesses[2] / thicknesses[0], rel=0.01)
    assert boxes[0][0] > boxes[2][0]  # the insulator lies below the skin
    assert 'role="img"' in text
    assert "gap, 1 µm" in text


@pytest.mark.parametrize("name", presets()[::4])
def test_plots_of_every_kind_of_scenario_can_be_sent(name):
    shown = compute(ev.load(name))
    plots = [*over_time(shown), *over_frequency(shown)]
    assert len(over_time(shown)) <= 4
    text = json.dumps(plots, allow_nan=False)
    assert len(text) < 400_000
    assert all(len(line["x"]) <= SHOWN_SAMPLES + 4 for plot in plots for line in plot["data"])
    assert "<svg" in drawing(shown)
    assert "<li>" in judged_words(shown.diagnostics)


def test_a_recording_stands_beside_the_prediction(shown):
    measured = shown.trace[["electrostatic_force", "impedance"]]
    plots = recorded(shown, measured)
    assert [title(plot) for plot in plots] == ["electrostatic force", "impedance"]
    assert plots[0]["data"][0]["y"] == plots[0]["data"][1]["y"]


def test_thinned_keeps_extremes_and_ends():
    x = np.arange(100_003.0)
    y = np.sin(x / 7)
    y[50_001], y[7] = 9.0, -8.0
    short, kept = thinned(x, y)
    assert len(short) <= SHOWN_SAMPLES + 2
    assert (kept.max(), kept.min()) == (9.0, -8.0)
    assert (short[0], short[-1]) == (0, 100_002)
    assert np.all(np.diff(short) > 0)


def test_numbers_that_are_not_finite_are_gaps():
    plot = figure(
        "t", Axis("x", "s"), Axis("y", "N"), [PlottedCurve([0, 1, 2], [1.23456789, math.nan, math.inf], "a")]
    )
    assert plot["data"][0]["y"] == (1.2346, None, None)


def test_a_small_change_of_a_large_value_keeps_its_digits():
    """Friction of 250 mN that attraction changes by 0.3 mN has no steps of rounding."""
    x = np.linspace(0, 1, 201)
    y = 0.25 + 0.3e-3 * x
    plot = figure("t", Axis("x", "s"), Axis("y", "N"), [PlottedCurve(x, y, "a")])
    shown = np.array(plot["data"][0]["y"])
    assert shown == pytest.approx(250 + 0.3 * x, abs=0.3e-5)
    assert max(len(repr(float(each))) for each in shown) <= 9
    assert figure("t", Axis("x", "s"), Axis("y", "N"), [PlottedCurve([0, 1], [2.5, 2.5], "a")])["data"][0][
        "y"
    ] == (2.5, 2.5)


def test_a_constant_is_drawn_as_one_and_zeros_on_a_logarithmic_axis_are_left_out():
    plot = figure("t", Axis("x", "s"), Axis("y", "N"), [PlottedCurve([0, 1], [2.0, 2.0 + 1e-12], "a")])
    assert plot["layout"]["yaxis"]["range"] == pytest.approx([1.6, 2.4])
    plot = figure(
        "t", Axis("x", "s"), Axis("y", "N", is_logarithmic=True), [PlottedCurve([0, 1], [0.0, 1e-3], "a")]
    )
    assert plot["layout"]["yaxis"]["title"]["text"] == "y [mN]"
    assert plot["layout"]["yaxis"]["range"] == pytest.approx([-0.1, 0.15])


def test_text_of_a_visitor_stays_text(shown):
    from electrovib.core.diagnostics import Diagnostic

    text = judged_words([Diagnostic("<b>", "warning", "<script>alert(1)</script>")])
    assert "<script>" not in text


def test_a_level_is_thinned_without_points_that_repeat():
    x = np.arange(10_000.0)
    shown, heights = thinned(x, np.where(x < 5000, 1.0, 2.0))
    assert np.all(np.diff(shown) > 0)
    assert (shown[0], shown[-1]) == (0, 9999)
    assert set(heights) == {1.0, 2.0}
