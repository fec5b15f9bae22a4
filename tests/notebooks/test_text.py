"""What a plain interpreter shows: texts of a scenario, names for completion, one sentence for a mistake."""

from __future__ import annotations

import tomllib

import pytest
from pydantic import BaseModel

import electrovib as ev
from electrovib.core.errors import InputError
from electrovib.core.trace import make_trace
from electrovib.scenario.toml import to_toml


@pytest.fixture(scope="module")
def scenario():
    return ev.load("vezzoli_2014/fig6")


def test_a_scenario_in_lines(scenario):
    lines = str(scenario).splitlines()
    assert repr(scenario) == str(scenario)
    assert lines[0] == f"Scenario: {scenario.title}"
    assert "  drive: Trapezium(high = 1 kV, rise = 36 ms, hold = 100 ms, fall = 36 ms)" in lines
    assert "  stack.insulator: Layer(thickness = 90 um, material = Constant(permittivity = 3.35))" in lines
    assert not any(line.startswith(("  motion", "  time")) for line in lines)  # those keep their defaults
    assert len(lines) < 15
    moved = scenario.replace({"motion.speed": "20 mm/s"})
    assert "  motion: Motion(speed = 20 mm/s)" in str(moved).splitlines()


def test_words_and_nested_parts_are_written_too(scenario):
    other = scenario.replace(
        {"drive": {"model": "Sum", "drives": [{"model": "Step", "level": 1}, {"model": "Step", "level": 2}]}}
    )
    assert "  drive: Sum(drives = (Step(level = 1 V), Step(level = 2 V)))" in str(other).splitlines()
    role = scenario.replace({"stack.insulator.role": "plate"})
    assert "role = 'plate'" in str(role)


def test_completion_lists_what_a_user_wants(scenario):
    names = dir(scenario)
    assert {"drive", "stack", "force", "replace", "parameters", "to_dict", "to_json", "to_toml"} <= set(names)
    assert not [name for name in names if name.startswith(("_", "model_"))]
    own = {"frequency", "load", "time", *type(scenario).model_fields}
    assert not (set(names) & set(dir(BaseModel))) - own
    assert not {"example", "offered_by", "is_family", "file_columns", "from_offer"} & set(names)
    assert all(hasattr(scenario, name) for name in names)


def test_completion_of_parts(scenario):
    assert {"insulator", "stratum_corneum", "layers", "thickness"} <= set(dir(scenario.stack))
    assert {"high", "voltage", "period"} <= set(dir(scenario.drive))
    assert {"equation", "reference", "status"} <= set(dir(scenario.force))
    assert not {"equation", "reference", "status"} & set(dir(scenario))


def test_a_scenario_writes_its_file(scenario):
    assert scenario.to_toml() == to_toml(scenario)
    assert ev.load(tomllib.loads(scenario.to_toml())) == scenario


def test_a_mistake_is_one_line_and_where_it_was_made(scenario):
    with pytest.raises(InputError) as caught:
        scenario.replace({"drive.hihg": "1 V", "drive.rise": "1 kg"})
    lines = caught.value._render_traceback_()
    assert len(lines) == 3
    assert lines[0].startswith("InputError: drive")
    assert lines[1].startswith("InputError: drive.rise")
    assert lines[2].endswith('scenario.replace({"drive.hihg": "1 V", "drive.rise": "1 kg"})')
    assert lines[2].startswith("in line ")


def test_the_line_is_that_which_called_the_package(tmp_path):
    """Not one of a library that the package uses: here the error passes through contextlib."""
    trace = make_trace({}, {}, {})
    with pytest.raises(InputError) as caught:
        ev.save(trace, tmp_path / "absent" / "a.nc")
    assert any("contextlib" in str(frame.path) for frame in caught.traceback)
    assert caught.value._render_traceback_()[-1].endswith('ev.save(trace, tmp_path / "absent" / "a.nc")')


def test_a_mistake_that_was_never_raised_has_no_line():
    assert InputError("drive.high: is missing")._render_traceback_() == ["InputError: drive.high: is missing"]
