"""What each tab shows, for every shipped scenario: plots or a sentence, and never a failure of the program."""

from __future__ import annotations

import json

import pytest

import electrovib as ev
from electrovib.apps.explorer.computed import compute
from electrovib.apps.explorer.controls import STEPS, controls
from electrovib.apps.explorer.further import (
    FELT,
    FREQUENCY,
    LAWS,
    RECORDING,
    SAFETY,
    TABS,
    TIME,
    Further,
    slices,
)
from electrovib.apps.explorer.page.plots import MOST_PLOTS, content
from electrovib.apps.explorer.session import Pinned
from electrovib.apps.explorer.state import PageState, presets, scenario_of
from electrovib.core.errors import ElectrovibError


@pytest.fixture(scope="module")
def shown():
    return compute(ev.load("vezzoli_2014/fig6_gap"))


def of_tab(tab, found, **options):
    known = Further()
    for each in slices(tab, found):
        known = each(known)
    return content(tab, found, known, **options)


@pytest.mark.slow
@pytest.mark.parametrize("name", presets())
def test_every_scenario_shows_plots_or_a_sentence_on_every_tab(name):
    found = compute(ev.load(name))
    measured = found.trace[["electrostatic_force"]]
    for tab in TABS:
        if tab == FELT and presets().index(name) % 3:
            continue  # what is felt takes seconds
        shown = of_tab(tab, found, measured=measured)
        assert shown.figures or shown.above or tab == SAFETY, tab
        assert len(shown.figures) <= MOST_PLOTS
        json.dumps(shown.figures, allow_nan=False)
        if tab in (LAWS, SAFETY):
            assert "<table" in shown.below
        for figure in shown.figures:
            assert figure["layout"]["title"]["text"]
            assert figure["layout"]["xaxis"]["title"]["text"].endswith(("[Hz]", "s]"))
            assert any(value is not None for line in figure["data"] for value in line["y"])


@pytest.mark.slow
@pytest.mark.parametrize("name", ["vezzoli_2014/fig6", "bau_2010/sine"])
def test_both_ends_of_every_slider_show_plots_or_a_sentence(name):
    for each in controls(ev.load(name)):
        for position in (0, STEPS):
            state = PageState(name).changed(each.path, each.written(each.at(position)))
            try:
                found = compute(scenario_of(state, own={}))
            except ElectrovibError as error:
                assert str(error)
                continue
            for tab in (TIME, FREQUENCY):
                json.dumps(content(tab, found, Further()).figures, allow_nan=False)


def test_a_tab_states_what_cannot_be_shown(shown):
    for tab in (FELT, SAFETY):
        assert content(tab, shown, Further(problems=("a < b",))).above == "<p>a &lt; b</p>"
    assert content(RECORDING, shown, Further()).above == ""
    fields = shown.trace[["field"]]
    assert "No signal of this recording" in content(RECORDING, shown, Further(), measured=fields).above


def test_curves_that_are_kept_are_listed_over_time_and_over_frequency_only(shown):
    kept = [Pinned("mine: drive.high = 5 V", shown)]
    for tab in (TIME, FREQUENCY):
        assert "kept 1: mine: drive.high = 5 V" in content(tab, shown, Further(), pinned=kept).above
    assert content(LAWS, shown, Further(), pinned=kept).above == ""


def test_a_force_that_does_not_vary_has_a_sentence_in_place_of_a_spectrum(shown):
    constant = compute(shown.scenario.replace({"drive": {"model": "Step", "level": 0}}))
    found = of_tab(FELT, constant)
    assert found.figures == []
    assert "does not vary" in found.above


def test_a_signal_without_a_value_has_a_sentence_in_place_of_a_plot():
    found = of_tab(TIME, compute(ev.load("shultz_2018/at_rest")))
    assert "lateral force is not shown: it has no value in this scenario" in found.above
    titles = [figure["layout"]["title"]["text"] for figure in found.figures]
    assert not any(title.startswith("Lateral force") for title in titles)
    assert "Electrostatic force" in titles


def test_a_parameter_that_can_only_be_0_has_no_slider():
    scenario = ev.load("vezzoli_2014/fig6_gap")
    paths = {each.path for each in controls(scenario)}
    assert "stack.insulator.initial_charge" in paths
    assert "stack.stratum_corneum.initial_charge" not in paths  # it would lie on the conducting finger
    assert {
        "drive.low",
        "drive.delay",
        "stack.insulator.material.conductivity",
    } <= paths  # which are 0, and can move


def test_a_calibrated_perception_is_stated_with_its_level():
    changes = {
        "perception.compliance": {"model": "ElasticSkin", "stiffness": 1000},
        "perception.threshold": "1 um",
        "perception.threshold_uncertainty": 3,
    }
    threshold, compliance = "a detection threshold", "a compliance of the skin"
    for given, assumed in (
        ((), [threshold, compliance]),
        (list(changes)[1:], [compliance]),
        (list(changes)[:1], [threshold]),
        (list(changes), []),
    ):
        scenario = ev.load("bau_2010/sine").replace({path: changes[path] for path in given})
        percept = ev.perceive(scenario)
        above = of_tab(FELT, compute(scenario)).above
        assert f"<b>felt</b>, {percept.felt_by} channel: {percept.sensation:+.1f} dB (" in above
        assert ("assumed from publications" in above) == bool(assumed)
        if assumed:
            assert f"assumed from publications: {' and '.join(assumed)}; " in above
    weak = ev.load("bau_2010/sine").replace({**changes, "perception.threshold": "1 mm"})
    assert (
        f"<b>not felt</b>, Pacinian channel: {ev.perceive(weak).sensation:+.1f} dB ("
        in of_tab(FELT, compute(weak)).above
    )
