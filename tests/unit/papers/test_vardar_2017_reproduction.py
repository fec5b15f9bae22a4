"""The reproduction of the 2017 abstract, as data."""

from __future__ import annotations

import numpy as np
import pytest

from electrovib.core.errors import InputError
from electrovib.core.items import items_heard
from electrovib.papers import vardar_2017

pytestmark = pytest.mark.slow  # the reproduction takes tens of seconds


@pytest.fixture(scope="module")
def found():
    items = []
    with items_heard(lambda *item: items.append(item)):
        found = vardar_2017.reproduce()
    count = 6
    assert [(number, total) for _, number, total in items] == [
        (number, count) for number in range(1, count + 1)
    ]
    return found


def test_nothing_is_called_reproduced_that_the_abstract_does_not_print(found):
    rows = {row.id: row for row in found.rows}
    assert {row.verdict for row in found.rows} == {"consistent", "open", "ours"}
    assert rows["direction"].verdict == "consistent"
    assert rows["direction"].ours[0] > 1.0
    assert rows["crossover_tau"].paper == 60.0
    assert rows["crossover_tau"].verdict == "open"
    assert found.count() == (
        "2 numbers of the paper: 2 open; 3 statements in words: 2 consistent, 1 open; beside them 2 quantities of ours"
    )
    assert len(found.findings) == 3
    assert "from 48 to 630 Hz" in found.findings[1]


def test_the_numbers_of_the_rows(found):
    rows = {row.id: row.ours for row in found.rows}
    assert rows["crossover_tau"] == pytest.approx((48.0, 630.0), rel=0.01)  # closed form apart from this code
    assert rows["crossover_weight"] == pytest.approx((85.3, 91.2), rel=0.01)
    assert rows["edges_480"] == pytest.approx((-7.6, -2.8), abs=0.1)
    assert rows["best_frequency"] == pytest.approx(
        125.0, rel=0.04
    )  # the high-pass of the skin moves it by a little
    tau = rows["tau_of_60"] * 1e-3
    assert vardar_2017.sine_over_square(
        vardar_2017.first_order_skin(time_constant=tau), frequency=60.0
    ) == pytest.approx(0, abs=0.01)


def test_the_panels_show_the_direction_and_the_crossing(found):
    panels = {panel.id: panel for panel in found.panels}
    curves = {curve.label: curve for curve in panels["thresholds"].curves}
    sine, square = curves["sine, 7.7 ms"], curves["square, 7.7 ms"]
    assert sine.y[0] > square.y[0] + 10
    assert sine.y[-1] < square.y[-1]
    over_tau = panels["crossover"].curves[0]
    assert np.all(np.diff(over_tau.y) < 0)
    band = panels["ratio"].curves[0]
    assert np.all(band.upper >= band.y)


def test_a_table_of_skin_is_refused():
    with pytest.raises(InputError, match="electrovib run"):
        vardar_2017.reproduce(skin="own.csv")
