"""The look comes and goes; pyplot is used only by those who use it."""

from __future__ import annotations

import itertools
import re
import subprocess
import sys
from importlib import resources

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.colors import to_rgb

from electrovib.view import plots
from electrovib.view.style import (
    COLOURS,
    FURTHER_COLOURS,
    LAYER_COLOURS,
    NEUTRAL,
    OTHER_LAYERS,
    between,
    layer_colours,
    style,
)


def test_settings_of_matplotlib_come_back(trace):
    before = dict(mpl.rcParams)
    plots.force(trace)
    with style():
        assert mpl.rcParams["svg.hashsalt"] == "electrovib"
    assert dict(mpl.rcParams) == before


def distance(one, other):
    """Difference of two colours in CIELAB, about 2 where it is just noticed."""
    return float(np.linalg.norm(lab(one) - lab(other)))


def lab(colour):
    part = np.array(to_rgb(colour))
    linear = np.where(part > 0.04045, ((part + 0.055) / 1.055) ** 2.4, part / 12.92)
    to_xyz = [[0.4125, 0.3576, 0.1804], [0.2127, 0.7152, 0.0722], [0.0193, 0.1192, 0.9503]]
    xyz = np.array(to_xyz) @ linear / [0.9505, 1.0, 1.089]
    f = np.where(xyz > 0.008856, np.cbrt(xyz), 7.787 * xyz + 16 / 116)
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


CURVES = COLOURS + FURTHER_COLOURS
LAYERS = (*LAYER_COLOURS.values(), *OTHER_LAYERS)
AMOUNTS = tuple(between(part) for part in np.linspace(0, 1, 5))


@pytest.mark.parametrize(
    "pairs",
    [
        itertools.product(CURVES, LAYERS),
        itertools.product(CURVES[:-1], (*AMOUNTS, NEUTRAL)),
        itertools.product(LAYER_COLOURS.values(), AMOUNTS),
        itertools.combinations(CURVES, 2),
        itertools.combinations(LAYERS, 2),
    ],
    ids=["curves and layers", "curves and amounts", "layers and amounts", "curves", "layers"],
)
def test_no_colour_has_two_meanings_and_colours_of_one_meaning_differ(pairs):
    assert min(distance(*pair) for pair in pairs) > 20


def test_layers_and_states_of_a_page_have_colours_of_their_own():
    names = ["insulator", "coating", "gap", "sweat", "stratum_corneum", "dermis"]
    found = layer_colours(names)
    assert list(found) == names
    assert len(set(found.values())) == len(names)
    css = resources.files("electrovib.view").joinpath("templates/style.css.jinja").read_text(encoding="utf-8")
    used = set(re.findall(r"#[0-9a-f]{6}\b", css))
    assert used
    assert used.isdisjoint({*CURVES, *LAYERS})


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
