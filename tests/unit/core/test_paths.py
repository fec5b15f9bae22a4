"""Dotted paths: reading, changing, what one that is not there may mean; and the sentences that a user reads."""

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
from electrovib.core.paths import quantity_at, value_at
from electrovib.core.samples import Samples
from electrovib.core.tables import Changed, meant, read_changes
from electrovib.scenario import Scenario, load


@pytest.fixture(scope="module")
def scenario():
    return load("vezzoli_2014/fig6_gap")


def test_values_and_declarations(scenario):
    assert value_at(scenario, "stack.gap.thickness") == 1e-6
    assert value_at(scenario, "drive.model") == "Trapezium"
    assert value_at(scenario, "load") == {"normal_force": 0.5, "time_profile": {"model": "Steady"}}
    assert value_at(scenario, "drive.repeat") is None
    assert quantity_at(scenario, "stack.gap.thickness").unit == "m"
    with pytest.raises(InputError, match="no physical parameter has this path"):
        quantity_at(scenario, "stack.gap")
    paths = [path for path, _, _ in scenario.parameters()]
    assert len(set(paths)) == len(paths)
    layers = [path.split(".")[1] for path in paths if path.startswith("stack.")]
    assert list(dict.fromkeys(layers)) == ["insulator", "gap", "stratum_corneum"]  # in the order of the file


LAYERS = "the stack has no layer 'gop'; its layers are insulator, gap, stratum_corneum. Did you mean 'gap'?"


@pytest.mark.parametrize(
    ("path", "sentence"),
    [
        ("stack.gap.thicknes", "unknown parameter 'thicknes' in 'stack.gap'. Did you mean 'thickness'?"),
        ("drive.hihg", "unknown parameter 'hihg' of Trapezium. Did you mean 'high'?"),
        ("stak.gap", "unknown parameter 'stak'. Did you mean 'stack'?"),
        ("stack.gop.thickness", LAYERS),
        ("load.normal_force.x", "'load.normal_force' is a single value, without parameters of its own"),
        ("drive.repeat.x", "without parameters of its own"),
        ("", "unknown parameter ''"),
        (".", "unknown parameter ''"),
        ("stack..gap", "unknown parameter '' in 'stack'"),
    ],
)
def test_paths_that_are_not_there(scenario, path, sentence):
    for ask in (value_at, lambda model, where: model.replace({where: 1.0})):
        with pytest.raises(InputError) as caught:
            ask(scenario, path)
        assert sentence in str(caught.value)
    assert meant(scenario, path) == ""


def test_a_word_names_the_parameters_that_end_with_it_or_mean_it(scenario):
    assert meant(scenario, "thickness") == (
        " Did you mean 'stack.insulator.thickness' (thickness of the layer),"
        " 'stack.gap.thickness' (thickness of the layer) or"
        " 'stack.stratum_corneum.thickness' (thickness of the layer)?"
    )
    assert meant(scenario, "rise") == " Did you mean 'drive.rise' (duration of an edge; 0 for a step)?"
    asked = meant(scenario, "voltage")
    assert asked.startswith(" Did you mean 'drive.low' (voltage before and after), 'drive.high'")
    assert "limits" not in asked  # a limit that is not declared
    assert meant(scenario, "gap").startswith(" Did you mean 'stack.gap.thickness' (")


def test_a_parameter_of_another_model_names_the_models_that_have_it(scenario):
    asked = meant(scenario, "drive.frequency")
    assert asked.startswith(" Models with 'frequency': Burst, ")
    assert " Sine, " in asked
    assert asked.endswith("; to take one, set drive.model as well.")
    model = "stack.insulator.material.model"
    deep = meant(scenario, "stack.insulator.material.exponent")
    assert deep == f" Models with 'exponent': ConstantPhase; to take one, set {model} as well."


@pytest.mark.parametrize("path", ["drive.nothing_has_this", "nothing_has_this", "no.such.x", "sources.x"])
def test_nothing_is_added_where_nothing_has_the_name(scenario, path):
    assert meant(scenario, path) == ""


@pytest.mark.parametrize("path", ["thickness", "rise", "drive.frequency"])
def test_reading_changing_and_declaring_say_it_once(scenario, path):
    for ask in (value_at, quantity_at, lambda model, where: model.replace({where: 1.0})):
        with pytest.raises(InputError) as caught:
            ask(scenario, path)
        (problem,) = caught.value.problems
        assert problem.startswith(f"{path}: ")
        assert problem.count("Did you mean") + problem.count("Models with") == 1
        assert problem.count(meant(scenario, path)) == 1


def test_texts_are_values_by_path_and_those_that_cannot_be_read_are_told_at_once():
    texts = ["drive.high = 150 V", "gap={ thickness = '5 um' }", "drive.times=[0, 1]", "title="]
    known = {"drive.high": "150 V", "gap": {"thickness": "5 um"}, "drive.times": [0, 1], "title": ""}
    assert read_changes(texts) == read_changes(known) == known
    assert read_changes(None) == {}
    problems = []
    assert read_changes(["a=1", "a=2", "b", "=3", "c={"], problems) == {"a": "1"}
    assert [each.partition(": ")[0] for each in problems] == ["--set a=2", "--set b", "--set =3", "--set c={"]
    with pytest.raises(InputError, match="'a' is set twice") as refused:
        read_changes(["a=1", "a=2", "b"])
    assert len(refused.value.problems) == 2


def test_what_is_given_within_a_number_is_refused_beside_the_number(scenario):
    with pytest.raises(InputError, match=r"drive\.high\.x: 'drive\.high' is a single value"):
        scenario.replace({"drive.high": 3.0, "drive.high.x": 1.0})


def mended(tables, changes):
    return Changed().within(changes, tables, Scenario, fresh=True)


def test_a_new_model_comes_before_its_parameters_and_the_same_model_keeps_them():
    tables = {"drive": {"model": "Sine", "amplitude": 1.0}}
    assert mended(tables, {"drive.model": "Sine"}) == tables
    step = {"drive": {"model": "Step", "level": 5.0}}
    assert mended(tables, {"drive.level": 5.0, "drive.model": "Step"}) == step


@pytest.mark.parametrize("key", ["file", "time_column", "voltage_unit"])
def test_samples_do_not_outlive_how_they_were_read(key):
    read = {"time_column": "time", "voltage_unit": "V", "level": 1.0}
    for file in ("old.csv", ""):
        tables = {"drive": read | {"file": file, "time_samples": Samples([0, 1])}}
        assert "time_samples" in mended(tables, {"drive.level": 2.0})["drive"]
        again = mended(tables, {f"drive.{key}": "new"})["drive"]
        assert ("time_samples" in again) == (not file and key != "file")


def test_tables_can_be_made_on_the_way_and_a_part_that_is_not_given_is_told_apart_from_a_value(scenario):
    assert mended({}, {"a.b.c": 1, "a.b.d": 2}) == {"a": {"b": {"c": 1, "d": 2}}}
    with pytest.raises(InputError, match=r"'drive\.repeat' is not given, .*set it whole"):
        scenario.replace({"drive.repeat.x": 1})
    with pytest.raises(InputError, match=r"'time\.samples' is not given, .*set it whole"):
        scenario.replace({"time.samples.x": 1})
    with pytest.raises(InputError, match=r"drive\.model: is set beside the table 'drive'"):
        scenario.replace({"drive": {"model": "Step", "level": 1.0}, "drive.model": "Sine"})


def test_a_source_is_changed_and_none_is_added_by_its_path(scenario):
    named = scenario.model_copy(update={"sources": {"title": "ours"}})
    assert Changed(named).within({"sources.title": "theirs"}, named)["sources"] == {"title": "theirs"}
    found = Changed(named)
    found.within({"sources.other": "theirs"}, named)
    (problem,) = found.problems
    assert problem.path == "sources.other"


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
