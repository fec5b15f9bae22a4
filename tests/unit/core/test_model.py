"""What a model and its parameters are, what they take and refuse, and the sentences a user reads."""

from __future__ import annotations

import math
from abc import abstractmethod
from decimal import Decimal
from typing import Annotated, ClassVar

import numpy as np
import pytest
from pydantic import model_validator
from pydantic_core import PydanticCustomError

from electrovib.core.errors import InputError
from electrovib.core.model import Model, read_model
from electrovib.core.quantity import Number, Quantity, quantity_of
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
    assert {
        "unit": "m",
        "minimum": 1e-6,
        "maximum": 1e-3,
        "description": "thickness",
    }.items() <= described.items()
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


def test_a_mistake_in_a_scenario_knows_its_path_and_its_value():
    tables = load("vezzoli_2014/fig6").to_dict()
    for layer, path, value, reason in (
        ({"thickness": "2 V"}, "thickness", "'2 V'", "expected a length, for instance '90 um'"),
        (
            {"thicknes": "90 um"},
            "thicknes",
            "",
            "unknown parameter 'thicknes' of Layer. Did you mean 'thickness'?",
        ),
    ):
        with pytest.raises(InputError) as caught:
            load({"schema": 1} | tables | {"stack": {"insulator": layer}})
        told = [(problem.path, problem.value, problem.reason) for problem in caught.value.problems]
        assert (f"stack.insulator.{path}", value, reason) in told
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
        (
            {"thickness": -1},
            "a number without a unit is in SI, so this is -1 m; must lie between 1 nm and 1 m",
        ),
        ({"thickness": "9**9**9"}, f"thickness = '9**9**9': {NO_NUMBER}"),
        ({"thickness": "x" * 500}, LONG),
        ({"thickness": 1, "count": 13}, "the file = {...}: 13 slabs {never} hold"),
        ({"thickness": 1, "count": 2.5}, "count = 2.5: Input should be a valid integer, got a number with a"),
        (
            {"thickness": 1, "filling": {}},
            'filling = {...}: needs a name, for instance model = "...", one of:',
        ),
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
