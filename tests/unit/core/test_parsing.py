"""TOML and JSON from outside, and the samples packed in them."""

from __future__ import annotations

import base64
import time
import zlib

import numpy as np
import pytest
from pydantic_core import PydanticCustomError

from electrovib.core.errors import InputError
from electrovib.core.model import Model, read_model
from electrovib.core.parsing import read_json, read_toml
from electrovib.core.samples import Samples

DEEP = "nested more than 50 deep"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("x = " + "[" * 5000 + "]" * 5000, DEEP),
        ("x = " + "[" * 51 + "]" * 51, DEEP),
        ("x = " + "{a = " * 60 + "1" + "}" * 60, DEEP),
        (".".join("a" * 3000) + " = 1", DEEP),
        ("x = " + "1" * 5000, "a whole number of thousands of digits"),
        ("x = [", "Invalid value"),
    ],
)
def test_toml_is_refused_with_a_reason(text, words):
    with pytest.raises(ValueError, match=words):
        read_toml(text)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[" * 100_000, DEEP),
        ("[" * 51 + "]" * 51, DEEP),
        ('{"a":' * 60 + "1" + "}" * 60, DEEP),
        ("1" * 5000, "a whole number of thousands of digits"),
        ("{", "Expecting"),
        (7, "of type int, not a text"),
        (np.arange(2), "of type ndarray, not a text"),
    ],
)
def test_json_is_refused_with_a_reason(text, words):
    with pytest.raises(ValueError, match=words):
        read_json(text)


def test_what_is_in_order_is_read():
    assert read_toml("a.b = [[1]]") == {"a": {"b": [[1]]}}
    assert read_toml("x = " + "[" * 49 + "]" * 49)["x"]
    assert read_json("[" * 50 + "]" * 50)
    assert read_json('{"a": [1, null]}') == {"a": [1, None]}


MARK = "zlib+base64:"


def packed(raw, level=9):
    return MARK + base64.b64encode(zlib.compress(raw, level)).decode()


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (packed(bytes(40_000_000)), "would unpack to more than 33"),
        (packed(np.arange(100.0).tobytes())[:-8], "incomplete"),
        (MARK, "incomplete"),
        ([10**400], "not numbers"),
    ],
)
def test_packed_samples_that_are_refused(text, words):
    with pytest.raises(PydanticCustomError, match=words):
        Samples.read(text)


def test_any_samples_are_packed_so_that_they_can_be_read():
    alike = Samples(np.zeros(4_300_000))  # 34.4 MB, more than their packed text may unfold to
    text = alike.packed()
    assert len(text) > 34_400_000
    assert Samples.read(text).values.tobytes() == alike.values.tobytes()
    assert len(Samples(np.zeros(1000)).packed()) < 100


class Many(Model):
    """A model of this test."""

    one: int = 1


def test_a_whole_number_of_thousands_of_digits_is_told():
    with pytest.raises(InputError, match=r"one = .*whole number"):
        read_model(Many, {"one": [10**5000]})


@pytest.mark.parametrize(
    "text", ["a" * 124_000, "a b" + "1." * 62_000, "x = " + "1." * 62_000, "a-b_" * 31_000]
)
def test_advice_on_a_long_line_takes_no_time(text):
    begun = time.process_time()
    with pytest.raises(ValueError, match=r"line 1"):
        read_toml(f"{text}\n")
    assert time.process_time() - begun < 1.0
