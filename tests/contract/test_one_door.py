"""Every public function that takes a scenario takes it in every form, and refuses everything else in one sentence."""

from __future__ import annotations

import functools
import inspect
import sys
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest

import electrovib as ev
from electrovib.core.discovery import paper
from electrovib.core.errors import InputError
from electrovib.core.trace import make_trace
from electrovib.scenario.toml import to_toml

mpl.use("Agg")
PRESET = "vezzoli_2014/fig6"
SURFACE = {"model": "LinearSpring", "stiffness": "1 GPa/m", "free_gap": "10 um"}
CHANGES = {
    "contact.surface": SURFACE,
    "force.model": "MaxwellStressInGap",
    "stack.gap.material.conductivity": 0.0,
    "drive": {"model": "Sine", "frequency": "100 Hz", "amplitude": "100 V"},
    "time.samples": 200,
    "time.duration": "30 ms",
    "title": "one",
}
SCENARIO = ev.load("vezzoli_2014/fig6_gap", changes=CHANGES)
MEAN = "mean electrostatic_force"
RISE = {"load.normal_force": [0.5, 1.0]}
LOADS = {
    "load.normal_force": {"model": "Uniform", "low": 0.5, "high": 1.0},
    "stack.gap.thickness": {"model": "Uniform", "low": "2 um", "high": "6 um"},
}


def exported(scenario):
    return ev.export(scenario, "out.cir", force=True).read_text(encoding="utf-8")


@functools.cache
def record():
    """A force over time, 1 % above that of the scenario, with a ripple for noise."""
    trace = ev.simulate(SCENARIO, signals=["electrostatic_force"])
    ripple = 1e-6 * np.cos(np.arange(trace.time.size) ** 2)
    return trace.assign(electrostatic_force=1.01 * trace.electrostatic_force + ripple)


def drawn(scenario):
    ev.plot.stack(scenario)
    return [text.get_text() for text in ev.plot.stack(scenario).texts]


def explored(scenario):
    """Return the force that the page would show first, without serving it."""
    shown = {}
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr("nicegui.ui.run", lambda **_: None)
        patched.setattr("nicegui.app.add_middleware", lambda *_, **__: None)
        patched.setattr(
            "electrovib.apps.explorer.page.build", lambda own, first: shown.update(own=own, first=first)
        )
        ev.explore(scenario, browser=False, say=lambda _: None)
    return ev.simulate(shown["own"].get(shown["first"], shown["first"])).electrostatic_force.values


FORCE = "electrostatic_force"
TEXTURE = {"model": "Grating", "period": "1 mm", "amplitude": "0.1 mN"}
HELD = {"voltage": 1e3, "current": 1}
FORCE_LAWS = ["MaxwellStressInGap", "MaxwellStressInInsulator"]
USES = {
    "compare": lambda scenario: [e.static for e in ev.compare(scenario, models=FORCE_LAWS).entries],
    "compare_materials": lambda scenario: [each.force for each in ev.compare_materials(scenario, materials=["silica"]).entries],
    "design_plate": lambda scenario: [
        each.values[MEAN] for each in ev.design_plate(scenario, {"drive.amplitude": [50.0, 100.0]}, refine=0).candidates
    ],
    "design": lambda scenario: ev.design(scenario, want=f"{MEAN} = 1 mN", free="drive.amplitude", between="1 V:10 kV").values,
    "explore": explored,
    "equilibrium": lambda scenario: ev.equilibrium(scenario).force,
    "export": exported,
    "export_waveform": lambda scenario: ev.export_waveform(
        scenario, "out.csv", limits={"voltage": 1e3, "current": 1}, edge="line", force=True
    ).waveform.voltages,
    "fit": lambda scenario: [*ev.fit(scenario, record(), free=["stack.insulator.thickness"]).best.estimate.values.values()],
    "fit_separately": lambda scenario: [
        row.value for row in ev.fit_separately(scenario, record(), free=["stack.insulator.thickness"]).fits[0].rows
    ],
    "init": ev.init,
    "load": ev.load,
    "perceive": lambda scenario: ev.perceive(scenario).level,
    "plot.stack": drawn,
    "plan_bench": lambda scenario: ev.plan_bench(scenario).codes,
    "prepare": lambda scenario: [
        *ev.prepare(scenario, free=["load.normal_force"], quantities=[MEAN])({"load.normal_force": 1.0}).values()
    ],
    "read_space": lambda scenario: ev.read_space(scenario, LOADS).draw(1, 0, 4)["load.normal_force"],
    "run": lambda scenario: ev.run(scenario)[FORCE].values,
    "series_resistor": lambda scenario: ev.series_resistor(scenario, limits={"body_current": 1e-3}).resistance,
    "run_bench": lambda scenario: ev.run_bench(scenario, simulate=True).lateral_force.values,
    "sensitivity": lambda scenario: [
        each.total for each in ev.sensitivity(scenario, LOADS, quantity=MEAN, n=4, seed=1).indices
    ],
    "simulate": lambda scenario: ev.simulate(scenario).electrostatic_force.values,
    "study": lambda scenario: ev.study(scenario, LOADS, n=4, seed=1)["electrostatic_force_mean"].values,
    "texture_drive": lambda scenario: ev.texture_drive(scenario, texture=TEXTURE, path="50 mm/s", limits=HELD).voltages,
    "texture_stream": lambda scenario: ev.texture_stream(
        scenario, texture=TEXTURE, limits=HELD
    ).render(0.0, 0.0),
    "sweep": lambda scenario: ev.sweep(scenario, RISE)[MEAN].values,
}  # fmt: skip
"""Public function to what it makes of a scenario."""
FORMS = ("preset", "text", "path", "mapping", "scenario", "trace", "trace file")


@pytest.fixture(scope="module")
def trace():
    return ev.simulate(SCENARIO)


@pytest.fixture(scope="module")
def expected():
    return {}


@pytest.fixture(scope="module")
def forms(tmp_path_factory, trace):
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(tmp_path_factory.mktemp("forms"))
        patch.setattr(paper("vezzoli_2014"), "scenarios", lambda: {"fig6": SCENARIO})
        Path("one.toml").write_text(to_toml(SCENARIO), encoding="utf-8")
        ev.save(trace, "one.NC")
        given = (PRESET, "one.toml", Path("one.toml"), SCENARIO.to_dict(), SCENARIO, trace, "one.NC")
        yield dict(zip(FORMS, given, strict=True))


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("use", USES)
def test_a_scenario_is_taken_in_every_form(use, form, forms, expected):
    found = USES[use](forms[form])
    if use not in expected:
        expected[use] = USES[use](SCENARIO)
    np.testing.assert_array_equal(found, expected[use])


def measured():
    return make_trace({"drive_voltage": (("time",), [0.0, 1.0])}, {"time": [0.0, 1.0]}, {"title": "measured"})


WRONG = {
    "a number": (lambda: 3, "scenario = 3: expected a paper's scenario such as"),
    "nothing": (lambda: None, "scenario = None: expected"),
    "a list": (lambda: [PRESET], "scenario = .*: expected"),
    "no such paper": (lambda: "nobody_1900/fig1", "nobody_1900"),
    "no such scenario": (lambda: "vezzoli_2014/fig66", r"has no scenario 'fig66'. Did you mean 'vezzoli_2014/fig6' \("),
    "no such file": (lambda: "none.toml", "none.toml: No such file"),
    "no such Trace": (lambda: "none.nc", "none.nc: there is no such file"),
    "a measurement": (measured, "carries no scenario: it is a measurement"),
    "a sweep": (lambda: ev.sweep(SCENARIO, RISE), "this Trace holds a sweep over load.normal_force, that is many"),
}  # fmt: skip
ALLOWED = {("run", "a sweep"), ("init", "a sweep"), ("plot.stack", "a sweep")}
"""What is repeated, or written and drawn as what it began from."""


@pytest.mark.parametrize("wrong", WRONG)
@pytest.mark.parametrize("use", USES)
def test_anything_else_is_refused_in_one_sentence(use, wrong, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    given, words = WRONG[wrong]
    if (use, wrong) in ALLOWED:
        monkeypatch.setattr(
            sys.modules[__name__], "FORCE", "mean electrostatic_force"
        )  # what a sweep answers with
        USES[use](given())
        return
    if (use, wrong) == ("perceive", "a measurement"):
        words = "no signal to feel"
    with pytest.raises(InputError, match=words) as caught:
        USES[use](given())
    assert len(caught.value.problems) == 1
    assert not list(tmp_path.iterdir()), "nothing has been written"


def test_every_public_function_that_takes_a_scenario_is_here():
    taking = {
        name
        for name in dir(ev)
        if name not in {"plot", "Scenario", "__version__"}
        and list(inspect.signature(getattr(ev, name)).parameters)[:1] in (["scenario"], ["source"])
    }
    assert taking | {"plot.stack"} == set(USES)


def test_a_trace_file_gives_its_scenario_and_opens_as_a_trace(forms, trace):
    assert ev.load("one.NC") == SCENARIO
    assert ev.load("one.NC", changes={"load.normal_force": "1 N"}).load.normal_force == 1
    assert ev.open_trace("one.NC").identical(trace)
    with pytest.raises(
        InputError, match=r"one\.toml: a Trace is opened from \.nc, \.csv, \.mat, not from '\.toml'"
    ):
        ev.open_trace("one.toml")
