"""The unit of a file's column."""

from __future__ import annotations

from typing import Annotated

import pytest

from electrovib.core.column_unit import column_unit, is_unit_of
from electrovib.core.errors import InputError
from electrovib.core.model import Model, read_model


class Column(Model):
    """A column of this test."""

    unit: Annotated[str, column_unit("s")] = "s"


@pytest.mark.parametrize(
    ("kind", "text", "answer"),
    [
        ("s", "us", True),
        ("s", "µs", True),
        ("s", "V", False),
        ("s", "", False),
        ("s", "3 us", False),
        ("1", "1", True),
        ("1", "-", True),
        ("1", "%", True),
        ("1", "V", False),
        ("V/m", "kV/mm", True),
        ("s", 5, False),
    ],
)
def test_units_of_a_kind(kind, text, answer):
    assert is_unit_of(kind, text) == answer


def test_a_wrong_unit_is_told():
    assert read_model(Column, {"unit": "ms"}).unit == "ms"
    with pytest.raises(InputError, match="the column holds a time: expected a unit such as 's'"):
        read_model(Column, {"unit": "V"})
