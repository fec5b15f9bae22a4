"""The state of a page: its link, its scenario, and what no link may ask for; addresses that cannot be served."""

import socket

import pytest
from hypothesis import given
from hypothesis import strategies as st

import electrovib as ev
from electrovib.apps.explorer.runner import LONGEST_LINK, MOST_CHANGES, MOST_SAMPLES
from electrovib.apps.explorer.server import listening
from electrovib.apps.explorer.state import PageState, presets, read_query, refuse_files, scenario_of
from electrovib.core.errors import ElectrovibError, InputError

FIG6 = "vezzoli_2014/fig6"


def read(query):
    return read_query(query, own={}, default=FIG6)


def test_a_link_gives_the_scenario_again():
    assert scenario_of(read(""), own={}) == ev.load(FIG6)
    state = PageState(FIG6).changed("drive.high", "500 V").changed("stack.insulator.thickness", "50 um")
    again = read(state.to_query())
    assert again == state
    wanted = ev.load(FIG6).replace({"drive.high": 500.0, "stack.insulator.thickness": 50e-6})
    assert scenario_of(again, own={}) == wanted


def test_scenarios_that_the_page_was_started_with():
    own = {"yours": ev.load("bau_2010/sine")}
    assert presets(own)[0] == "yours"
    assert scenario_of(PageState("yours"), own=own) == own["yours"]
    with pytest.raises(InputError, match="no scenario is called 'yours'"):
        scenario_of(PageState("yours"), own={})


def test_a_part_that_is_replaced_loses_the_changes_inside_it():
    skin, film = "stack.stratum_corneum.material", "stack.insulator.thickness"
    state = PageState(FIG6).changed(f"{skin}.permittivity", "900").changed(film, "1 um")
    state = state.changed(skin, "gabriel_1996/wet")
    assert dict(state.changes) == {film: "1 um", skin: "gabriel_1996/wet"}
    assert dict(state.reset("stack").changes) == {}
    other = state.changed("force.model", "MaxwellStressInInsulator")
    assert dict(other.reset("force.model").changes) == dict(state.changes)
    assert state.reset() == PageState(FIG6)
    law = PageState(FIG6).changed("force.medium", "1").changed("force.model", "EffectiveMedium")
    assert dict(law.changes) == {"force.model": "EffectiveMedium"}


MALFORMED = """
preset=none
preset=../../etc/passwd
preset=/etc/passwd
preset=
set=drive.high
set=
set==5
set=drive.high=
set=drive.high=5 parsec
set=drive.high=nan
set=__class__=x
set=stack.stratum_corneum.material=nobody_1900/skin
set=stack.stratum_corneum.material={ model = "Tabulated", file = "/etc/passwd", conductivity = "1 uS/m" }
set=drive={ model = "Sampled", file = "/etc/passwd" }
set=drive.file=/etc/passwd
set=drive={ model = "Sampled", time_samples = [0, 1], voltage_samples = [0, 1], file = "x" }
set=drive={
set=drive=[[[[[[1]]]]]]
set=force.model=
set=time.samples=100000000
set=time.samples=-1
set=time.duration=-1 s
set=drive.high=%00
set=%FF%FE=1
""".strip().splitlines()
MALFORMED += ["set=" + "a." * 140 + "=1", "set=stack=" + "{" * 140, "x" * (LONGEST_LINK + 1)]
MALFORMED += [f"set=drive.high={'9' * digits}" for digits in (299, 3000)]
MALFORMED += [
    "&".join(f"set=a{i}=1" for i in range(MOST_CHANGES + 1)),
    "&".join(["a=1"] * (MOST_CHANGES + 50)),
]


@pytest.mark.parametrize("query", MALFORMED, ids=lambda query: query[:30])
def test_malformed_links_are_refused_with_a_sentence(query):
    with pytest.raises(InputError) as error:
        read(query)
    assert 10 < len(str(error.value)) < 5000


PARTS = ["drive.high", "drive", "stack.insulator", "force.model", "friction", "time", "stack"]


@given(st.none() | st.sampled_from(PARTS), st.text(max_size=300))
def test_any_text_as_a_link_or_a_value_gives_a_state_or_a_sentence(path, text):
    try:
        assert isinstance(read(PageState(FIG6, {path: text[:60]}).to_query() if path else text), PageState)
    except ElectrovibError as error:
        assert str(error)


def test_files_are_found_in_every_depth():
    refuse_files({"a": [{"b": "file"}], "c": "file"})
    for content in ({"file": 1}, {"a": {"file": 1}}, {"a": [0, {"b": {"file": ""}}]}, {"a.b.file": 1}):
        with pytest.raises(InputError, match="names a file"):
            refuse_files(content)


@pytest.mark.parametrize(
    ("state", "words"),
    [
        (PageState(None), "have to be texts"),
        (PageState(FIG6, {"drive.high": None}), "have to be texts"),
        (PageState(FIG6, {1: "2"}), "have to be texts"),
        (PageState([]), "have to be texts"),
        (PageState(FIG6, {"time.samples": str(MOST_SAMPLES + 1)}), "at most 20000"),
        (PageState(FIG6, {"frequency.samples": str(MOST_SAMPLES + 1)}), "at most 20000"),
    ],
)
def test_a_state_of_anything_but_texts_or_of_too_many_samples_is_refused(state, words):
    most = PageState(FIG6, {"time.samples": str(MOST_SAMPLES)})
    assert scenario_of(most, own={}).time.samples == MOST_SAMPLES
    with pytest.raises(InputError, match=words):
        scenario_of(state, own={})


@pytest.fixture
def busy(monkeypatch):
    """Listen on a port of this machine, which is the first that the page would take."""
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        monkeypatch.setattr("electrovib.apps.explorer.server.FIRST_PORT", port)
        yield port


def test_a_port_is_taken_before_the_page_is_served_and_one_in_use_is_refused(busy):
    words = rf"^port = {busy}: .* \(another program listens there\); .* omit --port for one that is free$"
    with pytest.raises(InputError, match=words):
        ev.explore(port=busy, browser=False)
    first, one = listening(None)
    second, other = listening(None)
    with one, other:
        assert busy < first < second < busy + 50
        with pytest.raises(InputError, match=f"^port = {first}: .*another program listens there"):
            ev.explore(port=first, browser=False)
    again, freed = listening(first)
    freed.close()
    assert again == first


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"port": 0}, "port = 0: a port is a number from 1 to 65535"),
        ({"port": 65536}, "port = 65536: a port is a number"),
    ],
)
def test_addresses_that_do_not_exist_are_refused(options, words):
    with pytest.raises(InputError, match=words):
        ev.explore(browser=False, **options)
