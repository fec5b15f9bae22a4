"""Content from outside: TOML and JSON, measured numbers inside a model, and the text in which they are packed."""

from __future__ import annotations

import base64
import copy
import pickle
import time
import zlib

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from pydantic_core import PydanticCustomError

from electrovib.core.errors import InputError
from electrovib.core.model import Model, read_model
from electrovib.core.parsing import read_json, read_toml
from electrovib.core.samples import Samples

DEEP = "nested more than 50 deep"
DIGITS = "a whole number of thousands of digits"


class Record(Model):
    """A record of this test."""

    values: Samples
    one: int = 1


@pytest.mark.parametrize(
    ("read", "text", "words"),
    [
        (read_toml, "x = " + "[" * 5000 + "]" * 5000, DEEP),
        (read_toml, "x = " + "[" * 51 + "]" * 51, DEEP),
        (read_toml, "x = " + "{a = " * 60 + "1" + "}" * 60, DEEP),
        (read_toml, ".".join("a" * 3000) + " = 1", DEEP),
        (read_toml, "x = " + "1" * 5000, DIGITS),
        (read_toml, "x = [", "Invalid value"),
        (read_json, "[" * 100_000, DEEP),
        (read_json, "[" * 51 + "]" * 51, DEEP),
        (read_json, '{"a":' * 60 + "1" + "}" * 60, DEEP),
        (read_json, "1" * 5000, DIGITS),
        (read_json, "{", "Expecting"),
        (read_json, 7, "of type int, not a text"),
        (read_json, np.arange(2), "of type ndarray, not a text"),
    ],
)
def test_a_text_is_refused_with_a_reason(read, text, words):
    with pytest.raises(ValueError, match=words):
        read(text)


def test_what_is_in_order_is_read():
    assert read_toml("a.b = [[1]]") == {"a": {"b": [[1]]}}
    assert read_toml("x = " + "[" * 49 + "]" * 49)["x"]
    assert read_json("[" * 50 + "]" * 50)
    assert read_json('{"a": [1, null]}') == {"a": [1, None]}


@pytest.mark.parametrize(
    "text", ["a" * 124_000, "a b" + "1." * 62_000, "x = " + "1." * 62_000, "a-b_" * 31_000]
)
def test_advice_on_a_long_line_takes_no_time(text):
    begun = time.process_time()
    with pytest.raises(ValueError, match=r"line 1"):
        read_toml(f"{text}\n")
    assert time.process_time() - begun < 1.0


@given(values=hnp.arrays(np.float64, st.integers(0, 50)))
def test_packing_loses_no_bit(values):
    again = Samples.read(Samples(values).packed())
    assert again.values.tobytes() == values.tobytes()
    assert again.canonical_content() == Samples(values.astype(">f8")).canonical_content()
    assert again.packed() == Samples(values.astype(">f8")).packed()


def test_any_samples_are_packed_so_that_they_can_be_read():
    alike = Samples(np.zeros(4_300_000))  # 34.4 MB, more than their packed text may unfold to
    text = alike.packed()
    assert len(text) > 34_400_000
    assert Samples.read(text).values.tobytes() == alike.values.tobytes()
    assert len(Samples(np.zeros(1000)).packed()) < 100


COPIES = {
    "pickle": lambda value: pickle.loads(pickle.dumps(value)),
    "oldest pickle": lambda value: pickle.loads(pickle.dumps(value, protocol=0)),
    "copy": copy.copy,
    "deep copy": copy.deepcopy,
}


@pytest.mark.parametrize("made", COPIES)
def test_a_copy_is_the_same_value_and_as_read_only(made):
    samples = Samples([1.0, np.nan, -0.0])
    record = read_model(Record, {"values": samples})
    for again in (COPIES[made](samples), COPIES[made](record).values):
        assert again == samples
        assert hash(again) == hash(samples)
        assert again.values.tobytes() == samples.values.tobytes()
        with pytest.raises(ValueError, match="read-only"):
            again.values[0] = 1
        with pytest.raises(ValueError, match="cannot set WRITEABLE"):
            again.values.setflags(write=True)
    assert COPIES[made](record) == record
    assert hash(COPIES[made](record)) == hash(record)


def test_every_bit_counts_for_equality_and_nothing_changes_it():
    assert Samples([0.0]) != Samples([-0.0])
    assert Samples([np.nan]) == Samples([np.nan])
    assert Samples([1.0]) != Samples([1.0, 1.0])
    assert Samples([1.0]) != [1.0]
    one, same = (read_model(Record, {"values": [1.0, 2.0]}) for _ in range(2))
    assert one == same
    assert hash(one) == hash(same)
    assert one != read_model(Record, {"values": [1.0, np.nextafter(2.0, 3.0)]})
    assert "2 samples" in repr(one.values)
    assert len(one.values) == 2
    source = np.arange(3.0)
    samples = Samples(source)
    source[0] = 9
    assert samples.values.tolist() == [0, 1, 2]
    with pytest.raises(AttributeError):
        samples.more = 1
    with pytest.raises(AttributeError, match="read-only"):
        samples.values = np.zeros(1)


@pytest.mark.parametrize("given", [[1, 2], (1.0, 2.0), np.array([1, 2]), np.array([1.0, 2.0], ">f4")])
def test_lists_and_arrays_are_read(given):
    assert Samples.read(given).values.tolist() == [1, 2]
    assert Samples.read(given).values.dtype == np.float64


MARK = "zlib+base64:"


def packed(raw):
    return MARK + base64.b64encode(zlib.compress(raw, 9)).decode()


@pytest.mark.parametrize(
    ("given", "words"),
    [
        (given, None)
        for given in ("1, 2", f"{MARK}???", f"{MARK}AAAA", 3.0, None, {}, ["x"], [[1], [2]], [1, [2]])
    ]
    + [(packed(bytes(40_000_000)), "would unpack to more than 33"), ([10**400], "not numbers")]
    + [(given, "incomplete") for given in (MARK, packed(np.arange(100.0).tobytes())[:-8])],
)
def test_what_is_no_list_of_numbers_is_refused_with_the_reason(given, words):
    with pytest.raises(PydanticCustomError, match=words):
        Samples.read(given)


def test_two_dimensions_and_thousands_of_digits_are_told():
    with pytest.raises(ValueError, match="one dimension"):
        Samples([[1.0]])
    with pytest.raises(InputError, match=r"one = .*whole number"):
        read_model(Record, {"values": [], "one": [10**5000]})
