"""What IPython is given to show: by its own formatters, without a kernel."""

import html
import json
import re
import subprocess
import sys
from types import SimpleNamespace

import matplotlib.pyplot as plt
import numpy as np
import pytest
import xarray
from matplotlib.figure import Figure

import electrovib as ev
from electrovib.core.answer import Table
from electrovib.core.signals import make_trace
from electrovib.view.notebook import register

IPython = pytest.importorskip("IPython")


@pytest.fixture(scope="module")
def form():
    """Return what IPython's own formatters, with ours among them, make of an object."""
    from IPython.core.formatters import DisplayFormatter

    shown = DisplayFormatter()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(IPython, "get_ipython", lambda: None)
        assert not register()
        patch.setattr(IPython, "get_ipython", lambda: SimpleNamespace(display_formatter=shown))
        assert register()
    return shown.format


@pytest.fixture(scope="module")
def shown(form):
    """Return the HTML of an object, its text without tags and pictures, and its plain text."""

    def call(given):
        data, _ = form(given)
        text = re.sub(r"<[^>]*>", " ", data["text/html"].replace("<wbr>", ""))
        return data["text/html"], " ".join(text.split()), data["text/plain"]

    return call


@pytest.fixture(scope="module")
def scenario():
    return ev.load("vezzoli_2014/fig6").replace({"title": "<b>own</b>", "frequency.samples": 5})


@pytest.fixture(scope="module")
def trace(scenario):
    return ev.simulate(scenario)


def in_order(text, *words):
    places = [text.index(each) for each in words]
    return places == sorted(places)


def test_a_scenario_shows_stack_and_parameters(shown, scenario):
    page, text, _ = shown(scenario)
    assert in_order(text, "finger", "stratum corneum", "insulator", "plate electrode")
    for words in ("90 µm", "1 kV", "Vezzoli 2014, section 3.1", "voltage of the hold"):
        assert words in text
    assert in_order(text, "drive.high 1 kV", "parameters keep their defaults", "drive.delay 0 s")
    assert "contact.length" not in text  # optional, and absent
    assert "&lt;b&gt;own&lt;/b&gt;" in page
    assert "<b>own" not in page
    # the law of figure 6 has no such layer; the stress in the insulator has
    assert "evaluated here" not in text
    other = shown(scenario.replace({"force.model": "MaxwellStressInInsulator"}))[1]
    assert in_order(other, "insulator", "evaluated here", "plate electrode")


def test_what_is_unverified_is_marked_and_a_material_of_the_library_named(shown, scenario):
    assert "unverified" not in shown(scenario)[1]
    sources = scenario.sources | {"drive.rise": "a textbook, cited from memory, unverified"}
    text = shown(scenario.model_copy(update={"sources": sources}))[1]
    assert "1 entry of this scenario" in text
    assert "unverified a textbook" in text
    silica, polyimide = (
        shown(scenario.replace({"stack.insulator.material": name}))[1] for name in ("silica", "polyimide")
    )
    assert "silica, Constant: ε = 3.9" in silica
    assert "unverified" not in silica
    assert polyimide.count("unverified set by the user to polyimide") == 2  # permittivity and conductivity
    assert "force Persson2018RoughGap unverified" in shown(ev.load("persson_2018/coating"))[1]


def test_a_trace_shows_its_warnings_first(shown, scenario, trace):
    page, text, plain = shown(trace)
    peak = float(trace["electrostatic_force"].max())
    assert in_order(text, "warning", "Validity:", "largest drive voltage 1 kV")
    for words in ("above 661 V", "Validity: 1 warning, 5 ok", f"{1e3 * peak:.4g} mN"):
        assert words in text
    assert "time (2001), layer (2), frequency (5)" in text
    assert "data:image/png;base64," in page
    assert "&lt;b&gt;own" in page
    lines = plain.splitlines()
    assert lines[0] == "Trace: <b>own</b>"
    assert lines[1].startswith("warning: the voltage across the stack reaches 1 kV, above 661 V")
    assert lines[2] == "validity: 1 warning, 5 ok"
    assert len(lines) < 15
    page, text, plain = shown(ev.simulate(scenario.replace({"drive.high": "10 V"})))
    assert "warning" not in plain
    assert in_order(page, "<details>", "largest")
    assert "Validity: 6 ok" in text


def test_whatever_is_taken_from_a_trace_is_shown(shown, trace):
    """One signal, one layer, one time, no time at all, no coordinates, numbers that are not known, a damaged entry."""
    text = shown(trace[["current"]])[1]
    assert "largest current into the contact" in text
    assert "1 variable name" in text
    assert "Dimensions: frequency (5)" in shown(trace[["mean_force"]])[1]
    plain = shown(trace.isel(layer=0))[2]
    assert "largest drive voltage: 1 kV" in plain
    assert "largest field" not in plain
    assert "dimensions: layer (2), frequency (5)" in shown(trace.isel(time=0))[2]
    for part in (trace.isel(time=[]), trace.isel(time=[3]), trace.drop_vars("time"), trace.where(False)):
        page, _, plain = shown(part)
        assert "electrovib-trace" in page
        assert plain.splitlines()[-1].startswith("dimensions: ")
    assert "largest drive voltage" in shown(trace.assign_attrs(validity="["))[0]


def test_a_measured_trace_shows_its_sentences(shown):
    values, sentences = np.linspace(0.0, 1.0, 5), "The finger slides 80.0 mm.\nThe recording holds 2 swipes."
    signals = {"lateral_force_measured": (("time",), values)}
    page, _, plain = shown(make_trace(signals, {"time": values}, {"source": "a.mat", "words": sentences}))
    assert plain == f"Trace: a.mat\n{sentences}\ndimensions: time (5)"
    assert "<p>The finger slides 80.0 mm.</p>" in page


def test_a_sweep_shows_its_quantities(form, shown, scenario):
    swept = ev.sweep(scenario, {"drive.high": [100.0, 200.0]}, quantity=["peak electrostatic_force"])
    page, text, _ = shown(swept)
    assert text.startswith("Sweep: &lt;b&gt;own")
    assert "at drive.high = 100 V" in text
    assert "drive.high 100 V … 200 V (2 values)" in text
    assert "data:image/png;base64," in page
    assert "data:image" not in shown(swept.drop_vars("peak electrostatic_force"))[0]
    nothing = form(swept.isel({"drive.high": []}))[0]
    assert "drive.high (0)" in nothing["text/plain"]
    assert "(0 values)" in nothing["text/html"]


def test_another_dataset_is_shown_as_xarray_does(shown, trace):
    for other in (xarray.Dataset({"a": ("x", np.zeros(3))}), trace.max()):
        page, _, plain = shown(other)
        assert plain == repr(other)
        assert "xarray.Dataset" in page
        assert "electrovib-trace" not in page


def test_a_plot_is_a_picture_and_one_of_pyplot_is_left_to_it(form, trace):
    data, metadata = form(ev.plot.force(trace, ax=Figure(figsize=(3, 2)).add_subplot()))
    assert data["image/png"].startswith(b"\x89PNG")
    assert metadata["image/png"] == {"width": 288, "height": 192}
    axes = ev.plot.force(trace, ax=plt.figure().add_subplot())
    assert "image/png" not in form(axes)[0]
    plt.close(axes.figure)


def test_catalogues_tables_and_compared_materials_are_tables(shown, scenario):
    for listed, name in ((ev.models(), "Trapezium"), (ev.scenarios(), "vezzoli_2014/fig6")):
        page, text, plain = shown(listed)
        assert "<th>" in page
        assert name in text
        assert plain == repr(listed).rstrip()
    page, _, plain = shown(Table("A <title>", ("name", "value"), (("a", "1 V"), ("b & c", "2 V"))))
    assert "<td>b &amp; c</td>" in page
    assert "b & c  2 V" in plain.splitlines()
    compared = ev.compare_materials(scenario, materials=["silica"])
    page, text, plain = shown(compared)
    assert page.count("<table>") == len(compared.tables)
    assert "silica" in text
    assert "silica" in plain
    assert "MaterialComparison" not in plain


@pytest.mark.parametrize("verb", [ev.compare, ev.check, ev.perceive])
def test_an_answer_is_shown_and_not_its_arrays(shown, verb):
    """The answer comes first; the fields of a comparison of laws would be 157 kB of numbers."""
    found = verb("vezzoli_2014/fig6")
    page, _, plain = shown(found)
    assert "array(" not in plain
    assert len(plain) < 5_000
    lines = plain.splitlines()
    assert page.startswith(f"<p>{html.escape(lines[0])}</p>")
    assert page.count("<table>") == len(found.document.tables)
    if verb is ev.perceive:
        assert lines[1].startswith("felt or not: undecided within the spread, Pacinian channel: ")
        assert len(lines) < 11


SCRIPT = """
import json, sys
import IPython
from IPython.core.formatters import DisplayFormatter
from types import SimpleNamespace
shown = DisplayFormatter()
IPython.get_ipython = lambda: SimpleNamespace(display_formatter=shown)
before = set(sys.modules)
import electrovib
names = [key[1] for key in shown.formatters["text/html"].deferred_printers]
print(json.dumps([sorted(set(sys.modules) - before), names]))
"""


def test_importing_in_ipython_imports_nothing_heavy():
    """Registration names types; it loads neither xarray nor matplotlib nor this package's models."""
    command = [sys.executable, "-c", SCRIPT]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=True)
    loaded, names = json.loads(done.stdout.splitlines()[-1])
    view = "electrovib.view"
    assert set(loaded) == {"electrovib", view, f"{view}.notebook"}
    assert {"Scenario", "Dataset"} <= set(names)
