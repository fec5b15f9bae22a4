"""Declared equations as lines of text."""

from __future__ import annotations

import pytest

from electrovib.core.formulas import formula_lines


@pytest.mark.parametrize(
    ("name", "text", "lines"),
    [
        ("voltage", "a*b + c", ("voltage = a*b + c",)),
        ("element.impedance", "r + path.element().impedance(f)", ("impedance = r + path.impedance(f)",)),
        ("part.friction'", "-a", ("part.friction' = -a",)),
        ("rate", "0 if leak is None else 1/leak", ("rate = 0, without leak", "rate = 1/leak, otherwise")),
        (
            "v",
            "low if t < a else high if a <= t < b else low",
            ("v = low, for t < a", "v = high, for a <= t < b", "v = low, otherwise"),
        ),
    ],
)
def test_an_equation_has_a_line_for_each_case(name, text, lines):
    assert formula_lines(name, text) == lines
