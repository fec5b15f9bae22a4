"""Every kind of answer: its sentences, warnings, tables and files are the same in text, notebook, page and folder."""

import copy
import functools
import html
import importlib
import pickle
import pkgutil
import tempfile
from dataclasses import FrozenInstanceError, fields, is_dataclass

import numpy as np
import pytest
import xarray
from matplotlib.figure import Figure

import electrovib as ev
from electrovib.core.answer import Answer, Curve, Document, Drawing, Panel, Table, laid_out
from electrovib.core.diagnostics import warning_lines
from electrovib.core.errors import InputError
from electrovib.core.signals import make_trace
from electrovib.core.unchangeable import FrozenDict
from electrovib.data.atomic import Form, is_ours
from electrovib.physics.contact import LinearSpring
from electrovib.physics.material import Debye
from electrovib.recordings.importing.own_material import SampleSpectrum
from electrovib.recordings.spectra.fitted import fit_samples
from electrovib.solve.equilibrium import equilibrium
from electrovib.studies.reproduction import Reproduction, Row
from electrovib.view.files import check_answer
from electrovib.view.pages import parts

SINE = "bau_2010/sine"
MEAN = "mean electrostatic_force"
LIMITS = {"limits.voltage": "1 kV", "limits.current": "10 mA"}
GAP = "stack.gap.thickness"


def spectrum():
    """Impedance of the plate with 1 % of noise."""
    grid = {"frequency.low": 1.0, "frequency.high": 1e5, "frequency.samples": 25}
    exact = ev.simulate(ev.load(SINE).replace(grid))
    rng, clean = np.random.default_rng(3), exact["impedance"].values
    noise = 0.01 * np.abs(clean) * (rng.normal(size=clean.size) + 1j * rng.normal(size=clean.size))
    axis = exact["frequency"].values
    return make_trace({"impedance": (("frequency",), clean + noise)}, {"frequency": axis}, {})


def edges():
    """A force that rises twice within 10 ms."""
    time = np.linspace(0.0, 0.4, 4001)
    up = (np.interp(time, at + np.array([0.0, 0.01, 0.1, 0.11]), [0.0, 1.0, 1.0, 0.0]) for at in (0.05, 0.25))
    values = sum(up) + 1e-3 * np.random.default_rng(1).normal(size=time.size)
    return make_trace({"lateral_force_measured": (("time",), values)}, {"time": time}, {})


def swipe():
    """One slide of a finger under 0.5 N with a friction coefficient of 0.4, between two rests of the sensors."""
    time = np.linspace(0.0, 2.0, 4001)
    inside = np.interp(time, [0.5, 0.55, 1.45, 1.5], [0.0, 1.0, 1.0, 0.0])
    rng = np.random.default_rng(2)
    signals = {
        f"{name}_force_measured": (("time",), size * inside + 1e-3 * rng.normal(size=time.size))
        for name, size in (("normal", 0.5), ("lateral", 0.2))
    }
    return ev.reduce_swipes(make_trace(signals, {"time": time}, {}))


def ring():
    """An oscillation of 380 Hz and a quality factor of 3 after an impact."""
    time = np.arange(0.0, 0.2, 5e-5)
    since = np.maximum(time - 0.05, 0.0)
    values = (time > 0.05) * np.exp(-np.pi * 380 / 3 * since) * np.sin(2 * np.pi * 380 * since)
    values += 1e-3 * np.random.default_rng(5).normal(size=time.size)
    return make_trace({"lateral_force_measured": (("time",), values)}, {"time": time}, {})


PRESSED = {
    "contact.surface": {"model": "LinearSpring", "stiffness": "1 GPa/m", "free_gap": "10 um"},
    "stack.gap.material.conductivity": 0.0,
}


def skin():
    """Permittivity of a material of Debye with 1 % of noise."""
    frequency = np.geomspace(10.0, 1e5, 25)
    noise = 1 + 0.01 * np.random.default_rng(4).normal(size=frequency.size)
    permittivity = Debye(
        permittivity_high=100.0, strength=900.0, relaxation_time=1e-4, conductivity=1e-6
    ).complex_permittivity(frequency)
    return SampleSpectrum(
        frequency=frequency, permittivity=permittivity * noise, thickness=1e-4, history=(), diagnostics=()
    )


def exported():
    """A sine with ramps, joined by straight lines."""
    with tempfile.TemporaryDirectory() as folder:
        return ev.export_waveform(SINE, f"{folder}/a.csv", set=LIMITS, edge="line", ramp=1e-3)


def reproduced():
    """One number of a paper beside ours, a check, and a curve of two points."""
    rows = (
        Row("C", "capacitance", 32.0, 32.4, "pF", "reproduced", ""),
        Row("sum", "sum of charges", None, 0.0, "1", "check", ""),
    )
    ends = np.array([0.0, 1.0])
    panel = Panel(
        id="fig", title="Force", caption="", x=("time", "s"), y=("force", "N"),
        curves=(Curve(label="a", x=ends, y=ends),),
    )  # fmt: skip
    return Reproduction(paper="nobody_2099", citation="N. N. 2099", rows=rows, panels=(panel,))


@functools.cache
def contact_fit():
    return ev.fit_contact(
        SINE,
        load=[0.1, 0.3, 1.0, 3.0],
        capacitance=[3e-10, 4e-10, 6e-10, 1e-9],
        roughness=ev.SelfAffine(rms=2e-6, hurst=0.8, longest=1e-3, roll_off=2.5e-4, shortest=2.5e-4),
        body=ev.Elastic(modulus=1e6),
        draws=2,
    )


ANSWERS = {
    "Comparison": lambda: ev.compare(SINE, models=["MaxwellStressInGap", "MaxwellStressInInsulator"]),
    "MaterialComparison": lambda: ev.compare_materials(SINE, materials=["silica"]),
    "CheckResult": lambda: ev.check(SINE, limits={"voltage": "1 kV"}),
    "SeriesResistor": lambda: ev.series_resistor(SINE, limits={"current": "1 mA"}),
    "Sensitivity": lambda: ev.sensitivity(SINE, "fingers", quantity=MEAN, n=4, seed=1),
    "PlateDesign": lambda: ev.plan_plate(SINE, {"drive.amplitude": [50.0, 100.0]}, refine=0),
    "DesignedParameter": lambda: ev.find_value(SINE, want=f"{MEAN} = 1 mN", free="drive.amplitude"),
    "DesignedDrive": lambda: ev.drive_for_force(SINE, target="sine 5 Hz 1 mN", method="carrier", set=LIMITS),
    "DesignedForShare": lambda: ev.value_for_share(
        SINE, want=f"{MEAN} = 1 mN", free="drive.amplitude", space="fingers", share=0.9, seed=1, n=20
    ),
    "Percept": lambda: ev.perceive(SINE),
    "TextureDrive": lambda: ev.texture_drive(
        SINE,
        texture={"model": "Grating", "period": "2 mm", "amplitude": "0.5 mN"},
        path="50 mm/s",
        carrier="3 kHz",
        set=LIMITS,
    ),
    "Evidence": lambda: ev.evidence("vezzoli_2014/swing", n=4),
    "ExperimentPlan": lambda: ev.plan_experiment(
        SINE,
        ["MaxwellStressInGap", "MaxwellStressInInsulator"],
        over={"drive.amplitude": [10.0, 20.0]},
        space="fingers",
        quantity=MEAN,
        n=8,
    ),
    "FitResult": lambda: ev.fit(SINE, spectrum(), free=[GAP], progress=lambda *_: None),
    "SeparateFits": lambda: ev.fit_separately(SINE, [spectrum()], free=[GAP]),
    "MeasuredTimes": lambda: ev.measure_times(edges(), quantity="lateral_force_measured"),
    "MeasuredRing": lambda: ev.measure_ring(ring()),
    "MeasuredRings": lambda: ev.measure_rings(ring()),
    "SwipeResult": lambda: swipe()[0],
    "Swipes": swipe,
    "BenchPlan": lambda: ev.plan_bench("vezzoli_2014/fig6"),
    "Balance": lambda: equilibrium(ev.load("vezzoli_2014/fig6_gap", changes=PRESSED)),
    "PowerLawFit": lambda: ev.fit_power_law(
        [1, 2, 3, 4, 5, 6], [1, 4, 9, 15, 25, 37], session=list("aaabbb")
    ),
    "FittedMaterial": lambda: fit_samples({"skin": skin()}, form="debye"),
    "WrittenWaveform": exported,
    "RestingContact": lambda: ev.rough_contact(
        SINE,
        roughness=ev.SelfAffine(rms=2e-6, hurst=0.8, longest=1e-3, roll_off=2.5e-4, shortest=1.25e-4),
        body=ev.Elastic(modulus=1e7),
        voltage=[0.0, 20.0],
    ),
    "Difference": lambda: ev.compare_percepts(
        ev.perceive(SINE), ev.perceive(SINE, set={"drive.amplitude": 10.0})
    ),
    "Hysteresis": lambda: ev.hysteresis(
        [0.0, 100.0, 200.0],
        surface=LinearSpring(stiffness=1e9, free_gap=10e-6),
        pressure=200.0,
        electrical_thickness=1e-6,
    ),
    "Reproduction": reproduced,
    "ContactFit": contact_fit,
    "ContactPrediction": lambda: contact_fit().predict(voltage=[10.0, 20.0], measured=[0.01, 0.04]),
    "StudyResult": lambda: ev.study(SINE, "fingers", n=8, seed=1, exceed="1 mN"),
}
"""Name of a class to an answer of it, or of a class below it."""


@functools.cache
def answer(name):
    """Compute an answer once for all that look at it: none can be changed."""
    return ANSWERS[name]()


@pytest.fixture(scope="module", params=ANSWERS)
def found(request):
    return answer(request.param)


def kinds(of=Answer):
    for each in of.__subclasses__():
        yield each
        yield from kinds(each)


def test_every_kind_of_answer_is_here():
    for module in pkgutil.walk_packages(ev.__path__, "electrovib."):
        if not module.name.endswith("__main__"):
            importlib.import_module(module.name)
    own = [each for each in kinds() if each.__module__.startswith("electrovib.")]
    leaves = {each.__name__ for each in own if not each.__subclasses__()}
    assert leaves >= {"Comparison", "Sensitivity", "PlateDesign"}
    assert leaves <= set(ANSWERS), "an answer without a test"


def members(value):
    """Return the parts of a container or of a frozen dataclass by their paths; tables of xarray are the user's own."""
    if isinstance(value, dict):
        return {f"[{name!r}]": each for name, each in value.items()}
    if isinstance(value, (list, tuple)):
        return {f"[{place}]": each for place, each in enumerate(value)}
    if is_dataclass(value) and value.__dataclass_params__.frozen:
        return {f".{each.name}": getattr(value, each.name) for each in fields(value)}
    return {}


def changeable(value, path, seen):
    """Yield the paths of all that can be changed in place."""
    if id(value) in seen:
        return
    seen[id(value)] = value
    array = isinstance(value, np.ndarray) and value.flags.writeable
    if array or isinstance(value, list) or (isinstance(value, dict) and not isinstance(value, FrozenDict)):
        yield path
    for name, each in members(value).items():
        yield from changeable(each, path + name, seen)


def test_an_answer_cannot_be_changed_afterwards(found):
    if isinstance(found, (xarray.Dataset, tuple)):
        return  # a table of xarray is the user's own, and a tuple has no fields
    assert list(changeable(found, type(found).__name__, {})) == []
    with pytest.raises(FrozenInstanceError):
        setattr(found, fields(found)[0].name, None)


def test_plans_waveforms_and_scenarios_cannot_be_changed_afterwards(tmp_path):
    plan = ev.plan_bench("vezzoli_2014/fig6")
    written = ev.export_waveform(SINE, tmp_path / "a.csv", set=LIMITS, edge="line", ramp=1e-3)
    assert list(changeable(plan, "plan", {})) == list(changeable(written, "written", {})) == []
    with pytest.raises(ValueError, match="read-only"):
        plan.codes[3] = 2047
    scenario = ev.load(SINE)
    other = scenario.stack.layers["insulator"]
    for mapping in (scenario.stack.layers, scenario.sources):
        for change in (
            lambda each: each.__setitem__("insulator", other),
            lambda each: each.update(insulator=other),
            lambda each: each.__ior__({"insulator": other}),
            lambda each: each.setdefault("more", other),
            lambda each: each.clear(),
            lambda each: each.popitem(),
            lambda each: each.pop("insulator"),
            lambda each: each.__delitem__("insulator"),
        ):
            with pytest.raises(InputError, match="not changed in place; replace returns"):
                change(mapping)
        for same in (copy.copy(mapping), copy.deepcopy(mapping), pickle.loads(pickle.dumps(mapping))):
            assert same == mapping == dict(mapping)
        assert type(mapping | {}) is dict
    for same in (copy.copy(scenario), copy.deepcopy(scenario), pickle.loads(pickle.dumps(scenario))):
        assert (same, hash(same), same.sources) == (scenario, hash(scenario), scenario.sources)
    assert ev.load(scenario.to_dict()) == scenario
    changed = scenario.replace({"drive.amplitude": 3.0})
    with pytest.raises(InputError, match="not changed in place"):
        changed.sources["drive.amplitude"] = "nobody"


def test_an_answer_is_pickled_and_copied(found):
    for again in (pickle.loads(pickle.dumps(found)), copy.deepcopy(found), copy.copy(found)):
        assert type(again) is type(found)
        assert again.document.text == found.document.text


@pytest.mark.parametrize("listed", [ev.models, ev.scenarios, ev.spaces])
def test_a_listing_is_pickled_and_copied(listed):
    whole = listed()
    for again in (pickle.loads(pickle.dumps(whole)), copy.deepcopy(whole), copy.copy(whole)):
        assert repr(again) == repr(whole)
        assert again._repr_html_() == whole._repr_html_()
        assert [each.name for each in again] == [each.name for each in whole]
        if listed is ev.models:
            assert [each.thing for each in again if each.kind == "paper"] == [
                each.thing for each in whole if each.kind == "paper"
            ]


@pytest.fixture(scope="module")
def written(found, tmp_path_factory, blank):
    """Save an answer as a folder, once for all tests of it; the figures, which take most of the time, are of test_figures.py."""
    with blank():
        return ev.save(found, tmp_path_factory.mktemp("saved") / "answer")


def test_text_notebook_and_page_say_the_same(found, written):
    said = found.document
    assert said.title
    assert said.sentences or said.tables
    shown = html.unescape(written[0].read_text())
    warnings = [line for line in warning_lines(said.diagnostics) if line.startswith("warning")]
    in_notebook = html.unescape(found._repr_html_())
    for text in [*said.sentences, *warnings]:
        assert text in repr(found)
        assert text in in_notebook
    for table in said.tables:
        assert table.title in in_notebook
        tag = "summary" if table.folded else "h2"
        assert f"<{tag}>{table.title}</{tag}>" in shown.replace("µ", "u").replace("Ω", "ohm")
        assert {len(row) for row in table.rows} <= {len(table.headings)}
    assert said.title in shown
    assert is_ours(written[0], Form.PAGE)


@pytest.mark.usefixtures("blank_pictures")
def test_a_folder_holds_the_page_and_all_files(found, written, tmp_path):
    figures = [f"{part.id}.pdf" for each in found.document.figures for part in parts(each)]
    assert [path.name for path in written] == ["report.html", *found.files, *figures]
    firsts = {path.suffix: path for path in reversed(written)}
    for path in written[1:]:
        form = found.files.get(path.name, Form.FIGURE)
        assert form is None or is_ours(path, Form(form)), path.name
        if firsts[path.suffix] == path and path.suffix != ".pdf":
            (alone,) = ev.save(found, tmp_path / f"alone{path.suffix}")
            assert alone.read_bytes() == path.read_bytes()


@pytest.mark.parametrize("name", ["Swipes", "MaterialComparison"])
def test_a_page_and_the_main_figure_alone_are_those_of_the_folder_which_only_force_replaces(
    name, tmp_path, monkeypatch
):
    """The main figure of the one is its first, that of the other its last; a figure is its name, which takes no time."""

    def named(part):
        figure = Figure((1, 1))
        figure.add_subplot().set_title(part.id)
        return figure

    for module in ("pages", "files"):
        monkeypatch.setattr(f"electrovib.view.{module}.drawn", named)
    found = answer(name)
    folder = tmp_path / "answer"
    written = ev.save(found, folder)
    main = folder / f"{parts(found.document.main)[0].id}.pdf"
    for path in (folder / "report.html", main):
        (alone,) = ev.save(found, tmp_path / f"alone{path.suffix}")
        assert alone.read_bytes() == path.read_bytes()
    (folder / "report.html").write_text("mine")
    before = {path: path.read_bytes() for path in written}
    with pytest.raises(InputError, match=r"report\.html: exists already and is no HTML page"):
        ev.save(found, folder)
    assert {path: path.read_bytes() for path in written} == before
    ev.save(found, folder, force=True)
    assert is_ours(folder / "report.html", Form.PAGE)


def test_other_suffixes_are_refused_before_the_computation(found, tmp_path):
    for write in (ev.save, lambda found, path: check_answer(type(found), path)):
        with pytest.raises(InputError, match=r"out\.gif: this result is written as \.html.*without a suffix"):
            write(found, tmp_path / "out.gif")
    assert not list(tmp_path.iterdir())


FORMER = {
    "MeasuredTimes": {"words"},
    "MeasuredRing": {"words"},
    "MeasuredRings": {"words"},
    "SwipeResult": {"words"},
    "DesignedParameter": {"answer", "verdict", "lines"},
}
"""Attributes that sentences, warnings and remarks of the document are in place of."""


@pytest.mark.parametrize(
    ("kind", "name"), [(kind, name) for kind, names in FORMER.items() for name in sorted(names)]
)
def test_a_former_attribute_warns_and_holds_what_the_document_says(kind, name):
    found = answer(kind)
    with pytest.warns(DeprecationWarning, match=f"{kind}.{name} is deprecated .* use document"):
        held = getattr(found, name)
    shown = found.document.shown(everything=True)
    for text in held.split(". ") if isinstance(held, str) else held:
        assert text in shown


class Sketch(Answer):
    FILES = {"a.csv": Form.TABLE, "b.csv": Form.TABLE}  # noqa: RUF012

    @property
    def document(self):
        figure = Drawing(id="f", title="Its figure", plot="stack", of=ev.load(SINE), size=(3.0, 2.0))
        table = Table("Numbers", ("a",), (("1",),))
        return Document(title="t", sentences=["one", "two"], figures=[figure], tables=[table], remarks=["r"])


def test_remarks_follow_warnings_and_tables_follow_sentences():
    assert [line.strip() for line in repr(Sketch()).splitlines()] == [
        "one",
        "two",
        "",
        "Numbers",
        "-------",
        "a",
        "1",
        "",
        "r",
    ]


def test_a_long_last_cell_is_wrapped_under_its_own_column(monkeypatch):
    monkeypatch.setenv("COLUMNS", "90")
    words = " ".join(f"word{number}" for number in range(30))
    _, _, heading, *lines = laid_out(
        Table("A title", ("name", "value", "why"), (("a", "1 V", words),))
    ).splitlines()
    column = heading.index("why")
    assert len(lines) > 2
    assert all(line[column:].startswith("word") and len(line) <= 90 for line in lines)
    assert {line[:column].strip() for line in lines[1:]} == {""}
    assert " ".join(line[column:] for line in lines) == words
