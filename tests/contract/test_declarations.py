"""Every parameter has unit, finite range and meaning; every model says what it is, is final and frozen, or has members."""

import math
from typing import get_args

import pytest
from pydantic_core import PydanticUndefined

from electrovib.core.citation import STATUSES
from electrovib.core.errors import InputError
from electrovib.core.model import Model, read_model
from electrovib.core.quantity import quantity_of
from electrovib.core.units import KINDS


def test_every_number_is_a_complete_quantity_with_its_default_in_range(final_class):
    for name, field in final_class.model_fields.items():
        kinds = (field.annotation, *get_args(field.annotation))
        # but the place of a column: 10**12 is refused, whoever reads it
        if int in kinds and str not in kinds:
            with pytest.raises(ValueError):
                final_class.model_validate({**final_class.example, name: 10**12})
        if float not in kinds:
            continue
        quantity = quantity_of(final_class, name)
        assert quantity is not None, f"{final_class.__name__}: no Quantity on {name}"
        assert quantity.unit in KINDS
        assert -math.inf < quantity.low <= quantity.high < math.inf
        assert len(quantity.doc.strip()) > 3, f"{name}: '{quantity.doc}' is no meaning"
        if field.default is not PydanticUndefined and field.default is not None:
            # an int would be written '1', not '1.0', and be another hash
            assert type(field.default) is float, f"{name} = {field.default!r}"
            quantity.read(field.default)


def test_a_model_says_what_it_is_and_how_well_it_is_known(final_class):
    text = final_class.__dict__.get("__doc__") or ""
    first = text.strip().split("\n\n")[0]
    assert first.endswith("."), f"{final_class.__name__} begins '{first[:60]}'"
    assert len(first.split()) >= 3
    assert final_class.status in ("", *STATUSES)
    if final_class.__module__.startswith("electrovib.papers."):
        assert final_class.reference
        assert final_class.status


def test_a_family_says_what_it_is_and_names_its_members(family, discovered):
    assert (family.__dict__.get("__doc__") or "").strip()
    names = [kind.__name__ for kind in discovered["final_class"].values() if issubclass(kind, family)]
    assert names
    with pytest.raises(InputError) as caught:
        read_model(family, {})
    assert all(name in str(caught.value) for name in names)


def test_a_member_is_built_from_its_example_and_read_by_its_name(final_class, build):
    model = build(final_class)
    assert type(model) is final_class
    family = final_class.__mro__[1]
    reader = final_class if family is Model else family
    assert read_model(reader, {"model": final_class.__name__, **final_class.example}) == model
    with pytest.raises(InputError, match="Tweaked"):
        read_model(reader, {"model": "Tweaked", **final_class.example})


def test_a_final_class_cannot_be_subclassed_nor_an_instance_be_changed(final_class, build):
    for bases in ((final_class,), (type("Mixin", (), {}), final_class)):
        with pytest.raises(TypeError, match="wrap it instead"):
            type("Tweaked", bases, {"__module__": __name__})
    model = build(final_class)
    for name in final_class.model_fields:
        with pytest.raises(InputError, match="replace returns a changed copy"):
            setattr(model, name, getattr(model, name))
    with pytest.raises(InputError, match="no_such_thing: is not changed in place"):
        model.no_such_thing = 1


KNOWN = {
    "drive_class": {"Trapezium", "Sine", "Sampled"},
    "material_class": {"Constant", "Debye", "Prony", "ColeCole", "Tabulated"},
    "law_class": {"MaxwellStressInGap", "Vezzoli2014Causal", "Vezzoli2014PerFrequency"},
    "paper": {"vezzoli_2014", "gabriel_1996", "palmar_1995", "plutchik_1963"},
    "scenario": {"vezzoli_2014-fig6"},
    "skin": {"gabriel_1996-dry"},
    "final_class": {"scenario.experiment.Scenario"},
    "family": {"physics.drive.base.Drive"},
}


def test_the_contracts_run_over_something_and_not_over_classes_of_other_tests(discovered):
    assert all(discovered.values()), {name: len(found) for name, found in discovered.items()}
    assert {
        name: found - set(discovered[name]) for name, found in KNOWN.items() if found - set(discovered[name])
    } == {}
    assert all("test" not in name.split(".")[0] for name in discovered["final_class"])
