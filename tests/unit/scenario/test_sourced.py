"""A path in the table of sources that no parameter has is refused where a file is read, and nowhere else."""

from __future__ import annotations

import json

import pytest

import electrovib as ev
from electrovib.core.discovery import find_members, offers
from electrovib.core.errors import InputError
from electrovib.physics.drive.base import Drive
from electrovib.scenario import Scenario, read_part
from electrovib.scenario.sourced import wrong_sources

GAP = "vezzoli_2014/fig6_gap"
WRONG = {
    "stack.gap.thicknes": "'stack.gap' has no 'thicknes'. Did you mean 'stack.gap.thickness'?",
    "stack.insulatr.thickness": "'stack' has no 'insulatr'. Did you mean 'stack.insulator.thickness'?",
    "stack.coating.thickness": "'stack' has no 'coating'. Did you mean 'stack.insulator.thickness' or",
    "lod.normal_force": "a scenario has no 'lod'. Did you mean 'load.normal_force'?",
    "normal_force": "a scenario has no 'normal_force'. Did you mean 'load.normal_force'?",
    "load.normal_force.value": "'load.normal_force' is a single value",
    "drive.amplitde": "'drive' has no 'amplitde'. Did you mean 'drive.amplitude'?",
    "stack.gap.material.permitivity": "Did you mean 'stack.gap.material.permittivity'?",
    "moisture.levl": "Did you mean 'moisture.level'?",
    "perception.treshold": "Did you mean 'perception.threshold'?",
    "": "a scenario has no ''. Known: ",
    "load.": "'load' has no ''. Known: ",
    "stack.gap.leak.xyz": "'stack.gap.leak' has no 'xyz'",
}
RIGHT = [
    "stack",  # a table
    "stack.insulator",
    "stack.insulator.material",
    "drive.model",
    "drive.frequency",  # of another drive
    "drive.file",
    "limits.voltage",  # not given
    "perception.threshold",  # an optional part that is not there
    "moisture.level",
    "circuit.amplifier.gain",
    "stack.gap.leak.model",
    "finger.mass",
]


def tables(**sources):
    return ev.load(GAP).to_dict() | {"sources": sources}


@pytest.mark.parametrize("path", WRONG)
def test_a_path_that_no_parameter_has_is_refused(path):
    with pytest.raises(InputError) as error:
        ev.load(tables(**{path: "mine", "load.normal_force": "mine"}))
    (problem,) = error.value.problems
    assert problem.path == f'sources."{path}"'
    assert problem.reason.startswith("no parameter has this path; ")
    assert WRONG[path] in problem


@pytest.mark.parametrize("path", RIGHT)
def test_a_path_that_a_parameter_may_have_is_kept(path):
    assert len(ev.load(tables(**{path: "mine"})).sources) == 1


def test_in_a_file_it_is_listed_beside_the_other_mistakes(tmp_path):
    text = ev.init(GAP).replace('"stack.gap.thickness" =', '"stack.gap.thicknes" =')
    file = tmp_path / "my.toml"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=r"Did you mean 'stack\.gap\.thickness'") as alone:
        ev.load(file)
    file.write_text(text.replace("normal_force = ", "normal_forc = "), encoding="utf-8")
    with pytest.raises(InputError) as error:
        ev.load(file)
    assert [problem.path for problem in error.value.problems][-1] == 'sources."stack.gap.thicknes"'
    assert any("normal_forc" in problem for problem in error.value.problems)
    with pytest.raises(InputError, match=r"Did you mean 'stack\.gap\.thickness'") as corrected:
        ev.load(file, changes={"load": {"normal_force": 0.5}})
    assert corrected.value.problems == alone.value.problems


def test_an_entry_of_a_list_has_a_number():
    found = next(
        (name, path)
        for name, scenario in offers(("scenarios",)).items()
        for path, _, _ in scenario.parameters()
        if any(part.isdigit() for part in path.split("."))
    )
    name, path = found
    entry = next(part for part in path.split(".") if part.isdigit())
    wrong = path.replace(f".{entry}.", ".99.", 1)
    assert ev.load(ev.load(name).to_dict() | {"sources": {path: "mine"}}).sources == {path: "mine"}
    with pytest.raises(InputError, match="has entries 0 to "):
        ev.load(ev.load(name).to_dict() | {"sources": {wrong: "mine"}})


def test_sources_written_by_electrovib_are_not_examined():
    assert ev.load(tables(**{"stack.adhesive.thickness": "set by the user"})).sources


def test_every_scenario_of_a_paper_is_read_again():
    for name, scenario in offers(("scenarios",)).items():
        assert wrong_sources(Scenario, scenario.to_dict()) == [], name


MOISTURE = {
    "level": 0.5,
    "dry_gap_resistivity": 1e6,
    "wet_gap_resistivity": 1e4,
    "dry_coefficient": 0.3,
    "wet_coefficient": 1.0,
}
CHANGES = [
    {"drive": {"model": "Sine", "amplitude": 100, "frequency": 200}},
    {"stack.gap.material": "silica"},
    {"stack": "strong_1970/display_gap"},
    {"moisture": MOISTURE},
    {"circuit.amplifier": {"gain": 100}, "perception": {}},
    {
        "stack.adhesive": {
            "thickness": "5 um",
            "role": "plate",
            "material": {"model": "Constant", "permittivity": 3},
        }
    },
    {"friction": {"model": "PowerLaw", "coefficient": 0.5, "at_force": "1 N", "exponent": -0.1}},
]


@pytest.mark.parametrize("changes", CHANGES)
def test_what_a_change_leaves_is_read_again(changes, tmp_path):
    changed = ev.load(GAP).replace(changes)
    file = tmp_path / "changed.toml"
    file.write_text(changed.to_toml(), encoding="utf-8")
    assert ev.load(file) == changed
    assert ev.load(file).sources == changed.sources
    assert ev.load(file, changes={"load.normal_force": 1.0}).load.normal_force == 1.0


def test_a_change_and_a_trace_are_not_examined():
    """Scenarios that exist keep their sources, whatever these are."""
    odd = ev.load(GAP).model_copy(update={"sources": {"stack.gone.thickness": "mine"}})
    assert odd.replace({"load.normal_force": 1.0}).sources["stack.gone.thickness"] == "mine"
    content = json.loads(odd.to_json())
    del content["schema"]
    assert read_part(Scenario, content).sources == odd.sources
    assert ev.load(ev.simulate(odd)).sources == odd.sources


def test_a_path_without_quotation_marks_is_explained(tmp_path):
    file = tmp_path / "my.toml"
    file.write_text(
        ev.init(GAP).replace('"stack.gap.thickness" =', "stack.gap.thickness ="), encoding="utf-8"
    )
    with pytest.raises(InputError) as error:
        ev.load(file)
    (problem,) = error.value.problems
    assert problem == (
        'sources.stack: a path with full stops is one name in quotation marks: "stack.gap.thickness" = "..."'
    )


def test_a_layer_of_the_interface_that_was_removed_may_keep_its_source():
    without = ev.load("vezzoli_2014/fig6").to_dict()
    assert "gap" not in without["stack"]
    assert ev.load(without | {"sources": {"stack.gap.thickness": "mine"}}).sources
    with pytest.raises(InputError, match=r"Did you mean 'stack\.gap\.thickness'"):
        ev.load(without | {"sources": {"stack.gap.thicknes": "mine"}})


def test_a_derived_parameter_has_a_source():
    sine = find_members(Drive)["Sine"]
    assert "high" in sine.derived
    assert wrong_sources(sine, {"sources": {"high": "mine", "amplitude": "mine"}}) == []
    assert len(wrong_sources(sine, {"sources": {"hold": "mine"}})) == 1
