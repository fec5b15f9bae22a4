"""Titles say what was computed: that of a ready-made scenario is followed by what was changed."""

import pytest

from electrovib.core.discovery import offers
from electrovib.scenario import load
from electrovib.scenario.sources import ready_made


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({}, ""),
        ({"drive.high": "1 kV", "friction.coefficient": 0.5}, ""),
        ({"drive.high": "500 V"}, ", changed: drive.high = 500 V"),
        ({"drive": {"model": "Step", "level": "100 V"}}, ", changed: drive = Step(level = 100 V)"),
        ({"force.model": "EffectiveMedium"}, ", changed: force = EffectiveMedium"),
        ({"stack.gap": {"thickness": "2 um"}}, ", changed: stack.gap = Layer(thickness = 2 um)"),
        ({"time.samples": 3, "limits.voltage": "2 kV"}, ", changed: time.samples = 3, limits.voltage = 2 kV"),
        (
            {
                "drive.high": 500,
                "drive.rise": "1 ms",
                "drive.fall": "2 ms",
                "load.normal_force": 1,
                "contact.area": 2e-4,
            },
            ", changed: drive.high = 500 V, drive.rise = 1 ms, drive.fall = 2 ms and 2 more",
        ),
    ],
)
def test_a_published_title_is_followed_by_what_was_changed(changes, told):
    """In Python and in a file that began from a ready-made scenario, whatever its sources say."""
    base = load("vezzoli_2014/fig6")
    changed = base.replace(changes)
    in_a_file = load(changed.model_copy(update={"sources": base.sources}).to_dict())
    assert changed.titled() == in_a_file.titled() == f"{base.title}{told}"
    assert load(changed.to_dict()).title == base.title, "the title itself stays"
    assert base.replace({"drive.high": 500}).titled(without=["drive.high"]) == base.title
    mine = changed.model_copy(update={"title": "my plate"})
    assert mine.titled() == "my plate"


def test_every_ready_made_scenario_is_found_by_its_title():
    for name, scenario in offers(("scenarios",)).items():
        assert ready_made(scenario.title) == scenario, name
        assert scenario.titled() == scenario.title, name
