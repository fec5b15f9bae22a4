"""Which lines a plot has, and what colour and dash stand for."""

from __future__ import annotations

import numpy as np
import pytest

from electrovib.core.errors import InputError
from electrovib.core.trace import make_trace
from electrovib.view.lines import MOST_LINES, labelled, left_out, lines, scenario_or_none, swept_units
from electrovib.view.style import COLOURS, LAYER_COLOURS


def test_one_trace_one_line_without_a_label(trace):
    (line,) = lines(trace, "electrostatic_force", "time")
    assert (line.label, line.kind, line.dash) == ("", "", "-")
    assert np.array_equal(line.y, trace.electrostatic_force.values)
    assert np.array_equal(line.x, trace.time.values)


def test_layers_have_colours_and_readable_names(trace):
    found = lines(trace, "field", "time")
    assert [line.label for line in found] == ["insulator", "gap", "stratum corneum"]
    assert [line.colour for line in found] == list(LAYER_COLOURS.values())
    assert np.array_equal(found[1].y, trace.field.sel(layer="gap").values)


def test_a_trace_keeps_its_colour_where_another_has_nothing_to_show(trace, other):
    assert "effective_voltage" not in trace
    (line,) = lines({"a": trace, "b": other}, "effective_voltage", "time")
    assert (line.label, line.colour) == ("b", COLOURS[1])


def test_a_long_sweep_shows_evenly_chosen_values_with_their_unit(swept):
    found = lines(swept, "electrostatic_force", "time")
    assert len(found) == MOST_LINES < swept.sizes["stack.gap.thickness"]
    assert found[0].label == "stack.gap.thickness = 100 nm"
    assert found[-1].label == "stack.gap.thickness = 100 µm"
    assert len({line.colour for line in found}) == MOST_LINES
    last = swept.electrostatic_force.isel({"stack.gap.thickness": -1}).values
    assert np.array_equal(found[-1].y, last)
    assert left_out(swept, "electrostatic_force") == "5 of 15 values"


def test_a_value_has_the_same_colour_whether_layers_are_drawn_or_not(swept):
    whole = {line.label: line.colour for line in lines(swept, "electrostatic_force", "time")}
    layered = lines(swept, "field", "time")
    assert len(layered) == 2 * 3
    assert {line.kind for line in layered} == {"insulator", "gap", "stratum corneum"}
    common = [line for line in layered if line.label in whole]
    assert common
    assert all(whole[line.label] == line.colour for line in common)
    assert left_out(swept, "field") == "2 of 15 values"


def test_the_unit_of_a_sweep_is_found_in_the_scenario_when_the_coordinate_lost_it(swept):
    bare = swept.copy()
    bare["stack.gap.thickness"] = ("stack.gap.thickness", swept["stack.gap.thickness"].values)
    assert "units" not in bare["stack.gap.thickness"].attrs
    assert swept_units(bare) == {"stack.gap.thickness": "m"}


def test_words_and_two_paths_can_be_swept():
    values = np.arange(16.0).reshape(2, 2, 4)
    signals = {"lateral_force": (("trial", "finger", "time"), values)}
    coordinates = {
        "trial": [1, 2],
        "finger": np.array(["thumb", "index"], dtype=object),
        "time": np.arange(4.0),
    }
    found = lines(make_trace(signals, coordinates, {}), "lateral_force", "time")
    assert [line.label for line in found][1] == "trial = 1, finger = index"
    assert np.array_equal(found[-1].y, values[1, 1])
    assert left_out(make_trace(signals, coordinates, {}), "lateral_force") == ""


def test_labels(trace, other, measured):
    assert list(labelled([trace, other])) == ["Glass & <film>", "Glass & <film> (2)"]
    assert list(labelled(make_trace({}, {}, {}))) == ["Trace 1"]
    assert list(labelled({"a": measured})) == ["a"]


def test_what_is_not_a_trace_is_named(trace, scenario):
    with pytest.raises(InputError, match="expected a Trace, not a Scenario; simulate first"):
        labelled(scenario)
    with pytest.raises(
        InputError, match=r"expected a Trace, not 'a\.nc'; open it first: trace = ev\.open_trace"
    ):
        labelled("a.nc")
    with pytest.raises(InputError, match="expected a Trace, not Scenario"):
        labelled([trace, scenario])
    with pytest.raises(InputError, match="at least one is needed"):
        labelled([])


def test_a_missing_signal_lists_those_there_are(measured):
    with pytest.raises(InputError, match=r"'electrostatic_force'\. There are: drive_voltage, lateral_force"):
        lines(measured, "electrostatic_force", "time")


def test_a_scenario_that_cannot_be_read_is_none(trace, measured):
    broken = trace.copy()
    broken.attrs["scenario"] = '{"schema": 99}'
    assert scenario_or_none(broken) is None
    broken.attrs["scenario"] = "not JSON"
    assert scenario_or_none(broken) is None
    assert scenario_or_none(measured) is None
    assert scenario_or_none(trace) is not None
