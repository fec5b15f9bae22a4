"""What IPython is given to show: by its own formatters, without a kernel."""

from __future__ import annotations

import html
import json
import re
import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest
import xarray
from matplotlib.figure import Figure

import electrovib as ev
from electrovib.core.trace import make_trace
from electrovib.study.reproduction import Table
from electrovib.view.notebook import register

IPython = pytest.importorskip("IPython")


@pytest.fixture(scope="module")
def formatter():
    """IPython's own formatters, with ours registered among them."""
    from IPython.core.formatters import DisplayFormatter

    shown = DisplayFormatter()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(IPython, "get_ipython", lambda: SimpleNamespace(display_formatter=shown))
        assert register()
    return shown


@pytest.fixture(scope="module")
def scenario():
    return ev.load("vezzoli_2014/fig6").replace({"title": "<b>own</b>", "frequency.samples": 5})


@pytest.fixture(scope="module")
def trace(scenario):
    return ev.simulate(scenario)


@pytest.fixture(scope="module")
def swept(scenario):
    return ev.sweep(scenario, {"drive.high": [100.0, 200.0]}, quantities=["peak electrostatic_force"])


def words(html):
    """Text of HTML, without tags and pictures."""
    return " ".join(re.sub(r"<[^>]*>", " ", html.replace("<wbr>", "")).split())


def test_nothing_is_registered_without_a_shell(monkeypatch):
    monkeypatch.setattr(IPython, "get_ipython", lambda: None)
    assert not register()


def test_a_scenario_shows_stack_and_parameters(formatter, scenario):
    html = formatter.format(scenario)[0]["text/html"]
    text = words(html)
    assert (
        text.index("finger")
        < text.index("stratum corneum")
        < text.index("insulator")
        < text.index("plate electrode")
    )
    assert "90 µm" in text
    assert "1 kV" in text
    assert "Vezzoli 2014, section 3.1" in text
    assert "voltage of the hold" in text
    assert (
        text.index("drive.high 1 kV")
        < text.index("parameters keep their defaults")
        < text.index("drive.delay 0 s")
    )
    assert "contact.length" not in text  # optional, and absent
    assert "&lt;b&gt;own&lt;/b&gt;" in html
    assert "<b>own" not in html


def test_the_layer_in_which_the_stress_is_evaluated_is_marked(formatter, scenario):
    """The law of figure 6 has none; the Maxwell stress in the insulator has."""
    assert "evaluated here" not in formatter.format(scenario)[0]["text/html"]
    other = scenario.replace({"force.model": "MaxwellStressInInsulator"})
    text = words(formatter.format(other)[0]["text/html"])
    assert text.index("insulator") < text.index("evaluated here") < text.index("plate electrode")


def test_what_is_unverified_is_marked(formatter, scenario):
    assert "unverified" not in formatter.format(scenario)[0]["text/html"]
    told = scenario.model_copy(
        update={"sources": scenario.sources | {"drive.rise": "a textbook, cited from memory, unverified"}}
    )
    text = words(formatter.format(told)[0]["text/html"])
    assert "1 entry of this scenario" in text
    assert "unverified a textbook" in text


def test_a_material_of_the_library_is_named_with_its_status(formatter, scenario):
    text = words(formatter.format(scenario.replace({"stack.insulator.material": "silica"}))[0]["text/html"])
    assert "silica, Constant: ε = 3.9" in text
    assert "unverified" not in text
    text = words(
        formatter.format(scenario.replace({"stack.insulator.material": "polyimide"}))[0]["text/html"]
    )
    assert text.count("unverified set by the user to polyimide") == 2  # permittivity and conductivity


def test_an_unverified_model_is_marked(formatter):
    rough = ev.load("persson_2018/coating")
    text = words(formatter.format(rough)[0]["text/html"])
    assert re.search(r"force Persson2018RoughGap unverified", text)


def test_a_trace_shows_its_warnings_first(formatter, trace):
    data, _ = formatter.format(trace)
    text = words(data["text/html"])
    peak = float(trace["electrostatic_force"].max())
    assert text.index("warning") < text.index("Validity:") < text.index("largest drive voltage 1 kV")
    assert "above 661 V" in text
    assert "Validity: 1 warning, 4 ok" in text
    assert f"{1e3 * peak:.4g} mN" in text
    assert "time (2001), layer (2), frequency (5)" in text
    assert "data:image/png;base64," in data["text/html"]
    assert "&lt;b&gt;own" in data["text/html"]
    lines = data["text/plain"].splitlines()
    assert lines[0] == "Trace: <b>own</b>"
    assert lines[1].startswith("warning: the voltage across the stack reaches 1 kV, above 661 V")
    assert lines[2] == "validity: 1 warning, 4 ok"
    assert len(lines) < 15


def test_a_trace_without_warnings_opens_with_its_numbers(formatter, scenario):
    quiet = ev.simulate(scenario.replace({"drive.high": "10 V"}))
    data, _ = formatter.format(quiet)
    assert "warning" not in data["text/plain"]
    assert data["text/html"].index("<details>") < data["text/html"].index("largest")
    assert "Validity: 5 ok" in words(data["text/html"])


def test_a_part_of_a_trace_is_still_shown(formatter, trace):
    text = words(formatter.format(trace[["current"]])[0]["text/html"])
    assert "largest current into the contact" in text
    assert "1 variable name" in text
    over_frequency = trace[["mean_force"]]
    assert "Dimensions: frequency (5)" in words(formatter.format(over_frequency)[0]["text/html"])


def test_whatever_is_taken_from_a_trace_is_shown(formatter, trace, swept):
    """One layer, one time, no time at all, no coordinates, numbers that are not known, another name."""
    layer = formatter.format(trace.isel(layer=0))[0]
    assert "largest drive voltage: 1 kV" in layer["text/plain"]
    assert "largest field" not in layer["text/plain"]
    assert "dimensions: layer (2), frequency (5)" in formatter.format(trace.isel(time=0))[0]["text/plain"]
    for part in (trace.isel(time=[]), trace.isel(time=[3]), trace.drop_vars("time"), trace.where(False)):
        data, _ = formatter.format(part)
        assert "electrovib-trace" in data["text/html"]
        assert data["text/plain"].splitlines()[-1].startswith("dimensions: ")
    assert "drive.high (0)" in formatter.format(swept.isel({"drive.high": []}))[0]["text/plain"]


def test_a_measured_trace_shows_its_sentences(formatter):
    values = np.linspace(0.0, 1.0, 5)
    attributes = {"source": "a.mat", "words": "The finger slides 80.0 mm.\nThe recording holds 2 swipes."}
    measured = make_trace({"lateral_force_measured": (("time",), values)}, {"time": values}, attributes)
    data, _ = formatter.format(measured)
    lines = [
        "Trace: a.mat",
        "The finger slides 80.0 mm.",
        "The recording holds 2 swipes.",
        "dimensions: time (5)",
    ]
    assert data["text/plain"].splitlines() == lines
    assert "<p>The finger slides 80.0 mm.</p>" in data["text/html"]


def test_a_damaged_diagnostic_does_not_hide_a_trace(formatter, trace):
    damaged = trace.assign_attrs(validity="[")
    assert "largest drive voltage" in formatter.format(damaged)[0]["text/html"]


def test_a_sweep_shows_its_quantities(formatter, swept):
    data, _ = formatter.format(swept)
    text = words(data["text/html"])
    assert text.startswith("Sweep: &lt;b&gt;own")
    assert "at drive.high = 100 V" in text
    assert "drive.high 100 V … 200 V (2 values)" in text
    assert "data:image/png;base64," in data["text/html"]
    fewer = formatter.format(swept.drop_vars("peak electrostatic_force"))[0]
    assert "data:image" not in fewer["text/html"]


def test_another_dataset_is_shown_as_xarray_does(formatter, trace):
    for other in (xarray.Dataset({"a": ("x", np.zeros(3))}), trace.max()):
        data, _ = formatter.format(other)
        assert data["text/plain"] == repr(other)
        assert "xarray.Dataset" in data["text/html"]
        assert "electrovib-trace" not in data["text/html"]


def test_a_plot_is_a_picture(formatter, trace):
    axes = ev.plot.force(trace, ax=Figure(figsize=(3, 2)).add_subplot())
    data, metadata = formatter.format(axes)
    assert data["image/png"].startswith(b"\x89PNG")
    assert metadata["image/png"] == {"width": 288, "height": 192}


def test_a_plot_of_pyplot_is_left_to_pyplot(formatter, trace):
    import matplotlib.pyplot as plt

    axes = ev.plot.force(trace, ax=plt.figure().add_subplot())
    try:
        assert "image/png" not in formatter.format(axes)[0]
    finally:
        plt.close(axes.figure)


@pytest.mark.parametrize(("listed", "name"), [(ev.models, "Trapezium"), (ev.scenarios, "vezzoli_2014/fig6")])
def test_the_catalogue_is_a_table(formatter, listed, name):
    data, _ = formatter.format(listed())
    assert "<th>" in data["text/html"]
    assert name in words(data["text/html"])
    assert data["text/plain"] == repr(listed()).rstrip()


def test_tables_and_compared_materials_are_tables(formatter, scenario):
    table = Table("A <title>", ("name", "value"), (("a", "1 V"), ("b & c", "2 V")))
    data, _ = formatter.format(table)
    assert "<td>b &amp; c</td>" in data["text/html"]
    assert "b & c  2 V" in data["text/plain"].splitlines()
    compared = ev.compare_materials(scenario, materials=["silica"])
    data, _ = formatter.format(compared)
    assert "silica" in words(data["text/html"])
    assert data["text/html"].count("<table>") == len(compared.tables)
    assert "MaterialComparison" not in data["text/plain"]
    assert "silica" in data["text/plain"]


def test_a_percept_is_its_answer(formatter):
    lines = formatter.format(ev.perceive("vezzoli_2014/fig6"))[0]["text/plain"].splitlines()
    assert lines[0].startswith("Vezzoli 2014, figure 6")
    assert lines[1].startswith("felt or not: undecided within the spread, Pacinian channel: ")
    assert lines[2].endswith("(calibrated_on lists assumptions)")
    assert len(lines) < 6


@pytest.mark.parametrize("verb", [ev.compare, ev.check, ev.perceive])
def test_an_answer_is_shown_and_not_its_arrays(formatter, verb):
    """The answer comes first; a comparison of laws as its `repr` was 157 kB of numbers."""
    found = verb("vezzoli_2014/fig6")
    data, _ = formatter.format(found)
    assert len(repr(found)) > 2 * len(data["text/plain"])
    assert len(data["text/plain"]) < 10_000
    first = data["text/plain"].splitlines()[0]
    assert data["text/html"].startswith(f"<p>{html.escape(first)}</p>")
    tables = {ev.compare: len(getattr(found, "tables", ())), ev.check: 1, ev.perceive: 0}[verb]
    assert data["text/html"].count("<table>") == tables


def test_importing_in_ipython_imports_nothing_heavy():
    """Registration names types; it loads neither xarray nor matplotlib nor this package's models."""
    script = """
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
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, timeout=60, check=True
    )
    loaded, names = json.loads(done.stdout.splitlines()[-1])
    assert set(loaded) == {
        "electrovib",
        "electrovib.view",
        "electrovib.view.notebook",
        "electrovib.view.notebook.hooks",
    }
    assert {"Scenario", "Dataset"} <= set(names)


SHARE = {
    "want": "mean electrostatic_force = 5 mN",
    "free": "drive.amplitude",
    "space": "fingers",
    "share": 0.5,
}


@pytest.mark.parametrize(
    ("asked", "begins"),
    [
        (
            {"target": "constant 1 mN for 2 ms", "method": "carrier", "carrier": 3e3},
            "target: a constant force of 1 mN",
        ),
        (SHARE | {"seed": 1, "n": 20}, "drive.amplitude = "),
    ],
)
def test_every_design_shows_its_answer(formatter, asked, begins):
    found = ev.design("bau_2010/sine", **asked)
    given = formatter.format(found)[0]
    assert given["text/plain"] == "\n".join(found.lines)
    assert words(given["text/html"]).startswith(begins)


def test_a_designed_plate_shows_its_answer_and_tables(formatter):
    found = ev.design_plate("bau_2010/sine", {"drive.amplitude": [50.0, 100.0]}, refine=0)
    given = formatter.format(found)[0]
    assert words(given["text/html"]).startswith(found.sentences[0])
    assert given["text/html"].count("<table") == len(found.tables) == 2


def test_a_designed_parameter_shows_its_answer_and_tables(formatter):
    found = ev.design("bau_2010/sine", want="mean electrostatic_force = 50 mN", free="drive.amplitude")
    given = formatter.format(found)[0]
    assert given["text/plain"] == "\n".join(found.lines)
    text = words(given["text/html"])
    assert text.startswith("drive.amplitude = 50.8183 V gives mean electrostatic_force = 50 mN.")
    assert given["text/html"].count("<table") == 2
    assert "contact.area 1 cm2 -0.5" in text
