"""The queue of one, and what a visitor sees."""

from __future__ import annotations

import asyncio
import threading
import time
from concurrent.futures import ThreadPoolExecutor

import pytest

import electrovib as ev
from electrovib.apps.explorer import computed
from electrovib.apps.explorer.further import LAWS
from electrovib.apps.explorer.limits import MOST_PINNED
from electrovib.apps.explorer.runner import LatestOnly, Workers
from electrovib.apps.explorer.session import Session
from electrovib.apps.explorer.state import PageState

FIG6 = "vezzoli_2014/fig6"
LONGEST = 60.0
"""Time after which a visit fails that waits for what does not come [s]."""


def visit(actions, *, own=None, state=None, busy=bool):
    """Run a visit, and return the session with everything that was shown and complained of."""
    shown, complaints = [], []

    async def run():
        with ThreadPoolExecutor(2) as executor:
            session = Session(
                own or {},
                state or PageState(FIG6),
                Workers(executor, executor),
                lambda found, further: shown.append((found, further)),
                complaints.append,
                busy,
            )
            await asyncio.wait_for(actions(session), LONGEST)
            while not session.is_idle:
                await asyncio.sleep(0.005)
            return session

    return asyncio.run(run()), shown, complaints


def test_what_is_shown_is_what_the_library_gives():
    async def actions(session):
        session.ask(session.state.changed("drive.high", "500 V"))

    session, shown, complaints = visit(actions)
    assert complaints == []
    expected = ev.simulate(ev.load(FIG6).replace({"drive.high": "500 V"}))
    assert shown[-1][0].trace.electrostatic_force.equals(expected.electrostatic_force)
    assert session.computed is shown[-1][0]


def test_the_latest_value_wins_and_no_queue_grows():
    async def actions(session):
        for volts in range(100, 400):
            session.ask(session.state.changed("drive.high", f"{volts} V"))
            if volts % 50 == 0:
                await asyncio.sleep(0.02)

    _, shown, _ = visit(actions)
    assert shown[-1][0].scenario.drive.high == 399
    assert len(shown) < 60


def test_a_mistake_is_a_sentence_and_the_page_goes_on():
    async def actions(session):
        session.ask(session.state.changed("drive.high", "five"))
        while not session.is_idle:
            await asyncio.sleep(0.005)
        session.ask(session.state.changed("drive.high", "5 V"))

    _, shown, complaints = visit(actions)
    assert "drive.high = 'five'" in complaints[0]
    assert complaints[-1] == ""
    assert shown[-1][0].scenario.drive.high == 5


def test_a_mistake_of_the_program_is_reported_and_the_page_goes_on(monkeypatch, caplog):
    real = computed.Expanded
    calls = []

    def broken(scenario):
        calls.append(scenario)
        if len(calls) == 1:
            raise ZeroDivisionError("of ours")
        return real(scenario)

    monkeypatch.setattr(computed, "Expanded", broken)

    async def actions(session):
        session.ask(session.state)
        while not session.is_idle:
            await asyncio.sleep(0.005)
        session.ask(session.state.changed("drive.high", "5 V"))

    _, shown, complaints = visit(actions)
    assert "ZeroDivisionError: of ours" in complaints[0]
    assert shown[-1][0].scenario.drive.high == 5
    assert "could not compute" in caplog.text


def test_slices_of_long_work_end_when_something_newer_waits():
    async def actions(session):
        session.open(LAWS)
        await asyncio.sleep(0.1)
        for volts in (300, 200, 100):
            session.ask(session.state.changed("drive.high", f"{volts} V"))
            await asyncio.sleep(0.03)

    session, shown, _ = visit(actions)
    assert shown[-1][0].scenario.drive.high == 100
    assert len(session.further.laws) >= 3
    assert all(case.scenario.drive.high == 100 for case in session.further.laws.values())


def test_no_further_slice_begins_when_something_newer_waits(monkeypatch):
    begun = []

    def slices(tab, found):
        for number in range(40):

            def slow(known, number=number):
                time.sleep(0.01)
                begun.append((found.scenario.drive.high, number))
                return known

            yield slow

    monkeypatch.setattr("electrovib.apps.explorer.session.slices", slices)

    async def actions(session):
        session.ask(session.state)
        while not begun:
            await asyncio.sleep(0.005)
        session.ask(session.state.changed("drive.high", "5 V"))

    visit(actions)
    assert len([volts for volts, _ in begun if volts == 1000]) < 20
    assert len([volts for volts, _ in begun if volts == 5]) == 40


@pytest.mark.parametrize("fails", [False, True])
def test_a_visitor_is_told_of_work_that_takes_long_until_it_has_ended_or_failed(fails, monkeypatch):
    told, release = [], threading.Event()

    def held(known):
        assert release.wait(LONGEST)
        if fails:
            raise ZeroDivisionError
        return known

    monkeypatch.setattr("electrovib.apps.explorer.session.slices", lambda *_: [held])
    monkeypatch.setattr("electrovib.apps.explorer.runner.NOTICED", 0.02)

    async def actions(session):
        session.ask(session.state)
        assert told == []
        while not told:
            await asyncio.sleep(0.005)
        session.ask(session.state.changed("drive.high", "5 V"))  # which follows without a pause
        release.set()

    _, shown, _ = visit(actions, busy=told.append)
    assert shown[-1][0].scenario.drive.high == 5
    assert told == [True, False]


def test_a_visitor_is_not_told_of_work_that_is_done_in_a_moment(monkeypatch):
    monkeypatch.setattr("electrovib.apps.explorer.runner.NOTICED", LONGEST)
    told = []

    async def actions(session):
        session.ask(session.state)

    visit(actions, busy=told.append)
    assert told == []


def test_curves_are_kept_and_the_oldest_is_dropped():
    async def actions(session):
        for volts in range(MOST_PINNED + 2):
            session.ask(session.state.changed("drive.high", f"{volts + 1} V"))
            while not session.is_idle:
                await asyncio.sleep(0.005)
            session.pin()

    session, _, _ = visit(actions)
    assert [each.computed.scenario.drive.high for each in session.pinned] == [3, 4, 5, 6]
    assert session.pinned[-1].name == f"{FIG6}: drive.high = 6 V"
    session.unpin()
    assert session.pinned == []


def test_two_visitors_share_nothing():
    async def run():
        with ThreadPoolExecutor(2) as executor:
            seen = {name: [] for name in "ab"}
            sessions = [
                Session(
                    {},
                    PageState(FIG6),
                    Workers(executor, executor),
                    lambda found, _, name=name: seen[name].append(found),
                    print,
                )
                for name in "ab"
            ]
            for session, volts in zip(sessions, ("100 V", "200 V"), strict=True):
                session.ask(session.state.changed("drive.high", volts))
            while not all(session.is_idle for session in sessions):
                await asyncio.sleep(0.005)
            sessions[0].pin()
            return seen, sessions

    seen, sessions = asyncio.run(run())
    assert [seen[name][-1].scenario.drive.high for name in "ab"] == [100, 200]
    assert sessions[1].pinned == []


def test_a_visitor_who_leaves_ends_what_waits():
    started, release = threading.Event(), threading.Event()

    async def run():
        done = []

        async def task(value):
            started.set()
            while not release.is_set():
                await asyncio.sleep(0.001)
            done.append(value)

        latest = LatestOnly(task, done.append)
        latest.ask(1)
        await asyncio.sleep(0.01)
        latest.ask(2)
        assert latest.is_stale
        latest.stop()
        release.set()
        await asyncio.sleep(0.02)
        return done, latest

    done, latest = asyncio.run(run())
    assert started.is_set()
    assert done == []
    assert latest.is_idle


def test_only_one_task_runs_at_a_time():
    running, most = [], []

    async def run():
        async def task(value):
            running.append(value)
            most.append(len(running))
            await asyncio.sleep(0.002)
            running.remove(value)

        latest = LatestOnly(task, pytest.fail)
        for value in range(50):
            latest.ask(value)
            await asyncio.sleep(0.001)
        while not latest.is_idle:
            await asyncio.sleep(0.005)

    asyncio.run(run())
    assert max(most) == 1
    assert len(most) < 50
