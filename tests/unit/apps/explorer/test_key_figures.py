"""The line of key figures holds what the library states, and the curves before a change stay until the next one."""

import asyncio
import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from tests.unit.apps.explorer.test_session import FIG6, FILM, LONGEST, Visit, at, high, until

import electrovib as ev
from electrovib.apps.explorer import session as sessions
from electrovib.apps.explorer.computed import SAFETY, TIME, Further, compute, with_answers
from electrovib.apps.explorer.key_figures import (
    FELT,
    FORCES,
    LIMIT,
    VALIDITY,
    KeyFigure,
    _level,
    answers,
    felt,
    forces,
    limit,
    validity,
)
from electrovib.apps.explorer.page.plots import content
from electrovib.apps.explorer.pictures import over_frequency, over_time
from electrovib.apps.explorer.session import Earlier
from electrovib.apps.explorer.state import PageState, presets
from electrovib.core.diagnostics import Diagnostic
from electrovib.core.units import parse_quantity
from electrovib.studies.check.result import FAIL, CheckRow
from electrovib.studies.widths import TOGETHER

SINE = "bau_2010/sine"


def known(found):
    return {**found.figures, **answers(with_answers(Further(), found))}


@pytest.mark.parametrize("name", presets()[::6])
def test_forces_are_those_of_a_densely_sampled_run_or_of_the_output_times_where_it_says_so(name):
    scenario = ev.load(name)
    run, trace = compute(scenario), ev.simulate(scenario)
    found = with_answers(Further(), run).forces
    assert list(found) == list(FORCES.values())
    end = float(trace.time[-1])
    dense = trace
    if not any(each.note for each in found.values()):
        dense = ev.simulate(scenario, time=np.union1d(trace.time, np.linspace(0, end, 20_001)))
    for quantity, words in FORCES.items():
        how, signal = quantity.split()
        if signal not in trace or not np.isfinite(trace[signal]).any():
            assert found[words].value == "–"
            continue
        kept = dense[signal].dropna("time")
        expected = (
            np.abs(kept).max() if how == "peak" else kept.integrate("time") / (kept.time[-1] - kept.time[0])
        )
        # of three digits
        assert parse_quantity(found[words].value, "N") == pytest.approx(float(expected), rel=6e-3)
        if how == "peak":
            largest = float(np.abs(trace[signal]).max())
            assert parse_quantity(run.figures[words].value, "N") == pytest.approx(largest, rel=6e-3)


@pytest.mark.parametrize(
    ("times", "values", "mean"), [([0.0, 1.0, 3.0], [0.0, 1.0, 1.0], "833 mN"), ([2.0], [0.5], "500 mN")]
)
def test_a_mean_at_uneven_output_times_is_that_over_time(times, values, mean):
    rows = {"time": times, "electrostatic_force": values}
    found = forces(SimpleNamespace(has=rows.__contains__, values=rows.get))
    assert found["Mean attraction"].value == mean


def test_forces_between_the_output_times_replace_those_at_them():
    coarse = compute(ev.load(SINE).replace({"time.samples": 4}))
    quick, exact = coarse.figures, answers(with_answers(Further(), coarse))
    assert parse_quantity(quick["Peak attraction"].value, "N") < 0.36
    assert exact["Peak attraction"] == KeyFigure("387 mN")
    assert {**quick, **exact}["Peak attraction"].value == "387 mN"


def test_what_is_felt_and_the_nearest_limit_are_those_of_perceive_and_check():
    found = known(compute(ev.load(SINE)))
    percept, checked = ev.perceive(SINE), ev.check(SINE)
    low, middle, high_ = (percept.sensation + each * percept.uncertainty for each in (-1, 0, 1))
    assert found[FELT].value == f"yes, +{middle:.0f} dB"
    least, most = next(each.interval for each in percept.widths if each.name == TOGETHER)
    assert found[FELT].note == (
        f"+{low:.0f} to +{high_:.0f} dB relative to published thresholds;"
        f" +{least:.0f} to +{most:.0f} dB with the spread of the force law"
    )
    nearest = max(
        (row for row in checked.rows if row.limit and row.value), key=lambda row: row.value / row.limit
    )
    assert found[LIMIT].value == f"{100 * nearest.value / nearest.limit:.2g} % reached"
    assert found[LIMIT].note.startswith(f"{nearest.quantity}: ")
    assert found[LIMIT].note.endswith(", of uncertain standing; not shown to be safe")
    assert found[LIMIT].state == "unknown"


def test_a_limit_that_is_exceeded_is_a_warning_and_nothing_is_made_up_where_nothing_is_known():
    row = CheckRow(quantity="peak current", value=2.0, limit=1.0, unit="A", source="", state=FAIL, text="")
    assert limit(row, FAIL) == KeyFigure("exceeded", "peak current: 2 A of 1 A", FAIL)
    held = replace(row, value=0.5, state="pass")
    assert limit(held, "pass") == KeyFigure(
        "50 % reached", "peak current: 500 mA of 1 A; within all limits", "pass"
    )
    assert limit(None, "unknown").value == "none"
    still = ev.load(FIG6).replace({"drive": {"model": "Step", "level": 0}})
    assert felt(ev.perceive(still)).value == "no"
    weak = ev.load(SINE).replace({"drive.amplitude": "10 mV"})
    assert re.fullmatch(r"no, \N{MINUS SIGN}\d+ dB", known(compute(weak))[FELT].value)
    rests = known(compute(ev.load("shultz_2018/at_rest")))
    assert rests[FORCES["peak lateral_force"]] == KeyFigure("–", "the finger rests")
    assert rests[FELT].value == "–"
    assert "motion.speed" in rests[FELT].note


def test_answers_that_take_longer_are_left_to_their_tab(monkeypatch):
    found = compute(ev.load(FIG6))
    monkeypatch.setattr("electrovib.apps.explorer.computed.LONGEST_SHORT_RUN", 1e-9)
    told = answers(with_answers(Further(), found))
    assert told[FELT] == KeyFigure("–", "takes longer: open the tab 'Felt'")
    assert told[LIMIT] == KeyFigure("–", "takes longer: open the tab 'Safety'")
    checked = Further(check=ev.check(FIG6))
    assert with_answers(checked, found).check is checked.check
    assert list(with_answers(checked, found).unanswered) == [FELT]


def test_the_answers_follow_once_no_slider_has_moved_for_a_moment():
    async def actions(visit):
        one, told = visit.session(), []
        one.tell = lambda: told.append(one.further)
        for volts in (100, 200, 300):
            one.ask(at(volts))
            await asyncio.sleep(sessions.REST / 4)
        await until(lambda: one.is_idle)
        assert len(told) == 1
        assert told[0].check.scenario.drive.high == 300
        one.ask(replace(one.state, tab=SAFETY))
        await until(lambda: one.is_idle)
        assert told[1].check is one.further.check
        return one

    Visit(actions, rest=sessions.REST)


def test_no_answer_is_computed_while_a_slider_moves_however_quick_it_would_be(monkeypatch):
    monkeypatch.setattr(sessions, "with_answers", lambda further, **_: further)

    async def actions(visit):
        one, told = visit.session(), []
        one.tell = lambda: told.append(one.further)
        for volts in (100, 200):
            one.ask(at(volts))
            await until(lambda: one.computed is not None and high(one.computed) == volts)  # noqa: B023 - at once
            await asyncio.sleep(0.1)
        one.stop()
        return told

    assert Visit(actions, rest=LONGEST).found == []


def test_the_result_before_a_change_stays_until_the_next_change(monkeypatch):
    async def actions(visit):
        one, moment = visit.session(), [100.0]
        monkeypatch.setattr(sessions, "monotonic", lambda: moment[0])

        async def ask(state, pause=0.0):
            moment[0] += pause
            one.ask(state)
            await until(lambda: one.is_idle)
            return None if one.earlier is None else high(one.earlier.computed)

        assert await ask(PageState(FIG6)) is None
        assert await ask(at(100)) == 1000
        assert await ask(at(200), pause=0.9 * sessions.GESTURE) == 1000  # of the same movement
        assert await ask(at(300), pause=1.1 * sessions.GESTURE) == 200
        assert await ask(at(300), pause=9 * sessions.GESTURE) == 200  # another tab, for instance
        assert await ask(at(300).changed(FILM, "50 um")) == 300
        assert one.earlier.computed.scenario.stack.layers["insulator"].thickness == pytest.approx(90e-6)
        assert await ask(PageState(SINE)) is None
        await ask(PageState(SINE, {"drive.amplitude": "50 V"}))
        assert one.earlier is not None
        one.stop()
        assert one.earlier is None

    Visit(actions)


def test_validity_counts_what_is_open_and_names_the_worst():
    states = ("ok", "unknown", "warning", "warning")
    found = [Diagnostic(f"{state}_{place}", state, "...") for place, state in enumerate(states)]
    assert validity(found) == KeyFigure("2 warning, 1 unknown", "warning 2, warning 3", "warning")
    assert validity(found[:2]) == KeyFigure("1 unknown", "unknown 1", "unknown")
    assert validity(found[:1]) == validity([]) == KeyFigure("ok", "", "ok")
    run = compute(ev.load(FIG6))
    assert run.figures[VALIDITY] == validity(run.diagnostics)


def test_a_level_that_rounds_to_nothing_has_no_sign():
    assert {_level(each) for each in (-0.4, 0.0, 0.4)} == {"0"}
    assert [_level(each) for each in (-12.0, 3.0)] == ["\N{MINUS SIGN}12", "+3"]


def test_former_curves_are_faint_behind_the_others_and_on_the_same_scale():
    shown, former = (
        compute(ev.load("vezzoli_2014/fig6_gap").replace({"drive.high": each})) for each in (500, 1000)
    )
    plots = [
        *over_time(shown, Earlier(former, PageState(FIG6))),
        *over_frequency(shown, Earlier(former, PageState(FIG6))),
    ]
    for plot in plots:
        now = [each for each in plot["data"] if "opacity" not in each]
        before = [each for each in plot["data"] if "opacity" in each]
        assert len(now) == len(before) > 0, plot["layout"]["title"]
        assert plot["data"][: len(now)] == now
        for one, other in zip(now, before, strict=True):
            assert other["line"]["color"] == one["line"]["color"]
            assert (other["opacity"], other["zorder"], other["hoverinfo"], other["showlegend"]) == (
                0.45,
                -1,
                "skip",
                False,
            )
    force = next(each for each in plots if each["layout"]["title"]["text"] == "Electrostatic force")["data"]
    assert max(force[1]["y"]) == pytest.approx(4 * max(force[0]["y"]), rel=1e-3)
    relative = next(each for each in plots if "over its largest" in each["layout"]["title"]["text"])["data"]
    assert max(relative[0]["y"]) == pytest.approx(1, rel=1e-3)
    assert max(relative[3]["y"]) == pytest.approx(2, rel=1e-3)
    figures = content(TIME, shown, Further(), earlier=Earlier(former, PageState(FIG6))).figures
    assert any("opacity" in line for line in figures[0]["data"])
