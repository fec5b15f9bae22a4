"""Traces that earlier versions wrote, in every format, are opened, reported and repeated with the names of today."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pytest

import electrovib as ev
from electrovib.apps.cli import main
from electrovib.core.diagnostics import read_diagnostics

WRITTEN = Path(__file__).parents[2] / "data" / "written_before"
RUNS = ["a727f48_run.nc", "a727f48_run.csv", "a727f48_run.mat", "7cb751d_run.mat"]
SWEEPS = ["a727f48_sweep.nc", "a727f48_sweep.csv", "a727f48_sweep.mat"]


def test_the_files_are_small_and_are_all_tried():
    files = [file for file in WRITTEN.iterdir() if file.suffix in {".nc", ".csv", ".mat"}]
    assert sum(file.stat().st_size for file in files) < 60e3
    second = {"a727f48_run.frequency.csv"}  # opened with the file over time
    assert {file.name for file in files} == {*RUNS, *SWEEPS, "a727f48_sweep_of_profile.mat"} | second


@pytest.mark.parametrize("name", [*RUNS, *SWEEPS])
def test_attributes_have_the_names_of_today(name):
    trace = ev.open_trace(WRITTEN / name)
    assert "lamps" not in trace.attrs
    found = read_diagnostics(trace.attrs["validity"])
    assert {"film strength, insulator", "field emission"} <= {diagnostic.name for diagnostic in found}
    assert all(diagnostic.text for diagnostic in found)


@pytest.mark.parametrize("name", [*RUNS, *SWEEPS])
def test_models_and_parameters_have_the_names_of_today(name):
    """The files hold ``GapPlane`` and ``programme``, the oldest the drive ``Constant``."""
    trace = ev.open_trace(WRITTEN / name)
    written = json.loads(trace.attrs["scenario"])
    assert written["force"]["model"] == "GapPlane"
    assert written["drive"]["model"] == ("Constant" if name.startswith("7cb751d") else "Step")
    assert written["load"]["programme"]["model"] == "Press"
    scenario = ev.load(trace) if name in RUNS else ev.scenario_of(trace)
    today = scenario.to_dict()
    assert today["force"]["model"] == "MaxwellStressInGap"
    assert today["drive"]["model"] == "Step"
    assert today["load"]["time_profile"] == written["load"]["programme"]
    assert today["motion"]["time_profile"] == written["motion"]["programme"]


@pytest.mark.parametrize("name", [*RUNS, *SWEEPS])
def test_repeated_it_gives_the_same_numbers(name):
    written = ev.open_trace(WRITTEN / name)
    again = ev.run(WRITTEN / name)
    assert again.sizes == written.sizes or name in RUNS  # a run was saved without some of its signals
    for signal in written.data_vars:
        values = written[signal].values
        close = {"rtol": 1e-12, "atol": 1e-12 * np.nanmax(np.abs(values)), "err_msg": signal}
        np.testing.assert_allclose(again[signal].values, values, **close)
    for coordinate in {*written.coords} - {"layer"}:
        np.testing.assert_allclose(again[coordinate], written[coordinate], rtol=1e-12)


def test_a_sweep_over_a_former_parameter_is_repeated():
    """Its parameter ``load.programme.rise`` has the name of today in what is computed again."""
    name = "a727f48_sweep_of_profile.mat"
    again, written = ev.run(WRITTEN / name), ev.open_trace(WRITTEN / name)
    assert dict(again.sizes) == {"load.time_profile.rise": 2}
    np.testing.assert_array_equal(again["load.time_profile.rise"], [1e-3, 2e-3])
    for signal in ("peak electrostatic_force", "mean lateral_force"):
        np.testing.assert_allclose(again[signal].values, written[signal].values, rtol=1e-12)


def test_the_command_repeats_one(tmp_path, monkeypatch, capsys):
    output = tmp_path / "again.nc"
    monkeypatch.setattr(
        sys, "argv", ["electrovib", "run", str(WRITTEN / "a727f48_sweep.csv"), "-o", str(output)]
    )
    with pytest.raises(SystemExit) as stop:
        main()
    assert not stop.value.code, capsys.readouterr().err
    again, written = ev.open_trace(output), ev.open_trace(WRITTEN / "a727f48_sweep.csv")
    np.testing.assert_allclose(again["mean lateral_force"], written["mean lateral_force"], rtol=1e-12)
    assert "validity" in again.attrs


@pytest.mark.parametrize("name", ["a727f48_run.nc", "7cb751d_run.mat", "a727f48_sweep.csv"])
def test_it_is_reported(name, tmp_path):
    """With its diagnostics, its parameters and what was computed; the oldest as the newest."""
    text = ev.report(WRITTEN / name, tmp_path / "report.html").read_text(encoding="utf-8")
    assert "cannot be read by this version" not in text
    plain = text.replace("<wbr>", "")
    for word in ("MaxwellStressInGap", "field emission", "load.time_profile.rise"):
        assert word in plain, word
    assert "GapPlane" not in text
