"""The contracts run over something: discovery is not empty and finds what it must."""

from __future__ import annotations


def test_known_things_are_found(discovered):
    assert {"Trapezium", "Sine", "Sampled"} <= set(discovered["drive_class"])
    assert {"Constant", "Debye", "Prony", "ColeCole", "Tabulated"} <= set(discovered["material_class"])
    assert {"MaxwellStressInGap", "Vezzoli2014Causal", "Vezzoli2014PerFrequency"} <= set(
        discovered["law_class"]
    )
    assert {"vezzoli_2014", "gabriel_1996", "palmar_1995", "plutchik_1963"} <= set(discovered["paper"])
    assert "vezzoli_2014-fig6" in discovered["scenario"]
    assert "gabriel_1996-dry" in discovered["skin"]
    assert "scenario.experiment.Scenario" in discovered["final_class"]
    assert "physics.drive.base.Drive" in discovered["family"]


def test_every_kind_of_thing_is_found(discovered):
    assert all(discovered.values()), {name: len(found) for name, found in discovered.items()}


def test_classes_of_other_tests_are_not_found(discovered):
    assert all("test" not in name.split(".")[0] for name in discovered["final_class"])
