"""Legends stand inside the plot and cover no curve."""

import numpy as np
import pytest

from electrovib.view import plots
from electrovib.view.lines import finish
from electrovib.view.style import drawing

X = np.linspace(0.0, 1.0, 401)
CURVES = {
    "free corner": [X, X**2],
    "free lower right": [1 - X, 1 - 0.9 * X],
    "five everywhere": [a * np.sin(45 * X + a) for a in (1, 0.9, 0.8, 0.7, 0.6)],
    "three decades": [10.0 ** (3 * np.sin(40 * X)), 10.0 ** (3 * np.cos(50 * X))],
    "fourteen": [np.sin(50 * X + number) for number in range(14)],
}


def covered(ax):
    """List the curves that have a point, or a piece between points, under the legend of a rendered figure."""
    ax.figure.draw_without_rendering()
    box = ax.get_legend().get_window_extent()
    found = []
    for line in ax.lines:
        seen = ax.transData.transform(np.column_stack(line.get_data()))
        places, dense = np.arange(len(seen)), np.linspace(0, len(seen) - 1, 20_000)
        x, y = (np.interp(dense, places, part) for part in seen.T)
        inside = (x > box.x0) & (x < box.x1) & (y > box.y0) & (y < box.y1)
        found += [line.get_label()] if inside.any() else []
    return found


@pytest.mark.parametrize("case", CURVES)
@pytest.mark.parametrize("size", [(5.6, 3.6), (4.0, 2.6)])
def test_no_curve_runs_under_the_legend(case, size):
    """Many entries stand beside the plot."""
    with drawing(None, size) as ax:
        for number, y in enumerate(CURVES[case]):
            ax.plot(X, y, label=f"a rather long name of a curve, {number}")
        if case == "three decades":
            ax.set_yscale("log")
        finish(ax, x=("time", "s"), y=("force", "N"))
    assert covered(ax) == []
    outer, box = ax.get_window_extent(), ax.get_legend().get_window_extent()
    if case == "fourteen":
        assert box.x0 >= outer.x1
    elif size == (5.6, 3.6):
        assert outer.x0 <= box.x0 < box.x1 <= outer.x1 + 1
        assert outer.y0 <= box.y0 < box.y1 <= outer.y1 + 1


@pytest.mark.parametrize("resolution", [60, 150, 300])
def test_a_legend_above_the_curves_ends_within_the_plot_at_any_resolution(resolution):
    """Letters are up to some per cent wider in a picture of another resolution than where the columns were chosen."""
    for letters in (20, 22):
        with drawing(None, (5.6, 3.6)) as ax:
            for number in range(5):
                name = "i" * letters if number == 4 else "mmm"
                ax.plot(X, np.sin(45 * X + number), label=f"{number}{name}")
            finish(ax, x=("time", "s"), y=("force", "N"))
        ax.figure.set_dpi(resolution)
        ax.figure.draw_without_rendering()
        assert ax.get_legend().get_window_extent().x1 <= ax.get_window_extent().x1


def test_a_legend_avoids_bands_and_points():
    with drawing(None) as ax:
        ax.fill_between(X, 0.5 + 0 * X, 1.0 + 0 * X, label="band")
        ax.plot([0.1, 0.12, 0.9], [0.1, 0.2, 0.15], "o", label="points")
        finish(ax, x=("time", "s"), y=("force", "N"))
    ax.figure.draw_without_rendering()
    box = ax.get_legend().get_window_extent()
    low, high = ax.transData.transform([(0, 0.5), (0, 1.0)])[:, 1]
    assert box.y1 <= low or box.y0 >= high
    points = ax.transData.transform(np.column_stack(ax.lines[0].get_data()))
    assert not any(box.contains(*point) for point in points)


@pytest.mark.parametrize("plot", [plots.force, plots.lateral_force, plots.field, plots.layer_voltages])
def test_no_plot_over_time_has_a_curve_under_its_legend(plot, trace, other):
    assert covered(plot({"Maxwell stress in the gap": trace, "effective medium": other})) == []
