"""A figure of a reproduced paper."""

from __future__ import annotations

import numpy as np
from matplotlib.colors import to_hex

from electrovib.study.reproduction import REFERENCE, Curve, Panel
from electrovib.view import plots
from electrovib.view.plots.reproduced import PALETTE
from electrovib.view.style import NEUTRAL

X = np.geomspace(1, 1e4, 30)


def make(*curves, **more):
    return Panel(
        id="fig",
        title="Force at 5 um",
        caption="words",
        x=("frequency", "Hz"),
        y=("force", "N"),
        curves=curves,
        **more,
    )


def test_lines_points_and_bands_have_their_data():
    curves = (
        Curve(label="band of 2 uS", x=X, y=1e-3 + 0 * X, upper=2e-3 + 0 * X, kind="band"),
        Curve(label="line", x=X, y=1e-6 * X),
        Curve(label="dashed", x=X, y=2e-6 * X, kind="dashed"),
        Curve(label="points", x=X[::5], y=3e-6 * X[::5], kind="points"),
    )
    ax = plots.panel(make(*curves, log_x=True))
    shown = {line.get_label(): line for line in ax.lines}
    assert np.array_equal(shown["line"].get_ydata(), 1e-6 * X)
    assert shown["dashed"].get_linestyle() == "--"
    assert (shown["points"].get_marker(), shown["points"].get_linestyle()) == ("o", "None")
    corners = ax.collections[0].get_paths()[0].vertices
    assert (corners[:, 1].min(), corners[:, 1].max()) == (1e-3, 2e-3)
    assert ax.get_legend().get_texts()[0].get_text() == "band of 2 µS"
    assert ax.get_title(loc="left") == "Force at 5 µm"
    assert (ax.get_xscale(), ax.get_yscale()) == ("log", "linear")
    assert ax.get_ylabel() == "force [mN]"


def test_every_curve_looks_different():
    curves = [Curve(label=f"line {n}", x=X, y=n * X) for n in range(9)]
    curves += [Curve(label=f"dashed {n}", x=X, y=n * X, kind="dashed") for n in range(3)]
    ax = plots.panel(make(*curves, log_x=True, log_y=True))
    looks = {(line.get_color(), line.get_linestyle()) for line in ax.lines}
    assert len(looks) == len(curves)


def test_few_curves_differ_in_colour_even_where_one_is_dashed():
    ax = plots.panel(make(Curve(label="a", x=X, y=X), Curve(label="b", x=X, y=2 * X, kind="dashed")))
    assert len({line.get_color() for line in ax.lines}) == 2


def test_nothing_is_drawn_below_the_floor():
    ax = plots.panel(make(Curve(label="a", x=X, y=1e-3 * X), log_y=True, floor=0.1))
    (line,) = ax.lines
    assert np.array_equal(np.isnan(line.get_ydata()), X * 1e-3 < 0.1)
    assert np.nanmin(line.get_ydata()) >= 0.1


def test_a_look_has_one_colour_in_every_figure_and_a_reference_is_grey():
    """Whatever else is drawn, and whether the line is broken."""
    first = plots.panel(make(Curve(label="a", x=X, y=X), Curve(label="skin", x=X, y=2 * X, look=8)))
    second = plots.panel(
        make(
            Curve(label="skin", x=X, y=X, look=8, kind="dashed"),
            Curve(label="limit", x=X, y=2 * X, look=REFERENCE),
            Curve(label="range", x=X, y=X, upper=3 * X, look=REFERENCE, kind="band"),
        )
    )
    colours = [{line.get_label(): line.get_color() for line in ax.lines} for ax in (first, second)]
    assert colours[0]["skin"] == colours[1]["skin"] == PALETTE[8]
    assert colours[1]["limit"] == NEUTRAL
    assert to_hex(second.collections[0].get_facecolor()[0]) == NEUTRAL
