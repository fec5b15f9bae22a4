"""What a model, its parameters and samples are, what they take and refuse, and texts from outside."""

import base64
import copy
import math
import pickle
import time
import zlib
from abc import abstractmethod
from decimal import Decimal
from typing import Annotated, ClassVar

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from pydantic import model_validator
from pydantic_core import PydanticCustomError

from electrovib.core.errors import InputError
from electrovib.core.model import Model, read_model
from electrovib.core.parsing import read_json, read_toml
from electrovib.core.quantity import Number, Quantity, quantity_of
from electrovib.core.samples import Samples
from electrovib.scenario import load

LENGTH = Quantity("m", 1e-6, 1e-3, "thickness")
SHARE = Quantity("1", 0, 10, "share")


class Film(Model):
    """A film of this test."""

    thickness: Annotated[Number, LENGTH]
    charge: Annotated[Number | None, Quantity("C/m2", -1, 1, "charge, if any")] = None


@pytest.mark.parametrize(
    ("quantity", "given", "value"),
    [(LENGTH, given, 9e-05) for given in ("90 um", 9e-05, "9e-5", np.float64(9e-05))]
    + [(LENGTH, 1e-6, 1e-6), (LENGTH, 1e-3, 1e-3)]  # the ends belong to the range
    + [(SHARE, np.int64(1), 1.0), (SHARE, np.float32(0.5), 0.5), (SHARE, 1, 1.0)],
)
def test_numbers_and_texts_are_read(quantity, given, value):
    found = quantity.read(given)
    assert found == value
    assert type(found) is float
    assert str(Quantity("V", -1, 1, "level").read(-0.0)) == "0.0"  # there is one zero


FAR = "must lie between 1 um and 1 mm"
ENDLESS = "must be a finite number; expected a length"
NO_NUMBER = "expected a length, for instance '90 um'"


@pytest.mark.parametrize(
    ("words", "given"),
    [(FAR, given) for given in (np.nextafter(1e-6, 0), np.nextafter(1e-3, 1), -9e-05, "90 m")]
    + [(ENDLESS, given) for given in (math.nan, math.inf, -math.inf, np.nan, np.float64("inf"))]
    + [(NO_NUMBER, given) for given in (True, False, np.True_, None, [], {}, 1j, np.array([1e-5]))]
    + [(NO_NUMBER, given) for given in ("2 V", "nan", b"90 um", Decimal("9e-5"))],
)
def test_what_a_parameter_refuses(words, given):
    with pytest.raises(PydanticCustomError, match=words):
        LENGTH.read(given)


@pytest.mark.parametrize(
    ("unit", "low", "high", "doc"),
    [("furlong", 0, 1, "length"), ("m", 0, 1, "")]
    + [("m", low, high, "length") for low, high in ((1, 0), (0, math.inf), (math.nan, 1))],
)
def test_a_wrong_declaration_is_refused(unit, low, high, doc):
    with pytest.raises(TypeError):
        Quantity(unit, low, high, doc)


def test_the_declaration_is_found_again_and_describes_the_parameter():
    assert quantity_of(Film, "thickness") is LENGTH
    assert quantity_of(Film, "charge").unit == "C/m2"
    described = Film.model_json_schema()["properties"]["thickness"]
    known = {"unit": "m", "minimum": 1e-6, "maximum": 1e-3, "description": "thickness"}
    assert known.items() <= described.items()
    assert Film.model_validate({"thickness": "90 um"}).charge is None
    assert Film.model_validate({"thickness": "90 um", "charge": "1 uC/m2"}).charge == 1e-6


class Filling(Model, family=True):
    """What fills a layer of this test."""

    @abstractmethod
    def permittivity(self) -> float:
        """Give it."""


class Plain(Filling):
    """One number."""

    value: Annotated[Number, Quantity("1", 1, 100, "relative permittivity")] = 2.0
    reference: ClassVar[str] = "doi:10.0/x"

    def permittivity(self):
        return self.value


class Mixture(Filling):
    """Two fillings in a share."""

    first: Filling
    second: Filling
    share: Annotated[Number, Quantity("1", 0, 1, "share of the first")]

    def permittivity(self):
        return self.first.permittivity() * self.share + self.second.permittivity() * (1 - self.share)


class Unfinished(Filling):
    """Forgets the method of its family."""


class Slab(Model):
    """A slab of this test."""

    thickness: Annotated[Number, Quantity("m", 1e-9, 1, "thickness of the slab")]
    filling: Filling = Plain()
    count: int = 1
    name: str = ""

    @model_validator(mode="after")
    def _odd(self):
        if self.count == 13:
            raise PydanticCustomError("count", "{why}", {"why": "13 slabs {never} hold"})
        return self


def problems(content, kind=Slab):
    with pytest.raises(InputError) as caught:
        read_model(kind, content)
    return list(caught.value.problems)


def test_members_are_chosen_by_name_and_nest():
    slab = read_model(Slab, {"thickness": 1, "filling": {"model": "Plain", "value": 3}})
    assert slab.filling == Plain(value=3.0)
    plain, other = {"model": "Plain", "value": 4}, {"model": "Plain"}
    filling = read_model(Filling, {"model": "Mixture", "first": plain, "second": other, "share": 0.5})
    assert filling.permittivity() == 3.0
    assert [path for path, _, _ in filling.parameters()] == ["first.value", "second.value", "share"]
    assert read_model(Slab, {"thickness": 1, "filling": filling}).filling is filling
    assert Plain().to_dict() == {"model": "Plain", "value": 2.0}  # words on the class are no parameters
    assert "model" not in Slab(thickness=1.0).to_dict()


def test_a_mistake_knows_its_path_and_its_value():
    unit, unknown = problems({"thickness": "2 V", "filling": {"model": "Plain"}, "thicknes": 1})
    assert (unit.path, unit.value, unit.reason) == ("thickness", "'2 V'", NO_NUMBER)
    assert (unknown.path, unknown.value) == ("thicknes", "")
    with pytest.raises(InputError) as caught:
        load("vezzoli_2014/fig6").replace({"drive.hight": 3, "load.normal_force": "2 V"})
    assert [problem.path for problem in caught.value.problems] == ["drive.hight", "load.normal_force"]


def test_all_mistakes_are_told_at_once():
    wrong = {
        "thicknes": 1,
        "filling": {"model": "Mixture", "first": {"model": "Plane"}, "second": 3, "share": "2 V", "extra": 1},
        "count": True,
        "name": 5,
    }
    assert sorted(problems(wrong)) == [
        "count = True: expected a whole number",
        "filling.extra: unknown parameter 'extra' of Mixture. Known: first, second, share.",
        "filling.first = {model = 'Plane', ...}: unknown Filling model 'Plane'. Did you mean 'Plain' (One number)?",
        'filling.second = 3: expected a table that names a Filling model, { model = "..." }.'
        " Known: Mixture, Plain, Unfinished.",
        "filling.share = '2 V': expected a plain number, for instance '0.5'",
        "name = 5: Input should be a valid string",
        "thicknes: unknown parameter 'thicknes' of Slab. Did you mean 'thickness'?",
        "thickness: missing: thickness of the slab, between 1 nm and 1 m",
    ]


LONG = f"thickness = '{'x' * 34} ... {'x' * 19}': {NO_NUMBER}"


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        ({"thickness": math.nan}, "thickness = nan: must be a finite number; expected a length"),
        ({"thickness": True}, f"thickness = True: {NO_NUMBER}"),
        ({"thickness": -1}, "a number without a unit is in SI, so this is -1 m; must lie between 1 nm and"),
        ({"thickness": "9**9**9"}, f"thickness = '9**9**9': {NO_NUMBER}"),
        ({"thickness": "x" * 500}, LONG),
        ({"thickness": 1, "count": 13}, "the file = {...}: 13 slabs {never} hold"),
        ({"thickness": 1, "count": 2.5}, "count = 2.5: Input should be a valid integer, got a number with a"),
        ({"thickness": 1, "filling": {}}, 'filling = {...}: needs a name, for instance model = "...", one'),
        ({"thickness": 1, "filling": {"model": 1}}, "filling = {model = 1, ...}: needs a name"),
        ({"thickness": 1, "filling": {"model": "PLAIN"}}, "Did you mean 'Plain' ("),
        ({"thickness": 1, "filling": "plain"}, "{ model = \"...\" }. Did you mean 'Plain' ("),
        ({"model": "Slob", "thickness": 1}, "expected the model Slab, not 'Slob'"),
        ([], "the file = []: expected a table of parameters of Slab"),
    ],
)
def test_sentences(content, sentence):
    (found,) = problems(content)
    assert sentence in found


def test_equality_and_hash_are_those_of_the_content():
    one, other = Slab(thickness=1.0), read_model(Slab, {"thickness": "1 m", "count": 1})
    assert one == other
    assert hash(one) == hash(other)
    assert one != Slab(thickness=0.5)
    assert one != one.to_dict()
    assert Plain() != one


def test_models_are_frozen_final_and_a_family_is_not_built():
    with pytest.raises(InputError, match="replace returns a changed copy"):
        Plain().value = 3.0
    with pytest.raises(InputError, match=r"Plain\.value: is not deleted in place"):
        del Plain().value
    for abstract in (Filling, Unfinished):
        with pytest.raises(TypeError, match="abstract"):
            abstract()
    with pytest.raises(TypeError, match="Better subclasses the final class Plain: wrap it instead"):

        class Better(Plain):
            """Not allowed."""


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


DECIMALS = st.builds(
    lambda whole, places: np.array([float(f"{each}e-{places}") for each in whole]),
    st.lists(st.integers(-(10**9), 10**9), min_size=1, max_size=50),
    st.integers(0, 9),
)


@given(decimals=DECIMALS)
def test_decimal_numbers_travel_without_loss(decimals):
    assert Samples(decimals).packed().startswith("decimals+zlib+base64:")
    assert Samples.read(Samples(decimals).packed()) == Samples(decimals)


@given(values=hnp.arrays(np.float64, st.integers(0, 50)))
def test_packing_loses_no_bit(values):
    again = Samples.read(Samples(values).packed())
    assert again.values.tobytes() == values.tobytes()
    assert again.canonical_content() == Samples(values.astype(">f8")).canonical_content()
    assert again.packed() == Samples(values.astype(">f8")).packed()


@pytest.mark.parametrize(
    ("values", "size"),
    [
        pytest.param(np.zeros(4_300_000), 2, id="zeros"),
        pytest.param(np.arange(5_000_000) / 1e6, 2, id="even stamps"),
        pytest.param(np.full(4_300_000, 1 / 3), 8, id="no decimals"),
    ],
)
def test_any_samples_are_packed_so_that_they_can_be_read(values, size):
    """Compressed they would be less than the reader unpacks: their steps, or they themselves, are kept as they are."""
    samples = Samples(values)
    text = samples.packed()
    assert len(text) == pytest.approx(4 / 3 * size * len(values), rel=1e-2)
    assert Samples.read(text) == samples
    assert len(Samples(values[:1000]).packed()) < 200


COPIES = {
    "pickle": lambda value: pickle.loads(pickle.dumps(value)),
    "oldest pickle": lambda value: pickle.loads(pickle.dumps(value, protocol=0)),
    "copy": copy.copy,
    "deep copy": copy.deepcopy,
}


@pytest.mark.parametrize("values", [[1.0, np.nan, -0.0], [0.0, -0.0, 0.25, -0.0]], ids=["bytes", "decimals"])
def test_a_packed_text_keeps_every_bit(values):
    samples = Samples(values)
    assert Samples.read(samples.packed()) == samples


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
    [(given, None) for given in ("1, 2", f"{MARK}???", f"{MARK}AAAA", 3.0, {}, ["x"], [[1], [2]], [1, [2]])]
    + [(packed(bytes(40_000_000)), "would unpack to more than 33"), ([10**400], "not numbers"), (None, None)]
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
