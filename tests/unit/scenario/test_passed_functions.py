"""What a value that is typed passes before it is a number of a frozen model, counted by the interpreter."""

import sys
from pathlib import Path

import pytest
from pydantic import BaseModel
from typer.testing import CliRunner

import electrovib as ev
from electrovib.apps.cli import app
from electrovib.apps.run import run

SOURCE = f"{Path(ev.__file__).parent}/"
FIG6 = "vezzoli_2014/fig6"
DEEPEST = 8
"""Levels of tables within which a value is looked for."""


def holds(thing, wanted, levels=DEEPEST):
    """Tell whether a text or a number is, or is held by, what a function was given or returned."""
    if isinstance(thing, str):
        return isinstance(wanted, str) and wanted in thing
    if isinstance(thing, float):
        return thing == wanted
    if levels == 0 or isinstance(thing, type):
        return False
    if isinstance(thing, dict):
        parts = [*thing, *thing.values()]
    elif isinstance(thing, (list, tuple)):
        parts = thing if len(thing) < 200 else ()
    elif isinstance(thing, BaseModel) or type(thing).__module__.startswith("electrovib."):
        parts = getattr(thing, "__dict__", {}).values()
    else:
        return False
    return any(holds(each, wanted, levels - 1) for each in parts)


def passed(call, text="", number=0.0):
    """Return the functions of the package that a call walks, and those that a value passes until one holds the number."""
    walked, before, is_number = {}, {}, False

    def note(frame, event, returned):
        nonlocal is_number
        code = frame.f_code
        is_function = code.co_flags & 1 and not code.co_name.startswith("<")
        if event not in {"call", "return"} or not (is_function and code.co_filename.startswith(SOURCE)):
            return
        sys.setprofile(None)
        name = (code.co_filename.removeprefix(SOURCE), code.co_qualname)
        walked.setdefault(name)
        if text and not is_number:
            held = [returned] if event == "return" else [*frame.f_locals.values()]
            if holds(held, text) or holds(held, number):
                before.setdefault(name)
            is_number = bool(before) and holds(held, number)
        sys.setprofile(note)

    sys.setprofile(note)
    try:
        call()
    finally:
        sys.setprofile(None)
    assert not text or is_number
    return list(walked), list(before)


@pytest.fixture
def file(tmp_path):
    """Return a scenario file in which the drive has the height 203 V."""
    path = tmp_path / "own.toml"
    path.write_text(ev.load(FIG6).replace({"drive.high": 203.0}).to_toml(), encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("path", "typed", "number"),
    [
        ("drive.high", "203V", 203.0),
        ("drive.amplitude", "203 V", 203.0),
        ("stack.insulator.thickness", "93um", 93e-6),
    ],
)
def test_a_value_that_is_set_passes_eight_functions_before_it_is_a_number(path, typed, number):
    run(FIG6)  # what is made once is made
    _, before = passed(lambda: run(FIG6, set=[f"{path}={typed}"]), typed, number)
    assert before[0] == ("apps/run.py", "run")
    assert before[-1] == ("core/units.py", "parse_quantity")
    assert len(before) <= 8, before


def test_a_value_of_a_file_passes_as_many_beside_those_that_read_toml(file):
    _, before = passed(lambda: ev.load(file), "203 V", 203.0)
    assert before[-1] == ("core/units.py", "parse_quantity")
    assert len(before) <= 12, before
    assert len([each for each in before if each[0] not in {"core/parsing.py", "core/file_kinds.py"}]) <= 8, (
        before
    )


def test_the_command_adds_what_reads_its_options_and_walks_no_more_than_it_did():
    line = ["run", FIG6, "--set", "drive.high=203V"]
    CliRunner().invoke(app, line)
    walked, before = passed(lambda: CliRunner().invoke(app, line), "203V", 203.0)
    assert len([name for file, name in before if not file.startswith("apps/cli/")]) <= 8
    assert len(before) <= 10
    assert len(walked) <= 560
    assert len({file for file, _ in walked}) <= 90
