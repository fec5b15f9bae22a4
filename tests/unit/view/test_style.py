"""The look comes and goes; pyplot is used only by those who use it."""

from __future__ import annotations

import subprocess
import sys

import matplotlib as mpl
import pytest

from electrovib.view import plots
from electrovib.view.style import COLOURS, layer_colours, style


def test_settings_of_matplotlib_come_back(trace):
    before = dict(mpl.rcParams)
    plots.force(trace)
    with style():
        assert mpl.rcParams["svg.hashsalt"] == "electrovib"
    assert dict(mpl.rcParams) == before


def test_layers_differ_in_colour():
    names = ["insulator", "coating", "gap", "sweat", "stratum_corneum", "dermis"]
    found = layer_colours(names)
    assert list(found) == names
    assert len(set(found.values())) == len(names)
    assert set(found.values()) <= set(COLOURS)


def test_importing_draws_nothing_in():
    code = (
        "import sys, electrovib.view.report, electrovib.view.reproduce, electrovib.view.plots\n"
        "heavy = {'matplotlib', 'jinja2', 'xarray', 'scipy.signal'} & set(sys.modules)\n"
        "assert not heavy, heavy"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_a_report_never_imports_pyplot(scenario, tmp_path):
    code = (
        "import sys, json\n"
        "from electrovib.scenario import load\n"
        "from electrovib.view.report import report\n"
        "report(load(json.loads(sys.argv[1])), sys.argv[2])\n"
        "assert 'matplotlib.figure' in sys.modules and 'matplotlib.pyplot' not in sys.modules"
    )
    output = tmp_path / "report.html"
    subprocess.run([sys.executable, "-c", code, scenario.to_json(), str(output)], check=True)
    assert output.exists()


def test_a_user_of_pyplot_finds_the_figure_there(trace, monkeypatch):
    pyplot = pytest.importorskip("matplotlib.pyplot")
    monkeypatch.setitem(sys.modules, "matplotlib.pyplot", pyplot)
    pyplot.switch_backend("agg")
    ax = plots.force(trace)
    assert pyplot.gcf() is ax.figure
    pyplot.close("all")
    figure, mine = pyplot.subplots()
    assert plots.force(trace, ax=mine) is mine
    pyplot.close(figure)
