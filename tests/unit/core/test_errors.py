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


def test_every_error_lists_its_problems_and_all_are_of_one_family():
    error = InputError(["one", "two"])
    assert (error.problems, str(error)) == (("one", "two"), "one\ntwo")
    assert NotCausalError("it is not causal").problems == ("it is not causal",)
    missing = NoColumnError("there is none", path="a.csv", column="time")
    assert (missing.column, str(missing)) == ("time", "a.csv: there is none")
    assert issubclass(DataFileError, InputError)
    assert issubclass(InputError, ElectrovibError)
    assert issubclass(NotCausalError, ElectrovibError)


@pytest.mark.parametrize(
    ("word", "known", "close", "sentence"),
    [
        ("thicknes", ["thickness", "material"], "thickness", " Did you mean 'thickness'?"),
        ("SINE", ["Sine", "Square"], "Sine", " Did you mean 'Sine'?"),
        ("zzz", ["b", "a"], None, " Known: a, b."),
        ("zzz", [], None, ""),
    ],
)
def test_the_nearest_name(word, known, close, sentence):
    assert nearest(word, known) == sentence
    assert closest(word, known) == close
    assert suggestion(word, known) == (sentence if close else "")


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
    found = []
    with gathered(found):
        raise InputError([problem])
    assert found[0] is problem
    (again,) = InputError("expected a voltage", path=path, value=value).problems
    assert (again, again.path, again.value) == (problem, path, value)


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
    problem = Problem("too large", path="threshold", value="2")
    assert problem.within("perception") == "perception.threshold = 2: too large"
    assert Problem("no table", value="3").within("perception") == "perception = 3: no table"
    more = problem.followed_by(" (at b = 2)")
    assert (more, more.path) == ("threshold = 2: too large (at b = 2)", "threshold")


def test_what_is_quoted_is_printable_and_short():
    problem = Problem("x" * 5000, path="a\nb")
    assert "\n" not in problem
    assert len(problem) <= 1200
    assert len(problem.reason) == 5000
