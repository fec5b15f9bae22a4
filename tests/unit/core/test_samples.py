"""Measured numbers inside a model."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from pydantic_core import PydanticCustomError

from electrovib.core.model import Model, read_model
from electrovib.core.samples import Samples


class Record(Model):
    """A record of this test."""

    values: Samples


@given(values=hnp.arrays(np.float64, st.integers(0, 50)))
def test_packing_loses_no_bit(values):
    again = Samples.read(Samples(values).packed())
    assert again.values.tobytes() == values.tobytes()


def test_numbers_are_read_only_and_a_copy():
    source = np.arange(3.0)
    samples = Samples(source)
    source[0] = 9
    assert samples.values.tolist() == [0, 1, 2]
    with pytest.raises(ValueError, match="read-only"):
        samples.values[0] = 1
    with pytest.raises(AttributeError):
        samples.more = 1


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


def test_every_bit_counts():
    assert Samples([0.0]) != Samples([-0.0])
    assert Samples([np.nan]) == Samples([np.nan])
    assert Samples([1.0]) != Samples([1.0, 1.0])
    assert Samples([1.0]) != [1.0]
    with pytest.raises(AttributeError, match="read-only"):
        Samples([1.0]).values = np.zeros(1)


@pytest.mark.parametrize("given", [[1, 2], (1.0, 2.0), np.array([1, 2]), np.array([1.0, 2.0], ">f4")])
def test_lists_and_arrays_are_read(given):
    assert Samples.read(given).values.tolist() == [1, 2]
    assert Samples.read(given).values.dtype == np.float64


@pytest.mark.parametrize(
    "given", ["1, 2", "zlib+base64:???", "zlib+base64:AAAA", 3.0, None, {}, ["x"], [[1], [2]], [1, [2]]]
)
def test_what_is_no_list_of_numbers_is_refused(given):
    with pytest.raises(PydanticCustomError):
        Samples.read(given)


def test_two_dimensions_are_refused():
    with pytest.raises(ValueError, match="one dimension"):
        Samples([[1.0]])


def test_content_counts_for_equality_and_hash():
    one, same = (read_model(Record, {"values": [1.0, 2.0]}) for _ in range(2))
    other = read_model(Record, {"values": [1.0, np.nextafter(2.0, 3.0)]})
    assert one == same
    assert hash(one) == hash(same)
    assert one != other
    assert "2 samples" in repr(one.values)
    assert len(one.values) == 2


def test_the_byte_order_of_the_machine_does_not_matter():
    little, big = np.array([1.5, -2.5], "<f8"), np.array([1.5, -2.5], ">f8")
    assert Samples(little).canonical_content() == Samples(big).canonical_content()
    assert Samples(little).packed() == Samples(big).packed()
