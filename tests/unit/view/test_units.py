"""Units as a person reads them."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from electrovib.core.units import PREFIXES, parse_quantity
from electrovib.view.style import drawing
from electrovib.view.units import label_axis, prefix_for, pretty_quantity, pretty_unit, typeset


@pytest.mark.parametrize(
    ("unit", "shown"),
    [
        ("um", "µm"),
        ("kohm", "kΩ"),
        ("ohm m2", "Ω·m²"),
        ("uC/m2", "µC/m²"),
        ("MV/m", "MV/m"),
        ("1", ""),
        ("mN", "mN"),
    ],
)
def test_units_have_their_letters(unit, shown):
    assert pretty_unit(unit) == shown


@pytest.mark.parametrize(
    ("value", "unit", "shown"),
    [
        (90e-6, "m", "90 µm"),
        (1000.0, "ohm", "1 kΩ"),
        (0.5, "1", "0.5"),
        (-330e-6, "C/m2", "-330 µC/m²"),
        (0.0, "V", "0 V"),
        (1e-4, "m2", "1 cm²"),
        (None, "V", "–"),
        (3.0, "kg", "3 kg"),
        (float("nan"), "N", "nan N"),
    ],
)
def test_quantities(value, unit, shown):
    assert pretty_quantity(value, unit) == shown


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


@pytest.mark.parametrize(
    ("largest", "unit"), [(5e-3, "1"), (5e-3, "°"), (0.0, "N"), (np.nan, "N"), (np.inf, "N")]
)
def test_no_prefix_where_there_is_none(largest, unit):
    assert prefix_for(largest, unit) == ("", 1.0)


def test_sentences_get_proper_units_and_keep_their_words():
    text = "within 250 uA: 5 um and 8.7e8 ohm m, 1 kohm, a V^2 law; unit 3 used, 4 users, 10^20"
    assert typeset(text) == "within 250 µA: 5 µm and 8.7e8 Ω m, 1 kΩ, a V² law; unit 3 used, 4 users, 10^20"


def numbers(axis):
    axis.figure.canvas.draw()
    return [text.get_text() for text in axis.get_ticklabels()]


def test_a_linear_axis_has_its_prefix_in_the_label_and_data_in_si():
    with drawing(None) as ax:
        ax.plot([0.0, 0.2], [0.0, 0.0565])
        label_axis(ax.xaxis, "time", "s")
        label_axis(ax.yaxis, "force", "N")
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("time [ms]", "force [mN]")
    assert {"0", "20", "40"} <= set(numbers(ax.yaxis))
    assert ax.lines[0].get_ydata()[1] == 0.0565


def test_a_pure_number_has_no_brackets_and_minus_is_a_minus():
    with drawing(None) as ax:
        ax.plot([0, 1], [-1, 1])
        label_axis(ax.yaxis, "gain", "1")
    assert ax.get_ylabel() == "gain"
    assert "\N{MINUS SIGN}1" in numbers(ax.yaxis)


def test_a_logarithmic_axis_has_a_prefix_at_each_number():
    with drawing(None) as ax:
        ax.set_xscale("log")
        ax.set_yscale("log")
        ax.plot([1.0, 1e6], [1e-4, 1.0])
        label_axis(ax.xaxis, "frequency", "Hz")
        label_axis(ax.yaxis, "gain", "1")
    assert ax.get_xlabel() == "frequency [Hz]"
    assert {"1", "1\N{THIN SPACE}k", "1\N{THIN SPACE}M"} <= set(numbers(ax.xaxis))
    assert "0.001" in numbers(ax.yaxis)


def test_rounding_is_not_magnified_into_a_curve():
    with drawing(None) as ax:
        ax.plot([0, 1, 2], [0.25, 0.25 * (1 + 1e-12), 0.25])
        label_axis(ax.yaxis, "force", "N")
    low, high = ax.get_ylim()
    assert low == pytest.approx(0.2, rel=1e-6)
    assert high == pytest.approx(0.3, rel=1e-6)


def test_a_small_real_change_is_shown():
    with drawing(None) as ax:
        ax.plot([0, 1, 2], [0.25, 0.25 * (1 + 1e-4), 0.25])
        label_axis(ax.yaxis, "force", "N")
    assert np.ptp(ax.get_ylim()) < 1e-4
