"""What a model is, and the sentences a user reads."""

from __future__ import annotations

import math
from abc import abstractmethod
from typing import Annotated, ClassVar

import pytest
from pydantic import model_validator
from pydantic_core import PydanticCustomError

from electrovib.core.errors import InputError
from electrovib.core.model import Model, read_model
from electrovib.core.quantity import Number, Quantity
from electrovib.scenario import load


class Filling(Model, family=True):
    """What fills a layer of this test."""

    @abstractmethod
    def permittivity(self) -> float:
        """Give it."""


class Plain(Filling):
    """One number."""

    value: Annotated[Number, Quantity("1", 1, 100, "relative permittivity")] = 2.0

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


def test_members_are_chosen_by_name():
    slab = read_model(Slab, {"thickness": 1, "filling": {"model": "Plain", "value": 3}})
    assert slab.filling == Plain(value=3.0)
    assert slab.filling.permittivity() == 3.0


def test_members_nest():
    plain = {"model": "Plain", "value": 4}
    filling = read_model(
        Filling, {"model": "Mixture", "first": plain, "second": {"model": "Plain"}, "share": 0.5}
    )
    assert filling.permittivity() == 3.0
    assert [path for path, _, _ in filling.parameters()] == ["first.value", "second.value", "share"]


def test_a_model_is_taken_as_it_is():
    plain = Plain(value=5.0)
    assert read_model(Slab, {"thickness": 1, "filling": plain}).filling is plain


def test_the_sentences_of_the_design():
    changes = {
        "stack": {"insulator": {"thickness": "2 V", "material": {"model": "Constant", "permittivity": 3}}}
    }
    tables = load("vezzoli_2014/fig6").to_dict() | changes
    sentence = "stack.insulator.thickness = '2 V': expected a length, for instance '90 um'"
    with pytest.raises(InputError) as caught:
        load({"schema": 1} | tables)
    assert sentence in caught.value.problems
    tables["stack"]["insulator"] = {"thicknes": "90 um"}
    with pytest.raises(InputError) as caught:
        load({"schema": 1} | tables)
    sentence = "unknown parameter 'thicknes' of Layer. Did you mean 'thickness'?"
    assert f"stack.insulator.thicknes: {sentence}" in caught.value.problems


def test_a_mistake_knows_its_path_and_its_value():
    unit, unknown = problems({"thickness": "2 V", "filling": {"model": "Plain"}, "thicknes": 1})
    assert (unit.path, unit.value) == ("thickness", "'2 V'")
    assert unit.reason.startswith("expected a length")
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


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        (
            {"thickness": math.nan},
            "thickness = nan: must be a finite number; expected a length, for instance '90 um'",
        ),
        (
            {"thickness": math.inf},
            "thickness = inf: must be a finite number; expected a length, for instance '90 um'",
        ),
        ({"thickness": True}, "thickness = True: expected a length, for instance '90 um'"),
        (
            {"thickness": -1},
            "thickness = -1: a number without a unit is in SI, so this is -1 m; must lie between 1 nm and 1 m",
        ),
        ({"thickness": "9**9**9"}, "thickness = '9**9**9': expected a length, for instance '90 um'"),
        (
            {"thickness": "x" * 500},
            f"thickness = '{'x' * 34} ... {'x' * 19}': expected a length, for instance '90 um'",
        ),
        ({"thickness": 1, "count": 13}, "the file = {...}: 13 slabs {never} hold"),
        ({"thickness": 1, "count": 2.5}, "count = 2.5: Input should be a valid integer, got a number with a"),
        (
            {"thickness": 1, "filling": {}},
            'filling = {...}: needs a name, for instance model = "...", one of:',
        ),
        ({"thickness": 1, "filling": {"model": 1}}, "filling = {model = 1, ...}: needs a name"),
        ({"model": "Slob", "thickness": 1}, "expected the model Slab, not 'Slob'"),
        ({"thickness": 1, "filling": "plain"}, "{ model = \"...\" }. Did you mean 'Plain' ("),
        ([], "the file = []: expected a table of parameters of Slab"),
    ],
)
def test_sentences(content, sentence):
    found = problems(content)
    assert len(found) == 1
    assert sentence in found[0]


def test_wrong_capitals_find_the_name():
    assert "Did you mean 'Plain' (" in problems({"thickness": 1, "filling": {"model": "PLAIN"}})[0]


def test_equality_and_hash_are_those_of_the_content():
    one, other = Slab(thickness=1.0), read_model(Slab, {"thickness": "1 m", "count": 1})
    assert one == other
    assert hash(one) == hash(other)
    assert len({one, other}) == 1
    assert one != Slab(thickness=0.5)
    assert one != one.to_dict()
    assert Plain() != Slab(thickness=1.0)


def test_a_family_is_not_built():
    with pytest.raises(TypeError, match="abstract"):
        Filling()
    with pytest.raises(TypeError, match="abstract"):
        Unfinished()


def test_final_classes_stay_final():
    with pytest.raises(TypeError, match="Better subclasses the final class Plain: wrap it instead"):

        class Better(Plain):
            """Not allowed."""


def test_models_are_frozen():
    with pytest.raises(InputError, match="replace returns a changed copy"):
        Plain().value = 3.0
    with pytest.raises(InputError, match=r"Plain\.value: is not deleted in place"):
        del Plain().value


def test_to_dict_names_members_only():
    assert Plain().to_dict() == {"model": "Plain", "value": 2.0}
    assert "model" not in Slab(thickness=1.0).to_dict()


def test_words_on_the_class_are_no_parameters():
    class Described(Filling):
        """With words of its own."""

        reference: ClassVar[str] = "doi:10.0/x"

        def permittivity(self):
            return 1.0

    assert Described().to_dict() == {"model": "Described"}
