"""Units as a person reads them."""

from __future__ import annotations

import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from electrovib.core.units import PREFIXES, parse_quantity
from electrovib.view.style import drawing
from electrovib.view.units import label_axis, prefix_for, pretty_quantity, pretty_unit, typeset


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
