"""The tour of the code: its places exist and are passed in its order by the run that it follows."""

import re
import sys
from pathlib import Path

from typer.testing import CliRunner

import electrovib as ev
from electrovib.apps.cli import app

TOUR = Path(__file__).parent.parent / "docs" / "contribute" / "tour.md"
ROW = re.compile(r"^\| (\d) \| `([\w/.]+)` \| `([\w.]+)` \|", re.MULTILINE)
SOURCE = f"{Path(ev.__file__).parent}/"


def test_the_run_of_the_tour_passes_its_places_in_their_order():
    places = ROW.findall(TOUR.read_text(encoding="utf-8"))
    assert [int(number) for number, _, _ in places] == list(range(1, 9))
    passed: dict[tuple[str, str], None] = {}

    def note(frame, event, _):
        if event == "call" and frame.f_code.co_filename.startswith(SOURCE):
            passed.setdefault((frame.f_code.co_filename.removeprefix(SOURCE), frame.f_code.co_qualname))

    CliRunner().invoke(app, ["run", "vezzoli_2014/fig6"])  # what is kept from an earlier run changes nothing
    sys.setprofile(note)
    try:
        shown = CliRunner().invoke(app, ["run", "vezzoli_2014/fig6"])
    finally:
        sys.setprofile(None)
    assert shown.exit_code == 0
    seen = [each for each in passed if each in {(file, name) for _, file, name in places}]
    assert seen == [(file, name) for _, file, name in places]


def test_the_numbers_of_the_tour():
    text = TOUR.read_text(encoding="utf-8")
    scenario = ev.load("vezzoli_2014/fig6")
    trace = ev.simulate(scenario)
    assert f"{1e3 * float(trace.electrostatic_force.max()):.4g} mN at the end of the ramp" in text
    friction, load = scenario.friction.coefficient, scenario.load.normal_force
    assert f"{friction:g} ({load:g} N + " in text
    skin = scenario.stack.layers["stratum_corneum"].material
    assert f"of {1e3 * 8.854e-12 * skin.permittivity / skin.conductivity:.1f} ms" in text


def test_the_files_to_copy_and_the_tests_that_find_them_exist():
    text, folder = TOUR.with_name("parts.md").read_text(encoding="utf-8"), ""
    named = re.findall(r"`((?:src|tests)/[\w/.]+|test_\w+\.py)`", text)
    assert len(named) > 12
    for name in named:
        folder = name.rpartition("/")[0] or folder
        assert (TOUR.parents[2] / folder / name.rpartition("/")[2]).is_file(), name
