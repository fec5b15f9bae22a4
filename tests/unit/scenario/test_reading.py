"""Scenarios from files, names and Traces, and inputs that are none."""

from __future__ import annotations

import os

import pytest

from electrovib.core.discovery import find_members
from electrovib.core.errors import InputError
from electrovib.core.numbers import with_numbers
from electrovib.core.paths import quantity_at, value_at
from electrovib.core.trace import make_trace
from electrovib.data.traces import load_nc, open_trace, save_nc
from electrovib.physics.friction import Load
from electrovib.physics.motion import Motion
from electrovib.physics.rig import SensorCreep
from electrovib.scenario import load, read_part, scenario_of, sweep_of
from electrovib.scenario.sources import BY_THE_USER
from electrovib.scenario.toml import to_toml
from electrovib.study.catalogue import families

PAPER = "vezzoli_2014/fig6"


def refusal(path):
    with pytest.raises(InputError) as caught:
        load(path)
    assert all("\n" not in problem for problem in caught.value.problems)
    return str(caught.value)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("schema = 1\nx = " + "[" * 5000 + "]" * 5000, "not valid TOML: its tables and lists are nested more than 50"),
        ("schema = 1\nx = " + "1" * 5000, "not valid TOML: it has a whole number of thousands of digits"),
        ("schema = " + "1" * 400, "schema = 1111"),
        ("schema = 1\nload = { normal_force = " + "1" * 400 + " }", "must be a finite number; expected a force"),
        ("schema = 1\n".encode("utf-16"), "not a text in UTF-8; a scenario is TOML, saved as UTF-8"),
    ],
)  # fmt: skip
def test_toml_that_is_refused(tmp_path, content, words):
    path = tmp_path / "a.toml"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    said = refusal(path)
    assert words in said
    assert len(said.splitlines()[0]) < 400


def test_a_byte_order_mark_is_no_trouble(tmp_path):
    (tmp_path / "a.toml").write_text('\ufeffschema = 1\n[load]\nnormal_force = "2 V"\n', encoding="utf-8")
    assert "normal_force = '2 V': expected a force" in refusal(tmp_path / "a.toml")


def test_what_is_no_ordinary_file_is_not_opened(tmp_path):
    os.mkfifo(tmp_path / "pipe.toml")
    assert "is not an ordinary file" in refusal(tmp_path / "pipe.toml")
    assert "is not an ordinary file" in refusal("/dev/zero")
    assert "is a folder" in refusal(tmp_path)
    assert "No such file" in refusal(tmp_path / "no.toml")


def carrying(**attributes):
    return make_trace({"current": (("time",), [1.0, 2.0])}, {"time": [0.0, 1.0]}, attributes)


def test_what_a_trace_carries_is_given_back(tmp_path):
    scenario = load(PAPER)
    trace = carrying(
        scenario=scenario.to_json(), over='{"drive.rise": [1.0, 2.0]}', quantities='["current.max"]'
    )
    save_nc(trace, tmp_path / "a.nc")
    found = load_nc(tmp_path / "a.nc")
    assert scenario_of(found) == scenario
    assert sweep_of(found) == ({"drive.rise": [1.0, 2.0]}, ["current.max"])
    assert sweep_of(carrying()) == ({}, [])


def test_a_name_that_a_model_had_is_read_in_files_and_traces(tmp_path):
    scenario = load(PAPER, changes={"drive": {"model": "Step", "level": "100 V"}})
    assert load(scenario.to_dict() | {"drive": {"model": "Constant", "level": "100 V"}}) == scenario
    assert load(PAPER, changes={"drive": {"model": "Constant", "level": "100 V"}}) == scenario
    old = scenario.to_json().replace('"model": "Step"', '"model": "Constant"')
    assert old != scenario.to_json()
    assert scenario_of(carrying(scenario=old)) == scenario
    assert '"Step"' in to_toml(scenario)
    (tmp_path / "a.toml").write_text(to_toml(scenario).replace('"Step"', '"Constant"'), encoding="utf-8")
    assert load(tmp_path / "a.toml") == scenario


def test_a_part_without_a_family_may_be_called_by_its_former_name():
    creep = {"share": -0.02, "time": 5.0}
    for name in ("Creep", "SensorCreep"):
        assert read_part(SensorCreep, {"model": name} | creep) == SensorCreep(**creep)
    with pytest.raises(InputError, match="expected the model SensorCreep, not 'Creeping'"):
        read_part(SensorCreep, {"model": "Creeping"} | creep)


def test_a_scenario_of_a_paper_is_found_by_its_former_name():
    assert load("persson_2018/coat") == load("persson_2018/coating")
    stack = load(PAPER, changes={"stack": "persson_2018/coat"}).stack
    assert stack == load("persson_2018/coating").stack


SWIPE = {"model": "Swipe", "begin": 0.01, "rise": 0.05, "hold": 0.2, "fall": 0.05}


def swiped(**changes):
    return load(PAPER, changes={"motion.speed": "30 mm/s", "motion.time_profile": SWIPE} | changes)


def test_a_parameter_is_read_by_its_former_name_in_files_and_traces(tmp_path):
    scenario = swiped()
    old = to_toml(scenario).replace("time_profile", "programme")
    assert old.count("programme") > 1  # of the load, of the motion, and in their sources
    (tmp_path / "a.toml").write_text(old, encoding="utf-8")
    found = load(tmp_path / "a.toml")
    assert found == scenario
    assert found.sources == scenario.sources
    old = scenario.to_json().replace("time_profile", "programme")
    trace = carrying(scenario=old, over='{"motion.programme.rise": [0.01, 0.02]}')
    assert scenario_of(trace) == scenario
    assert scenario_of(trace).sources == scenario.sources
    assert sweep_of(trace) == ({"motion.time_profile.rise": [0.01, 0.02]}, [])
    assert "programme" not in to_toml(found) + found.to_json()


def test_a_change_is_read_by_the_former_name_of_its_parameter(tmp_path):
    expected = swiped(**{"motion.time_profile.rise": 0.1})
    for found in (
        swiped().replace({"motion.programme.rise": "100 ms"}),
        load(PAPER, changes={"motion.speed": 0.03, "motion.programme": SWIPE, "motion.time_profile.rise": 0.1}),
        load(PAPER, changes={"motion.speed": 0.03, "motion.programme": SWIPE | {"rise": 0.1}}),
        load(PAPER, changes={"motion.speed": 0.03, "motion.programme.model": "Swipe"}
             | {f"motion.programme.{name}": value for name, value in (SWIPE | {"rise": 0.1}).items()}),
        with_numbers(swiped(), {"motion.programme.rise": 0.1}),
    ):  # fmt: skip
        assert found == expected
        assert found.sources["motion.time_profile.rise"] == BY_THE_USER
    assert value_at(expected, "motion.programme.rise") == 0.1
    assert quantity_at(expected, "motion.programme.rise").unit == "s"
    wrong = to_toml(swiped()).replace("time_profile", "programme").replace('"Swipe"', '"Swip"')
    (tmp_path / "wrong.toml").write_text(wrong, encoding="utf-8")
    mended = load(tmp_path / "wrong.toml", changes={"motion.time_profile.model": "Swipe"} | {
        f"motion.time_profile.{name}": value for name, value in SWIPE.items()})  # fmt: skip
    assert mended == swiped()


def test_a_parameter_given_by_both_names_is_refused():
    both = "'motion.time_profile', which is given as well"
    with pytest.raises(InputError, match=f"motion.programme: is the former name of {both}") as caught:
        swiped().replace(
            {"motion.time_profile": SWIPE, "motion.programme": SWIPE, "load.normal_force": "2 V"}
        )
    assert [problem.path for problem in caught.value.problems] == ["motion.programme", "load.normal_force"]
    tables = swiped().to_dict()
    tables["motion"] |= {"programme": SWIPE}
    with pytest.raises(
        InputError, match=r"motion.programme: is the former name of 'time_profile', .*remove one"
    ):
        load(tables)
    with pytest.raises(
        InputError, match=r"motion.programme.rise: is the former name of 'motion.time_profile.rise'"
    ):
        with_numbers(swiped(), {"motion.programme.rise": 0.1, "motion.time_profile.rise": 0.2})


def test_no_former_parameter_is_one_of_today():
    kinds = [Load, Motion]
    assert all(kind.former_parameters for kind in kinds)
    for kind in kinds:
        assert not set(kind.former_parameters) & set(kind.model_fields)
        assert set(kind.former_parameters.values()) <= set(kind.model_fields)


def test_no_former_name_is_one_of_today():
    for family in families():
        members = find_members(family)
        former = [name for member in members.values() for name in member.former_names]
        assert len(set(former)) == len(former)
        assert not set(former) & set(members)


@pytest.mark.parametrize(
    ("scenario", "words"),
    [
        ("{", "is damaged: Expecting"),
        ("[1]", "is damaged: it holds a list"),
        ("null", "is damaged: it holds a NoneType"),
        ("[" * 10_000, "is damaged: its tables and lists are nested"),
        (7, "is damaged: it is of type int, not a text"),
        (0.5, "is damaged: it is of type float"),
        ("", "is damaged: Expecting"),
        ('{"schema": 2}', "schema = 2"),
        ('{"schema": 1, "contact": 3}', "contact = 3"),
        ('{"schema": 1, "contact": [1]}', "contact = "),
    ],
)
def test_a_damaged_scenario_of_a_trace(tmp_path, scenario, words):
    save_nc(carrying(scenario=scenario), tmp_path / "a.nc")
    with pytest.raises(InputError) as caught:
        scenario_of(open_trace(tmp_path / "a.nc"))
    assert words in str(caught.value)
    with pytest.raises(InputError):
        load(tmp_path / "a.nc", changes={"drive.high": "1 V"})


@pytest.mark.parametrize(
    "over", ["{", "[1]", 7, "null", '{"drive.rise": 3}', '{"drive.rise": []}', "[" * 10_000]
)
def test_a_damaged_sweep_of_a_trace(over):
    with pytest.raises(InputError, match="attribute 'over' of this Trace is damaged"):
        sweep_of(carrying(over=over))


@pytest.mark.parametrize("names", ["{", "{}", 7, "[1]"])
def test_damaged_quantities_of_a_trace(names):
    with pytest.raises(InputError, match="attribute 'quantities' of this Trace is damaged"):
        sweep_of(carrying(over="{}", quantities=names))


def test_the_standard_input_is_no_scenario():
    with pytest.raises(InputError, match=r"save it as a \.toml file"):
        load("-")
