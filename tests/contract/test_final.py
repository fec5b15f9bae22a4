"""Abstract or final: a family has members and cannot be built, a final class is never subclassed."""

from __future__ import annotations

import pytest

from electrovib.core.errors import InputError
from electrovib.core.model import Model, read_model


def test_a_final_class_cannot_be_subclassed(final_class):
    with pytest.raises(TypeError, match="wrap it instead"):
        type("Tweaked", (final_class,), {"__module__": __name__})


def test_a_mixin_does_not_open_a_final_class(final_class):
    with pytest.raises(TypeError, match="wrap it instead"):
        type("Tweaked", (type("Mixin", (), {}), final_class), {"__module__": __name__})


def test_a_family_has_members_and_names_them(family, discovered):
    names = [kind.__name__ for kind in discovered["final_class"].values() if issubclass(kind, family)]
    assert names
    with pytest.raises(InputError) as caught:
        read_model(family, {})
    assert all(name in str(caught.value) for name in names)


def test_a_member_is_read_by_its_name(final_class, build):
    family = final_class.__mro__[1]
    reader = final_class if family is Model else family
    model = build(final_class)
    assert read_model(reader, {"model": final_class.__name__, **final_class.example}) == model
    with pytest.raises(InputError, match="Tweaked"):
        read_model(reader, {"model": "Tweaked", **final_class.example})


def test_models_are_frozen(final_class, build):
    model = build(final_class)
    for name in final_class.model_fields:
        with pytest.raises(InputError, match="replace returns a changed copy"):
            setattr(model, name, getattr(model, name))
    with pytest.raises(InputError, match="no_such_thing: is not changed in place"):
        model.no_such_thing = 1
