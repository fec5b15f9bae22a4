"""A changed scenario is validated where something changes; it is the same as one that is built anew as a whole."""

import pytest

import electrovib as ev
from electrovib.apps.explorer.state import presets
from electrovib.core.errors import InputError
from electrovib.scenario import Scenario

WRONG = (
    {"drve.high": 1},
    {"drive.hihg": 1},
    {"drive.high.more": 1},
    {"stack.gpa.thickness": 1e-6},
    {"stack.gap": {"thickness": "-1 um"}},
    {"load.normal_force": "1 V"},
    {"finger.mass": 1},
    {"circuit.series_resistance": -1, "contact.area": "x"},
    {"motion.distance.gap": 1},
    {"title.words": "x"},
    {"sources.x": "y"},
)


def changes_of(scenario):
    """Return a change of the first number of every part, alone, and all of them together."""
    first = {}
    for path, value, _ in scenario.parameters():
        if value:
            first.setdefault(path.split(".")[0], {path: value * 1.01})
    together = {path: value for each in first.values() for path, value in each.items()}
    return [*first.values(), together, {"title": "another"}]


def outcome(scenario, changes):
    """Return the changed scenario with its sources, or the sentences of its refusal."""
    try:
        changed = scenario.replace(changes)
    except InputError as error:
        return [str(each) for each in error.problems]
    return changed.to_dict(), changed.digest()


@pytest.mark.parametrize("name", sorted(presets({})))
def test_parts_that_stay_are_the_same_objects_and_change_nothing(name, monkeypatch):
    scenario = ev.load(name)
    cases = [*changes_of(scenario), *WRONG]
    found = [outcome(scenario, each) for each in cases]
    changed = scenario.replace({"drive": scenario.drive.to_dict()})
    assert changed.stack is scenario.stack
    monkeypatch.setattr(Scenario, "to_change", lambda self, _: self.to_dict())
    assert found == [outcome(scenario, each) for each in cases]
    assert sum(isinstance(each, tuple) for each in found) >= 5
