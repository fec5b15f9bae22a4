"""Signals over time."""

from __future__ import annotations

import numpy as np
import pytest

from electrovib.core.errors import InputError
from electrovib.core.trace import make_trace
from electrovib.study.sweep import sweep
from electrovib.view import plots
from electrovib.view.envelope import BINS
from electrovib.view.plots.draw import shared_words

SIGNALS = {
    plots.drive: ("drive_voltage", "drive voltage $v$ [kV]"),
    plots.force: ("electrostatic_force", "electrostatic force $f_e$ [mN]"),
    plots.lateral_force: ("lateral_force", "lateral force $f_t$ [mN]"),
    plots.current: ("current", "current $i$ [nA]"),
}


@pytest.mark.parametrize("plot", SIGNALS, ids=lambda plot: plot.__name__)
def test_data_is_the_signal_in_si_and_the_label_has_its_unit(plot, trace):
    name, label = SIGNALS[plot]
    ax = plot(trace)
    line = ax.lines[0]
    assert np.array_equal(line.get_xdata(), trace.time.values)
    assert np.array_equal(line.get_ydata(), trace[name].values)
    assert ax.get_ylabel() == label
    assert ax.get_xlabel() == "time $t$ [ms]"
    assert ax.get_legend() is None


def test_effective_voltage_needs_a_law_that_has_one(trace, other):
    ax = plots.effective_voltage(other)
    assert np.array_equal(ax.lines[0].get_ydata(), other.effective_voltage.values)
    with pytest.raises(InputError, match="effective_voltage"):
        plots.effective_voltage(trace)


def test_field_has_a_line_for_each_layer(trace):
    ax = plots.field(trace)
    shown = {line.get_label(): line.get_ydata() for line in ax.lines}
    assert list(shown) == ["insulator", "gap", "stratum corneum"]
    assert np.array_equal(shown["gap"], trace.field.sel(layer="gap").values)
    assert ax.get_ylabel() == "field $E$ [MV/m]"


def test_layer_voltages_add_up_to_the_voltage_of_the_stack(trace):
    shown = [line.get_ydata() for line in plots.layer_voltages(trace).lines]
    # the sum of three floats of up to 1 kV
    np.testing.assert_allclose(np.sum(shown, axis=0), trace.stack_voltage.values, rtol=1e-9, atol=1e-6)


def test_layer_voltages_follow_a_swept_thickness(swept):
    lines = plots.layer_voltages(swept).lines[-3:]
    last = swept.isel({"stack.gap.thickness": -1})
    np.testing.assert_allclose(
        np.sum([line.get_ydata() for line in lines], axis=0), last.stack_voltage.values, rtol=1e-9, atol=1e-6
    )


def test_layer_voltages_need_fields_and_thicknesses(measured):
    with pytest.raises(InputError, match="thicknesses"):
        plots.layer_voltages(measured)


def test_overlay_has_labels_and_one_line_a_trace(trace, other, measured):
    ax = plots.lateral_force({"Maxwell stress in the gap": trace, "_medium": other, "$5": measured})
    texts = [text.get_text() for text in ax.get_legend().get_texts()]
    assert texts == ["Maxwell stress in the gap", " _medium", r"\$5"]
    ax.figure.canvas.draw()


def test_a_second_call_adds_to_the_same_axes_and_rescales_the_prefix(trace, other):
    ax = plots.force({"weak": other})
    before = ax.get_ylabel()
    assert plots.force(trace * 1e4, ax=ax) is ax
    assert (before, ax.get_ylabel()) == ("electrostatic force $f_e$ [mN]", "electrostatic force $f_e$ [kN]")
    assert len(ax.lines) == 2


def test_a_sweep_has_its_path_as_the_title_of_the_legend(swept):
    legend = plots.force(swept).get_legend()
    assert legend.get_title().get_text() == "stack.gap.thickness\n5 of 15 values"
    assert legend.get_texts()[0].get_text() == "100 nm"


def test_a_sweep_over_two_paths_has_both_as_the_title_of_the_legend(scenario):
    over = {"stack.gap.thickness": [1e-6, 5e-6], "stack.insulator.thickness": [50e-6, 90e-6]}
    both = sweep(scenario, over, records=True)
    legend = plots.force(both).get_legend()
    assert legend.get_title().get_text() == "stack.gap.thickness, stack.insulator.thickness"
    shown = [text.get_text() for text in legend.get_texts()]
    assert shown == ["1 µm, 50 µm", "1 µm, 90 µm", "5 µm, 50 µm", "5 µm, 90 µm"]


def test_labels_that_name_different_paths_stay_as_they_are():
    for labels in (["a = 1 m", "b = 2 m"], ["a = 1 m", "a = 1 m, b = 2 m"], ["dry, a = 1 m", "wet, a = 1 m"]):
        assert shared_words(labels) == ("", labels)
    assert shared_words(["a = 1 m, b = 2 s", "film"]) == ("a, b", ["1 m, 2 s", "film"])


def test_a_layered_sweep_explains_colours_and_dashes_apart(swept):
    ax = plots.field(swept)
    texts = [text.get_text() for text in ax.get_legend().get_texts()]
    assert len(ax.lines) == 6
    assert texts[:2] == ["100 nm", "100 µm"]
    assert texts[2:] == ["insulator", "gap", "stratum corneum"]


def test_a_noisy_long_record_is_drawn_as_its_envelope():
    count = 300_001
    time = np.linspace(0, 1, count)
    force = np.random.default_rng(1).standard_normal(count)
    force[1000:90_000] = np.nan
    ax = plots.lateral_force(make_trace({"lateral_force": (("time",), force)}, {"time": time}, {}))
    drawn = ax.lines[0].get_ydata()
    assert len(drawn) <= 2 * BINS + 2
    assert (np.nanmin(drawn), np.nanmax(drawn)) == (np.nanmin(force), np.nanmax(force))


def test_nothing_but_nan_says_so():
    empty = make_trace({"lateral_force": (("time",), np.full(5, np.nan))}, {"time": np.arange(5.0)}, {})
    ax = plots.lateral_force(empty)
    assert [text.get_text() for text in ax.texts] == ["no numbers to draw"]
    ax.figure.canvas.draw()


def test_the_records_of_a_sweep_are_drawn_at_their_own_times(scenario):
    sine = scenario.replace({"drive": {"model": "Sine", "amplitude": 100, "frequency": 50}})
    swept = sweep(sine, {"drive.frequency": [50.0, 100.0]}, records=True)
    ends = [line.get_xdata()[-1] for line in plots.force(swept).lines]
    assert ends == pytest.approx([0.1, 0.05])


def test_nothing_is_drawn_after_the_end_of_a_shorter_record(scenario):
    record = {"model": "Sampled", "time_samples": [0, 1e-3, 3e-3], "voltage_samples": [0, 9, 0]}
    swept = sweep(
        scenario.replace({"drive": record, "time": {}}), {"time.duration": [1e-3, 3e-3]}, records=True
    )
    drawn, stated = [line.get_xdata() for line in plots.force(swept).lines], swept.time.values
    assert [times[-1] for times in drawn] == pytest.approx([1e-3, 3e-3])
    assert [len(times) for times in drawn] == np.isfinite(stated).sum(axis=1).tolist()
    assert len(drawn[0]) < len(drawn[1]) == stated.shape[1]


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
    assert "friction of the load, 250 mN" in [text.get_text() for text in ax.texts]
    change = float(small.lateral_force.max()) - 0.25
    low, high = ax.get_ylim()
    assert low < 0.25 < 0.25 + change < high
    assert change > 0.6 * (high - low)
    assert percent(ax).get_ylim() == pytest.approx((100 * (low / 0.25 - 1), 100 * (high / 0.25 - 1)))
    shown = {text.get_text() for text in ax.get_yticklabels()}
    assert {"0", "1"} <= shown
    assert not any(text.startswith("25") for text in shown)


def test_a_large_change_of_friction_is_drawn_from_zero_beside_the_friction_of_the_load(trace):
    ax = plots.lateral_force(trace)
    assert ax.get_ylim()[0] == 0
    assert percent(ax) is None
    assert "friction of the load, 250 mN" in [text.get_text() for text in ax.texts]


def test_friction_that_never_falls_to_that_of_the_load_is_above_its_smallest_value(other):
    held = other.assign(lateral_force=0.26 + 0.05 * (other.lateral_force - 0.25))
    ax = plots.lateral_force(held)
    assert "smallest value, 260 mN" in [text.get_text() for text in ax.texts]


def test_friction_of_both_signs_is_drawn_as_it_is(measured):
    ax = plots.lateral_force(measured - 0.3)
    assert ax.get_ylim()[0] < -0.1
    assert (percent(ax), ax.texts[:]) == (None, [])
