"""Every physical parameter has unit, finite range and meaning; every model says what it is."""

from __future__ import annotations

import math
from typing import get_args

import pytest
from pydantic_core import PydanticUndefined

from electrovib.core.checks import STATUSES
from electrovib.core.quantity import Quantity, quantity_of
from electrovib.core.units import KINDS


def numbers_of(kind):
    for name, field in kind.model_fields.items():
        if float in (field.annotation, *get_args(field.annotation)):
            yield name, field


def test_every_float_is_a_declared_quantity(final_class):
    bare = [name for name, _ in numbers_of(final_class) if quantity_of(final_class, name) is None]
    assert not bare, f"{final_class.__name__}: no Quantity on {bare}"


def test_quantities_are_complete(final_class):
    for name, _ in numbers_of(final_class):
        quantity = quantity_of(final_class, name)
        assert quantity.unit in KINDS
        assert math.isfinite(quantity.low)
        assert math.isfinite(quantity.high)
        assert quantity.low <= quantity.high
        assert len(quantity.doc.split()) >= 1
        assert len(quantity.doc) > 3, f"{name}: '{quantity.doc}' is no meaning"


def test_defaults_lie_in_their_range(final_class):
    for name, field in numbers_of(final_class):
        if field.default is PydanticUndefined or field.default is None:
            continue
        # an int would be written '1', not '1.0', and be another hash
        assert type(field.default) is float, f"{name} = {field.default!r}"
        quantity_of(final_class, name).read(field.default)


def test_whole_numbers_are_bounded(final_class, build):
    """A count of 10**12 must be refused, whoever reads it."""
    for name, field in final_class.model_fields.items():
        if field.annotation is int or int in get_args(field.annotation):
            if str in get_args(field.annotation):
                continue  # the place of a column
            with pytest.raises(ValueError):
                final_class.model_validate({**final_class.example, name: 10**12})
    assert build(final_class) is not None


def test_the_example_is_enough_to_build_it(final_class, build):
    model = build(final_class)
    assert type(model) is final_class


def test_a_model_says_what_it_is(final_class):
    text = final_class.__dict__.get("__doc__") or ""
    first = text.strip().split("\n\n")[0]
    assert first.endswith("."), f"{final_class.__name__} begins '{first[:60]}'"
    assert len(first.split()) >= 3


def test_a_family_says_what_it_is(family):
    assert (family.__dict__.get("__doc__") or "").strip()


def test_status_is_known(final_class):
    assert final_class.status in ("", *STATUSES)
    if final_class.__module__.startswith("electrovib.papers."):
        assert final_class.reference
        assert final_class.status


@pytest.mark.parametrize(
    ("unit", "low", "high", "doc"),
    [
        ("feet", 0, 1, "length"),
        ("m", 0, math.inf, "length"),
        ("m", math.nan, 1, "length"),
        ("m", 2, 1, "length"),
        ("m", 0, 1, " "),
    ],
)
def test_an_incomplete_quantity_is_refused(unit, low, high, doc):
    with pytest.raises(TypeError):
        Quantity(unit, low, high, doc)
