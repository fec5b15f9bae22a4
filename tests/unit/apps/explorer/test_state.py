"""The state of a page: its link, its scenario, and what no link may ask for."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

import electrovib as ev
from electrovib.apps.explorer.limits import LONGEST_LINK, MOST_CHANGES, MOST_SAMPLES
from electrovib.apps.explorer.state import PageState, presets, read_query, refuse_files, scenario_of
from electrovib.core.errors import ElectrovibError, InputError

FIG6 = "vezzoli_2014/fig6"


def read(query):
    return read_query(query, own={}, default=FIG6)


def test_a_link_gives_the_scenario_again():
    state = PageState(FIG6).changed("drive.high", "500 V").changed("stack.insulator.thickness", "50 um")
    again = read(state.to_query())
    assert again == state
    wanted = ev.load(FIG6).replace({"drive.high": 500.0, "stack.insulator.thickness": 50e-6})
    assert scenario_of(again, own={}) == wanted


def test_without_a_query_the_first_scenario_is_shown():
    assert read("") == PageState(FIG6)
    assert scenario_of(read(""), own={}) == ev.load(FIG6)


def test_scenarios_that_the_page_was_started_with():
    own = {"yours": ev.load("bau_2010/sine")}
    assert presets(own)[0] == "yours"
    assert scenario_of(PageState("yours"), own=own) == own["yours"]
    with pytest.raises(InputError, match="no scenario is called 'yours'"):
        scenario_of(PageState("yours"), own={})


def test_a_part_that_is_replaced_loses_the_changes_inside_it():
    state = PageState(FIG6).changed("stack.stratum_corneum.material.permittivity", "900")
    state = state.changed("stack.insulator.thickness", "1 um").changed(
        "stack.stratum_corneum.material", "gabriel_1996/wet"
    )
    assert dict(state.changes) == {
        "stack.insulator.thickness": "1 um",
        "stack.stratum_corneum.material": "gabriel_1996/wet",
    }
    assert dict(state.reset("stack").changes) == {}
    assert dict(
        state.changed("force.model", "MaxwellStressInInsulator").reset("force.model").changes
    ) == dict(state.changes)
    assert state.reset() == PageState(FIG6)
    law = PageState(FIG6).changed("force.medium", "1").changed("force.model", "EffectiveMedium")
    assert dict(law.changes) == {"force.model": "EffectiveMedium"}


MALFORMED = [
    "preset=none",
    "preset=../../etc/passwd",
    "preset=/etc/passwd",
    "preset=my.toml",
    "preset=vezzoli_2014",
    "preset=",
    "set=drive.high",
    "set=",
    "set==5",
    "set=drive.high=",
    "set=drive.high=five",
    "set=drive.high=5 parsec",
    "set=drive.high=1e300 V",
    "set=drive.high=nan",
    "set=drive.hihg=5 V",
    "set=__class__=x",
    "set=drive.__init__=x",
    "set=stack.stratum_corneum.material=nobody_1900/skin",
    "set=stack.stratum_corneum.material=skin.csv",
    "set=stack.stratum_corneum.material="
    '{ model = "Tabulated", file = "/etc/passwd", conductivity = "1 uS/m" }',
    "set=drive=" + '{ model = "Sampled", file = "/etc/passwd" }',
    "set=drive.file=/etc/passwd",
    "set=drive=" + '{ model = "Sampled", time_samples = [0, 1], voltage_samples = [0, 1], file = "x" }',
    "set=drive={",
    "set=drive={ model = 5 }",
    "set=drive=[[[[[[1]]]]]]",
    "set=force.model=os.system",
    "set=force.model=",
    "set=time.samples=100000000",
    "set=frequency.samples=1000000",
    "set=time.samples=-1",
    "set=time.duration=-1 s",
    "set=" + "a." * 140 + "=1",
    "set=drive.high=" + "9" * 299,
    "set=drive.high=" + "9" * 3000,
    "x" * (LONGEST_LINK + 1),
    "&".join(f"set=a{i}=1" for i in range(MOST_CHANGES + 1)),
    "&".join("a=1" for _ in range(MOST_CHANGES + 50)),
    "set=drive.high=%00",
    "set=%FF%FE=1",
    "set=stack=" + "{" * 140,
]


@pytest.mark.parametrize("query", MALFORMED, ids=lambda query: query[:30])
def test_malformed_links_are_refused_with_a_sentence(query):
    with pytest.raises(InputError) as error:
        read(query)
    assert 10 < len(str(error.value)) < 5000


@given(st.text(max_size=300))
def test_any_text_as_a_link_gives_a_state_or_a_sentence(text):
    try:
        assert isinstance(read(text), PageState)
    except ElectrovibError as error:
        assert str(error)


@given(
    st.sampled_from(["drive.high", "drive", "stack.insulator", "force.model", "friction", "time", "stack"]),
    st.text(max_size=60),
)
def test_any_value_of_a_parameter_gives_a_state_or_a_sentence(path, text):
    try:
        read(PageState(FIG6, {path: text}).to_query())
    except ElectrovibError as error:
        assert str(error)


def test_files_are_found_in_every_depth():
    refuse_files({"a": [{"b": "file"}], "c": "file"})
    for content in ({"file": 1}, {"a": {"file": 1}}, {"a": [0, {"b": {"file": ""}}]}, {"a.b.file": 1}):
        with pytest.raises(InputError, match="names a file"):
            refuse_files(content)


@pytest.mark.parametrize(
    "state",
    [PageState(None), PageState(FIG6, {"drive.high": None}), PageState(FIG6, {1: "2"}), PageState([])],
)
def test_a_state_of_anything_but_texts_is_refused(state):
    with pytest.raises(InputError, match="have to be texts"):
        scenario_of(state, own={})


def test_samples_are_limited():
    state = PageState(FIG6, {"time.samples": str(MOST_SAMPLES)})
    assert scenario_of(state, own={}).time.samples == MOST_SAMPLES
    with pytest.raises(InputError, match="at most 20000"):
        scenario_of(PageState(FIG6, {"time.samples": str(MOST_SAMPLES + 1)}), own={})
    with pytest.raises(InputError, match="at most 20000"):
        scenario_of(PageState(FIG6, {"frequency.samples": str(MOST_SAMPLES + 1)}), own={})
