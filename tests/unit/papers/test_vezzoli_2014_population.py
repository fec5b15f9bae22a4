"""The population of figures 6 and 7 against closed forms, and what the spread is due to."""

import numpy as np
import pytest
import vezzoli_fingers as forms

import electrovib as ev
from electrovib.papers.vezzoli_2014 import values
from electrovib.papers.vezzoli_2014.population import (
    FORCE,
    SEED,
    SET_UP,
    over_frequency,
    panels,
    population,
    predicted,
    readings,
    rising,
    rows,
    table,
)
from electrovib.papers.vezzoli_2014.values import scenarios


@pytest.mark.parametrize(
    ("figure", "function"), [("fig6", forms.lateral_by_law), ("fig6_gap", forms.lateral_in_gap)]
)
def test_the_forces_of_figure_6_are_those_of_the_closed_forms(figure, function):
    """To 1e-9, and with the body of the scenario, which the closed forms do not have, to 1e-6."""
    space = population(figure)
    drawn = space.draw(1, 0, 40)
    for scenario, rtol in ((rising(figure), 1e-9), (scenarios()[figure], 1e-6)):
        found = ev.prepare(scenario, free=space.paths, quantity=[FORCE])(drawn)[FORCE]
        np.testing.assert_allclose(function(drawn), found, rtol=rtol)


@pytest.mark.slow
def test_the_distributions_are_those_of_the_closed_forms():
    for each, figure, function in zip(
        predicted(), ("fig6", "fig6_gap"), (forms.lateral_by_law, forms.lateral_in_gap), strict=True
    ):
        drawn = population(figure).draw(SEED, 0, 8000)
        np.testing.assert_allclose(each.force, function(drawn), rtol=1e-9)


@pytest.mark.parametrize(("in_gap", "function"), [(False, forms.mean_by_law), (True, forms.mean_in_gap)])
def test_the_bands_of_figure_7_are_the_quantiles_of_the_closed_forms(in_gap, function):
    """To the rounding of float32, in which a study keeps the signals of its fingers."""
    scenario, space = over_frequency(in_gap=in_gap)
    found = ev.study(scenario, space, n=300, seed=SEED, quantity="mean_force")
    force = function(space.draw(SEED, 0, 300), found.frequency.values)
    np.testing.assert_allclose(
        found["mean_force_percentile"], np.quantile(force, [0.05, 0.5, 0.95], axis=0), rtol=1.2e-7
    )


def test_both_laws_have_the_same_nominal_time_constants():
    space = population("fig6_gap")
    groups, drawn = space.draw_groups(1, 0, 20_000)["moisture"], space.draw(1, 0, 20_000)
    for group in ("dry", "moist"):
        skin, leak = (drawn[path][groups == group] for path in (forms.CONDUCTIVITY, forms.LEAK))
        factor = (1 + values.FILM_PERMITTIVITY * 1e-6 / values.FILM_THICKNESS) / values.SKIN_PERMITTIVITY
        of_leak, of_skin = (np.quantile(each, [0, 0.5, 1]) for each in (leak, skin))
        np.testing.assert_allclose(of_leak, factor * of_skin, rtol=0.02)


@pytest.mark.slow
def test_thickness_holds_next_to_nothing_of_the_spread_and_the_resistivities_most():
    by_law, in_gap = predicted()
    assert by_law.shares["groups of moisture"][0] > 0.6
    assert in_gap.shares["groups of moisture"][0] > 0.7
    assert by_law.shares[forms.SKIN][1] < 0.1
    assert in_gap.shares[forms.SKIN][1] < 1e-3
    for each in (by_law, in_gap):
        assert sum(first for first, _ in each.shares.values()) == pytest.approx(1, abs=0.2)


@pytest.mark.slow
def test_of_dry_fingers_friction_and_leak_hold_most_of_the_spread():
    by_law, in_gap = predicted("dry")
    assert 0.02 < by_law.shares[forms.SKIN][0] < 0.1 < by_law.shares[forms.FRICTION][0]
    assert in_gap.shares[forms.LEAK][0] > 0.5
    for each in (by_law, in_gap):
        assert sum(first for first, _ in each.shares.values()) == pytest.approx(1, abs=0.2)


@pytest.mark.slow
def test_the_range_of_eight_is_that_of_the_quantiles_of_its_ends():
    """The smallest of eight independent values lies below the quantile q with probability 1 - (1 - q)^8."""
    for each in predicted():
        quantile = 1 - 0.5 ** (1 / 8)
        low, high = np.quantile(each.force, [quantile, 1 - quantile])
        assert each.of_subjects == (pytest.approx(low, rel=0.1), pytest.approx(high, rel=0.05))
        assert each.central[0] < each.of_subjects[0] < each.of_subjects[1] < each.central[1]


@pytest.mark.slow
def test_rows_table_and_figures_of_the_population():
    """Both laws are open, as people are drawn; every input has a line under both laws and for dry fingers."""
    found = {row.id: row for row in rows()}
    verdicts = {name: row.verdict for name, row in found.items()}
    variances = {"variance_thickness": "ours", "variance_resistivity": "ours"}
    assert verdicts == {"population_law_1": "open", "population_gap": "open"} | variances
    for row in (found["population_law_1"], found["population_gap"]):
        assert row.paper == (2.0, 5.0)
        assert "population 'fingers'" in row.note
    assert found["population_law_1"].ours == pytest.approx((0.003, 1.0), rel=0.11)
    assert found["population_gap"].ours[0] < 5.0 < found["population_gap"].ours[1]
    assert found["variance_thickness"].ours == pytest.approx(0.01, abs=0.005)
    assert found["variance_resistivity"].ours == pytest.approx(0.76, abs=0.02)
    assert "thickness of the stratum corneum 0.00" in found["population_gap"].note
    shown = table()
    assert len(shown.headings) == 9
    lines = {line[0]: line[1:] for line in shown.rows}
    assert lines["thickness of the gap"][:2] == ("", "")
    assert all(lines["thickness of the stratum corneum"])
    assert "-0.00" not in str(shown.rows)
    assert lines["eight subjects [mN]"][0].startswith("0.0027 to 1")
    six, _, seven = panels()
    measured, *laws = six.curves
    labels = ["measured, eight subjects", "law (1) of the paper", "Maxwell stress in a leaky gap"]
    assert [curve.label for curve in six.curves] == labels
    assert tuple(measured.x) == values.FORCE_MEASURED
    for curve in laws:
        assert (np.diff(curve.x) >= 0).all()
        assert curve.y[0] < 0.01
        assert curve.y[-1] > 0.99
    thickness, law, median, *_ = seven.curves
    assert (law.upper > median.y).all()
    assert (median.y > law.y).all()
    assert (law.upper / law.y > thickness.upper / thickness.y)[0]


def test_eight_fingers_go_through_amplifier_sensors_and_digitiser():
    """The reading is the friction of the attraction, delayed and rounded to levels of 2 N/2^16."""
    drawn = population("fig6_gap").draw(SEED, 0, 8)
    time, attraction = readings("fig6_gap")
    assert attraction.shape == (8, len(time))
    assert (attraction[:, 0] == 0).all()
    levels = attraction * drawn[forms.FRICTION][:, None] / (2 / 2**16)
    np.testing.assert_allclose(levels, np.round(levels), atol=1e-6)
    after = time > values.RAMP - 1e-9
    peaks = attraction[:, after][:, :4].max(axis=1) * drawn[forms.FRICTION]
    np.testing.assert_allclose(peaks, forms.lateral_in_gap(drawn), rtol=0.1, atol=2 / 2**16)
    scenario = scenarios()["fig6_gap"].replace(SET_UP)
    assert scenario.rig.digitiser.bits == 16
    assert scenario.circuit.amplifier.source_current == 250e-6


@pytest.mark.slow
def test_the_figure_of_the_set_up_has_a_line_for_each_finger():
    _, panel, _ = panels()
    band, *curves = panel.curves
    assert (band.y[0], band.upper[0]) == values.attraction_of(values.FORCE_MEASURED)
    for curve, figure in zip(curves, ("fig6", "fig6_gap"), strict=True):
        time, attraction = readings(figure)
        assert len(curve.x) == 8 * len(time)
        for number in range(8):
            part = slice(number * len(time), (number + 1) * len(time))
            found = dict(zip(curve.x[part], curve.y[part], strict=True))
            assert [found[each] for each in time] == list(attraction[number])
        assert np.abs(attraction[:, [0, -1]]).max() < 2e-4
