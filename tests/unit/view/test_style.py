"""The look comes and goes, pyplot is used only by those who use it; units as a person reads them."""

import itertools
import re
import subprocess
import sys
from importlib import resources

import matplotlib as mpl
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from matplotlib.colors import to_rgb

from electrovib.core.units import PREFIXES, parse_quantity
from electrovib.view import plots
from electrovib.view.style import (
    COLOURS,
    FURTHER_COLOURS,
    LAYER_COLOURS,
    NEUTRAL,
    OTHER_LAYERS,
    between,
    drawing,
    label_axis,
    layer_colours,
    legends_taken,
    prefix_for,
    pretty_quantity,
    pretty_unit,
    style,
    typeset,
)


def test_legends_are_taken_from_their_axes_with_each_entry_once():
    from matplotlib.figure import Figure

    first, second, third = Figure().subplots(1, 3)
    for axes, names, title in ((first, "ab", ""), (second, "bc", "layers")):
        for name in names:
            axes.plot([0, 1], label=name)
        axes.legend(title=title)
    entries, title = legends_taken([first, second, third])
    assert (list(entries), title) == (["a", "b", "c"], "layers")
    assert [each.get_legend() for each in (first, second)] == [None, None]


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


@pytest.mark.slow
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


def test_units_have_their_letters():
    for unit, shown in (
        ("um", "µm"),
        ("kohm", "kΩ"),
        ("ohm m2", "Ω·m²"),
        ("uC/m2", "µC/m²"),
        ("MV/m", "MV/m"),
    ):
        assert pretty_unit(unit) == shown
    assert pretty_unit("1") == ""


@settings(deadline=None, max_examples=100)
@given(st.floats(1e-14, 1e14), st.sampled_from(["V", "N", "m", "V/m", "ohm", "S/m"]))
def test_a_shown_quantity_reads_back(value, unit):
    # six digits are shown, so the value may move by half of the sixth
    assert parse_quantity(pretty_quantity(value, unit), unit) == pytest.approx(value, rel=5.1e-6)


@settings(deadline=None, max_examples=100)
@given(st.floats(1e-14, 9e14))
def test_the_prefix_leaves_one_to_three_digits(largest):
    prefix, scale = prefix_for(largest, "N")
    assert scale == 10.0 ** PREFIXES[prefix]
    assert 0.999 <= largest / scale < 1000.001
    for without in ((5e-3, "1"), (5e-3, "°"), (0.0, "N"), (np.nan, "N"), (np.inf, "N")):
        assert prefix_for(*without) == ("", 1.0)


def test_sentences_get_proper_units_and_keep_their_words():
    text = "within 250 uA: 5 um and 8.7e8 ohm m, 1 kohm, a V^2 law; unit 3 used, 4 users, 10^20"
    assert typeset(text) == "within 250 µA: 5 µm and 8.7e8 Ω m, 1 kΩ, a V² law; unit 3 used, 4 users, 10^20"
    assert typeset("5.232 uJ and 40 uW") == "5.232 µJ and 40 µW"


def vertical(x, y, quantity, unit, *, log=False):
    """Return the axes of a curve, and the numbers that stand at its vertical axis."""
    with drawing(None) as ax:
        ax.set_yscale("log" if log else "linear")
        ax.plot(x, y)
        label_axis(ax.yaxis, quantity, unit)
    ax.figure.canvas.draw()
    return ax, [text.get_text() for text in ax.yaxis.get_ticklabels() if text.get_text()]


def test_a_linear_axis_has_its_prefix_in_the_label_and_data_in_si():
    ax, numbers = vertical([0.0, 0.2], [0.0, 0.0565], "force", "N")
    label_axis(ax.xaxis, "time", "s")
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("time [ms]", "force [mN]")
    assert {"0", "20", "40"} <= set(numbers)
    assert ax.lines[0].get_ydata()[1] == 0.0565
    ax, numbers = vertical([0, 1], [-1, 1], "gain", "1")
    assert ax.get_ylabel() == "gain", "a pure number has no brackets"
    assert "\N{MINUS SIGN}1" in numbers


def test_rounding_is_not_magnified_into_a_curve_and_a_small_real_change_is_shown():
    ax, _ = vertical([0, 1, 2], [0.25, 0.25 * (1 + 1e-12), 0.25], "force", "N")
    assert ax.get_ylim() == pytest.approx((0.2, 0.3), rel=1e-6)
    ax, _ = vertical([0, 1, 2], [0.25, 0.25 * (1 + 1e-4), 0.25], "force", "N")
    assert np.ptp(ax.get_ylim()) < 1e-4


def power(exponent):
    return rf"$\mathdefault{{10^{{{exponent}}}}}$"


@pytest.mark.parametrize(
    ("low", "high", "unit", "label", "some"),
    [
        (1e-3, 0.1, "s", "quantity [ms]", {"1", "10", "100"}),
        (1e-7, 1e-4, "m", "quantity [µm]", {"0.1", "1", "10", "100"}),
        (100.0, 1e4, "Hz", "quantity [Hz]", {"100", "1000", "10000"}),
        (15.0, 1920.0, "Hz", "quantity [Hz]", {"20", "50", "100", "200", "1000"}),
        (10.0, 1e6, "Hz", "quantity [Hz]", {power(1), power(6)}),
        (1e3, 1e6, "Hz", "quantity [kHz]", {"1", "10", "100", "1000"}),
        (1e-5, 1e-4, "m", "quantity [µm]", {"10", "20", "50", "100"}),
        (1e-8, 1e-6, "m2", "quantity [mm²]", {"0.01", "0.1", "1"}),
        (0.6, 0.97, "1", "quantity", {"0.6", "0.8"}),
        (1e-9, 1e-1, "N", "quantity [N]", {power(-9), power(-1)}),
        (1e-6, 1e-5, "1", "quantity", {power(-6)}),
    ],
)
def test_numbers_of_a_logarithmic_axis_are_those_of_the_unit_in_its_label(low, high, unit, label, some):
    """Plain numbers of a prefixed unit, or powers of ten of the SI unit; never a prefix at a number."""
    ax, shown = vertical([0, 1], [low, high], "quantity", unit, log=True)
    assert ax.get_ylabel() == label
    assert some <= set(shown)
    plain = [text for text in shown if "mathdefault" not in text]
    assert all(text.replace(".", "").isdigit() for text in plain)
    assert plain in ([], shown)


@settings(deadline=None, max_examples=25)
@given(st.floats(1e-12, 1e6), st.floats(0.1, 9.0), st.sampled_from(["s", "N", "1", "Hz", "ohm m2"]))
def test_a_logarithmic_axis_has_at_least_two_numbers_and_no_prefix_at_them(low, decades, unit):
    _, shown = vertical([0, 1], [low, low * 10**decades], "quantity", unit, log=True)
    assert len(shown) >= 2
    assert not any(re.search(r"[kMGTmµunpf]$", text) for text in shown)
