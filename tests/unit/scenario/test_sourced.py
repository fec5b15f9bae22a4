"""A path in the table of sources that no parameter has is refused where a file is read, and nowhere else."""

import json

import pytest

import electrovib as ev
from electrovib.core.discovery import find_members, offers
from electrovib.core.errors import InputError
from electrovib.physics.drive.base import Drive
from electrovib.physics.finger import Moisture
from electrovib.scenario import Scenario, read_part
from electrovib.scenario.sources import wrong_sources

GAP = "vezzoli_2014/fig6_gap"
MISSPELT = "Did you mean 'stack.gap.thickness'?"
WRONG = {
    "stack.gap.thicknes": f"'stack.gap' has no 'thicknes'. {MISSPELT}",
    "stack.insulatr.thickness": "'stack' has no 'insulatr'. Did you mean 'stack.insulator.thickness'?",
    "stack.coating.thickness": "'stack' has no 'coating'. Did you mean 'stack.insulator.thickness', 'stack.gap.thickness' or",
    "lod.normal_force": "a scenario has no 'lod'. Did you mean 'load.normal_force'?",
    "load.normal_force.value": "'load.normal_force' is a single value",
    "stack.gap.material.permitivity": "Did you mean 'stack.gap.material.permittivity'?",
    "moisture.levl": "Did you mean 'moisture.level'?",
    "perception.treshold": "Did you mean 'perception.threshold'?",
    "": "a scenario has no ''. Known: ",
    "stack.gap.leak.xyz": "'stack.gap.leak' has no 'xyz'",
}
RIGHT = [
    "stack",  # a table
    "drive.model",
    "drive.frequency",  # of another drive
    "drive.file",
    "perception.threshold",  # an optional part that is not there
    "circuit.amplifier.gain",
    "stack.gap.leak.model",
    "finger.mass",
]


def tables(**sources):
    return ev.load(GAP).to_dict() | {"sources": sources}


def problems(*arguments, **more):
    with pytest.raises(InputError) as error:
        ev.load(*arguments, **more)
    return error.value.problems


@pytest.mark.parametrize("path", WRONG)
def test_a_path_that_no_parameter_has_is_refused(path):
    (problem,) = problems(tables(**{path: "mine", "load.normal_force": "mine"}))
    assert problem.path == f'sources."{path}"'
    assert problem.reason.startswith("no parameter has this path; ")
    assert WRONG[path] in problem


@pytest.mark.parametrize("path", RIGHT)
def test_a_path_that_a_parameter_may_have_is_kept(path):
    assert len(ev.load(tables(**{path: "mine"})).sources) == 1


def test_in_a_file_it_is_listed_beside_the_other_mistakes(tmp_path):
    text, file = ev.init(GAP), tmp_path / "my.toml"
    wrong = text.replace('"stack.gap.thickness" =', '"stack.gap.thicknes" =')
    file.write_text(wrong, encoding="utf-8")
    alone = problems(file)
    assert MISSPELT in alone[0]
    file.write_text(wrong.replace("normal_force = ", "normal_forc = "), encoding="utf-8")
    both = problems(file)
    assert both[-1].path == 'sources."stack.gap.thicknes"'
    assert any("normal_forc" in problem for problem in both)
    assert problems(file, changes={"load": {"normal_force": 0.5}}) == alone
    file.write_text(text.replace('"stack.gap.thickness" =', "stack.gap.thickness ="), encoding="utf-8")
    marks = 'a path with full stops is one name in quotation marks: "stack.gap.thickness" = "..."'
    assert problems(file) == (f"sources.stack: {marks}",)


def test_the_scenarios_of_papers_are_read_again_and_entries_of_their_lists_have_numbers():
    shipped = offers(("scenarios",)).values()
    for scenario in shipped:
        assert wrong_sources(Scenario, scenario.to_dict()) == [], scenario.title
    paths = [(path, each) for each in shipped for path, _, _ in each.parameters()]
    entry, scenario = next(found for found in paths if any(part.isdigit() for part in found[0].split(".")))
    content = scenario.to_dict()
    number = next(part for part in entry.split(".") if part.isdigit())
    assert ev.load(content | {"sources": {entry: "mine"}}).sources == {entry: "mine"}
    beyond = entry.replace(f".{number}.", ".99.", 1)
    assert "has entries 0 to " in problems(content | {"sources": {beyond: "mine"}})[0]


@pytest.mark.parametrize(
    "changes",
    [
        {"drive": {"model": "Sine", "amplitude": 100, "frequency": 200}},
        {"stack.gap.material": "silica"},
        {"stack": "strong_1970/display_gap"},
        {"moisture": dict(Moisture.example)},
        {"circuit.amplifier": {"gain": 100}, "perception": {}},
        {"stack.adhesive": {"thickness": "5 um", "role": "plate", "material": "pet"}},
        {"friction": {"model": "PowerLaw", "coefficient": 0.5, "at_force": "1 N", "exponent": -0.1}},
    ],
)
def test_what_a_change_leaves_is_read_again(changes, tmp_path):
    changed = ev.load(GAP).replace(changes)
    file = tmp_path / "changed.toml"
    file.write_text(changed.to_toml(), encoding="utf-8")
    assert ev.load(file) == changed
    assert ev.load(file).sources == changed.sources
    assert ev.load(file, changes={"load.normal_force": 1.0}).load.normal_force == 1.0


def test_a_change_a_trace_and_what_electrovib_writes_are_not_examined():
    """Scenarios that exist keep their sources, whatever these are."""
    odd = ev.load(GAP).model_copy(update={"sources": {"stack.gone.thickness": "mine"}})
    assert odd.replace({"load.normal_force": 1.0}).sources["stack.gone.thickness"] == "mine"
    content = json.loads(odd.to_json())
    del content["schema"]
    assert read_part(Scenario, content).sources == odd.sources
    assert ev.load(ev.simulate(odd)).sources == odd.sources
    assert ev.load(tables(**{"stack.adhesive.thickness": "set by the user"})).sources


def test_a_layer_that_was_removed_and_a_derived_parameter_may_have_a_source():
    without = ev.load("vezzoli_2014/fig6").to_dict()
    assert "gap" not in without["stack"]
    assert ev.load(without | {"sources": {"stack.gap.thickness": "mine"}}).sources
    assert MISSPELT in problems(without | {"sources": {"stack.gap.thicknes": "mine"}})[0]
    sine = find_members(Drive)["Sine"]
    assert "high" in sine.derived
    assert wrong_sources(sine, {"sources": {"high": "mine", "amplitude": "mine"}}) == []
    assert len(wrong_sources(sine, {"sources": {"hold": "mine"}})) == 1
