"""Every function, command and file that computes a number from a scenario takes it in every form and states its warnings.

Everything that is no scenario is refused in one sentence.
"""

import functools
import html
import inspect
import re
import shlex
import sys
from pathlib import Path
from types import SimpleNamespace

import matplotlib as mpl
import numpy as np
import pytest
import typer

import electrovib as ev
from electrovib.apps.cli import app, main
from electrovib.apps.explorer.computed import compute
from electrovib.apps.explorer.page.plots import judged_words
from electrovib.core.diagnostics import diagnostics_of
from electrovib.core.discovery import paper
from electrovib.core.errors import InputError
from electrovib.core.signals import make_trace
from electrovib.scenario import read_scenario
from electrovib.scenario.toml import to_toml
from electrovib.solve.quantities.answer import validity
from electrovib.studies.reproduction import Reproduction

mpl.use("Agg")
PRESET, MEAN, FORCE = "vezzoli_2014/fig6", "mean electrostatic_force", "electrostatic_force"
CHANGES = {
    "force.model": "MaxwellStressInGap",
    "stack.gap.material.conductivity": 0.0,
    "contact.surface": {"model": "LinearSpring", "stiffness": "1 GPa/m", "free_gap": "10 um"},
    "drive": {"model": "Sine", "frequency": "100 Hz", "amplitude": "100 V"},
    "circuit.return_path": {"model": "Floating", "capacitance": "200 pF"},
    "limits": {"voltage": "2 kV", "current": "250 uA", "body_current": "1 mA"},
    "time": {"duration": "20 ms", "samples": 201},
    "title": "one",
}
SCENARIO = ev.load("vezzoli_2014/fig6_gap", changes=CHANGES)
WARNING = "the body is not grounded"
"""Of a warning that holds under every law and every drive."""
LOAD, GAP = "load.normal_force", "stack.gap.thickness"
SPACE = {
    LOAD: {"model": "Uniform", "low": 0.4, "high": 0.6},
    GAP: {"model": "Uniform", "low": 4e-6, "high": 6e-6},
}
LAWS = ["MaxwellStressInGap", "MaxwellStressInInsulator"]
TEXTURE = {"model": "Grating", "period": "1 mm", "amplitude": "0.01 mN"}
FILM, LOADS = ["stack.insulator.thickness"], {LOAD: [0.5, 1.0]}
WANT = {"want": f"{MEAN} = 1 mN", "free": "drive.amplitude = 10 V:400 V"}
PLATE = {"over": {"drive.amplitude": [50.0, 100.0]}, "refine": 0}
ROUGH = {
    "roughness": ev.SelfAffine(rms=2e-6, hurst=0.8, longest=1e-3, roll_off=2.5e-4, shortest=2.5e-4),
    "body": ev.Elastic(modulus=1e7),
}
DRAWS = {"n": 4, "seed": 1}
CAPACITANCES = {"load": [0.1, 0.5, 2.0, 5.0], "capacitance": [25.99e-12, 27.17e-12, 28.09e-12, 28.29e-12]}
IMPEDANCES = {"frequency": [1e3, 1e4], "impedance": [-6e6j, -6e5j]}
WAVE = {"path": "50 mm/s", "carrier": "3 kHz"}


@functools.cache
def record():
    """A force over time, 1 % above that of the scenario, with a ripple for noise."""
    trace = ev.simulate(SCENARIO, signals=[FORCE])
    values = 1.01 * trace[FORCE].values + 1e-6 * np.cos(np.arange(trace.time.size) ** 2)
    return make_trace({FORCE: (("time",), values)}, {"time": trace.time.values}, {})


def stored(scenario):
    ev.study(scenario, SPACE, **DRAWS, output="study.zarr")
    return ev.open_study("study.zarr")


def opened(scenario):
    ev.save(ev.simulate(scenario), "trace.nc")
    return ev.open_trace("trace.nc")


def shown_first(scenario):
    """Return what the page would show first, without serving it."""
    shown = {}
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr("nicegui.ui.run", lambda **_: None)
        patched.setattr("nicegui.app.add_middleware", lambda *_, **__: None)
        patched.setattr(
            "electrovib.apps.explorer.page.build", lambda own, first: shown.update(own=own, first=first)
        )
        ev.explore(scenario, browser=False, say=lambda _: None)
    return shown["own"].get(shown["first"], shown["first"])


def explored(scenario):
    found = compute(ev.load(shown_first(scenario)))
    assert WARNING in judged_words(found.diagnostics)  # what the page shows above its tabs
    return found


def grounded(source):
    """Return the scenario with a grounded body, for what refuses one that floats."""
    return read_scenario(source).replace({"circuit.return_path": {"model": "Grounded"}})


REFUSING = {
    "contact_capacitance": lambda one: ev.contact_capacitance(one, **IMPEDANCES),
    "fit_contact": lambda one: ev.fit_contact(one, **ROUGH, **CAPACITANCES),
    "rough_contact": lambda one: ev.rough_contact(one, **ROUGH),
}
"""Functions that refuse what the warning is of, a body that floats."""
DOORS = {
    "check": ev.check,
    "compare": lambda one: ev.compare(one, models=LAWS),
    "compare_materials": lambda one: ev.compare_materials(one, materials=["silica"]),
    "compare_percepts": lambda one: ev.compare_percepts(ev.perceive(one), ev.perceive(one)),
    "contact_capacitance": lambda one: ev.contact_capacitance(grounded(one), **IMPEDANCES),
    "drive_for_force": lambda one: ev.drive_for_force(one, target="sine 5 Hz 1 mN", method="carrier"),
    "equilibrium": ev.equilibrium,
    "explore": explored,
    "export": lambda one: ev.export(one, "out.cir", force=True).absolute(),
    "export_waveform": lambda one: ev.export_waveform(one, "out.csv", edge="line", force=True),
    "find_value": lambda one: ev.find_value(one, **WANT),
    "find_value without a solution": lambda one: ev.find_value(one, **WANT | {"want": f"{MEAN} = 1 kN"}),
    "fit": lambda one: ev.fit(one, record(), free=FILM),
    "fit_contact": lambda one: ev.fit_contact(grounded(one), **ROUGH, **CAPACITANCES, draws=1),
    "fit_laws": lambda one: ev.fit_laws(one, record(), free=FILM, laws=["EffectiveMedium"]),
    "fit_separately": lambda one: ev.fit_separately(one, record(), free=FILM),
    "open_study": stored,
    "open_trace": opened,
    "perceive": ev.perceive,
    "plan_bench": ev.plan_bench,
    "plan_experiment": lambda one: ev.plan_experiment(
        one, LAWS, over=LOADS, space={GAP: SPACE[GAP]}, quantity=MEAN, n=4
    ),
    "plan_plate": lambda one: ev.plan_plate(one, **PLATE),
    "prepare": lambda one: ev.prepare(one, free=[LOAD], quantity=[MEAN]),
    "report": lambda one: ev.report(one, "out.html").absolute(),
    "rough_contact": lambda one: ev.rough_contact(grounded(one), **ROUGH),
    "run": ev.run,
    "run_bench": lambda one: ev.run_bench(one, simulate=True),
    "save": lambda one: ev.save(ev.simulate(one), "out.csv")[0].absolute(),
    "sensitivity": lambda one: ev.sensitivity(one, SPACE, quantity=MEAN, **DRAWS),
    "series_resistor": ev.series_resistor,
    "simulate": lambda one: ev.simulate(one, signals=[FORCE]),
    "study": lambda one: ev.study(one, SPACE, **DRAWS),
    "sweep": lambda one: ev.sweep(one, LOADS),
    "texture_drive": lambda one: ev.texture_drive(one, texture=TEXTURE, **WAVE),
    "texture_stream": lambda one: ev.texture_stream(one, texture=TEXTURE),
    "value_for_share": lambda one: ev.value_for_share(one, **WANT, space=SPACE, share=0.9, seed=1, n=20),
}
"""Public function to a result of it, or the file that it writes."""
READING = {
    "init": ev.init,
    "load": ev.load,
    "plot.stack": lambda one: [text.get_text() for text in ev.plot.stack(one).texts],
    "read_space": lambda one: ev.read_space(one, SPACE).draw(1, 0, 4)[LOAD],
}
"""Public function that takes a scenario and computes no number that a warning could be of."""
VALUES = {
    "compare": lambda found: [each.static for each in found.entries],
    "compare_materials": lambda found: [each.force for each in found.entries],
    "contact_capacitance": lambda found: found,
    "drive_for_force": lambda found: found.values,
    "equilibrium": lambda found: found.force,
    "explore": lambda found: found.trace[FORCE].values,
    "export": lambda found: found.read_text(encoding="utf-8"),
    "export_waveform": lambda found: found.waveform.voltages,
    "find_value": lambda found: found.values,
    "fit": lambda found: [*found.best.estimate.values.values()],
    "fit_contact": lambda found: found.fitted,
    "fit_laws": lambda found: [*found.best.estimate.values.values()],
    "fit_separately": lambda found: [row.value for row in found.fits[0].rows],
    "perceive": lambda found: found.level,
    "plan_bench": lambda found: found.codes,
    "plan_experiment": lambda found: [*found.best.log_odds, *found.own.log_odds],
    "plan_plate": lambda found: [each.values[MEAN] for each in found.candidates],
    "prepare": lambda found: [*found({LOAD: 1.0}).values()],
    "rough_contact": lambda found: found.force,
    "run": lambda found: found[FORCE].values,
    "run_bench": lambda found: found.lateral_force.values,
    "sensitivity": lambda found: [each.total for each in found.indices],
    "series_resistor": lambda found: found.resistance,
    "simulate": lambda found: found[FORCE].values,
    "study": lambda found: found[f"{FORCE}_mean"].values,
    "sweep": lambda found: found[MEAN].values,
    "texture_drive": lambda found: found.voltages,
    "texture_stream": lambda found: found.render(0.0, 0.0),
    "value_for_share": lambda found: found.value,
}
"""Public function whose first argument is a scenario, to the numbers of its result that are compared."""
READS, LISTS = "reads what computes nothing", "lists what is shipped"
MEASURES = "evaluates a record, without a scenario"
NO_NUMBER = {
    READS: "Coated Elastic MeasuredHeights Recordings Sampling Scenario Scaling SelfAffine Sensor Space SpectrumErrors"
    " SpectrumRecipe budget init load read_space scenario_of",
    LISTS: "__version__ models scenarios spaces",
    MEASURES: "calibrate fit_material fit_power_law import_file import_material measure_ring"
    " measure_rings measure_times merge_traces read_recording reduce_swipe reduce_swipes",
    "takes surfaces of its own, without a scenario": "compare_surfaces hysteresis",
    "draws what a result holds, which states its diagnostics itself": "plot",
    "takes measurements, whose set-ups are judged in test_evidence": "Measurement evidence measurements",
    "takes a paper; its scenarios are judged in test_a_reproduction_states_the_warnings": "reproduce",
}
"""Why these public names compute no number from a scenario that they are given."""


@pytest.fixture(autouse=True)
def _here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def test_every_public_name_is_a_door_or_computes_nothing_from_a_scenario():
    without = " ".join(NO_NUMBER.values()).split()
    doors = {name.partition(" ")[0] for name in DOORS}
    assert sorted([*doors, *without]) == sorted(dir(ev))
    functions = [name for name in dir(ev) if callable(getattr(ev, name)) and name != "Scenario"]
    first = {name: [*inspect.signature(getattr(ev, name)).parameters][:1] for name in functions}
    taking = {name for name in functions if first[name] in (["scenario"], ["source"])}
    assert taking | {"plot.stack"} == {*VALUES, *READING}


SLOW = {"fit_laws"}
"""Functions that integrate over all parameters, for some ten seconds."""


def marked(names):
    """Return names of functions, or calls of commands, as parameters; those that take long are slow."""
    return [
        pytest.param(name, marks=pytest.mark.slow if name.split()[0].replace("-", "_") in SLOW else ())
        for name in names
    ]


@functools.cache
def computed(name):
    """Result of a function for the scenario itself, once for all that look at it."""
    return DOORS[name](SCENARIO)


@pytest.mark.usefixtures("blank_pictures")
@pytest.mark.parametrize("name", marked(DOORS))
def test_every_function_states_the_warning(name):
    if name in REFUSING:
        with pytest.raises(InputError, match=r"circuit\.return_path: a floating body"):
            REFUSING[name](SCENARIO)
        return
    found = computed(name)
    if isinstance(found, Path):
        assert WARNING in html.unescape(found.read_text(encoding="utf-8"))
    else:
        told = [each.state for each in diagnostics_of(found) if each.text.startswith(WARNING)]
        assert told == ["warning"]


TEXTS = ("preset", "text", "trace file")
"""Forms in which other tests of each function give a scenario all the time."""


def use(name, given):
    return READING[name](given) if name in READING else VALUES[name](DOORS[name](given))


@functools.cache
def expected(name):
    return use(name, SCENARIO) if name in READING else VALUES[name](computed(name))


@pytest.fixture(scope="module")
def forms(tmp_path_factory):
    folder, trace = tmp_path_factory.mktemp("forms"), ev.simulate(SCENARIO)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(paper("vezzoli_2014"), "scenarios", lambda: {"fig6": SCENARIO})
        path, stored = folder / "one.toml", folder / "one.NC"
        path.write_text(to_toml(SCENARIO), encoding="utf-8")
        ev.save(trace, stored)
        given = {"preset": PRESET, "text": str(path), "path": path, "trace": trace, "trace file": str(stored)}
        yield given | {"mapping": SCENARIO.to_dict()}


FORMS = ["mapping", "path", "trace", *(pytest.param(each, marks=pytest.mark.slow) for each in TEXTS)]


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("name", marked([*VALUES, *READING]))
def test_a_scenario_is_taken_in_every_form(name, form, forms):
    np.testing.assert_array_equal(use(name, forms[form]), expected(name))


def test_a_trace_file_gives_its_scenario_and_opens_as_a_trace(forms):
    assert ev.load(forms["trace file"]) == SCENARIO
    assert ev.load(forms["trace file"], changes={LOAD: "1 N"}).load.normal_force == 1
    assert ev.open_trace(forms["trace file"]).identical(forms["trace"])
    with pytest.raises(InputError, match=r"a Trace is opened from \.nc, \.mat, not from '\.toml'"):
        ev.open_trace(forms["path"])


def measured():
    return make_trace({"drive_voltage": (("time",), [0.0, 1.0])}, {"time": [0.0, 1.0]}, {"title": "measured"})


NO_SCENARIO = r"has no scenario 'fig66'. Did you mean 'vezzoli_2014/fig6' \("
WRONG = {
    "a number": (lambda: 3, "scenario = 3: expected a paper's scenario such as"),
    "nothing": (lambda: None, "scenario = None: expected"),
    "a list": (lambda: [PRESET], "scenario = .*: expected"),
    "no such paper": (lambda: "nobody_1900/fig1", "nobody_1900"),
    "no such scenario": (lambda: "vezzoli_2014/fig66", NO_SCENARIO),
    "no such file": (lambda: "none.toml", "none.toml: No such file"),
    "no such Trace": (lambda: "none.nc", "none.nc: there is no such file"),
    "a measurement": (measured, "carries no scenario: it is a measurement"),
    "a sweep": (lambda: ev.sweep(SCENARIO, LOADS), f"this Trace holds a sweep over {LOAD}, that is many"),
}
REPEATED = ("run", "init", "plot.stack")
"""What takes a sweep: it is repeated, or written and drawn as what it began from."""
ONE_READER = {"a number", "a list", "no such paper", "no such file", "no such Trace"}
"""Refused by the one function that reads scenarios, as the others of their kind are."""


@pytest.mark.parametrize(
    "wrong", [pytest.param(each, marks=pytest.mark.slow if each in ONE_READER else ()) for each in WRONG]
)
@pytest.mark.parametrize("name", [*VALUES, *READING])
def test_anything_else_is_refused_in_one_sentence(name, wrong, tmp_path):
    given, words = WRONG[wrong]
    if wrong == "a sweep" and name in REPEATED:
        assert {**READING, **DOORS}[name](given()) is not None
        return
    if (name, wrong) == ("perceive", "a measurement"):
        words = "no signal to feel"
    with pytest.raises(InputError, match=words) as caught:
        use(name, given())
    assert len(caught.value.problems) == 1
    assert not list(tmp_path.iterdir()), "nothing has been written"


FREE = f'--want "{MEAN} = 1 mN" --free "drive.amplitude=10 V:400 V"'
TARGET = '--target "sine 5 Hz 1 mN" --method carrier'
OVER = "--over drive.amplitude=50:100:2"
PATTERN = '{ model = "Grating", period = "1 mm", amplitude = "0.01 mN" }'
STUDY = "--space space.toml -n 4 --seed 1"
COMMANDS = [
    "bench run s.toml",
    "bench run s.toml --simulate -o t.csv",
    *(f"check s.toml -o out.{form}" for form in ("csv", "json", "html")),
    "compare s.toml -o out.html",
    "compare s.toml --materials silica",
    f"find-value s.toml {FREE} -o out.json",
    f"value-for-share s.toml {FREE} --space space.toml --share 0.9 --seed 1 -n 20 -o out.json",
    f"drive-for-force s.toml {TARGET} -o out.json",
    f"drive-for-force s.toml {TARGET} --edge line -o out.csv",
    *(f"plan-plate s.toml {OVER} -o out.{form}" for form in ("csv", "html")),
    f"texture-drive s.toml --texture '{PATTERN}' --path '100 mm/s' --carrier '3 kHz' --edge line -o out.csv",
    "export s.toml -o out.cir",
    "export s.toml --edge line -o out.csv",
    "fit s.toml r.nc --free contact.area -o out",
    "fit-laws s.toml r.nc --free contact.area --laws EffectiveMedium --seed 1 -o out",
    "fit-separately s.toml r.nc --free contact.area -o out",
    f"plan-experiment s.toml --models {','.join(LAWS)} --over {LOAD}=0.5:1:2 --space space.toml --quantity '{MEAN}' -n 4"
    " --noise '10 %' --noise '1 mN' -o out.html",
    "report s.toml -o out.html",
    "report s.toml t.nc -o out.html",
    *(f"run s.toml {option}" for option in ("", "--all", "--states", "-o out.csv --report out.html")),
    "run s.toml --over load.normal_force=0.4:0.6:2 -o out.csv --report out.html",
    f"study s.toml {STUDY} -o out.zarr -o out.csv -o out.html",
    f"study s.toml {STUDY} --sensitivity --quantity '{MEAN}' -o out",
]
"""Calls of commands that compute numbers from a scenario."""
WITHOUT_A_NUMBER = {
    *("bench init", "evidence", "explore", "fit-material", "fit-power-law"),
    *("import", "init", "list", "reproduce", "times"),
}
"""Commands that compute none from a scenario; `evidence`, the page of `explore` and `reproduce` are doors of their own."""
INPUTS = {"s.toml", "r.nc", "space.toml", "parameters.toml", "zarr.json"}
"""Files that hold no number that was computed, but what one is computed from; a study is read by `open_study`."""


def commands():
    """Return the names of all commands, those of a group after its name."""
    for name, command in typer.main.get_command(app).commands.items():
        inner = getattr(command, "commands", None)
        yield from [name] if inner is None else (f"{name} {each}" for each in inner)


def test_every_command_is_a_door_or_computes_nothing_from_a_scenario():
    called = {call.partition(" s.toml")[0] for call in COMMANDS}
    assert sorted([*called, *WITHOUT_A_NUMBER, *REFUSING_COMMANDS]) == sorted(commands())


SPECTRUM = '{ hurst = 0.8, longest = "1 mm", roll_off = "0.25 mm", shortest = "0.25 mm" }'
REFUSING_COMMANDS = {
    "fit-contact": f"s.toml c.csv --load 'load [N]' --capacitance 'C [F]' --roughness '{SPECTRUM}' -o out.csv"
}


@pytest.mark.parametrize("name", REFUSING_COMMANDS)
def test_a_command_refuses_a_floating_body_and_writes_nothing(name, capsys, monkeypatch):
    Path("s.toml").write_text(to_toml(SCENARIO), encoding="utf-8")
    points = zip(*CAPACITANCES.values(), strict=True)
    Path("c.csv").write_text("load [N],C [F]\n" + "".join(f"{load},{value}\n" for load, value in points))
    monkeypatch.setattr(sys, "argv", ["electrovib", name, *shlex.split(REFUSING_COMMANDS[name])])
    with pytest.raises(SystemExit) as stop:
        main()
    assert stop.value.code == 2
    assert "circuit.return_path: a floating body" in capsys.readouterr().err
    assert not Path("out.csv").exists()


@pytest.mark.usefixtures("blank_pictures")
@pytest.mark.parametrize("call", marked(COMMANDS))
def test_every_command_states_the_warning_once_and_in_each_of_its_files(call, capsys, monkeypatch):
    Path("s.toml").write_text(to_toml(SCENARIO), encoding="utf-8")
    lines = [
        f'"{path}" = {{{", ".join(f"{k} = {v!r}" for k, v in each.items())}}}' for path, each in SPACE.items()
    ]
    Path("space.toml").write_text("\n".join(["[space]", *lines]), encoding="utf-8")
    if "r.nc" in call:
        ev.save(record(), "r.nc")
    if "t.nc" in call:
        ev.save(ev.simulate(SCENARIO), "t.nc")
    monkeypatch.setattr(sys, "argv", ["electrovib", *shlex.split(call)])
    with pytest.raises(SystemExit) as stop:
        main()
    shown = capsys.readouterr()
    assert not stop.value.code, shown.err
    assert shown.out.count(WARNING) == 1, shown.out
    assert all(Path(each).exists() for each in re.findall(r" (?:-o|--report) (\S+)", call))
    for file in [each for each in Path().rglob("*") if each.is_file() and each.name not in INPUTS]:
        if file.suffix in {".csv", ".html", ".json", ".cir"}:
            assert WARNING in html.unescape(file.read_text(encoding="utf-8")), file


def test_a_reproduction_states_the_warnings(monkeypatch):
    own = {"one": SCENARIO, "again": SCENARIO, "another": SCENARIO.replace({LOAD: 2.0})}
    empty = Reproduction(paper="example_2099", citation="", rows=(), panels=())
    module = SimpleNamespace(scenarios=lambda: own, reproduce=lambda **_: empty)
    monkeypatch.setattr("electrovib.core.discovery.paper", lambda _: module)
    told = [each.text for each in ev.reproduce("example_2099", "out").diagnostics]
    (found,) = [text for text in told if text.startswith(WARNING)]
    assert "(scenario one, again" in found
    assert WARNING in html.unescape(Path("out/report.html").read_text(encoding="utf-8"))


def test_what_cannot_be_judged_says_so():
    changes = {"force": {"model": "Vezzoli2014PerFrequency"}, "time.initial_state": {"model": "AtRest"}}
    (found,) = validity(SCENARIO.replace(changes))
    assert found.state == "unknown"
    assert "is not causal" in found.text
    damaged = record().assign_attrs(validity='[{"name": "gap"')
    assert [each.state for each in diagnostics_of(damaged)] == ["unknown"]
    assert [each.state for each in ev.perceive(damaged).diagnostics] == ["unknown"]
