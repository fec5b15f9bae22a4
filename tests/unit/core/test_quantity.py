"""The declaration of a parameter: what it takes, what it refuses, and how it describes itself."""

from __future__ import annotations

import math
from decimal import Decimal
from typing import Annotated

import numpy as np
import pytest
from pydantic_core import PydanticCustomError

from electrovib.core.model import Model
from electrovib.core.quantity import Number, Quantity, quantity_of

LENGTH = Quantity("m", 1e-6, 1e-3, "thickness")


class Slab(Model):
    """A slab of this test."""

    thickness: Annotated[Number, LENGTH]
    charge: Annotated[Number | None, Quantity("C/m2", -1, 1, "charge, if any")] = None


@pytest.mark.parametrize("given", ["90 um", 9e-05, "9e-5", np.float64(9e-05)])
def test_numbers_and_texts_are_read(given):
    value = LENGTH.read(given)
    assert value == 9e-05
    assert type(value) is float


@pytest.mark.parametrize("given", [np.int64(1), np.float32(0.5), 1])
def test_numbers_of_numpy_are_numbers(given):
    assert Quantity("1", 0, 10, "share").read(given) == float(given)


def test_the_ends_belong_to_the_range():
    assert LENGTH.read(1e-6) == 1e-6
    assert LENGTH.read(1e-3) == 1e-3


@pytest.mark.parametrize("given", [np.nextafter(1e-6, 0), np.nextafter(1e-3, 1), -9e-05, "90 m"])
def test_out_of_range_is_refused_with_the_range(given):
    with pytest.raises(PydanticCustomError, match="must lie between 1 um and 1 mm"):
        LENGTH.read(given)


@pytest.mark.parametrize("given", [math.nan, math.inf, -math.inf, np.nan, np.float64("inf")])
def test_not_finite_is_refused(given):
    with pytest.raises(PydanticCustomError, match="must be a finite number; expected a length"):
        LENGTH.read(given)


@pytest.mark.parametrize(
    "given",
    [True, False, np.True_, None, [], {}, "2 V", "nan", b"90 um", 1j, np.array([1e-5]), Decimal("9e-5")],
)
def test_what_is_no_number_is_refused(given):
    with pytest.raises(PydanticCustomError, match="expected a length, for instance '90 um'"):
        LENGTH.read(given)


def test_there_is_one_zero():
    assert str(Quantity("V", -1, 1, "level").read(-0.0)) == "0.0"


@pytest.mark.parametrize(
    ("unit", "low", "high", "doc"),
    [
        ("furlong", 0, 1, "length"),
        ("m", 1, 0, "length"),
        ("m", 0, math.inf, "length"),
        ("m", math.nan, 1, "length"),
        ("m", 0, 1, ""),
    ],
)
def test_a_wrong_declaration_is_refused(unit, low, high, doc):
    with pytest.raises(TypeError):
        Quantity(unit, low, high, doc)


def test_the_declaration_is_found_again():
    assert quantity_of(Slab, "thickness") is LENGTH
    assert quantity_of(Slab, "charge").unit == "C/m2"


def test_absent_stays_absent():
    assert Slab.model_validate({"thickness": "90 um"}).charge is None
    assert Slab.model_validate({"thickness": "90 um", "charge": "1 uC/m2"}).charge == 1e-6


def test_the_schema_describes_the_parameter():
    described = Slab.model_json_schema()["properties"]["thickness"]
    assert described["unit"] == "m"
    assert described["minimum"] == 1e-6
    assert described["maximum"] == 1e-3
    assert described["description"] == "thickness"
