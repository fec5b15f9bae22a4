"""What a computation may take: read, counted, measured, refused beyond, with what would help."""

import threading

import pytest

from electrovib.core.budget import (
    Budget,
    BudgetError,
    Work,
    allowed,
    budget,
    duration,
    listening,
    read_budget,
    refuse_beyond,
)
from electrovib.core.errors import InputError
from electrovib.solve.meter import Meter, measured


def test_what_is_allowed_holds_within_the_block_and_the_thread():
    seen = []
    with budget(time="2 h"):
        assert allowed() == Budget(time=7200.0)
        with budget(memory="16 GB"):
            assert allowed() == Budget(time=7200.0, memory=16e9)
        other = threading.Thread(target=lambda: seen.append(allowed()))
        other.start()
        other.join()
    assert allowed() == Budget() == seen[0]


@pytest.mark.parametrize(
    ("text", "time", "memory"),
    [("2 h, 16 GB", 7200, 16e9), ("500 MB,30 min", 1800, 5e8), ("90 s", 90, None), ("1.5 TB", None, 1.5e12)],
)
def test_a_text_names_time_and_memory_in_any_order(text, time, memory):
    expected = {"time": time, "memory": memory}
    assert read_budget(text) == pytest.approx({name: value for name, value in expected.items() if value})


WRONG = r"expected a time above 0|twice"


@pytest.mark.parametrize(
    ("text", "words"),
    [(text, WRONG) for text in ("", "soon", "-1 s", "0 GB", "1 h, 2 h", "1e400 s", "nan s", "4 m")]
    + [(text, f"Give its unit: '{text} min' or '{text} GB'") for text in ("1", "1e3", "0.5")]
    + [("2 h, 16", "Give its unit: '16 min' or '16 GB'")],
)
def test_anything_else_is_refused(text, words):
    with pytest.raises(InputError, match=words):
        read_budget(text)


FIRST = Work(what="first", time=6.0, memory=5e6, remedy="make the first less")
SECOND = Work(what="second", time=5.0, memory=6e6, remedy="make the second less")


def test_times_add_up_and_the_largest_memory_counts():
    with budget(time=12, memory=7e6):
        refuse_beyond([FIRST, SECOND])
    with budget(time=10.9, memory=7e6), pytest.raises(BudgetError) as told:
        refuse_beyond([FIRST, SECOND])
    assert str(told.value) == (
        "this run would take about 11 s and 6 MB, for first; allowed are 11 s and 7 MB. Make the first less, or allow"
        " more: electrovib --budget '16 s, 9 MB' ..., or electrovib.budget(time='16 s', memory='9 MB') in Python"
    )
    with (
        budget(time=12, memory=5.5e6),
        pytest.raises(BudgetError, match=r"for second; .* Make the second less"),
    ):
        refuse_beyond([FIRST, SECOND])


def test_an_offer_is_enough_and_what_nobody_would_wait_for_is_not_offered():
    """The budget that a refusal names lets the same computation through."""
    works = [Work(what="much", time=1234.0, memory=5.6e9, remedy="make it less")]
    with pytest.raises(BudgetError) as told:
        refuse_beyond(works)
    offered = str(told.value).split("--budget '")[1].split("'")[0]
    with budget(**read_budget(offered)):
        refuse_beyond(works)
    with pytest.raises(BudgetError, match=r"10 min and 4 GB\. Ask for less$"):
        refuse_beyond([Work(what="1e+12 output times", time=1e6, memory=1e15, remedy="ask for less")])


@pytest.fixture
def clock(monkeypatch):
    """A clock that is set by hand."""
    moments = [0.0]
    monkeypatch.setattr("electrovib.solve.meter.clock", lambda: moments[0])

    def spend(seconds):
        moments[0] += seconds

    return spend


def march(**given):
    return Meter("the march", end=2.0, remedy="march less", **given)


def sweep(count=1000, numbers=10):
    return Meter.of_cases("this sweep", f"{count} cases", count, numbers=numbers, remedy="sweep less")


def test_a_march_ends_when_the_budget_is_spent_or_it_holds_too_much(clock):
    with budget(time=1.0):
        meter = march()
    for step in range(100):
        clock(1 / 128)
        meter.count(step * 0.01)
    clock(0.25)
    with pytest.raises(BudgetError) as told, budget(time=1.0):
        meter.count(1.0)
    assert str(told.value) == (
        "the march would take about 2.1 s and 0 MB, for 2 s, of which 50 % took 1 s; allowed are 1 s and 4 GB. March less,"
        " or allow more: electrovib --budget '3.1 s' ..., or electrovib.budget(time='3.1 s') in Python"
    )
    with budget(memory=8e3):
        meter = march(held=1000)
        meter.count(0.5)
        meter.held += 1
        with pytest.raises(BudgetError, match=r"0.00801 MB, for 2 s, of which 30 % took .*March less"):
            meter.count(0.6)


def test_meters_of_one_computation_share_its_budget(clock):
    with budget(time=1.0):
        with measured():
            clock(0.75)
            with measured():
                meter = march()
            clock(0.5)
            with budget(time=1.0):
                march().count(1.0)  # another computation
            with pytest.raises(BudgetError, match=r"would take about 1\.8 s"):
                meter.count(1.0)
        march().count(1.0)  # the next one


def test_alike_parts_show_soon_what_the_whole_takes(clock):
    """The quickest tells; what precedes the first, such as compiling, is no part of it, and a batch is no slow case."""
    with budget(time=100.0):
        meter = sweep()
        for spent, done in ((0.0, 0), (20.0, 1)):
            clock(spent)
            meter.count(done)
        clock(1.0)
        with pytest.raises(BudgetError, match=r"this sweep .* 17 min .*1000 cases, of which 0.2 % took 21 s"):
            meter.count(2)
        for count, seconds in ((1000, lambda done: 20.0 if done == 1 else 1 / 16), (500, batches)):
            meter = sweep(count)
            for done in range(1, count):
                clock(seconds(done))
                meter.count(done)


def batches(done):
    """Spend everything on the first of 250 cases."""
    return 20.0 if done % 250 == 1 else 0.0


def test_time_stepping_that_spends_the_budget_of_all_cases_names_them(clock):
    told = r"this sweep would take about 48 s .*8 cases, of which 25 % took 12 s.*Sweep"
    with budget(time=10.0), measured():
        cases = sweep(8)
        clock(6.0)
        cases.count(2)
        clock(6.0)
        with pytest.raises(BudgetError, match=told):
            march().count(0.5)
    with pytest.raises(BudgetError, match=r"8e\+03 TB, for 1000000000000000 cases"):
        sweep(10**15, numbers=1)  # which the memory does not hold: at once


def test_a_meter_tells_how_far_it_is():
    heard, told = [], []
    with listening(heard.append):
        meter = march()
        with listening(None):
            march().count(0.5)
    for now in (0.5, 2.0):
        meter.count(now)
    assert heard == [0.25, 1.0]
    sweep(4).reporting(lambda *at: told.append(at))(1, 4)
    assert told == [(1, 4)]


def test_a_computing_time_has_two_digits():
    texts = {0.0123: "0.012 s", 119: "120 s", 121: "2 min", 5400: "90 min", 7200: "2 h", 1e6: "12 days"}
    assert {seconds: duration(seconds) for seconds in texts} == texts
