"""A Trace in words."""

import json

import numpy as np

import electrovib as ev
from electrovib.core.signals import make_trace
from electrovib.scenario import load, scenario_of
from electrovib.view.summary import (
    key_numbers,
    opening,
    provenance,
    quantity_ranges,
    scenario_text,
    swept_texts,
    versions,
)

PEAK = "peak electrostatic_force"


def ramp(times, values):
    return make_trace({"electrostatic_force": (("time",), values)}, {"time": times}, {})


def test_key_numbers_of_a_run(trace):
    found = key_numbers(trace)
    assert found["largest drive voltage"] == "1 kV"
    peak = float(ev.sweep(scenario_of(trace), {}, quantity=[PEAK])[PEAK])
    assert found["largest electrostatic force"] == f"{peak / 1e-3:.4g} mN"
    assert found["largest field, stratum corneum"].endswith("V/m")


def test_the_mean_weights_uneven_stamps_and_leaves_out_what_is_missing():
    times = np.unique(np.concatenate([np.linspace(0, 1, 2001), np.linspace(0, 0.1, 5000)]))
    for values in (times, np.where((times > 0.4) & (times < 0.6), np.nan, times)):
        # a ramp from 0 to 1 N has the mean 0.5 N, also without its middle; a plain average would give 0.19
        assert key_numbers(ramp(times, values))["mean electrostatic force"] == "500 mN"
        assert np.nanmean(values) < 0.3
    assert key_numbers(ramp(np.array([0.0]), np.array([2.0])))["mean electrostatic force"] == "2 N"
    empty = key_numbers(ramp(np.arange(3.0), np.full(3, np.nan)))
    assert empty["largest electrostatic force"] == "no numbers"


def test_a_sweep_gives_ranges_where_their_ends_are_and_what_is_not_known(swept):
    low, high = (float(value) for value in swept[PEAK].values[[-1, 0]])
    assert key_numbers(swept)[PEAK] == (
        f"{low / 1e-3:.4g} mN (at stack.gap.thickness = 100 µm) to"
        f" {high / 1e-3:.4g} mN (at stack.gap.thickness = 100 nm)"
    )
    assert opening(swept).startswith("Peak electrostatic force: ")
    assert "(at stack.gap.thickness = 100 nm)" in opening(swept)
    plain = quantity_ranges(swept, plain=True)[PEAK]
    assert plain.endswith("(at stack.gap.thickness = 100 nm)")
    assert "100 um" in plain
    assert swept_texts(swept) == {"stack.gap.thickness": "100 nm … 100 µm (15 values)"}
    partly = swept.copy(deep=True)
    partly["peak current"][3] = np.nan
    partly["swing lateral_force"][:] = np.nan
    found = quantity_ranges(partly)
    assert found["peak current"].endswith("; not known in 1 of 15 cases")
    assert found["swing lateral_force"] == "not known"


def test_diagnostics_that_cannot_be_read_are_not_passed_over(trace, measured):
    assert "electrowetting" in opening(trace)
    assert "Validity" not in opening(measured)
    for text in ("{", '[{"name": "x"}]', "[1]"):
        assert "Validity: 1 unknown (validity)." in opening(measured.assign_attrs(validity=text))


def test_the_opening_states_the_result_and_counts_the_diagnostics():
    found = ramp(np.array([0.0, 1.0]), np.array([0.5, 2.0]))
    assert opening(found) == "Largest electrostatic force: 2 N."
    for states, line in (
        ({"a": "ok", "b": "ok"}, "2 ok"),
        ({"a": "warning", "b": "ok"}, "1 ok, 1 warning (a)"),
        ({"a, 1": "warning", "b": "warning", "c": "unknown"}, "2 warnings (a, 1; b), 1 unknown (c)"),
    ):
        spoken = [{"name": name, "state": state, "text": ""} for name, state in states.items()]
        found.attrs["validity"] = json.dumps(spoken)
        assert opening(found) == f"Largest electrostatic force: 2 N. Validity: {line}."


def test_provenance(trace, measured):
    found = provenance(trace)
    assert found["hash of the scenario"] == trace.attrs["scenario_hash"]
    assert found["solver"] == "transient"
    assert {"Python", "electrovib", "numpy", "scipy", "xarray", "pydantic"} <= set(versions())
    assert found["largest error of a material reduced to relaxations"].endswith(" %")
    assert not any("dropped" in words for words in found)
    dropped = trace.copy()
    dropped.attrs["dropped_samples"] = 3
    assert provenance(dropped)["samples of the measured drive that were dropped"] == "3"
    assert provenance(measured) == {"operator": "N. N."}
    measured = measured.copy()
    measured.attrs["log"] = "x" * 10_000
    assert len(provenance(measured)["log"]) < 500


def test_the_scenario_repeats_but_leaves_long_records_out(scenario, tmp_path):
    file = tmp_path / "again.toml"
    file.write_text(scenario_text(scenario), encoding="utf-8")
    assert load(file) == scenario
    times = np.linspace(0, 1, 5000)
    drive = {"model": "Sampled", "time_samples": times, "voltage_samples": np.sin(times)}
    text = scenario_text(scenario.replace({"drive": drive}))
    assert text.count("(measured samples, omitted here)") == 2
    assert "base64" not in text
