"""Rough contact under a voltage: the trends of the abstract."""

from __future__ import annotations

from electrovib.papers import ayyildiz_2018


def test_it_runs_nothing():
    """An equation nobody has read is not offered: no law, scenario or skin, and the reason in words."""
    for thing in vars(ayyildiz_2018).values():
        assert not (isinstance(thing, type) and thing.__module__ == ayyildiz_2018.__name__)
    assert not hasattr(ayyildiz_2018, "scenarios")
    assert not hasattr(ayyildiz_2018, "skins")
    assert "equations, parameters and forces" in ayyildiz_2018.NOT_READ
    assert {check.status for check in ayyildiz_2018.CHECKS} <= {"abstract", "derived"}


def test_trends_can_be_missed(monkeypatch):
    def thicker_and_weaker(_rms, _in_rms, *, coating, voltage=1.0):
        return coating / (1 + voltage)

    assert ayyildiz_2018.thinner_coatings_pull_more() == 1
    assert ayyildiz_2018.real_contact_grows() == 1
    monkeypatch.setattr(ayyildiz_2018, "_pull", thicker_and_weaker)
    assert ayyildiz_2018.thinner_coatings_pull_more() == 0
    assert ayyildiz_2018.real_contact_grows() == 0
