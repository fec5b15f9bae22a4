"""What a plain interpreter shows: texts of a scenario, names for completion, one sentence for a mistake."""

import tomllib

import pytest
from pydantic import BaseModel

import electrovib as ev
from electrovib.core.errors import InputError
from electrovib.core.signals import make_trace
from electrovib.scenario.toml import to_toml

SCENARIO = ev.load("vezzoli_2014/fig6")


def test_a_scenario_in_lines_and_as_its_file():
    lines = str(SCENARIO).splitlines()
    assert repr(SCENARIO) == str(SCENARIO)
    assert lines[0] == f"Scenario: {SCENARIO.title}"
    assert "  stack.insulator: Layer(thickness = 90 um, material = Constant(permittivity = 3.35))" in lines
    assert not any(line.startswith(("  motion", "  time")) for line in lines)  # those keep their defaults
    assert len(lines) < 15
    assert SCENARIO.to_toml() == to_toml(SCENARIO)
    assert ev.load(tomllib.loads(SCENARIO.to_toml())) == SCENARIO
    steps = [{"model": "Step", "level": 1}, {"model": "Step", "level": 2}]
    for changes, line in (
        ({"motion.speed": "20 mm/s"}, "  motion: Motion(speed = 20 mm/s)"),
        ({"drive": {"model": "Sum", "drives": steps}}, "  drive: Sum(drives = (Step(level = 1 V), Step("),
        ({"stack.insulator.role": "plate"}, "role = 'plate'"),
    ):
        assert line in str(SCENARIO.replace(changes))


def test_completion_lists_what_a_user_wants():
    names = set(dir(SCENARIO))
    assert {"drive", "stack", "force", "replace", "parameters", "to_dict", "to_json", "to_toml"} <= names
    assert not [name for name in names if name.startswith(("_", "model_"))]
    own = {"frequency", "load", "time", *type(SCENARIO).model_fields}
    assert not (names & set(dir(BaseModel))) - own
    assert not {"example", "offered_by", "is_family", "file_columns", "from_offer"} & names
    assert all(hasattr(SCENARIO, name) for name in names)
    assert {"insulator", "stratum_corneum", "layers", "thickness"} <= set(dir(SCENARIO.stack))
    assert {"high", "voltage", "period"} <= set(dir(SCENARIO.drive))
    assert {"equation", "reference", "status"} <= set(dir(SCENARIO.force)) - names


def test_a_mistake_is_one_line_and_where_it_was_made(tmp_path):
    """Not the line of a library that the package uses: the second error passes through contextlib."""
    with pytest.raises(InputError) as caught:
        SCENARIO.replace({"drive.hihg": "1 V", "drive.rise": "1 kg"})
    lines = caught.value._render_traceback_()
    assert len(lines) == 3
    assert lines[0].startswith("InputError: drive")
    assert lines[1].startswith("InputError: drive.rise")
    assert lines[2].startswith("in line ")
    assert lines[2].endswith('SCENARIO.replace({"drive.hihg": "1 V", "drive.rise": "1 kg"})')
    trace = make_trace({}, {}, {})
    with pytest.raises(InputError) as caught:
        ev.save(trace, tmp_path / "absent" / "a.nc")
    assert any("contextlib" in str(frame.path) for frame in caught.traceback)
    assert caught.value._render_traceback_()[-1].endswith('ev.save(trace, tmp_path / "absent" / "a.nc")')
    assert InputError("drive.high: is missing")._render_traceback_() == ["InputError: drive.high: is missing"]
