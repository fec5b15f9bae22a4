"""What a visitor sees and can ask for, the queue of one, and what the others notice of it."""

import asyncio
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import pytest

import electrovib as ev
from electrovib.apps.explorer import computed, reading, runner
from electrovib.apps.explorer import session as sessions
from electrovib.apps.explorer.computed import LAWS, SAFETY, Further, compute
from electrovib.apps.explorer.reading import RunningFit
from electrovib.apps.explorer.runner import (
    LARGEST_RUN,
    LONGEST_QUICK_RUN,
    LONGEST_RUN,
    LONGEST_SHORT_RUN,
    InterruptedWorkError,
    LatestOnly,
    closed_at_end,
    end_work,
)
from electrovib.apps.explorer.session import Session
from electrovib.apps.explorer.state import PageState
from electrovib.core.budget import BudgetError, allowed
from electrovib.core.errors import InputError
from electrovib.core.tables import read_changes
from electrovib.solve.meter import Meter

FIG6 = "vezzoli_2014/fig6"
FILM = "stack.insulator.thickness"
LONGEST = 60.0
"""Time after which a visit fails that waits for what does not come [s]."""


async def until(true):
    while not true():
        await asyncio.sleep(0.003)


class Visit:
    """Visitors of a server with threads for quick and for long work, and everything that they are shown.

    The time for which no slider has moved before answers follow is short [s], where a test is not about it.
    """

    def __init__(self, actions, *, quick=1, busy=bool, rest=0.02):
        self.shown, self.complaints, self.busy = [], [], busy
        with (
            ThreadPoolExecutor(quick, "quick") as fast,
            ThreadPoolExecutor(1, "long") as patient,
            pytest.MonkeyPatch.context() as patch,
        ):
            patch.setattr(sessions, "REST", rest)
            self.workers = runner.Workers(fast, patient)
            self.found = asyncio.run(self.run(actions))

    async def run(self, actions):
        found = await asyncio.wait_for(actions(self), LONGEST)
        if isinstance(found, Session):
            await until(lambda: found.is_idle)
        return found

    def session(self):
        def show(found, further):
            self.shown.append((found, further))

        return Session({}, PageState(FIG6), self.workers, show, self.complaints.append, self.busy)


def at(volts):
    return PageState(FIG6, {"drive.high": f"{volts} V"})


def high(found):
    return found.scenario.drive.high


@pytest.mark.parametrize("fails", [False, True])
def test_what_waits_for_work_ends_with_its_visitor(fails):
    begun, left = threading.Event(), threading.Event()

    def report():
        begun.set()
        assert left.wait(LONGEST)
        if fails:
            raise InputError("no report")

    async def actions(visit):
        session, told = visit.session(), []

        async def download():
            await session.work(report)
            told.append("downloaded")

        task = asyncio.create_task(download())
        await until(begun.is_set)
        session.stop()
        left.set()
        await asyncio.wait([task])
        return task.cancelled(), told

    assert Visit(actions).found == (True, [])


def test_what_is_shown_is_what_the_library_gives_to_each_visitor_and_a_mistake_is_a_sentence():
    async def actions(visit):
        one, other = visit.session(), visit.session()
        for each, volts in ((one, 100), (other, 200)):
            each.ask(at(volts))
        await until(lambda: one.is_idle and other.is_idle)
        one.keep()
        assert other.kept is None
        assert (high(one.computed), high(other.computed)) == (100, 200)
        one.ask(at("five"))
        await until(lambda: one.is_idle)
        one.ask(at(500))
        return one

    visit = Visit(actions)
    assert "drive.high = 'five V'" in " ".join(visit.complaints)
    assert visit.complaints[-1] == ""
    expected = ev.simulate(ev.load(FIG6).replace({"drive.high": "500 V"}))
    assert visit.shown[-1][0].trace.electrostatic_force.equals(expected.electrostatic_force)
    assert visit.found.computed is visit.shown[-1][0]


def test_the_latest_value_wins_and_no_queue_grows():
    async def actions(visit):
        one = visit.session()
        for volts in range(100, 400):
            one.ask(at(volts))
            if volts % 50 == 0:
                await asyncio.sleep(0.02)
        return one

    visit = Visit(actions)
    assert high(visit.shown[-1][0]) == 399
    assert len(visit.shown) < 60


def test_another_tab_of_the_same_scenario_is_not_simulated_again_and_forgets_what_the_former_computed():
    async def actions(visit):
        one = visit.session()
        one.ask(replace(one.state, tab=LAWS))
        await until(lambda: one.is_idle)
        found = one.computed
        assert one.further.laws
        one.ask(replace(one.state, tab=SAFETY))
        await until(lambda: one.is_idle)
        assert one.computed is found
        assert one.shown == one.state
        assert one.further.check is not None
        assert one.further.laws == {}

    Visit(actions)


def test_a_mistake_of_the_program_is_reported_and_the_page_goes_on(monkeypatch, caplog):
    real, calls = computed.Expanded, []

    def broken(scenario):
        calls.append(scenario)
        return 1 / 0 if len(calls) == 1 else real(scenario)

    monkeypatch.setattr(computed, "Expanded", broken)

    async def actions(visit):
        one = visit.session()
        one.ask(one.state)
        await until(lambda: one.is_idle)
        one.ask(at(5))
        return one

    visit = Visit(actions)
    assert "ZeroDivisionError: division by zero" in visit.complaints[0]
    assert high(visit.shown[-1][0]) == 5
    assert "could not compute" in caplog.text


def test_slices_of_long_work_end_when_something_newer_waits(monkeypatch):
    begun = []

    def slices(tab, found):
        def slow(known):
            time.sleep(0.01)
            begun.append(high(found))
            return known

        return [slow] * 40

    monkeypatch.setattr(sessions, "slices", slices)

    async def actions(visit):
        one = visit.session()
        one.ask(replace(one.state, tab=LAWS))
        await until(lambda: begun)
        one.ask(at(5))
        return one

    assert high(Visit(actions).shown[-1][0]) == 5
    assert begun.count(1000) < 20
    assert begun.count(5) == 40


@pytest.mark.parametrize("case", ["done", "fails", "a moment"])
def test_a_visitor_is_told_of_work_that_takes_long_until_it_has_ended_or_failed(case, monkeypatch):
    told, release = [], threading.Event()

    def held(known):
        assert release.wait(LONGEST)
        return 1 / 0 if case == "fails" else known

    monkeypatch.setattr(sessions, "slices", lambda *_: [held])
    monkeypatch.setattr(runner, "NOTICED", LONGEST if case == "a moment" else 0.02)

    async def actions(visit):
        one = visit.session()
        one.ask(one.state)
        assert told == []
        await until(lambda: told or case == "a moment")
        one.ask(at(5))  # which follows without a pause
        release.set()
        return one

    assert high(Visit(actions, busy=told.append).shown[-1][0]) == 5
    assert told == ([] if case == "a moment" else [True, False])


def test_what_is_shown_is_kept_with_what_becomes_known_of_it_and_who_has_left_keeps_nothing():
    async def actions(visit):
        one = visit.session()
        one.keep()
        assert one.kept is None  # nothing is shown yet
        one.ask(at(5))
        await until(lambda: one.computed is not None)
        one.keep()
        one.state = at(6)  # which is not shown
        one.keep()
        assert (high(one.kept.computed), one.kept.name) == (5, f"{FIG6}, drive.high = 5 V")
        await until(lambda: one.is_idle)
        assert one.kept.further.check is not None
        known = one.kept
        one.ask(at(5).changed(FILM, "50 um"))
        await until(lambda: one.is_idle)
        assert one.earlier is known  # a change beside it is behind nothing
        one.measured = one.computed.trace
        one.stop()
        return one

    one = Visit(actions).found
    assert (one.computed, one.measured, one.kept, one.further) == (None, None, None, Further())


def test_only_one_task_runs_at_a_time_and_what_waits_ends_when_its_visitor_leaves():
    running, most, done = [], [], []

    async def run():
        async def task(value):
            running.append(value)
            most.append(len(running))
            await asyncio.sleep(0.002)
            running.remove(value)
            done.append(value)

        latest = LatestOnly(task, pytest.fail)
        for value in range(50):
            latest.ask(value)
            await asyncio.sleep(0.001)
        for value in ("begun", "waits"):
            latest.ask(value)
        assert latest.is_stale
        latest.stop()
        await asyncio.sleep(0.02)
        return latest

    assert asyncio.run(run()).is_idle
    assert max(most) == 1
    assert len(most) < 50
    assert "waits" not in done


def test_runs_that_take_longer_hold_up_nobody(monkeypatch):
    release, asked = threading.Event(), []

    def slow(scenario, *, longest):
        asked.append((threading.current_thread().name.partition("_")[0], longest))
        if scenario.time.duration == 3:
            if longest < LONGEST_RUN:
                raise BudgetError("too long")
            assert release.wait(20)
            return compute(scenario)
        return compute(scenario)

    monkeypatch.setattr(sessions, "compute", slow)

    async def actions(visit):
        first, *others = (visit.session() for _ in range(6))
        first.ask(PageState(FIG6, {"time.duration": "3 s"}))
        await until(lambda: len(asked) == 2)
        for each in others:
            each.ask(PageState(FIG6))
        await asyncio.wait_for(until(lambda: all(each.is_idle for each in others)), 20)
        assert len(visit.shown) == 5
        assert not first.is_idle
        release.set()
        return first

    visit = Visit(actions, quick=3)
    assert visit.found.computed.scenario.time.duration == 3
    assert visit.complaints.count("") == len(visit.complaints)
    quick = ("quick", LONGEST_SHORT_RUN)
    assert asked == [quick, ("long", LONGEST_RUN), *[quick] * 5]


def test_the_estimate_decides_where_a_run_goes():
    square = 'drive={ model = "Square", high = 9, low = -9, frequency = 1e6 }'
    for seconds, limit, words in ((3, {"longest": LONGEST_QUICK_RUN}, "would take"), (9, {}, "500 MB")):
        scenario = ev.load(FIG6).replace(read_changes([square, f"time.duration={seconds} s"]))
        with pytest.raises(BudgetError, match=words):
            compute(scenario, **limit)


def test_what_a_tab_computes_is_limited_as_a_run_is(monkeypatch):
    seen = []

    def slices(tab, found):
        def look(known):
            seen.append((tab, allowed().time, allowed().memory, threading.current_thread().name[:4]))
            return known

        yield look

    monkeypatch.setattr(sessions, "slices", slices)

    async def actions(visit):
        one = visit.session()
        one.ask(replace(one.state, tab=SAFETY))
        await until(lambda: one.is_idle)
        await one.work(lambda: seen.append((allowed().time, allowed().memory)))

    Visit(actions)
    assert seen == [(SAFETY, LONGEST_RUN, LARGEST_RUN, "long"), (LONGEST_RUN, LARGEST_RUN)]


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

    monkeypatch.setattr(sessions, "compute", run)

    async def actions(visit):
        one = visit.session()
        for number in (1, 2):
            one.ask(at(number))
            await until(lambda number=number: len(begun) == number)
        one.stop()
        await until(lambda: len(ended) == 2)
        one.ask(PageState(FIG6))
        assert one.is_idle

    visit = Visit(actions)
    assert (visit.shown, visit.complaints) == ([], [])


def test_files_are_read_one_at_a_time_and_mistakes_of_the_program_are_sentences(caplog):
    release = threading.Event()

    async def actions(visit):
        one, other = visit.session(), visit.session()
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
        with pytest.raises(asyncio.CancelledError):  # its page is no more
            await one.read(lambda: 4)

    Visit(actions, quick=2)
    assert "could not do what was asked" in caplog.text


@pytest.mark.parametrize("why", ["cancelled", "late", "server"])
def test_a_fit_ends_in_the_middle_of_a_prediction(why, monkeypatch):
    running, ended = RunningFit(ev.load(FIG6), None, [FILM]), threading.Event()
    ended.set()
    if why == "late":
        monkeypatch.setattr(reading, "LONGEST_FIT", 0.05)

    def fit(*_, **__):
        meter = Meter("steps", end=1.0)
        meter.count(0.1)
        if why == "cancelled":
            running.cancel()
        elif why == "late":
            time.sleep(0.1)
        else:
            monkeypatch.setattr(reading, "SERVER_ENDS", ended)
        meter.count(0.2)
        pytest.fail("the fit went on")

    monkeypatch.setattr("electrovib.apps.fit.fit", fit)
    with pytest.raises(InputError, match="cancelled" if why == "cancelled" else "ended"):
        running.run()


def test_work_ends_when_its_result_is_in_vain_or_the_server_stops(monkeypatch):
    is_in_vain, closed = threading.Event(), []

    def steps():
        meter = Meter("steps", end=1.0)
        for _ in range(1000):
            meter.count(0.5)
            is_in_vain.set()

    with runner.interruptible(lambda: False):
        steps()
    is_in_vain.clear()
    with pytest.raises(InterruptedWorkError), runner.interruptible(is_in_vain.is_set):
        steps()
    monkeypatch.setattr(runner, "SERVER_ENDS", threading.Event())
    with closed_at_end(lambda: closed.append(1)):
        end_work()
    assert closed == [1]
    with closed_at_end(lambda: closed.append(2)):
        pass
    assert closed == [1, 2]
    for each in (is_in_vain.is_set, lambda: False):
        with pytest.raises(InterruptedWorkError), runner.interruptible(each):
            pytest.fail("nothing begins in vain")


def test_what_waits_for_a_thread_when_the_server_ends_is_cancelled_without_a_word(monkeypatch):
    """A computation in several pieces asked for the next one after its threads had ended, and a traceback was printed."""
    monkeypatch.setattr(runner, "SERVER_ENDS", threading.Event())
    failed = []

    async def pieces():
        with ThreadPoolExecutor(1) as executor:

            async def task(_):
                assert await runner.apart(executor, lambda: 1) == 1
                end_work()
                executor.shutdown()
                await runner.apart(executor, lambda: 2)

            latest = runner.LatestOnly(task, failed.append)
            latest.ask(0)
            while not latest.is_idle:
                await asyncio.sleep(0.01)

    asyncio.run(pieces())
    assert failed == []
