"""Panels of at most five curves."""

from __future__ import annotations

import numpy as np

from electrovib.study.reproduction import Curve, Panel
from electrovib.view.few_curves import few_curves

X = np.geomspace(1, 1e4, 30)


def panel(*factors, log_y=True, points=()):
    curves = [Curve(label=f"law {n}", x=X, y=a / X, look=n) for n, a in enumerate(factors)]
    marks = [Curve(label=f"law {n} breaks down", x=X[:3], y=X[:3], kind="points", look=n) for n in points]
    return Panel(
        id="fig",
        title="Force",
        caption="",
        x=("time", "s"),
        y=("force", "N"),
        curves=(*curves, *marks),
        log_y=log_y,
    )


def test_a_panel_of_few_curves_stays_as_it_is():
    given = panel(1, 2, 3, points=(1,))
    (found,) = few_curves(given)
    assert [curve.label for curve in found.curves] == [curve.label for curve in given.curves]
    assert (found.id, found.title) == ("fig", "Force")


def test_equal_curves_share_a_line_with_both_names():
    (found,) = few_curves(panel(1, 2, 2.1, 3, 4, 5))
    assert [curve.label for curve in found.curves] == ["law 0", "law 1,\nlaw 2", "law 3", "law 4", "law 5"]
    assert [curve.look for curve in found.curves] == [0, 1, 3, 4, 5]
    (linear,) = few_curves(panel(1, 2, 2.1, 3, 4, log_y=False))
    assert len(linear.curves) == 5


def test_further_curves_have_a_figure_of_their_own_beside_the_first():
    parts = few_curves(panel(*(2.0**n for n in range(11)), points=(0, 6)))
    assert [part.title for part in parts] == ["Force, 1 of 3", "Force, 2 of 3", "Force, 3 of 3"]
    assert len({part.id for part in parts}) == 3
    lines = [[curve.look for curve in part.curves if curve.kind != "points"] for part in parts]
    assert lines == [[0, 1, 2, 3, 4], [0, 5, 6, 7, 8], [0, 9, 10]]
    marks = [[curve.look for curve in part.curves if curve.kind == "points"] for part in parts]
    assert marks == [[0], [0, 6], [0]]
