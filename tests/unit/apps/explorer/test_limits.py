"""What one visitor can ask for, and what the others notice of it."""

from __future__ import annotations

import asyncio
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from html import escape

import pytest

import electrovib as ev
from electrovib.apps.explorer import fitting, runner
from electrovib.apps.explorer.computed import compute
from electrovib.apps.explorer.fitting import MOST_FITS, RunningFit
from electrovib.apps.explorer.further import SAFETY, Further
from electrovib.apps.explorer.limits import (
    LARGEST_RUN,
    LONGEST_QUICK_RUN,
    LONGEST_RUN,
    LONGEST_SHORT_RUN,
)
from electrovib.apps.explorer.runner import (
    InterruptedWorkError,
    Workers,
    closed_at_end,
    end_work,
    interruptible,
)
from electrovib.apps.explorer.session import Session
from electrovib.apps.explorer.state import PageState
from electrovib.core.budget import BudgetError, allowed
from electrovib.core.errors import InputError
from electrovib.solve.meter import Meter

FIG6 = "vezzoli_2014/fig6"
LONGEST = 60.0
"""Time after which a visit fails that waits for what does not come [s]."""
LONG = {"drive": '{ model = "Square", high = 9, low = -9, frequency = 1e6 }', "time.duration": "3 s"}
"""Estimated to take longer than a quick run."""


def visit(actions):
    """Run a visit with one thread for quick and one for long work."""
    shown, complaints = [], []

    async def run():
        with ThreadPoolExecutor(1, "quick") as quick, ThreadPoolExecutor(1, "long") as patient:
            workers = Workers(quick, patient)

            def session():
                return Session(
                    {}, PageState(FIG6), workers, lambda *found: shown.append(found), complaints.append
                )

            return await asyncio.wait_for(actions(session), LONGEST)

    return asyncio.run(run()), shown, complaints


async def idle(session):
    while not session.is_idle:
        await asyncio.sleep(0.005)


def test_a_long_run_of_one_visitor_does_not_hold_up_another(monkeypatch):
    release, threads = threading.Event(), []

    def slow(scenario, *, longest):
        threads.append((threading.current_thread().name.partition("_")[0], longest))
        if scenario.time.duration == 3:
            if longest < LONGEST_RUN:
                raise BudgetError("too long")
            assert release.wait(20)
        return compute(scenario)

    monkeypatch.setattr("electrovib.apps.explorer.session.compute", slow)
    short = ev.load(FIG6).replace({"time.duration": "1 s"})
    monkeypatch.setattr(
        "electrovib.apps.explorer.session.scenario_of",
        lambda state, **_: short.replace({"time.duration": "3 s"}) if state.changes else short,
    )

    async def actions(session):
        busy, other = session(), session()
        busy.ask(PageState(FIG6, LONG))
        while len(threads) < 3:
            await asyncio.sleep(0.005)
        other.ask(PageState(FIG6))
        await asyncio.wait_for(idle(other), 20)
        assert not busy.is_idle
        release.set()
        await idle(busy)
        return busy.computed, other.computed

    (busy, other), _, _ = visit(actions)
    assert (busy.scenario.time.duration, other.scenario.time.duration) == (3, 1)
    assert threads == [
        ("quick", LONGEST_SHORT_RUN),
        ("quick", LONGEST_QUICK_RUN),
        ("long", LONGEST_RUN),
        ("quick", LONGEST_SHORT_RUN),
    ]


def test_short_runs_take_turns_and_longer_ones_hold_up_nobody(monkeypatch):
    release, running, most = threading.Event(), [], []

    def slow(scenario, *, longest):
        if scenario.time.duration == 3:
            if longest == LONGEST_SHORT_RUN:
                raise BudgetError("not short")
            assert release.wait(20)
            return compute(scenario)
        running.append(scenario)
        most.append(len(running))
        time.sleep(0.01)
        running.pop()
        return compute(scenario)

    monkeypatch.setattr("electrovib.apps.explorer.session.compute", slow)

    async def actions():
        shown = []
        with ThreadPoolExecutor(3) as quick:
            workers = Workers(quick, quick)
            visitors = [
                Session({}, PageState(FIG6), workers, lambda *found: shown.append(found), print)
                for _ in range(6)
            ]
            visitors[0].ask(PageState(FIG6, {"time.duration": "3 s"}))
            for each in visitors[1:]:
                each.ask(PageState(FIG6))
            await asyncio.wait_for(asyncio.gather(*map(idle, visitors[1:])), 20)
            assert len(shown) == 5
            assert not visitors[0].is_idle
            release.set()
            await idle(visitors[0])
        return len(shown)

    assert asyncio.run(actions()) == 6
    assert most == [1] * 5


def test_the_estimate_decides_where_a_run_goes():
    with pytest.raises(BudgetError):
        compute(ev.load(FIG6).replace(_read(LONG)), longest=LONGEST_QUICK_RUN)
    large = LONG | {"time.duration": "9 s"}
    with pytest.raises(BudgetError, match="500 MB"):
        compute(ev.load(FIG6).replace(_read(large)))


def _read(changes):
    from electrovib.apps.changes import read_changes

    return read_changes(f"{path}={value}" for path, value in changes.items())


def test_what_a_tab_computes_is_limited_as_a_run_is(monkeypatch):
    seen = []

    def slices(tab, found):
        def look(known):
            seen.append((tab, allowed().time, allowed().memory, threading.current_thread().name[:4]))
            return known

        yield look

    monkeypatch.setattr("electrovib.apps.explorer.session.slices", slices)

    async def actions(session):
        one = session()
        one.open(SAFETY)
        await idle(one)
        await one.work(lambda: seen.append((allowed().time, allowed().memory)))

    visit(actions)
    assert seen == [(SAFETY, LONGEST_RUN, LARGEST_RUN, "long"), (LONGEST_RUN, LARGEST_RUN)]


def test_time_stepping_ends_when_its_result_is_in_vain():
    is_in_vain = threading.Event()

    def steps():
        meter = Meter("steps", end=1.0)
        for _ in range(1000):
            meter.count(0.5)
            is_in_vain.set()

    with interruptible(lambda: False):
        steps()
    is_in_vain.clear()
    with pytest.raises(InterruptedWorkError), interruptible(is_in_vain.is_set):
        steps()
    with pytest.raises(InterruptedWorkError), interruptible(is_in_vain.is_set):
        pytest.fail("nothing begins in vain")


def test_a_long_run_ends_when_a_newer_state_waits_or_the_visitor_leaves(monkeypatch):
    begun, ended = [], []

    def run(scenario, *, longest):
        if longest < LONGEST_RUN:
            raise BudgetError("too long")
        begun.append(scenario)
        meter = Meter("steps", end=1.0)
        try:
            for _ in range(5000):
                meter.count(0.5)
                time.sleep(0.002)
        except InterruptedWorkError:
            ended.append(scenario)
            raise
        return pytest.fail("it was not ended")

    monkeypatch.setattr("electrovib.apps.explorer.session.compute", run)

    async def actions(session):
        one = session()
        for number in (1, 2):
            one.ask(PageState(FIG6, {"drive.high": f"{number} V"}))
            while len(begun) < number:
                await asyncio.sleep(0.002)
        one.stop()
        while len(ended) < 2:
            await asyncio.sleep(0.002)
        one.ask(PageState(FIG6))
        assert one.is_idle

    _, shown, complaints = visit(actions)
    assert (shown, complaints) == ([], [])


def test_files_are_read_one_at_a_time_and_mistakes_of_the_program_are_sentences(caplog):
    release = threading.Event()

    async def actions(session):
        one, other = session(), session()
        first = asyncio.create_task(one.read(lambda: release.wait(20)))
        await asyncio.sleep(0)
        with pytest.raises(InputError, match="Another file is still being read"):
            await one.read(lambda: 1)
        release.set()
        assert await first
        assert await other.read(lambda: 2) == 2
        with pytest.raises(InputError, match="ZeroDivisionError"):
            await one.read(lambda: 1 / 0)
        assert await one.read(lambda: 3) == 3
        one.stop()
        with pytest.raises(InputError, match="no longer wanted"):
            await one.read(lambda: 4)

    visit(actions)
    assert "could not do what was asked" in caplog.text


def test_a_visitor_who_has_left_keeps_nothing():
    async def actions(session):
        one = session()
        one.ask(PageState(FIG6))
        await idle(one)
        one.pin()
        one.measured = one.computed.trace
        one.stop()
        return one

    one, shown, _ = visit(actions)
    assert shown
    assert (one.computed, one.measured, one.pinned, one.further) == (None, None, [], Further())


def test_fits_of_all_visitors_are_limited(monkeypatch):
    release, begun = threading.Event(), []
    monkeypatch.setattr(RunningFit, "_fit", lambda self: begun.append(self) or release.wait(20))
    fits = [RunningFit(ev.load(FIG6), None, ["stack.insulator.thickness"]) for _ in range(MOST_FITS + 1)]
    with ThreadPoolExecutor(MOST_FITS) as threads:
        running = [threads.submit(each.run) for each in fits[:MOST_FITS]]
        while len(begun) < MOST_FITS:
            time.sleep(0.002)
        with pytest.raises(InputError, match="2 fits run on this server"):
            fits[-1].run()
        release.set()
        assert all(each.result() for each in running)
    assert fits[-1].run()


@pytest.mark.parametrize("why", ["cancelled", "late", "server"])
def test_a_fit_ends_in_the_middle_of_a_prediction(why, monkeypatch):
    running = RunningFit(ev.load(FIG6), None, ["stack.insulator.thickness"])
    if why == "late":
        monkeypatch.setattr(fitting, "LONGEST_FIT", 0.05)

    def fit(*_, **__):
        meter = Meter("steps", end=1.0)
        meter.count(0.1)
        if why == "cancelled":
            running.cancel()
        elif why == "late":
            time.sleep(0.1)
        else:
            monkeypatch.setattr(fitting, "SERVER_ENDS", _set())
        meter.count(0.2)
        pytest.fail("the fit went on")

    monkeypatch.setattr("electrovib.apps.fit.fit", fit)
    with pytest.raises(InputError, match="cancelled" if why == "cancelled" else "ended"):
        running.run()


def _set():
    event = threading.Event()
    event.set()
    return event


def test_stopping_the_server_ends_what_is_open(monkeypatch):
    monkeypatch.setattr(runner, "SERVER_ENDS", threading.Event())
    closed = []
    with closed_at_end(lambda: closed.append(1)):
        end_work()
    assert closed == [1]
    with closed_at_end(lambda: closed.append(2)):
        pass
    assert closed == [1, 2]
    with pytest.raises(InterruptedWorkError), interruptible(lambda: False):
        pytest.fail("nothing begins")


def test_sentences_of_a_tab_are_no_html():
    pytest.importorskip("nicegui")
    from electrovib.apps.explorer.page.plots import content

    evil = "<img src=x onerror=alert(1)>"
    words = content(SAFETY, None, Further(problems=(evil,))).above
    assert escape(evil) in words
    assert evil not in words
