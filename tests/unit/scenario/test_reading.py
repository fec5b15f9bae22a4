"""Scenarios from files, names and Traces, and inputs that are none."""

from __future__ import annotations

import os

import pytest

from electrovib.core.errors import InputError
from electrovib.core.trace import make_trace
from electrovib.data.traces import load_nc, open_trace, save_nc
from electrovib.scenario import load, scenario_of, sweep_of

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


SWIPE = {"model": "Swipe", "begin": 0.01, "rise": 0.05, "hold": 0.2, "fall": 0.05}


def swiped(**changes):
    return load(PAPER, changes={"motion.speed": "30 mm/s", "motion.time_profile": SWIPE} | changes)


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
