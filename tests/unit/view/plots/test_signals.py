"""Which lines a plot of signals has, over time and over frequency, and what its colours, dashes and words stand for."""

import numpy as np
import pytest

from electrovib.core.errors import InputError
from electrovib.core.signals import make_trace
from electrovib.studies.sweep import sweep
from electrovib.view import plots
from electrovib.view.lines import (
    BINS,
    MOST_LINES,
    labelled,
    left_out,
    lines,
    scenario_or_none,
    shared_words,
    swept_units,
)
from electrovib.view.style import COLOURS, LAYER_COLOURS

LAYERS = ["insulator", "gap", "stratum corneum"]


def texts(ax):
    return [text.get_text() for text in ax.texts]


def entries(ax):
    return [text.get_text() for text in ax.get_legend().get_texts()]


@pytest.mark.parametrize(
    ("plot", "name", "label"),
    [
        (plots.drive, "drive_voltage", "drive voltage $v$ [kV]"),
        (plots.force, "electrostatic_force", "electrostatic force $f_e$ [mN]"),
        (plots.lateral_force, "lateral_force", "lateral force $f_t$ [mN]"),
        (plots.current, "current", "current $i$ [nA]"),
    ],
)
def test_data_is_the_signal_in_si_and_the_label_has_its_unit(plot, name, label, trace):
    ax = plot(trace)
    line = ax.lines[0]
    assert np.array_equal(line.get_xdata(), trace.time.values)
    assert np.array_equal(line.get_ydata(), trace[name].values)
    assert (ax.get_xlabel(), ax.get_ylabel(), ax.get_legend()) == ("time $t$ [ms]", label, None)


def test_effective_voltage_and_gain_are_those_of_a_law_that_has_one(trace, other):
    ax = plots.effective_voltage(other)
    assert np.array_equal(ax.lines[0].get_ydata(), other.effective_voltage.values)
    gain = other.effective_voltage_gain.values
    np.testing.assert_array_equal(plots.gain(other).lines[0].get_ydata(), np.abs(gain))
    np.testing.assert_array_equal(plots.gain_phase(other).lines[0].get_ydata(), np.angle(gain, deg=True))
    layered = plots.gain(trace).lines
    assert len(layered) == 3
    np.testing.assert_array_equal(layered[1].get_ydata(), np.abs(trace.field_gain.sel(layer="gap").values))
    # a trace keeps its colour where another has nothing to show
    (line,) = lines({"a": trace, "b": other}, "effective_voltage", "time")
    assert (line.label, line.colour) == ("b", COLOURS[1])


def test_the_responses_of_force_and_impedance(trace):
    ax = plots.frequency_response(trace)
    assert np.array_equal(ax.lines[0].get_ydata(), trace.mean_force.values)
    assert np.array_equal(ax.lines[0].get_xdata(), trace.frequency.values)
    assert (ax.get_xscale(), ax.get_yscale(), ax.get_xlabel()) == ("log", "linear", "frequency $f$ [Hz]")
    assert ax.get_ylim()[0] == 0
    assert ax.get_ylim()[1] > trace.mean_force.values.max()
    wide = trace.assign(mean_force=trace.mean_force / trace.frequency)
    assert plots.frequency_response(wide).get_yscale() == "log"
    ax = plots.impedance(trace)
    assert (ax.get_xscale(), ax.get_yscale(), ax.get_ylabel()) == ("log", "log", "impedance $|Z|$ [Ω]")
    assert np.array_equal(ax.lines[0].get_ydata(), np.abs(trace.impedance.values))
    ax = plots.impedance_phase(trace)
    shown = ax.lines[0].get_ydata()
    # a film blocks: nearly a capacitor in the middle of the band
    assert shown[len(shown) // 2] == pytest.approx(-90, abs=1)
    assert ax.get_ylabel().endswith("[°]")


def test_field_and_voltage_have_a_line_for_each_layer(trace, swept):
    """The voltages add up to that of the stack, also where the thickness is swept."""
    ax = plots.field(trace)
    assert [line.get_label() for line in ax.lines] == LAYERS
    assert [line.colour for line in lines(trace, "field", "time")] == list(LAYER_COLOURS.values())
    assert np.array_equal(ax.lines[1].get_ydata(), trace.field.sel(layer="gap").values)
    assert ax.get_ylabel() == "field $E$ [MV/m]"
    for run, of in ((trace, trace), (swept, swept.isel({"stack.gap.thickness": -1}))):
        shown = [line.get_ydata() for line in plots.layer_voltages(run).lines[-3:]]
        # the sum of three floats of up to 1 kV
        np.testing.assert_allclose(np.sum(shown, axis=0), of.stack_voltage.values, rtol=1e-9, atol=1e-6)


def test_an_overlay_has_labels_and_rescales_its_prefix(trace, other, measured):
    ax = plots.lateral_force({"Maxwell stress in the gap": trace, "_medium": other, "$5": measured})
    assert entries(ax) == ["Maxwell stress in the gap", " _medium", r"\$5"]
    ax.figure.canvas.draw()
    ax = plots.force({"weak": other})
    before = ax.get_ylabel()
    assert plots.force(trace * 1e4, ax=ax) is ax
    assert (before, ax.get_ylabel()) == ("electrostatic force $f_e$ [mN]", "electrostatic force $f_e$ [kN]")
    assert len(ax.lines) == 2
    assert ax.get_ylim()[1] >= float((trace.electrostatic_force * 1e4).max())
    (alone,) = lines(trace, "electrostatic_force", "time")
    assert (alone.label, alone.kind, alone.dash) == ("", "", "-")
    assert list(labelled([trace, other])) == ["Glass & <film>", "Glass & <film> (2)"]
    assert list(labelled(make_trace({}, {}, {}))) == ["Trace 1"]
    assert list(labelled({"a": measured})) == ["a"]


def test_a_long_sweep_shows_evenly_chosen_values_with_their_unit(swept):
    found = lines(swept, "electrostatic_force", "time")
    assert len(found) == MOST_LINES < swept.sizes["stack.gap.thickness"]
    assert found[0].label == "stack.gap.thickness = 100 nm"
    assert found[-1].label == "stack.gap.thickness = 100 µm"
    assert len({line.colour for line in found}) == MOST_LINES
    assert np.array_equal(found[-1].y, swept.electrostatic_force.isel({"stack.gap.thickness": -1}).values)
    ax = plots.force(swept)
    assert ax.get_legend().get_title().get_text() == "stack.gap.thickness\n5 of 15 values"
    assert entries(ax)[0] == "100 nm"
    # a value has the same colour whether layers are drawn or not; colours and dashes are explained apart
    whole = {line.label: line.colour for line in found}
    layered = lines(swept, "field", "time")
    assert len(layered) == len(plots.field(swept).lines) == 2 * 3
    assert {line.kind for line in layered} == set(LAYERS)
    common = [line for line in layered if line.label in whole]
    assert common
    assert all(whole[line.label] == line.colour for line in common)
    assert left_out(swept, "field") == "2 of 15 values"
    assert entries(plots.field(swept)) == ["100 nm", "100 µm", *LAYERS]
    # the unit is found in the scenario when the coordinate lost it
    bare = swept.copy()
    bare["stack.gap.thickness"] = ("stack.gap.thickness", swept["stack.gap.thickness"].values)
    assert "units" not in bare["stack.gap.thickness"].attrs
    assert swept_units(bare) == {"stack.gap.thickness": "m"}


def test_a_sweep_over_two_paths_has_both_as_the_title_of_the_legend(scenario):
    over = {"stack.gap.thickness": [1e-6, 5e-6], "stack.insulator.thickness": [50e-6, 90e-6]}
    ax = plots.force(sweep(scenario, over, records=True))
    title = ax.get_legend().get_title().get_text()
    assert title == "stack.gap.thickness, stack.insulator.thickness"
    assert entries(ax) == ["1 µm, 50 µm", "1 µm, 90 µm", "5 µm, 50 µm", "5 µm, 90 µm"]
    for labels in (["a = 1 m", "b = 2 m"], ["a = 1 m", "a = 1 m, b = 2 m"], ["dry, a = 1 m", "wet, a = 1 m"]):
        assert shared_words(labels) == ("", labels)
    assert shared_words(["a = 1 m, b = 2 s", "film"]) == ("a, b", ["1 m, 2 s", "film"])


def test_words_can_be_swept():
    values = np.arange(16.0).reshape(2, 2, 4)
    fingers = np.array(["thumb", "index"], dtype=object)
    coordinates = {"trial": [1, 2], "finger": fingers, "time": np.arange(4.0)}
    trace = make_trace({"lateral_force": (("trial", "finger", "time"), values)}, coordinates, {})
    found = lines(trace, "lateral_force", "time")
    assert found[1].label == "trial = 1, finger = index"
    assert np.array_equal(found[-1].y, values[1, 1])
    assert left_out(trace, "lateral_force") == ""


def test_the_records_of_a_sweep_are_drawn_at_their_own_times_and_to_their_end(scenario):
    sine = scenario.replace({"drive": {"model": "Sine", "amplitude": 100, "frequency": 50}})
    swept = sweep(sine, {"drive.frequency": [50.0, 100.0]}, records=True)
    ends = [line.get_xdata()[-1] for line in plots.force(swept).lines]
    assert ends == pytest.approx([0.1, 0.05])
    record = {"model": "Sampled", "time_samples": [0, 1e-3, 3e-3], "voltage_samples": [0, 9, 0]}
    sampled = scenario.replace({"drive": record, "time": {}})
    swept = sweep(sampled, {"time.duration": [1e-3, 3e-3]}, records=True)
    drawn, stated = [line.get_xdata() for line in plots.force(swept).lines], swept.time.values
    assert [times[-1] for times in drawn] == pytest.approx([1e-3, 3e-3])
    assert [len(times) for times in drawn] == np.isfinite(stated).sum(axis=1).tolist()
    assert len(drawn[0]) < len(drawn[1]) == stated.shape[1]


def test_a_noisy_long_record_is_drawn_as_its_envelope_and_an_empty_one_says_so():
    time = np.linspace(0, 1, 300_001)
    force = np.random.default_rng(1).standard_normal(time.size)
    force[1000:90_000] = np.nan
    ax = plots.lateral_force(make_trace({"lateral_force": (("time",), force)}, {"time": time}, {}))
    drawn = ax.lines[0].get_ydata()
    assert len(drawn) <= 2 * BINS + 2
    assert (np.nanmin(drawn), np.nanmax(drawn)) == (np.nanmin(force), np.nanmax(force))
    empty = make_trace({"lateral_force": (("time",), np.full(5, np.nan))}, {"time": np.arange(5.0)}, {})
    ax = plots.lateral_force(empty)
    assert texts(ax) == ["no numbers to draw"]
    ax.figure.canvas.draw()


def percent(ax):
    """Return the second vertical axis of a friction; None where there is none."""
    axes = [child for child in ax.child_axes if "%" in child.get_ylabel()]
    return axes[0] if axes else None


def test_a_small_change_of_friction_is_drawn_above_the_friction_of_the_load_and_in_percent_of_it(other):
    """The attraction of the effective medium, 57 mN, adds a little to 250 mN of friction."""
    small = other.assign(lateral_force=0.25 + 0.05 * (other.lateral_force - 0.25))
    ax = plots.lateral_force(small)
    ax.figure.draw_without_rendering()
    assert ax.get_ylabel() == "lateral force $f_t$ above 250 mN [mN]"
    assert np.array_equal(ax.lines[0].get_ydata(), small.lateral_force.values)
    assert "of the load, 250 mN" in texts(ax)
    change = float(small.lateral_force.max()) - 0.25
    low, high = ax.get_ylim()
    assert low < 0.25 < 0.25 + change < high
    assert change > 0.6 * (high - low)
    assert percent(ax).get_ylim() == pytest.approx((100 * (low / 0.25 - 1), 100 * (high / 0.25 - 1)))
    shown = {text.get_text() for text in ax.get_yticklabels()}
    assert {"0", "1"} <= shown
    assert not any(text.startswith("25") for text in shown)
    held = small.assign(lateral_force=small.lateral_force + 0.01)  # which never falls to that of the load
    assert "smallest value, 260 mN" in texts(plots.lateral_force(held))


def test_a_large_change_of_friction_is_drawn_from_zero_and_one_of_both_signs_as_it_is(trace, measured):
    ax = plots.lateral_force(trace)
    assert (ax.get_ylim()[0], percent(ax)) == (0, None)
    assert "of the load, 250 mN" in texts(ax)
    ax = plots.lateral_force(measured - 0.3)
    assert ax.get_ylim()[0] < -0.1
    assert (percent(ax), texts(ax)) == (None, [])


def test_what_cannot_be_drawn_is_named(trace, measured, scenario):
    signal = r"'electrostatic_force'\. There are: drive_voltage, lateral_force"
    for draw, of, words in (
        (plots.effective_voltage, trace, "effective_voltage"),
        (plots.layer_voltages, measured, "thicknesses"),
        (plots.frequency_response, measured, "mean_force"),
        (plots.force, measured, signal),
        (plots.stack, measured, "no scenario"),
        (labelled, scenario, "expected a Trace, not a Scenario; simulate first"),
        (labelled, "a.nc", r"expected a Trace, not 'a\.nc'; open it first: trace = ev\.open_trace"),
        (labelled, [trace, scenario], "expected a Trace, not Scenario"),
        (labelled, [], "at least one is needed"),
    ):
        with pytest.raises(InputError, match=words):
            draw(of)


def test_a_scenario_that_cannot_be_read_is_none(trace, measured):
    for text in ('{"schema": 99}', "not JSON"):
        broken = trace.copy()
        broken.attrs["scenario"] = text
        assert scenario_or_none(broken) is None
    assert scenario_or_none(measured) is None
    assert scenario_or_none(trace) is not None
