"""Figures as data: their curves and looks, parts of at most five curves, and what is kept of a long record."""

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from matplotlib.colors import to_hex

from electrovib.core.answer import REFERENCE, Curve, Panel
from electrovib.view import plots
from electrovib.view.fitted import fit_panels
from electrovib.view.lines import BINS, LONG, envelope
from electrovib.view.pages import drawn, few_curves
from electrovib.view.plots.of_answers import PALETTE
from electrovib.view.style import NEUTRAL, PALE

X = np.geomspace(1, 1e4, 30)


def make(*curves, **more):
    words = {
        "id": "fig",
        "title": "Force at 5 um",
        "caption": "",
        "x": ("frequency", "Hz"),
        "y": ("force", "N"),
    }
    return Panel(**words, curves=curves, **more)


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
    assert (ax.get_xscale(), ax.get_yscale(), ax.get_ylabel()) == ("log", "linear", "force [mN]")
    (line,) = plots.panel(make(Curve(label="a", x=X, y=1e-3 * X), log_y=True, floor=0.1)).lines
    assert np.array_equal(np.isnan(line.get_ydata()), X * 1e-3 < 0.1), "nothing is drawn below the floor"
    assert np.nanmin(line.get_ydata()) >= 0.1


def test_every_curve_looks_different():
    """Few curves differ in colour, even where one is dashed."""
    curves = [Curve(label=f"line {n}", x=X, y=n * X) for n in range(9)]
    curves += [Curve(label=f"dashed {n}", x=X, y=n * X, kind="dashed") for n in range(3)]
    ax = plots.panel(make(*curves, log_x=True, log_y=True))
    assert len({(line.get_color(), line.get_linestyle()) for line in ax.lines}) == len(curves)
    few = plots.panel(make(curves[0], curves[-1]))
    assert len({line.get_color() for line in few.lines}) == 2


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


def test_curves_of_the_background_are_pale_under_one_name_and_a_single_abscissa_is_a_mark_or_a_bar():
    curves = [
        Curve(label="paper", x=X, y=X, kind="bold"),
        *(Curve(label=f"skin {n}", x=X, y=n * X, look=REFERENCE, background="skins") for n in (2, 3)),
        Curve(label="printed", x=X[:1], y=X[:1], look=REFERENCE),
        Curve(label="measured", x=X[:1], y=X[:1], upper=2 * X[:1], kind="band", look=REFERENCE),
        Curve(label="force", x=X, y=4 * X),
    ]
    ax = plots.panel(make(*curves))
    assert [text.get_text() for text in ax.get_legend().get_texts()] == [
        "paper",
        "skins",
        "printed",
        "measured",
    ]
    bold, *behind, mark, named_by_axis = ax.lines
    assert {line.get_color() for line in behind} == {PALE}
    assert bold.get_linewidth() > 2 * behind[0].get_linewidth()
    assert bold.get_zorder() > behind[0].get_zorder()
    assert (mark.get_marker(), mark.get_color()) == ("_", NEUTRAL)
    assert named_by_axis.get_ydata()[-1] == 4 * X[-1]
    (bar,) = ax.collections
    assert bar.get_segments()[0][:, 1].tolist() == [1.0, 2.0]


def test_panels_below_share_the_axis_and_the_picture():
    whole = make(Curve(label="a", x=X, y=X), below=(make(Curve(label="b", x=X, y=X)),) * 2, log_x=True)
    figure = drawn(whole)
    heights = [ax.get_position().height for ax in figure.axes]
    assert len(heights) == 3
    assert heights[0] < 0.6 * heights[1]
    assert figure.get_figheight() > drawn(make(*whole.curves)).get_figheight()
    assert [ax.get_xlabel() for ax in figure.axes] == ["", "", "frequency [Hz]"]
    assert len({ax.get_xlim() for ax in figure.axes}) == 1


def laws(*factors, points=(), **more):
    curves = [Curve(label=f"law {n}", x=X, y=a / X, look=n) for n, a in enumerate(factors)]
    marks = [Curve(label=f"law {n} breaks down", x=X[:3], y=X[:3], kind="points", look=n) for n in points]
    return make(*curves, *marks, **more)


def test_few_curves_stay_and_equal_ones_share_a_line_with_both_names():
    given_panel = laws(1, 2, 3, points=(1,), log_y=True)
    (found,) = few_curves(given_panel)
    assert [curve.label for curve in found.curves] == [curve.label for curve in given_panel.curves]
    assert (found.id, found.title) == ("fig", "Force at 5 um")
    (found,) = few_curves(laws(1, 2, 2.1, 3, 4, 5, log_y=True))
    assert [curve.label for curve in found.curves] == ["law 0", "law 1,\nlaw 2", "law 3", "law 4", "law 5"]
    assert [curve.look for curve in found.curves] == [0, 1, 3, 4, 5]
    (linear,) = few_curves(laws(1, 2, 2.1, 3, 4))
    assert len(linear.curves) == 5


def test_further_curves_have_a_figure_of_their_own_beside_the_first():
    parts = few_curves(laws(*(2.0**n for n in range(11)), points=(0, 6), log_y=True))
    assert [part.title for part in parts] == [f"Force at 5 um, {n} of 3" for n in (1, 2, 3)]
    assert len({part.id for part in parts}) == 3
    for of_points, expected in (
        (False, [[0, 1, 2, 3, 4], [0, 5, 6, 7, 8], [0, 9, 10]]),
        (True, [[0], [0, 6], [0]]),
    ):
        looks = [[c.look for c in part.curves if (c.kind == "points") is of_points] for part in parts]
        assert looks == expected


def test_a_band_stays_with_its_line_and_points_of_no_line_are_in_every_part():
    """Whatever is not drawn takes no place, and a thin line of the background none of the five."""
    curves = [
        part
        for look in range(7)
        for part in (
            Curve(label=f"law {look}, 90 %", x=X, y=X * 2**look, upper=X * 3**look, kind="band", look=look),
            Curve(label=f"law {look}", x=X, y=X * 2.5**look, look=look),
            Curve(label=f"law {look}, hidden", x=X, y=X, look=20 + look, drawn=False),
        )
    ]
    curves += [
        Curve(label="measured", x=X[::9], y=X[::9], kind="points", look=REFERENCE),
        Curve(label="its spread", x=X[::9], y=X[::9], upper=2 * X[::9], kind="band", look=REFERENCE),
        Curve(label="record", x=X[::7], y=X[::7], kind="points", look=9),
        Curve(label="faint", x=X, y=X, look=3, background="others"),
    ]
    first, second = few_curves(make(*curves, log_y=True))
    everywhere = {"measured", "its spread", "record", "faint"}
    for part, looks in ((first, range(5)), (second, (0, 5, 6))):
        own = {f"law {look}{end}" for look in looks for end in ("", ", 90 %")}
        assert {curve.label for curve in part.curves} == own | everywhere
        assert [curve.label for curve in part.curves][-2:] == ["record", "measured"], "points on top"
    legend = [text.get_text() for text in plots.panel(second).get_legend().get_texts()]
    assert sorted(legend) == ["law 0", "law 5", "law 6", "measured", "others", "record"]
    limit = Curve(label="limit", x=X, y=1 + 0 * X, look=REFERENCE)
    bands = [Curve(label=f"band {n}", x=X, y=X, upper=2 * X, kind="band", look=n) for n in range(7)]
    for part in (parts := few_curves(make(limit, *bands))):
        assert "limit" in [curve.label for curve in part.curves]
    assert [len(part.curves) for part in parts] == [6, 4], "equal bands are no equal lines"
    (residuals,) = few_curves(make(*(Curve(label=f"{n}", x=X, y=n * X, kind="points") for n in range(5))))
    assert [curve.look for curve in residuals.curves] == [0, 1, 2, 3, 4]


def test_data_of_one_recording_are_grey_and_of_several_have_the_colour_of_their_model():
    def looks(*recordings):
        x = np.linspace(0.0, 1.0, 50)
        observed = SimpleNamespace(signal="lateral_force", axis="time", parts=1, x=x, y=x, scale=1.0)
        common = {"observed": observed, "predicted": x, "values": 0 * x, "noise": 1.0}
        panel = fit_panels([SimpleNamespace(**common, recording=name) for name in recordings])[0]
        return {curve.label: curve.look for curve in panel.curves}

    assert looks("a.nc") == {"a.nc, data": REFERENCE, "a.nc, model": 0}
    both = {"a.nc, data": 0, "a.nc, model": 0, "b.nc, data": 1, "b.nc, model": 1}
    assert looks("a.nc", "b.nc") == both


@settings(deadline=None, max_examples=20)
@given(st.integers(LONG + 1, 4 * LONG), st.integers(0, 2**32 - 1))
def test_extremes_ends_and_points_of_a_long_record_stay(count, seed):
    y = np.random.default_rng(seed).standard_normal(count)
    x = np.linspace(0, 1, count)
    kept_x, kept_y = envelope(x, y)
    assert len(kept_y) <= 2 * BINS + 2
    assert (kept_y.min(), kept_y.max()) == (y.min(), y.max())
    assert (kept_y[0], kept_y[-1]) == (y[0], y[-1])
    assert np.all(np.diff(kept_x) > 0)
    assert np.array_equal(kept_y, y[np.searchsorted(x, kept_x)])


def test_a_short_record_is_whole_and_missing_samples_leave_a_gap_and_hide_nothing():
    x, y = np.arange(LONG, dtype=float), np.ones(LONG)
    assert envelope(x, y)[1] is y
    y = np.sin(np.linspace(0, 20, 5 * LONG))
    y[30_000:40_000] = np.nan
    y[50_000] = np.nan
    y[50_001] = 2.0
    x, kept = envelope(np.arange(len(y), dtype=float), y)
    inside = (x > 30_100) & (x < 39_900)
    assert inside.any()
    assert np.isnan(kept[inside]).all()
    assert np.nanmax(kept) == pytest.approx(2.0, abs=0)
    assert np.isnan(envelope(np.arange(3.0 * LONG), np.full(3 * LONG, np.nan))[1]).all()
