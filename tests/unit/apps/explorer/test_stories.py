"""The stories of the page: every number and statement of a sentence is that of the state beside it."""

import functools
import re
from dataclasses import replace

import numpy as np
import pytest

from electrovib.apps.explorer.computed import FADING, FREQUENCY, LAWS, Further, compute, slices
from electrovib.apps.explorer.controls import controls
from electrovib.apps.explorer.page.plots import content
from electrovib.apps.explorer.runner import FINGERS, LONGEST_SHORT_RUN
from electrovib.apps.explorer.state import STEPS, STORIES, PageState, read_query, scenario_of
from electrovib.core.constants import eps0
from electrovib.core.errors import InputError
from electrovib.studies.check import check
from electrovib.studies.perceive import perceive

UNITS = {
    "V": 1, "N": 1, "mN": 1e-3, "g": 1e-3 * 9.80665, "ms": 1e-3, "Hz": 1, "µm": 1e-6, "mA": 1e-3, "µA": 1e-6,
    "kΩ": 1e3, "dB": 1, "%": 1e-2,
}  # fmt: skip
"""Size of each unit of the sentences [SI]; a mass counts as its weight."""
NUMBER = re.compile(rf"(?<![\w.])(\d+(?:\.\d+)?)(?: ({'|'.join(UNITS)})\b| (%))?")


@functools.cache
def computed(name, **changes):
    """The result of a step, with other values of some of its parameters."""
    scenario = scenario_of(PageState.of_step(STEPS[name]), own={})
    return compute(scenario.replace({path.replace("__", "."): value for path, value in changes.items()}))


@functools.cache
def further(name):
    """What the tab of a step needs beside the run."""
    known, found = Further(), computed(name)
    for each in slices(STEPS[name].tab, found):
        known = each(known)
    return known


@pytest.mark.parametrize("step", STEPS.values(), ids=lambda step: step.name)
def test_a_step_asks_for_a_parameter_that_has_a_slider(step):
    offered = {each.path: each for each in controls(scenario_of(PageState.of_step(step), own={}))}
    assert offered[step.asks].value is not None
    assert step.asks in step.changes or not offered.keys() & step.changes.keys()


def top(found, signal="electrostatic_force"):
    return float(found.values(signal).max())


def at(found, time, signal="electrostatic_force"):
    return float(np.interp(time, found.values("time"), found.values(signal)))


def under_sine(found, frequency):
    return float(np.interp(np.log(frequency), np.log(found.values("frequency")), found.values("mean_force")))


def student_1():
    found = computed("student.1")
    return [top(found, "drive_voltage"), top(found), top(found)]


def student_2():
    found = computed("student.2")
    drive = found.scenario.drive
    left, tight = at(found, drive.rise + 0.02), {"stack__gap__material__conductivity": 0}
    assert at(found, drive.rise + drive.hold) < 1e-3 * top(found)
    assert at(found, drive.rise + drive.hold + drive.fall) > 0.99 * top(found)  # attracts again
    assert at(computed("student.2", **tight), drive.rise + drive.hold) > 0.9 * top(
        computed("student.2", **tight)
    )
    return [top(found, "drive_voltage"), drive.hold, 0.02, left / top(found)]


def peaks_per_second(found):
    force = found.values("electrostatic_force")
    inner = (force[1:-1] >= force[:-2]) & (force[1:-1] > force[2:]) & (force[1:-1] > 0.9 * force.max())
    return int(inner.sum()) / float(np.ptp(found.values("time")))


def student_3():
    found = computed("student.3")
    force, friction = found.values("electrostatic_force"), found.values("lateral_force")
    assert np.corrcoef(force, friction)[0, 1] > 0.999
    assert at(found, 0.002) == pytest.approx(at(found, 0.006), rel=0.01)  # at the peak of either sign
    assert at(found, 0.002, "drive_voltage") == pytest.approx(-at(found, 0.006, "drive_voltage"))
    return [found.scenario.drive.frequency, peaks_per_second(found)]


def student_4():
    found, before = computed("student.4"), computed("student.3")
    volts, first = top(found, "drive_voltage"), top(before, "drive_voltage")
    assert volts / first == pytest.approx(2)  # twice
    assert top(found) / top(before) == pytest.approx(4, rel=1e-3)  # four times
    return [top(found), volts, first, top(before)]


def student_5():
    percept = further("student.5").percept
    lines = percept.spectrum
    assert percept.headline.startswith("felt,")
    assert lines.signal == "lateral_force"
    return [lines.frequency[np.argmax(lines.amplitude * (lines.frequency > 1))], percept.sensation]


def engineer_1():
    found = computed("engineer.1")
    film, friction = found.scenario.stack.layers["insulator"], found.values("lateral_force")
    assert film.material.substance == "silica"
    volts = top(found, "drive_voltage")
    return [film.thickness, volts, top(found), friction.min(), friction.max()]


def engineer_2():
    thin, thick = computed("engineer.1"), computed("engineer.2")
    hafnia = computed("engineer.2", stack__insulator__material="hafnia")
    ends = [each.scenario.stack.layers["insulator"].thickness for each in (thick, thin)]
    assert hafnia.scenario.stack.layers["insulator"].thickness == ends[0]
    assert thick.scenario.stack.layers["insulator"].material.substance == "silica"
    volts = np.abs(thick.values("field", layer="insulator")).max() * ends[0]
    left = [top(each) / top(thin) for each in (thick, hafnia)]
    return [*ends, left[0], volts, top(thick, "drive_voltage"), left[1]]


def engineer_3():
    found, band = computed("engineer.3"), further("engineer.3").band
    frequency = found.scenario.drive.frequency
    ends = [np.interp(np.log(frequency), np.log(band["frequency"]), band[each]) for each in ("low", "high")]
    return [FINGERS, frequency, *ends]  # from 5 to 95 %: nine in ten


def engineer_4():
    found, percept = computed("engineer.4"), further("engineer.4").percept
    low, high = ends(percept)
    lower = perceive(computed("engineer.4", drive__amplitude=5).scenario)
    assert percept.headline.startswith("felt,")
    assert lower.headline.startswith("felt or not: undecided")
    assert ends(lower)[0] < 0 < ends(lower)[1]
    return [top(found, "drive_voltage"), percept.sensation, low, high, 5, 0]


def ends(percept):
    """The spread of the sensation level, as the answer prints it [dB]."""
    return [float(each) for each in re.search(r"\((\S+) to (\S+) dB\)", percept.headline).groups()]


def engineer_5():
    found, rows = computed("engineer.5"), further("engineer.5").check.rows
    scenario = found.scenario
    current = next(row for row in rows if row.quantity == "peak current")
    slower = check(scenario.replace({"circuit.source_resistance": 1e6})).rows
    assert current.state == "fail"
    assert next(row for row in slower if row.quantity == "peak current").state == "pass"
    assert scenario.circuit.source_resistance == 0
    body = scenario.circuit.return_path.resistance
    limit = scenario.limits.current
    return [top(found, "drive_voltage"), current.value, current.value / limit, limit, body]


def researcher_1():
    found, others = computed("researcher.1"), further("researcher.1").laws
    cases = [found, *others.values()]
    low, *_, high = sorted(cases, key=top)
    surfaces = [each.scenario.force.evaluation_surface for each in (low, high)]
    assert len(cases) == 5
    assert surfaces[0] != surfaces[1]
    assert len({each.scenario.force.evaluation_surface for each in cases}) >= 3
    return [top(low), top(high)]


def researcher_2():
    found = computed("researcher.2")
    drive, gap = found.scenario.drive, found.scenario.stack.layers["gap"].material
    times, force = found.values("time"), found.values("electrostatic_force")
    falls = (times >= times[force.argmax()]) & (times < drive.rise + drive.hold)
    half = np.interp(-top(found) / 2, -force[falls], times[falls]) - times[force.argmax()]
    assert half < drive.hold
    return [drive.rise, half, eps0 * gap.permittivity / gap.conductivity]


def researcher_3():
    found = computed("researcher.3")
    steps = [10, 100, 1000]
    forces = [under_sine(found, each) for each in steps]
    return [top(found, "drive_voltage"), forces[0], 10, forces[1], 100, forces[2], 1000]


def researcher_4():
    found, before = computed("researcher.4"), computed("engineer.1")
    gap, other = (each.scenario.stack.layers["gap"].thickness for each in (found, before))
    thick = [top(computed("researcher.1", stack__gap__thickness=each)) for each in (1e-6, 3e-6)]
    assert thick[0] / thick[1] < 2  # on a thick film the gap does not decide
    assert before.scenario.sources["stack.gap.thickness"].startswith("not printed in the abstract")
    return [gap, other, top(found) / top(before), top(found)]


def researcher_5():
    found = computed("researcher.5")
    rig = found.scenario.rig.lateral
    spread = [np.ptp(found.values(each)) for each in ("lateral_force_measured", "lateral_force")]
    return [rig.natural_frequency, peaks_per_second(found), spread[0] / spread[1]]


NUMBERS = {
    name.replace("_", "."): each
    for name, each in globals().items()
    if name.startswith(("student_", "engineer_", "researcher_"))
}


@pytest.mark.parametrize("name", STEPS)
def test_the_numbers_of_a_sentence_are_those_of_its_state(name):
    found = [
        (text, UNITS[unit or percent or "V"]) for text, unit, percent in NUMBER.findall(STEPS[name].sentence)
    ]
    expected = NUMBERS[name]()
    assert len(found) == len(expected) > 0
    for (text, unit), value in zip(found, expected, strict=True):
        last_digit = 10.0 ** -len(text.partition(".")[2])
        assert value / unit == pytest.approx(float(text), abs=0.5001 * last_digit), (text, value / unit)


@pytest.mark.parametrize("name", STEPS)
def test_a_step_is_quick_and_its_tab_shows_something(name):
    step = STEPS[name]
    state = PageState.of_step(step)
    scenario = scenario_of(state, own={})
    found = compute(scenario, longest=LONGEST_SHORT_RUN)
    shown = content(step.tab, found, further(name))
    assert further(name).problems == ()
    assert shown.figures or shown.pulse or "<table" in shown.below
    assert scenario == computed(name).scenario


def test_there_are_five_steps_of_short_sentences_for_three_kinds_of_visitor():
    assert [len(each.steps) for each in STORIES] == [5, 5, 5]
    assert set(NUMBERS) == set(STEPS)
    for step in STEPS.values():
        assert len(step.sentence.split()) <= 35, step.name
    assert len({each.sentence for each in STEPS.values()}) == 15
    assert {FADING, LAWS, FREQUENCY} < {each.tab for each in STEPS.values()}


@pytest.mark.parametrize("name", STEPS)
def test_the_address_of_a_step_gives_it_again(name):
    state = PageState.of_step(STEPS[name])
    again = read_query(state.to_query(), own={}, default="bau_2010/sine")
    assert again == state
    assert again.story == name
    assert again.changed("drive.low", "0 V").story == name
    assert ("tab=" in state.to_query()) == (STEPS[name].tab != "Over time")


@pytest.mark.parametrize(
    ("query", "words"),
    [
        ("tab=Force law", "tab: no tab is called 'Force law'. Did you mean 'Force laws'?"),
        ("tab=", "tab: no tab is called ''."),
        ("story=engineer.6", "story: no story is called 'engineer.6'. Did you mean 'engineer.5'?"),
    ],
)
def test_an_unknown_tab_or_story_is_refused_with_the_nearest_name(query, words):
    with pytest.raises(InputError, match=re.escape(words)):
        read_query(query, own={}, default="bau_2010/sine")


def test_what_is_shown_of_a_scenario_is_no_other_scenario():
    state = PageState("bau_2010/sine", {"drive.amplitude": "5 V"})
    assert state.has_scenario_of(replace(state, tab=LAWS, story="student.1"))
    assert not state.has_scenario_of(state.reset())
    assert not state.has_scenario_of(replace(state, preset="kang_2017/sine"))


@pytest.mark.parametrize("name", ["student.5", "engineer.4"])
def test_the_bar_of_a_vibration_and_the_curve_below_it_are_both_in_sight(name):
    (plot,) = content("Felt", computed(name), further(name)).figures
    bars, *_, curve = plot["data"]
    low, high = plot["layout"]["yaxis"]["range"]
    assert low < np.log10(np.nanmin(curve["y"])) < np.log10(max(bars["y"])) < high
    assert 20 * np.log10(max(bars["y"]) / np.nanmin(curve["y"])) == pytest.approx(
        further(name).percept.sensation, abs=1.5
    )
