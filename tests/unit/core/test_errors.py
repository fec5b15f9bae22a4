"""What a user reads."""

from __future__ import annotations

import pytest

from electrovib.core.errors import DataFileError, ElectrovibError, InputError, NotCausalError, nearest


def test_several_problems_are_one_error():
    error = InputError(["one", "two"])
    assert error.problems == ("one", "two")
    assert str(error) == "one\ntwo"
    assert InputError("alone").problems == ("alone",)


def test_all_are_of_one_family():
    assert issubclass(InputError, ElectrovibError)
    assert issubclass(DataFileError, InputError)
    assert issubclass(NotCausalError, ElectrovibError)


@pytest.mark.parametrize(
    ("word", "known", "sentence"),
    [
        ("thicknes", ["thickness", "material"], " Did you mean 'thickness'?"),
        ("SINE", ["Sine", "Square"], " Did you mean 'Sine'?"),
        ("zzz", ["b", "a"], " Known: a, b."),
        ("zzz", [], ""),
    ],
)
def test_nearest(word, known, sentence):
    assert nearest(word, known) == sentence
