"""Electrovibration: the force between a finger and a charged plate, from drive voltage to friction.

Public names are loaded on first use, so that ``import electrovib`` takes no time.
"""

from __future__ import annotations

import importlib
import sys
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from electrovib.apps.explorer.server import explore as explore
    from electrovib.apps.fit import fit as fit
    from electrovib.apps.fit_material import fit_material as fit_material
    from electrovib.apps.fit_separately import fit_separately as fit_separately
    from electrovib.apps.init import init as init
    from electrovib.apps.run import run as run
    from electrovib.bench.run import plan_bench as plan_bench
    from electrovib.bench.run import run_bench as run_bench
    from electrovib.core.budget import budget as budget
    from electrovib.data.traces import open_trace as open_trace
    from electrovib.export.save import save as save
    from electrovib.export.scenario import export as export
    from electrovib.export.waveform import export_waveform as export_waveform
    from electrovib.recordings.fit.posterior import Sampling as Sampling
    from electrovib.recordings.fit.power_law import fit_power_law as fit_power_law
    from electrovib.recordings.importing import calibrate as calibrate
    from electrovib.recordings.importing import import_file as import_file
    from electrovib.recordings.importing import import_material as import_material
    from electrovib.recordings.importing import merge_traces as merge_traces
    from electrovib.recordings.recording import read_recording as read_recording
    from electrovib.recordings.release import fit_release as fit_release
    from electrovib.recordings.swipe import reduce_swipe as reduce_swipe
    from electrovib.recordings.swipe import reduce_swipes as reduce_swipes
    from electrovib.recordings.transitions import Sensor as Sensor
    from electrovib.recordings.transitions import measure_ring as measure_ring
    from electrovib.recordings.transitions import measure_rings as measure_rings
    from electrovib.recordings.transitions import measure_times as measure_times
    from electrovib.scenario import Scenario as Scenario
    from electrovib.scenario import load as load
    from electrovib.scenario import scenario_of as scenario_of
    from electrovib.scenario.space import Space as Space
    from electrovib.scenario.space import read_space as read_space
    from electrovib.solve.equilibrium import equilibrium as equilibrium
    from electrovib.solve.equilibrium import hysteresis as hysteresis
    from electrovib.solve.prepare import prepare as prepare
    from electrovib.solve.simulate import simulate as simulate
    from electrovib.study.catalogue import models as models
    from electrovib.study.catalogue import scenarios as scenarios
    from electrovib.study.catalogue import spaces as spaces
    from electrovib.study.check import check as check
    from electrovib.study.check.series import series_resistor as series_resistor
    from electrovib.study.compare import compare as compare
    from electrovib.study.compare import compare_materials as compare_materials
    from electrovib.study.design import design as design
    from electrovib.study.design.plate import design_plate as design_plate
    from electrovib.study.perceive import perceive as perceive
    from electrovib.study.percept import compare_percepts as compare_percepts
    from electrovib.study.population import open_study as open_study
    from electrovib.study.population import study as study
    from electrovib.study.sensitivity import sensitivity as sensitivity
    from electrovib.study.surfaces import compare_surfaces as compare_surfaces
    from electrovib.study.sweep import sweep as sweep
    from electrovib.study.texture import texture_drive as texture_drive
    from electrovib.study.texture import texture_stream as texture_stream
    from electrovib.view import plots as plot
    from electrovib.view.report import report as report
    from electrovib.view.reproduce import reproduce as reproduce

_PLACES = {
    "Sampling": "electrovib.recordings.fit.posterior",
    "Scenario": "electrovib.scenario",
    "Sensor": "electrovib.recordings.transitions",
    "budget": "electrovib.core.budget",
    "calibrate": "electrovib.recordings.importing",
    "check": "electrovib.study.check",
    "compare": "electrovib.study.compare",
    "design_plate": "electrovib.study.design.plate",
    "design": "electrovib.study.design",
    "equilibrium": "electrovib.solve.equilibrium",
    "explore": "electrovib.apps.explorer.server",
    "export": "electrovib.export.scenario",
    "export_waveform": "electrovib.export.waveform",
    "fit": "electrovib.apps.fit",
    "fit_material": "electrovib.apps.fit_material",
    "fit_power_law": "electrovib.recordings.fit.power_law",
    "fit_separately": "electrovib.apps.fit_separately",
    "fit_release": "electrovib.recordings.release",
    "hysteresis": "electrovib.solve.equilibrium",
    "import_file": "electrovib.recordings.importing",
    "import_material": "electrovib.recordings.importing",
    "merge_traces": "electrovib.recordings.importing",
    "init": "electrovib.apps.init",
    "compare_materials": "electrovib.study.compare",
    "compare_percepts": "electrovib.study.percept",
    "load": "electrovib.scenario",
    "measure_ring": "electrovib.recordings.transitions",
    "measure_rings": "electrovib.recordings.transitions",
    "measure_times": "electrovib.recordings.transitions",
    "models": "electrovib.study.catalogue",
    "open_study": "electrovib.study.population",
    "open_trace": "electrovib.data.traces",
    "perceive": "electrovib.study.perceive",
    "plan_bench": "electrovib.bench.run",
    "prepare": "electrovib.solve.prepare",
    "Space": "electrovib.scenario.space",
    "read_space": "electrovib.scenario.space",
    "read_recording": "electrovib.recordings.recording",
    "reduce_swipe": "electrovib.recordings.swipe",
    "reduce_swipes": "electrovib.recordings.swipe",
    "report": "electrovib.view.report",
    "reproduce": "electrovib.view.reproduce",
    "run": "electrovib.apps.run",
    "run_bench": "electrovib.bench.run",
    "save": "electrovib.export.save",
    "scenario_of": "electrovib.scenario",
    "scenarios": "electrovib.study.catalogue",
    "spaces": "electrovib.study.catalogue",
    "sensitivity": "electrovib.study.sensitivity",
    "simulate": "electrovib.solve.simulate",
    "series_resistor": "electrovib.study.check.series",
    "sweep": "electrovib.study.sweep",
    "texture_drive": "electrovib.study.texture",
    "texture_stream": "electrovib.study.texture",
    "compare_surfaces": "electrovib.study.surfaces",
}


def __getattr__(name: str) -> Any:
    if name == "plot":
        return importlib.import_module("electrovib.view.plots")
    if name == "__version__":
        from importlib.metadata import version

        return version("electrovib")
    if name == "study":  # a package that can be called
        return importlib.import_module("electrovib.study")
    if name in _PLACES:
        return getattr(importlib.import_module(_PLACES[name]), name)
    raise AttributeError(f"module 'electrovib' has no attribute '{name}'")


def __dir__() -> list[str]:
    return sorted([*_PLACES, "plot", "study", "__version__"])


if "IPython" in sys.modules:  # a notebook or an IPython terminal: results show themselves there
    importlib.import_module("electrovib.view.notebook").register()
