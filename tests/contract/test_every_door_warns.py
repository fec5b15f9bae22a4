"""Whatever computes a number from a scenario states the warnings of the scenario beside it: functions, commands and files."""

from __future__ import annotations

import functools
import html
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import typer

import electrovib as ev
from electrovib.apps.cli import app, main
from electrovib.apps.explorer.computed import compute
from electrovib.apps.explorer.page.words import judged_words
from electrovib.core.diagnostics import diagnostics_of
from electrovib.core.trace import make_trace
from electrovib.scenario.toml import to_toml
from electrovib.solve.quantities.answer import validity
from electrovib.study.reproduction import Reproduction

MEAN, FORCE = "mean electrostatic_force", "electrostatic_force"
LIMITS = {"voltage": "2 kV", "current": "250 uA", "body_current": "1 mA"}
SCENARIO = ev.load(
    "vezzoli_2014/fig6_gap",
    changes={
        "force.model": "MaxwellStressInGap",
        "stack.gap.material.conductivity": 0.0,
        "contact.surface": {"model": "LinearSpring", "stiffness": "1 GPa/m", "free_gap": "10 um"},
        "drive": {"model": "Sine", "frequency": "100 Hz", "amplitude": "100 V"},
        "circuit.return_path": {"model": "Floating", "capacitance": "200 pF"},
        "limits": LIMITS,
        "time": {"duration": "20 ms", "samples": 201},
    },
)
WARNING = "the body is not grounded"
"""Of a warning that holds under every law and every drive."""
SPACE = {
    "load.normal_force": {"model": "Uniform", "low": 0.4, "high": 0.6},
    "stack.gap.thickness": {"model": "Uniform", "low": 4e-6, "high": 6e-6},
}
TEXTURE = {"model": "Grating", "period": "1 mm", "amplitude": "0.01 mN"}
FREE, SOUGHT = ["contact.area"], {"free": "drive.amplitude", "between": "10 V:400 V"}


@functools.cache
def record():
    """A force over time, 1 % above that of the scenario, with a ripple for noise."""
    trace = ev.simulate(SCENARIO, signals=[FORCE])
    values = 1.01 * trace[FORCE].values + 1e-6 * np.cos(np.arange(trace.time.size) ** 2)
    return make_trace({FORCE: (("time",), values)}, {"time": trace.time.values}, {})


def stored():
    ev.study(SCENARIO, SPACE, n=4, seed=1, output="study.zarr")
    return ev.open_study("study.zarr")


def opened():
    ev.save(ev.simulate(SCENARIO), "trace.nc")
    return ev.open_trace("trace.nc")


def explored():
    found = compute(SCENARIO)
    assert WARNING in judged_words(found.diagnostics)  # what the page shows above its tabs
    return found


DOORS = {
    "check": lambda: ev.check(SCENARIO),
    "compare": lambda: ev.compare(SCENARIO, models=["MaxwellStressInGap"]),
    "compare_materials": lambda: ev.compare_materials(SCENARIO, materials=["silica"]),
    "compare_percepts": lambda: ev.compare_percepts(ev.perceive(SCENARIO), ev.perceive(SCENARIO)),
    "design": lambda: ev.design(SCENARIO, want=f"{MEAN} = 1 mN", **SOUGHT),
    "design for a target": lambda: ev.design(SCENARIO, target="sine 5 Hz 1 mN", method="carrier"),
    "design for a share": lambda: ev.design(SCENARIO, want=f"{MEAN} = 1 mN", space=SPACE, share=0.9, seed=1, n=20, **SOUGHT),
    "design without a solution": lambda: ev.design(SCENARIO, want=f"{MEAN} = 1 kN", **SOUGHT),
    "design_plate": lambda: ev.design_plate(SCENARIO, {"drive.amplitude": [50.0, 100.0]}, refine=0),
    "equilibrium": lambda: ev.equilibrium(SCENARIO),
    "explore": explored,
    "export": lambda: ev.export(SCENARIO, "out.cir"),
    "export_waveform": lambda: ev.export_waveform(SCENARIO, "out.csv", edge="line"),
    "fit": lambda: ev.fit(SCENARIO, record(), free=FREE),
    "fit_separately": lambda: ev.fit_separately(SCENARIO, record(), free=FREE),
    "open_study": stored,
    "open_trace": opened,
    "perceive": lambda: ev.perceive(SCENARIO),
    "plan_bench": lambda: ev.plan_bench(SCENARIO),
    "prepare": lambda: ev.prepare(SCENARIO, free=["load.normal_force"], quantities=[MEAN]),
    "report": lambda: ev.report(SCENARIO, "out.html"),
    "run": lambda: ev.run(SCENARIO),
    "run_bench": lambda: ev.run_bench(SCENARIO, simulate=True),
    "save": lambda: ev.save(ev.simulate(SCENARIO), "out.csv")[0],
    "sensitivity": lambda: ev.sensitivity(SCENARIO, SPACE, quantity=MEAN, n=4, seed=1),
    "series_resistor": lambda: ev.series_resistor(SCENARIO),
    "simulate": lambda: ev.simulate(SCENARIO, signals=[FORCE]),
    "study": lambda: ev.study(SCENARIO, SPACE, n=4, seed=1),
    "sweep": lambda: ev.sweep(SCENARIO, {"load.normal_force": [0.5, 1.0]}),
    "texture_drive": lambda: ev.texture_drive(SCENARIO, texture=TEXTURE, path="50 mm/s", carrier="3 kHz"),
    "texture_stream": lambda: ev.texture_stream(SCENARIO, texture=TEXTURE),
}  # fmt: skip
"""Public function to a result of it, or the file that it writes."""
READS, LISTS, MEASURES = (
    "reads what computes nothing",
    "lists what is shipped",
    "evaluates a record, without a scenario",
)
NO_NUMBER = {
    "Sampling": READS,
    "Scenario": READS,
    "Sensor": READS,
    "Space": READS,
    "__version__": LISTS,
    "budget": READS,
    "calibrate": MEASURES,
    "compare_surfaces": "compares laws on two stacks of its own",
    "fit_material": MEASURES,
    "fit_power_law": MEASURES,
    "fit_release": MEASURES,
    "hysteresis": "takes a surface, a pressure and voltages, without a scenario",
    "import_file": MEASURES,
    "import_material": MEASURES,
    "init": READS,
    "load": READS,
    "measure_ring": MEASURES,
    "measure_rings": MEASURES,
    "measure_times": MEASURES,
    "merge_traces": MEASURES,
    "models": LISTS,
    "plot": "draws what a result holds, which states its diagnostics itself",
    "read_recording": MEASURES,
    "read_space": READS,
    "reduce_swipe": MEASURES,
    "reduce_swipes": MEASURES,
    "reproduce": "takes a paper; its scenarios are judged in test_a_reproduction_states_the_warnings_of_its_scenarios",
    "scenario_of": READS,
    "scenarios": LISTS,
    "spaces": LISTS,
}
"""Public name to the reason why it computes no number from a scenario that it is given."""


@pytest.fixture(autouse=True)
def _here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("s.toml").write_text(to_toml(SCENARIO), encoding="utf-8")
    lines = "\n".join(f'"{path}" = {to_toml_table(table)}' for path, table in SPACE.items())
    Path("space.toml").write_text(f"[space]\n{lines}\n", encoding="utf-8")


def to_toml_table(table):
    return "{" + ", ".join(f"{name} = {value!r}" for name, value in table.items()) + "}"


def test_every_public_name_is_a_door_or_computes_nothing_from_a_scenario():
    assert {name.partition(" ")[0] for name in DOORS} | set(NO_NUMBER) == set(dir(ev))
    assert not set(DOORS) & set(NO_NUMBER)


@pytest.mark.parametrize("name", DOORS)
def test_every_function_states_the_warning(name):
    found = DOORS[name]()
    if isinstance(found, Path):
        assert WARNING in html.unescape(found.read_text(encoding="utf-8"))
    else:
        told = [each.state for each in diagnostics_of(found) if each.text.startswith(WARNING)]
        assert told == ["warning"]


TARGET = ["design", "s.toml", "--want", "electrostatic_force = sine 5 Hz 1 mN", "--method", "carrier"]
WANT = [
    "design",
    "s.toml",
    "--want",
    f"{MEAN} = 1 mN",
    "--free",
    "drive.amplitude=10 V:400 V",
]
PLATE = ["design", "s.toml", "--over", "drive.amplitude=50:100:2", "--refine", "0"]
PATTERN = '{ model = "Grating", period = "1 mm", amplitude = "0.01 mN" }'
COMMANDS = {
    "bench run": [["s.toml"], ["s.toml", "--simulate", "-o", "t.csv"]],
    "check": [["s.toml", "-o", f"out.{form}"] for form in ("csv", "json", "html")],
    "compare": [["s.toml", "-o", "out.html"], ["s.toml", "--material", "silica"]],
    "design": [
        [*WANT[1:], "-o", "out.json"],
        [*WANT[1:], "--space", "space.toml", "--share", "0.9", "--seed", "1", "-n", "20", "-o", "out.json"],
        [*TARGET[1:], "-o", "out.json"],
        [*TARGET[1:], "--edge", "line", "-o", "out.csv"],
        *([*PLATE[1:], "-o", f"out.{form}"] for form in ("csv", "html")),
        ["s.toml", "--texture", PATTERN, "--path", "100 mm/s", "--carrier", "3 kHz", "--edge", "line", "-o", "out.csv"],
    ],
    "export": [["s.toml", "-o", "out.cir"], ["s.toml", "--edge", "line", "-o", "out.csv"]],
    "fit": [
        ["s.toml", "r.nc", "--free", "contact.area", "-o", "out"],
        ["s.toml", "r.nc", "--free", "contact.area", "--separately", "-o", "out"],
    ],
    "report": [["s.toml", "-o", "out.html"], ["s.toml", "t.nc", "-o", "out.html"]],
    "run": [
        ["s.toml"],
        ["s.toml", "--all"],
        ["s.toml", "--states"],
        ["s.toml", "-o", "out.csv", "--report", "out.html"],
        ["s.toml", "--over", "load.normal_force=0.4:0.6:2", "-o", "out.csv", "--report", "out.html"],
    ],
    "study": [
        ["s.toml", "--space", "space.toml", "-n", "4", "--seed", "1", "-o", "out.zarr", "-o", "out.csv", "--report", "out.html"],
        ["s.toml", "--space", "space.toml", "--sensitivity", "--quantity", MEAN, "-n", "4", "--seed", "1", "-o", "out"],
    ],
}  # fmt: skip
"""Command to the arguments of calls that compute numbers from a scenario."""
WITHOUT_A_NUMBER = {
    "bench init": LISTS,
    "explore": "the page that it serves is a door of its own above",
    "import": MEASURES,
    "init": READS,
    "list": LISTS,
    "reproduce": NO_NUMBER["reproduce"],
    "times": MEASURES,
}
"""Command to the reason why it computes no number from a scenario that it is given."""
INPUTS = {"s.toml", "r.nc", "space.toml", "parameters.toml", "zarr.json"}
"""Files that hold no number that was computed, but what one is computed from; a study is read by `open_study`."""


def commands():
    """Return the names of all commands, those of a group after its name."""
    group = typer.main.get_command(app)
    for name, command in group.commands.items():
        inner = getattr(command, "commands", None)
        yield from [name] if inner is None else (f"{name} {each}" for each in inner)


def test_every_command_is_a_door_or_computes_nothing_from_a_scenario():
    assert set(COMMANDS) | set(WITHOUT_A_NUMBER) == set(commands())
    assert not set(COMMANDS) & set(WITHOUT_A_NUMBER)


@pytest.mark.parametrize(
    ("name", "arguments"), [(name, each) for name in COMMANDS for each in COMMANDS[name]]
)
def test_every_command_states_the_warning_once_and_in_each_of_its_files(name, arguments, capsys, monkeypatch):
    if name == "fit":
        ev.save(record(), "r.nc")
    if "t.nc" in arguments:
        ev.save(ev.simulate(SCENARIO), "t.nc")
    monkeypatch.setattr(sys, "argv", ["electrovib", *name.split(), *arguments])
    with pytest.raises(SystemExit) as stop:
        main()
    shown = capsys.readouterr()
    assert not stop.value.code, shown.err
    assert shown.out.count(WARNING) == 1, shown.out
    for file in [each for each in Path().rglob("*") if each.is_file() and each.name not in INPUTS]:
        if file.suffix in {".csv", ".html", ".json", ".cir"}:
            assert WARNING in html.unescape(file.read_text(encoding="utf-8")), file


def test_a_reproduction_states_the_warnings_of_its_scenarios(monkeypatch):
    own = {"one": SCENARIO, "again": SCENARIO, "another": SCENARIO.replace({"load.normal_force": 2.0})}
    empty = Reproduction(paper="example_2099", citation="", rows=(), panels=())
    module = SimpleNamespace(scenarios=lambda: own, reproduce=lambda **_: empty)
    monkeypatch.setattr("electrovib.core.discovery.paper", lambda _: module)
    told = [each.text for each in ev.reproduce("example_2099", "out").diagnostics]
    assert sum(text.startswith(WARNING) for text in told) == 1
    assert WARNING in html.unescape(Path("out/report.html").read_text(encoding="utf-8"))


def test_a_scenario_that_cannot_be_judged_says_so():
    changes = {"force": {"model": "Vezzoli2014PerFrequency"}, "time.initial_state": {"model": "AtRest"}}
    (found,) = validity(SCENARIO.replace(changes))
    assert found.state == "unknown"
    assert "is not causal" in found.text


def test_a_trace_whose_diagnostics_are_damaged_says_so():
    damaged = record().assign_attrs(validity='[{"name": "gap"')
    assert [each.state for each in diagnostics_of(damaged)] == ["unknown"]
    assert [each.state for each in ev.perceive(damaged).diagnostics] == ["unknown"]
