"""What each tab shows: the numbers of the Trace in the unit of the axis, or a sentence, for every shipped scenario."""

import html
import json
import math
import re

import numpy as np
import pytest
import xarray

import electrovib as ev
from electrovib.apps.explorer.computed import (
    FELT,
    FREQUENCY,
    LAWS,
    RECORDING,
    SAFETY,
    TABS,
    TIME,
    Further,
    _printed,
    compute,
    slices,
)
from electrovib.apps.explorer.felt_picture import detection, felt
from electrovib.apps.explorer.key_figures import drawing
from electrovib.apps.explorer.page import plots as words
from electrovib.apps.explorer.page.plots import MOST_PLOTS, content
from electrovib.apps.explorer.pictures import (
    Axis,
    PlottedCurve,
    figure,
    laws,
    over_frequency,
    over_time,
    recorded,
    thinned,
)
from electrovib.apps.explorer.runner import SHOWN_SAMPLES
from electrovib.apps.explorer.session import Earlier
from electrovib.apps.explorer.state import PageState, presets
from electrovib.core.answer import Document
from electrovib.core.constants import eps0
from electrovib.core.diagnostics import Diagnostic, read_diagnostics
from electrovib.core.discovery import find_members
from electrovib.physics.drive.base import Drive
from electrovib.physics.perception import NonPacinian, Pacinian, Perception
from electrovib.studies.widths import TYPICAL_FACTORS
from electrovib.view.style import MOST

GAP = "vezzoli_2014/fig6_gap"
X, Y = Axis("x", "s"), Axis("y", "N")


@pytest.fixture(scope="module")
def shown():
    return compute(ev.load(GAP))


def title(plot):
    return plot["layout"]["title"]["text"]


def units(plot):
    return plot["layout"]["xaxis"]["title"]["text"], plot["layout"]["yaxis"]["title"]["text"]


def titled(plots, begin):
    return next(each for each in plots if title(each).startswith(begin))


def known_further(tab, shown, known=None):
    known = known or Further()
    for each in slices(tab, shown):
        known = each(known)
    return known


def of_tab(tab, found, **options):
    return content(tab, found, known_further(tab, found), **options)


@pytest.mark.parametrize("preset", [GAP, "vardar_2017/sine"])
def test_a_trace_is_made_as_simulate_returns_it(preset):
    scenario = ev.load(preset)
    found, expected = compute(scenario), ev.simulate(scenario)
    xarray.testing.assert_identical(found.trace, expected)
    assert found.diagnostics == read_diagnostics(expected.attrs["validity"])
    for name, variable in expected.variables.items():
        np.testing.assert_array_equal(found.values(name), variable.values)
        if name in expected.data_vars:
            assert found.has(name)
            assert found.dimensions(name) == variable.dims
    assert not found.has("voltage_of_nothing")


@pytest.mark.slow
@pytest.mark.parametrize("name", presets())
def test_every_scenario_shows_plots_or_a_sentence_on_every_tab(name):
    found = compute(ev.load(name))
    measured = found.trace[["electrostatic_force"]]
    for tab in TABS:
        if tab == FELT and presets().index(name) % 3:
            continue  # what is felt takes seconds
        shown = of_tab(tab, found, measured=measured)
        assert shown.figures or shown.above or tab == SAFETY, tab
        assert len(shown.figures) <= MOST_PLOTS
        json.dumps(shown.figures, allow_nan=False)
        if tab in (LAWS, SAFETY):
            assert "<table" in shown.below
        for plot in shown.figures:
            assert title(plot)
            assert units(plot)[0].endswith(("[Hz]", "s]"))
            assert any(value is not None for line in plot["data"] for value in line["y"])


@pytest.mark.parametrize("name", presets()[::4])
def test_plots_of_every_kind_of_scenario_can_be_sent(name):
    shown = compute(ev.load(name))
    plots = [*over_time(shown), *over_frequency(shown)]
    assert len(over_time(shown)) <= 4
    assert len(json.dumps(plots, allow_nan=False)) < 400_000
    assert all(len(line["x"]) <= SHOWN_SAMPLES + 4 for plot in plots for line in plot["data"])
    assert "<svg" in drawing(shown)
    assert "<li>" in words.judged_words(shown.diagnostics)


def test_a_recording_stands_beside_the_prediction_and_a_tab_states_what_cannot_be_shown(shown):
    plots = recorded(shown, shown.trace[["electrostatic_force", "impedance"]])
    assert [title(plot) for plot in plots] == ["electrostatic force", "impedance"]
    assert plots[0]["data"][0]["y"] == plots[0]["data"][1]["y"]
    evil = "<img src=x onerror=alert(1)>"
    for tab in (FELT, SAFETY):
        above = content(tab, shown, Further(problems=(evil,))).above
        assert above == "<p>&lt;img src=x onerror=alert(1)&gt;</p>"
    assert "<script>" not in words.judged_words([Diagnostic("<b>", "warning", "<script>alert(1)</script>")])
    assert content(RECORDING, shown, Further()).above == ""
    fields = shown.trace[["field"]]
    assert "No signal of this recording" in content(RECORDING, shown, Further(), measured=fields).above
    constant = of_tab(FELT, compute(shown.scenario.replace({"drive": {"model": "Step", "level": 0}})))
    assert constant.figures == []
    assert "nothing moves the skin" in constant.above
    rests = of_tab(TIME, compute(ev.load("shultz_2018/at_rest")))
    assert "lateral force is not shown: it has no value in this scenario" in rests.above
    titles = [title(plot) for plot in rests.figures]
    assert not any(each.startswith("Lateral force") for each in titles)
    assert "Electrostatic force" in titles


def test_a_mistake_of_a_slice_becomes_a_sentence():
    clutch = compute(ev.load("rauf_2025/relaxor"))  # no population of fingers fits it
    known = known_further(FREQUENCY, clutch)
    assert known.band is None
    assert known.problems[0].startswith("The band of fingers is not shown: the contact has neither skin nor")
    earlier = Further(
        band={"low": np.zeros(1)}, population=Document(title="of another scenario", sentences=[])
    )
    found = known_further(FREQUENCY, clutch, earlier)
    assert (found.band, found.population) == (None, None)


def test_a_curve_holds_the_numbers_of_the_trace_in_the_unit_of_its_axis(shown):
    plot = titled(over_time(shown), "Electrostatic force")
    assert units(plot) == ("time [ms]", "force [mN]")
    force = shown.trace.electrostatic_force.values
    assert max(plot["data"][0]["y"]) == pytest.approx(1e3 * force.max(), rel=1e-4)
    x, y = np.array(plot["data"][0]["x"]) / 1e3, np.array(plot["data"][0]["y"]) / 1e3
    expected = np.interp(x, shown.trace.time.values, force)
    np.testing.assert_allclose(y, expected, rtol=0, atol=1e-3 * force.max())


def test_kept_curves_are_dashed_and_in_the_legend_and_those_of_layers_faint(shown):
    kept = Earlier(compute(shown.scenario.replace({"drive.high": "500 V"})), PageState(GAP), is_kept=True)
    lines = titled(over_time(shown, kept), "Electrostatic force")["data"]
    assert [line["line"]["dash"] for line in lines] == ["solid", "dash"]
    assert [line["name"] for line in lines] == ["attraction", "attraction, A"]
    assert all(line["showlegend"] and "opacity" not in line for line in lines)
    assert max(lines[0]["y"]) == pytest.approx(4 * max(lines[1]["y"]), rel=1e-3)
    layers = titled(over_time(shown, kept), "Voltage across")["data"]
    assert [line.get("opacity") for line in layers] == [None] * 3 + [0.45] * 3
    for tab, place in ((TIME, 1), (FREQUENCY, 0)):
        assert content(tab, shown, Further(), earlier=kept).figures[place]["data"][1]["name"].endswith(", A")


@pytest.mark.parametrize("name", presets()[::6])
def test_a_legend_has_at_most_five_curves_in_five_colours_and_axes_are_words(name):
    found = compute(ev.load(name))
    band = {"frequency": np.ones(2), "low": np.ones(2), "high": np.full(2, 2.0)}
    plots = [
        *over_time(found, Earlier(found, PageState(name), is_kept=True)),
        *over_frequency(found, band=band),
    ]
    plots += content(LAWS, found, known_further(LAWS, found)).figures
    for plot in plots:
        curves = [line for line in plot["data"] if "opacity" not in line and "fill" not in line]
        colours = [line["line"]["color"] for line in curves if line["line"]["width"]]
        assert len(colours) == len(set(colours)) <= MOST + (plot in plots[-2:]), title(plot)
        assert not any(re.fullmatch(r"#(..)\1\1", each) for each in colours)
        for text in units(plot):
            assert re.fullmatch(r"[a-z][a-z ]+( \[[^\]]+\])?", text), text


def test_the_voltages_of_the_layers_add_up_and_where_they_differ_by_much_are_relative_to_their_largest(shown):
    clutch = compute(ev.load("rauf_2025/relaxor"))
    plot = titled(over_time(clutch), "Voltage across each layer")
    assert units(plot) == ("time [ms]", "voltage [V]")
    total = sum(np.interp(0.5, line["x"], line["y"]) for line in plot["data"])
    assert total == pytest.approx(float(clutch.trace.stack_voltage.interp(time=5e-4)), rel=1e-3)
    plot = over_time(shown)[-1]
    assert title(plot) == "Voltage across each layer over its largest"
    gap = shown.trace.field.sel(layer="gap").values * shown.scenario.stack.layers["gap"].thickness
    line = next(each for each in plot["data"] if each["name"].startswith("gap"))
    assert line["name"] == "gap (1 is 7.87 V)"
    assert np.abs(gap).max() == pytest.approx(7.87, abs=0.005)
    wanted = np.interp(0.06, shown.trace.time.values, gap) / np.abs(gap).max()
    assert np.interp(60, line["x"], line["y"]) == pytest.approx(wanted, rel=5e-3)
    assert len({each["line"]["dash"] for each in plot["data"]}) == 3  # of two that coincide both are visible


def test_over_frequency_stand_permittivity_over_conductivity_and_the_whole_impedance(shown):
    plot = over_frequency(shown)[1]
    assert title(plot).startswith("Time constant of each layer")
    assert units(plot)[1] == "time constant [ms]"
    by_name = {line["name"]: line["y"] for line in plot["data"]}
    skin = shown.scenario.stack.layers["stratum_corneum"].material
    expected = eps0 * skin.permittivity / skin.conductivity
    assert by_name["stratum corneum"][0] == pytest.approx(1e3 * expected, rel=1e-4)
    assert "insulator" not in by_name  # it does not conduct
    low, high = over_frequency(shown)[-1]["layout"]["yaxis"]["range"]
    size = np.abs(shown.trace.impedance.values)
    assert 10**low < size.min() < size.max() < 10**high


def test_a_band_of_fingers_is_that_of_a_study_and_states_what_was_drawn(shown):
    known = known_further(FREQUENCY, shown)
    assert known.problems == ()
    assert np.all(known.band["low"] <= known.band["middle"])
    assert np.all(known.band["middle"] <= known.band["high"])
    bands = ev.study(shown.scenario, "fingers", n=200, seed=1, quantity="mean_force").mean_force_percentile
    np.testing.assert_array_equal(known.band["high"], bands.sel(percentile=95).values)
    said = content(FREQUENCY, shown, known).below
    assert "differ between them: stack.stratum_corneum.thickness, stack.stratum_corneum.material.perm" in said
    assert "moisture.level is not drawn: the scenario has no such parameter" in said
    assert said.count("<li>") == len(known.population.remarks)
    plot = over_frequency(shown, band=known.band)[0]
    lower, upper, line = plot["data"]
    assert upper["fill"] == "tonexty"
    assert all(low <= high for low, high in zip(lower["y"], upper["y"], strict=True))
    assert line["name"] == "mean force of the scenario"
    assert 10 ** plot["layout"]["yaxis"]["range"][0] < min(lower["y"])
    bare = known_further(FREQUENCY, compute(ev.load("strong_1970/display")))  # a finger without skin
    assert bare.problems == ()
    said = content(FREQUENCY, shown, bare).below
    assert "contact.area" in said
    assert "stack.stratum_corneum.thickness is not drawn" in said
    assert np.all(bare.band["low"] < bare.band["high"])


def test_every_other_law_is_run_or_left_out_with_a_reason(shown):
    known = known_further(LAWS, shown)
    assert {"MaxwellStressInInsulator", "EffectiveMedium"} <= set(known.laws)
    assert "Vezzoli2014PerFrequency" in known.left_out
    assert known.left_out["Persson2018RoughGap"].startswith("it needs force.mean_gap and force.rms_gap: ")
    plots = laws(shown, known.laws)
    assert len(plots) == 2
    assert plots[0]["data"][0]["name"] == "MaxwellStressInGap (this scenario)"
    assert {line["line"]["width"] for line in plots[0]["data"][1:]} == {1.8}
    assert plots[0]["data"][0]["line"]["width"] > 3
    text = words.law_words(shown, known)
    assert "cannot run here" in text
    one = ev.simulate(shown.scenario.replace({"force": {"model": "MaxwellStressInInsulator"}}))
    ratio = one.electrostatic_force.values.max() / shown.trace.electrostatic_force.values.max()
    assert f"<td>{ratio:.3g}</td>" in text


@pytest.mark.parametrize("law", ["MaxwellStressInGap", "Vezzoli2014Causal"])
def test_what_was_measured_in_the_set_up_is_marked_and_nothing_beside_another(shown, law):
    """The lateral force swings by 3.16 mN, within 2 to 5 mN printed: by 6.3 mN of attraction at a friction of 0.5."""
    own = compute(shown.scenario.replace({"force": {"model": law}, "limits.current": "1 mA"}))
    known = known_further(LAWS, own)
    low, high = known.measured.interval
    assert math.sqrt(low * high) == pytest.approx(math.sqrt(2e-3 * 5e-3) / 0.5, rel=1e-3)
    assert high / low == pytest.approx(1.32**2)
    plot, other = laws(own, known.laws, known.measured)
    line, *band = plot["data"][-3:]
    assert line["name"] == "measured: Vezzoli 2014, section 4 and figure 6"
    assert line["y"] == pytest.approx([6.324555e-3] * 2, rel=1e-4)
    assert [each["showlegend"] for each in (line, *band)] == [True, False, False]
    assert not any("measured" in each["name"] for each in other["data"])
    assert "3.16 mN" in words.law_words(own, known)
    slippery = known_further(LAWS, compute(own.scenario.replace({"friction.coefficient": 0.25}))).measured
    assert slippery.interval == pytest.approx((2 * low, 2 * high), rel=1e-3)  # which was not printed
    for changes in ({"drive.high": 500}, {"drive": {"model": "Sine", "amplitude": 1000, "frequency": 100}}):
        assert known_further(LAWS, compute(own.scenario.replace(changes))).measured is None


def test_another_drive_is_another_set_up_whatever_its_numbers(shown):
    of_amplitude, of_root = (
        shown.scenario.replace({"drive": find_members(Drive)[name].example | {"model": name}})
        for name in ("AmplitudeModulation", "SquareRootModulation")
    )
    assert _printed(of_amplitude, ()) != _printed(of_root, ())


def test_the_curves_of_a_that_are_too_many_are_left_out():
    amplifier = {"circuit.amplifier": {"source_current": "250 uA", "stray_capacitance": "100 pF"}}
    found = compute(ev.load("vezzoli_2014/fig6").replace(amplifier))
    plot = titled(over_time(found, Earlier(found, PageState(GAP), is_kept=True)), "Voltage")
    names = ["drive", "effective", "plate, behind the amplifier", "drive, A", "effective, A"]
    assert [line["name"] for line in plot["data"]] == names


def test_the_laws_beside_that_of_the_page_are_those_that_miss_measured_forces_the_least(shown):
    known = Further(laws=dict.fromkeys((*TYPICAL_FACTORS, "Mine"), shown))
    plotted = [line["name"] for line in laws(shown, known.laws)[0]["data"]]
    best = sorted(TYPICAL_FACTORS, key=TYPICAL_FACTORS.get)
    assert plotted == ["MaxwellStressInGap (this scenario)", *best[:4]]
    assert "the four that miss measured forces the least" in words.law_words(shown, known)
    assert "the four" not in words.law_words(shown, Further(laws={"EffectiveMedium": shown}))


def test_felt_and_safety(shown):
    percept = known_further(FELT, shown).percept
    said, below = words.answer_words(percept.document, skipped=1)
    assert percept.headline.partition(",")[2] in said
    assert percept.widths[-1].text in below
    assert f"{percept.channels[0].level:+.1f} dB" in below
    (plot,) = felt(percept, shown.scenario)
    largest = percept.spectrum.amplitude[percept.spectrum.frequency >= 1].max()
    assert max(plot["data"][0]["y"]) == pytest.approx(largest * 1e3, rel=1e-6)
    low, high = plot["layout"]["yaxis"]["range"]
    assert 10**low < max(plot["data"][0]["y"]) < 10**high
    check = known_further(SAFETY, shown).check
    said, below = words.answer_words(check.document, check.state)
    assert "only hardware that limits the current protects" in said
    assert "250 µA" in below


def test_a_calibrated_perception_is_stated_with_its_level():
    skin = {"perception.compliance": {"model": "ElasticSkin", "stiffness": 1000}}
    own = {"perception.threshold": "1 um", "perception.threshold_uncertainty": 3}
    threshold, compliance = "a detection threshold", "a compliance of the skin"
    for changes, assumed in (
        ({}, f"{threshold} and {compliance}"),
        (own, compliance),
        (skin, threshold),
        (skin | own, ""),
    ):
        scenario = ev.load("bau_2010/sine").replace(changes)
        percept, felt_tab = ev.perceive(scenario), of_tab(FELT, compute(scenario))
        above = felt_tab.above + felt_tab.below
        assert f">felt, {percept.felt_by} channel: {percept.sensation:+.1f} dB (" in above
        assert percept.title
        assert html.escape(percept.title) not in felt_tab.above  # the page has it in its bar
        assert ("assumed from publications" in above) == bool(assumed)
        assert not assumed or f"assumed from publications: {assumed}; " in above
    weak = scenario.replace({"perception.threshold": "1 mm"})
    told = f">not felt, Pacinian channel: {ev.perceive(weak).sensation:+.1f} dB ("
    assert told in of_tab(FELT, compute(weak)).above


def test_without_a_calibration_the_curve_is_the_middle_of_the_published_thresholds(shown):
    """At 250 Hz: 19.1 to 122 nm at weight 1, and skins of 323.2 N/m without and with 3.95 N s/m."""
    percept = known_further(FELT, shown).percept
    lowest, level, highest, name = detection(percept, shown.scenario)
    frequency = np.geomspace(1, 2000, len(level))
    weight, stiff = Pacinian().weight, np.abs(323.2 + 2j * np.pi * 3.95 * frequency)
    ends = 0.03e-6 * weight(150.0) * 323.2, 0.13e-6 * weight(300.0) * stiff
    high = frequency > 110  # where the other channel feels nothing
    expected = np.sqrt(ends[0] * ends[1]) / weight(frequency)
    np.testing.assert_allclose(level[high], expected[high], rtol=1e-6)
    for edge, end in zip((lowest, highest), ends, strict=True):
        np.testing.assert_allclose(edge[high], (end / weight(frequency))[high], rtol=1e-6)
    (plot,) = felt(percept, shown.scenario)
    _, below, above, line = plot["data"]
    assert (above["fill"], above["showlegend"], line["name"]) == ("tonexty", True, name)
    np.testing.assert_allclose(above["y"], 1e3 * highest, rtol=1e-4)  # drawn with five digits
    np.testing.assert_allclose(below["y"], 1e3 * lowest, rtol=1e-4)
    assert name == "detection threshold of a single sine (published, middle)"
    nobody = Perception(channels=(NonPacinian(low=50.0),))  # its thresholds are below that band
    alone = shown.scenario.replace({"perception": nobody})
    lowest, level, highest, name = detection(ev.perceive(alone), alone)
    assert np.array_equal(lowest, highest, equal_nan=True)
    assert "no threshold is known" in name
    alike = NonPacinian().weight(50.0) * np.nanmin(level)
    assert 20 * np.log10(alike) == pytest.approx(ev.perceive(alone).level, abs=1e-9)
    assert "felt or not: unknown without perception.threshold" in ev.perceive(alone).headline


def test_a_calibrated_threshold_is_the_detection_level_at_the_best_frequency():
    skin = {"model": "ElasticViscousSkin", "stiffness": 1000, "corner": 100}
    own = {"threshold": "0.1 um", "threshold_uncertainty": 3, "compliance": skin}
    scenario = ev.load(GAP).replace({"perception": own})
    lowest, level, highest, name = detection(ev.perceive(scenario), scenario)
    np.testing.assert_allclose(20 * np.log10(highest / lowest), 6.0, rtol=1e-9)  # 3 dB to both sides
    frequency = np.geomspace(1, 2000, len(level))
    moved = np.abs(scenario.perception.compliance.compliance(frequency)) * level
    assert moved[np.argmin(np.abs(frequency - 250))] == pytest.approx(1e-7, rel=0.01)
    assert name == "detection threshold of a single sine (of the perception)"


def test_the_drawing_is_to_scale_on_its_left(shown):
    text = drawing(shown)
    box = r'<rect x="([\d.]+)" y="([\d.]+)" width="[\d.]+" height="([\d.]+)"[^>]*fill-opacity'
    found = [[float(each) for each in row] for row in re.findall(box, text)]
    boxes = [(y, height) for x, y, height in found if x < 10]
    thicknesses = [layer.thickness for layer in shown.scenario.stack.layers.values()]
    assert boxes[2][1] / boxes[0][1] == pytest.approx(thicknesses[2] / thicknesses[0], rel=0.01)
    assert boxes[0][0] > boxes[2][0]  # the insulator lies below the skin
    assert 'role="img"' in text
    assert "gap, 1 µm" in text


def test_thinned_keeps_extremes_and_ends_without_points_that_repeat():
    x = np.arange(100_003.0)
    y = np.sin(x / 7)
    y[50_001], y[7] = 9.0, -8.0
    short, kept = thinned(x, y)
    assert len(short) <= SHOWN_SAMPLES + 2
    assert (kept.max(), kept.min()) == (9.0, -8.0)
    level, heights = thinned(x, np.where(x < 5000, 1.0, 2.0))
    assert set(heights) == {1.0, 2.0}
    for each in (short, level):
        assert (each[0], each[-1]) == (0, 100_002)
        assert np.all(np.diff(each) > 0)


def plotted(x, y, axis=Y):
    return figure("t", X, axis, [PlottedCurve(x, y, "a")])


@pytest.mark.parametrize(
    ("low", "unit", "ticks"), [(1e-3, "mN", [1, 2, 5]), (3e-5, "mN", [1]), (1e-9, "N", [])]
)
def test_a_logarithmic_axis_of_few_decades_has_plain_numbers(low, unit, ticks):
    plot = plotted([1, 2], [low, 0.02], Axis("force", "N", is_logarithmic=True))
    axis = plot["layout"]["yaxis"]
    assert axis["title"]["text"] == f"force [{unit}]"
    assert [each for each in axis.get("tickvals", []) if 1 <= each < 10] == ticks
    assert ("dtick" in axis) == (not ticks)


def test_numbers_of_a_curve_are_short_and_keep_small_changes_and_gaps():
    """Friction of 250 mN that attraction changes by 0.3 mN has no steps of rounding."""
    assert plotted([0, 1, 2], [1.23456789, math.nan, math.inf])["data"][0]["y"] == (1.2346, None, None)
    x = np.linspace(0, 1, 201)
    shown = np.array(plotted(x, 0.25 + 0.3e-3 * x)["data"][0]["y"])
    assert shown == pytest.approx(250 + 0.3 * x, abs=0.3e-5)
    assert max(len(repr(float(each))) for each in shown) <= 9
    assert plotted([0, 1], [2.5, 2.5])["data"][0]["y"] == (2.5, 2.5)


def test_a_constant_is_drawn_as_one_and_zeros_on_a_logarithmic_axis_are_left_out():
    assert plotted([0, 1], [2.0, 2.0 + 1e-12])["layout"]["yaxis"]["range"] == pytest.approx([1.6, 2.4])
    axis = plotted([0, 1], [0.0, 1e-3], Axis("y", "N", is_logarithmic=True))["layout"]["yaxis"]
    assert axis["title"]["text"] == "y [mN]"
    assert axis["range"] == pytest.approx([-0.1, 0.15])
