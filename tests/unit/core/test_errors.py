"""What a user reads."""

from __future__ import annotations

import pytest

from electrovib.core.errors import (
    DataFileError,
    ElectrovibError,
    InputError,
    NoColumnError,
    NotCausalError,
    Problem,
    closest,
    gathered,
    nearest,
    suggestion,
)


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


def test_closest_gives_the_name_itself():
    assert closest("thicknes", ["thickness", "material"]) == "thickness"
    assert closest("SINE", ["Sine", "Square"]) == "Sine"
    assert closest("zzz", ["b", "a"]) is None
    assert suggestion("zzz", ["b", "a"]) == ""
    assert suggestion("SINE", ["Sine"]) == " Did you mean 'Sine'?"


@pytest.mark.parametrize(
    ("path", "value", "sentence"),
    [
        ("drive.high", "'2 m'", "drive.high = '2 m': expected a voltage"),
        ("drive.high", "", "drive.high: expected a voltage"),
        ("", "{model = 'Sine', ...}", "the file = {model = 'Sine', ...}: expected a voltage"),
        ("", "", "expected a voltage"),
    ],
)
def test_a_problem_is_its_sentence_and_knows_its_parts(path, value, sentence):
    problem = Problem("expected a voltage", path=path, value=value)
    assert problem == sentence
    assert (problem.path, problem.value, problem.reason) == (path, value, "expected a voltage")
    (again,) = InputError([problem]).problems
    assert again is problem


@pytest.mark.parametrize(
    ("sentence", "path", "value"),
    [
        ("motion.speed: the finger rests", "motion.speed", ""),
        ("time.initial_state = PeriodicState: start AtRest", "time.initial_state", "PeriodicState"),
        ("--over drive.rise: the same: twice", "", ""),
        ("no law can be compared here. MaxwellStressInGap: it fails", "", ""),
        ("'a.b': a map needs two values", "", ""),
        ("skin.csv: the file is empty.", "skin.csv", ""),
    ],
)
def test_a_sentence_that_is_written_as_all_are_is_taken_for_what_it_says(sentence, path, value):
    (problem,) = InputError(sentence).problems
    assert (problem, problem.path, problem.value) == (sentence, path, value)
    assert problem.reason == (sentence.partition(": ")[2] if path else sentence)


def test_problems_of_a_part_belong_to_the_whole():
    assert Problem("too large", path="threshold", value="2").within("perception") == (
        "perception.threshold = 2: too large"
    )
    assert Problem("no table", value="3").within("perception") == "perception = 3: no table"
    assert Problem("too large", path="a").followed_by(" (at b = 2)") == "a: too large (at b = 2)"
    assert Problem("too large", path="a").followed_by(" (at b = 2)").path == "a"


def test_every_error_lists_its_problems():
    assert NotCausalError("it is not causal").problems == ("it is not causal",)
    error = InputError("is too large", path="load.normal_force", value="3")
    assert str(error) == "load.normal_force = 3: is too large"
    assert error.problems[0].path == "load.normal_force"
    missing = NoColumnError("there is none", path="a.csv", column="time")
    assert (missing.column, str(missing)) == ("time", "a.csv: there is none")


def test_gathered_problems_keep_their_parts():
    found = []
    with gathered(found):
        raise InputError("is too large", path="load.normal_force", value="3")
    assert found[0].path == "load.normal_force"


def test_what_is_quoted_is_printable_and_short():
    problem = Problem("x" * 5000, path="a\nb")
    assert "\n" not in problem
    assert len(problem) <= 1200
    assert len(problem.reason) == 5000
