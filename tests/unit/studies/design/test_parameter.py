"""The parameter that gives a wanted quantity: closed forms, limits, uncertainty, and every mistake in one sentence."""

import json
import math
from operator import itemgetter

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import electrovib as ev
from electrovib.core.budget import budget
from electrovib.core.discovery import offers
from electrovib.core.errors import ElectrovibError, InputError
from electrovib.core.paths import quantity_at, value_at
from electrovib.studies.design import value as module

SINE = ev.load("bau_2010/sine")
MEAN, FREE = "mean electrostatic_force", "drive.amplitude"
WANT = f"{MEAN} = 50 mN"
AREA = {"contact.area": {"model": "LogNormal", "median": "1 cm2", "factor": 1.5}}
IDEAL = SINE.replace({"circuit.return_path.resistance": 0.0})
"""The voltage at the finger does not depend on its area."""
LEAKY = SINE.replace({"stack.gap.material.conductivity": 1e-8, "circuit.return_path.resistance": "1 Mohm"})
"""Below a frequency the gap conducts; above another the series resistance takes the voltage."""


def force(scenario=SINE, quantity=MEAN, at=None):
    return ev.prepare(scenario, free=list(at or [FREE]), quantity=[quantity])(at or {})[quantity]


def design(want=WANT, free=FREE, scenario=SINE, *, between=None, **options):
    return ev.find_value(scenario, want=want, free=free if between is None else {free: between}, **options)


def for_share(share=0.5, want=WANT, free=FREE, scenario=SINE, **options):
    return ev.value_for_share(scenario, want=want, free=free, share=share, **{"seed": 1, "n": 20} | options)


def test_amplitude_and_area_of_the_square_law_and_a_range_without_them():
    found = design()
    assert found.value == pytest.approx(100 * math.sqrt(0.05 / force()), rel=1e-10)
    assert (found.values, found.is_achieved) == ((found.value,), True)
    assert force(found.scenario) == pytest.approx(0.05, rel=1e-10)
    assert (
        found.document.sentences[0] == "drive.amplitude = 50.8183 V gives mean electrostatic_force = 50 mN."
    )
    line, computed, *_ = found.document.figures[0].curves
    assert (line.kind, computed.kind) == ("line", "points")
    assert computed.y == pytest.approx([force() * (x / 100) ** 2 for x in computed.x], rel=1e-9)
    found = design({MEAN: 0.05}, "contact.area", IDEAL)
    assert found.value == pytest.approx(1e-4 * 0.05 / force(IDEAL), rel=1e-9)
    found = design(f"{WANT}", f"{FREE} = 60 V:0.1 kV")
    assert (found.wanted.low, found.wanted.high) == (60, 100)
    assert min(found.explored.points, key=itemgetter(1)) == (60, pytest.approx(force() * 0.36, rel=1e-9))
    assert not found.solutions
    assert len(design(between=(50, "60 V")).solutions) == 1


def test_the_offset_has_two_signs_and_its_minimum_is_one_solution():
    """Mean of (offset + amplitude sin)^2, offset^2 + amplitude^2/2, without layers that conduct."""
    wanted = 1.8 * force()
    found = design({MEAN: wanted}, "drive.offset", set={"drive.frequency": "1 kHz"})
    assert len(found.values) == 2
    assert found.values[0] == pytest.approx(-found.values[1], rel=1e-9)
    for each in found.values:
        assert force(found.base, at={"drive.offset": each}) == pytest.approx(wanted, rel=1e-9)
    found = design({MEAN: force(at={"drive.offset": 0.0})}, "drive.offset")
    assert len(found.solutions) == 1
    assert found.value == pytest.approx(0, abs=0.01)
    assert "an extreme value" in found.document.sentences[0]


def test_two_frequencies_where_the_force_has_a_maximum_and_the_nearest_beyond_it():
    """Number and maximum are those of a dense sweep."""
    dense, wanted = np.geomspace(1e-3, 1e8, 300), 0.6 * force(LEAKY)
    values = ev.prepare(LEAKY, free=["drive.frequency"], quantity=[MEAN])([dense])[MEAN]
    found = design({MEAN: wanted}, "drive.frequency", LEAKY)
    crossed = dense[:-1][np.diff(np.sign(values - wanted)) != 0]
    assert len(found.values) == len(crossed) == 2
    for value, near in zip(sorted(found.values), crossed, strict=True):
        assert near <= value <= near * (dense[1] / dense[0])
        assert force(LEAKY, at={"drive.frequency": value}) == pytest.approx(wanted, rel=1e-9)
    assert found.document.sentences[1].startswith("Other solutions: ")
    found = design(f"{MEAN} = 1 N", "drive.frequency", LEAKY)
    at, highest = max(found.explored.points, key=itemgetter(1))
    assert (found.is_achieved, found.scenario) == (False, None)
    assert math.isnan(found.value)
    assert np.max(values) <= highest == pytest.approx(np.max(values), rel=1e-2)
    assert found.document.sentences[0].startswith("No value of drive.frequency from 1 mHz to 100 MHz gives")
    assert found.document.sentences[1].startswith("Nearest: ")
    assert force(LEAKY, at={"drive.frequency": at}) == pytest.approx(highest, rel=1e-12)


@pytest.mark.parametrize("limit", ["voltage", "current", "body_current", "charge"])
def test_a_limit_that_forbids_is_named_with_what_it_leaves(limit):
    """All of these grow with the amplitude, so that 70 V are left where 100 V exceed the limit by 1/0.7."""
    values = {
        each.quantity.removeprefix("peak ").replace(" ", "_"): each.value for each in ev.check(SINE).rows
    }
    bound = 0.7 * values[limit]
    found = design({MEAN: 0.9 * force()}, limits={limit: bound})
    assert not found.is_achieved
    assert found.solutions[0].value == pytest.approx(100 * math.sqrt(0.9), rel=1e-9)
    assert found.obtainable.value == pytest.approx(70, rel=1e-6)
    assert found.obtainable.value <= 70
    assert found.obtainable.reached == pytest.approx(0.49 * force(), rel=1e-6)
    assert f"limits.{limit} of limits" in found.document.sentences[1]
    assert "Within the limits mean electrostatic_force is at most" in found.document.sentences[2]
    assert ev.check(SINE.replace({FREE: found.obtainable.value}), limits={limit: bound}).state != "fail"


def test_what_is_obtained_under_the_strictest_limit_under_breakdown_of_the_film_and_under_none():
    found = design(f"{MEAN} = 1 N", limits={"voltage": 100.0})
    assert (found.obtainable.value, found.obtainable.reached) == (pytest.approx(100), pytest.approx(force()))
    assert "where the voltage of the plate reaches 100 V, within 100 V" in found.document.sentences[2]
    found = design(set={"limits.voltage": "45 V"}, limits=[{"voltage": 30.0}, {"voltage": 40.0}])
    assert found.obtainable.value == pytest.approx(30, rel=1e-9)
    found = design(free="contact.area", limits={"voltage": "1 V"})
    assert (found.is_achieved, found.obtainable) == (False, None)
    assert "Every value that could be computed exceeds a limit." in found.document.sentences
    found = design(set={"stack.insulator.breakdown_field": "2 MV/m"})
    assert not found.is_achieved
    film = ev.load(SINE).stack.layers["insulator"].thickness
    assert found.obtainable.value == pytest.approx(2e6 * film, rel=1e-6), "with the gap closed"
    assert any(
        "the field in 'insulator', with the gap closed" in line for line in found.document.sentences[:3]
    )


@pytest.mark.slow
def test_of_two_signs_that_of_the_scenario_is_obtained():
    for high in (900.0, -900.0):
        asked = {"set": {"drive.high": high}, "limits": {"voltage": "1 kV"}}
        found = design(f"{MEAN} = 9 mN", "drive.high", "vezzoli_2014/fig6", **asked)
        assert found.obtainable.value == pytest.approx(math.copysign(1000, high), rel=1e-9)


@pytest.mark.slow
def test_more_solutions_than_are_listed_are_counted_where_they_are_listed():
    """sin(2 pi f 20 ms)^2 is small twice at each multiple of 25 Hz, once at the ends: 40 times."""
    grounded = {"circuit.return_path": {"model": "Grounded", "resistance": 0.0}}
    want = "electrostatic_force at 20 ms = 0.1 mN"
    found = design(want, "drive.frequency", between="100 Hz:600 Hz", set=grounded)
    assert len(found.solutions) + found.explored.beyond == 40
    (line,) = [each for each in found.document.sentences if each.startswith("Other solutions")]
    counted = "Other solutions (30 with the first, of 40; a narrower range finds the others): "
    assert line.startswith(counted)


def test_a_forbidden_solution_does_not_hide_an_allowed_one():
    """The higher frequency gives the force too, but its current is larger; an offset of 500 V adds to one sign only."""
    wanted = {MEAN: 0.6 * force(LEAKY)}
    free = design(wanted, "drive.frequency", LEAKY)
    currents = [ev.check(LEAKY, set={"drive.frequency": each}).value("peak current") for each in free.values]
    limits = {"current": math.sqrt(currents[0] * currents[1])}
    found = design(wanted, "drive.frequency", LEAKY, limits=limits)
    assert found.values == (min(free.values),)
    assert [each.is_allowed for each in found.solutions] == [True, False]
    assert "(forbidden: the current into the contact" in found.document.sentences[1]
    asked = {"set": {"limits.current": "10 A"}, "limits": {"voltage": "1.9 kV"}, "between": "-3 kV:3 kV"}
    found = design(f"{MEAN} = 5 mN", scenario="vezzoli_2014/fig6", **asked)
    assert [each.is_allowed for each in found.solutions] == [True, False]
    assert found.value == found.solutions[0].value < 0 < found.solutions[1].value


def test_elasticities_of_the_square_law_and_of_solutions_nearby():
    by_path = {each.path: each.value for each in design(scenario=IDEAL).influences}
    assert by_path["contact.area"] == pytest.approx(-0.5, rel=1e-8)
    assert by_path["friction.coefficient"] == 0
    assert FREE not in by_path
    sizes = [abs(each) for each in by_path.values()]
    assert sizes == sorted(sizes, reverse=True)
    found, step = design(), 1e-3
    for path in ("stack.gap.thickness", "stack.stratum_corneum.thickness"):
        (stated,) = (each for each in found.influences if each.path == path)
        ends = (stated.at * math.exp(sign * step) for sign in (-1, 1))
        low, high = (design(scenario=found.scenario, set={path: each}).value for each in ends)
        assert stated.value == pytest.approx(math.log(high / low) / (2 * step), rel=1e-5)


def test_the_values_for_shares_of_the_draws_of_a_power_law():
    """The amplitude is proportional to the area to the power -1/2, so that the order statistics of the area give its own."""
    found = for_share(scenario=IDEAL, space=AREA, n=40, seed=3)
    area = ev.read_space(IDEAL, AREA).draw(3, 0, 40)["contact.area"]
    values = np.sort(design(scenario=IDEAL).value * np.sqrt(1e-4 / area))
    places = {0.05: 1, 0.25: 9, 0.5: 19, 0.75: 29, 0.95: 37}
    assert found.others == pytest.approx({share: values[place] for share, place in places.items()}, rel=1e-7)
    assert found.value == found.others[0.5]
    assert any(
        line.startswith(f"{FREE} at which a share of the draws has it: 5 %: ")
        for line in found.document.remarks
    )


def test_shares_that_no_value_in_the_range_reaches_are_not_given():
    space = {"contact.area": {"model": "Uniform", "low": "0.2 cm2", "high": "2 cm2"}}
    found = for_share(free=f"{FREE} = 1 V:55 V", space=space)
    area = ev.read_space(SINE, space).draw(1, 0, 20)["contact.area"]
    reached = np.sum(100 * np.sqrt(0.05 / force() * 1e-4 / area) < 55)
    assert 1 < reached < 15
    assert [share for share, value in found.others.items() if math.isfinite(value)] == [
        share for share in found.others if 20 * share <= reached
    ]


@pytest.mark.slow
def test_a_level_of_perception_can_be_wanted():
    """The level grows by 20 dB for ten times the force, and the force with the square of the amplitude."""
    skin = {"model": "ElasticViscousSkin", "stiffness": 1000.0, "corner": 100.0}
    calibrated = {"perception": {"compliance": skin, "threshold": 1e-7, "threshold_uncertainty": 3.0}}
    for known in (calibrated, {}):
        first, second = (
            design(f"detection level = {level} dB", between="1 V:10 kV", set=known).value for level in (6, 16)
        )
        assert second / first == pytest.approx(10 ** (10 / 40), rel=1e-6)
    with pytest.raises(InputError, match="relative level does not depend on it"):
        design("relative level = -3 dB", between="1 V:10 kV")


def test_signals_at_one_time_of_one_layer_and_under_a_current_can_be_wanted():
    want = "electrostatic_force at 20 ms = 1 mN"
    found = design(want, "drive.high", "vezzoli_2014/fig6", between="0:2 kV")
    assert found.diagnostics
    assert found.document.diagnostics == found.diagnostics
    prepared = ev.prepare("vezzoli_2014/fig6", free=["drive.high"])
    forces = prepared.signals([found.value], time=np.linspace(0, 0.1, 6))["electrostatic_force"]
    assert forces[1] == pytest.approx(1e-3, rel=1e-6)
    value = design("field in gap at 2 ms = 1 MV/m").value
    fields = ev.prepare(SINE, free=[FREE]).signals([value], names=["field"], time=[2e-3])["field"]
    assert fields[list(SINE.stack.layers).index("gap"), 0] == pytest.approx(1e6, rel=1e-9)
    found = design("peak field in gap = 1 MV/m", scenario="kim_2015/current")
    assert force(found.scenario, "peak field in gap") == pytest.approx(1e6)


RANGES = {
    FREE: (10.0, 500.0),
    "drive.frequency": (20.0, 5e4),
    "stack.insulator.thickness": (1e-7, 1e-4),
    "stack.gap.thickness": (3e-7, 3e-5),
    "contact.area": (1e-5, 5e-4),
}
QUANTITIES = (
    MEAN,
    "peak electrostatic_force",
    "swing electrostatic_force",
    "rms current",
    "peak field in gap",
)


@pytest.mark.slow
@settings(max_examples=25, deadline=None)
@given(st.sampled_from(sorted(RANGES)), st.sampled_from(QUANTITIES), st.floats(0, 1))
def test_round_trip(free, quantity, share):
    assume((free, quantity) != ("contact.area", "peak field in gap"))  # on which it hardly depends
    low, high = RANGES[free]
    value = low * (high / low) ** share
    base = SINE.replace({"stack.stratum_corneum.material.conductivity": 1e-6})
    wanted = force(base, quantity, {free: value})
    found = design({quantity: wanted}, free, base, between=(low, high))
    assert any(each.value == pytest.approx(value, rel=1e-5) for each in found.solutions)
    for each in found.solutions:
        assert force(base, quantity, {free: each.value}) == pytest.approx(wanted, rel=1e-6)


def free_of(scenario):
    """The first of these paths that the scenario has."""
    for path in ("drive.amplitude", "drive.level", "drive.high", "drive.drives.0.high"):
        try:
            quantity_at(scenario, path)
        except InputError:
            continue
        return path
    raise AssertionError


@pytest.mark.slow
@pytest.mark.parametrize("name", list(offers(("scenarios",))))
def test_the_drive_that_gives_0_64_times_the_force_of_a_preset_is_found_and_gives_it(name, monkeypatch):
    scenario = ev.load(name)
    if module.is_long(scenario):  # elasticities take most of the time, and are the same code for all
        monkeypatch.setattr(module, "_inputs", lambda *_: ())
    free = free_of(scenario)
    begin = value_at(scenario, free)
    wanted = force(scenario, at={free: 0.8 * begin})
    found = design({MEAN: wanted}, free, scenario, between=sorted([0.3 * begin, 1.5 * begin]))
    assert any(each.value == pytest.approx(0.8 * begin, rel=1e-6) for each in found.solutions)
    for each in found.solutions:
        back = ev.sweep(scenario.replace({free: each.value}), {}, quantity=[MEAN])
        assert back[MEAN].item() == pytest.approx(wanted, rel=1e-6)


LAYERS = {
    "stack.gap.thickness": {"model": "Uniform", "low": "2 um", "high": "4 um"},
    "stack.stratum_corneum.thickness": {"model": "LogNormal", "median": "200 um", "factor": 1.2},
}
SPACES = {"area": AREA, "layers": LAYERS, "fingers": "fingers"}


def combinations():
    for i, (space, free) in enumerate((space, free) for space in SPACES for free in RANGES):
        for j, quantity in enumerate(QUANTITIES):
            yield pytest.param(space, free, quantity, marks=() if (i + j) % 26 == 0 else pytest.mark.slow)


@pytest.mark.parametrize(("space", "free", "quantity"), [*combinations()])
def test_at_the_value_for_a_share_one_draw_has_just_what_is_wanted(space, free, quantity):
    wanted, space = 0.7 * force(quantity=quantity), ev.read_space(SINE, SPACES[space])
    asked = {"want": {quantity: wanted}, "free": {free: RANGES[free]}, "space": space}
    if free in space.paths:
        with pytest.raises(InputError, match=f"free: {free} differs between the fingers"):
            for_share(**asked)
        return
    found, drawn = for_share(**asked), space.draw(1, 0, 20)
    prepared = ev.prepare(SINE, free=[free, *drawn], quantity=[quantity])
    for value in {each for each in found.others.values() if math.isfinite(each)} - set(RANGES[free]):
        points = [{free: value} | {path: values[i] for path, values in drawn.items()} for i in range(20)]
        nearest = min(abs(prepared(each)[quantity] / wanted - 1) for each in points)
        assert nearest < 1e-6


REFUSED = {
    "no value": ({"want": MEAN}, "want = mean electrostatic_force: expected one quantity"),
    "two values": ({"want": f"{MEAN} = 1 = 2"}, "want = .*: expected one quantity"),
    "not a text": ({"want": 3}, "want = 3: expected one quantity"),
    "no quantity": ({"want": "mean electrostatic_forc = 1 N"}, "Did you mean 'electrostatic_force'"),
    "another unit": ({"want": f"{MEAN} = 50 mV"}, "want: mean electrostatic_force = 50 mV: expected a force"),
    "not finite": ({"want": {MEAN: math.inf}}, "want: mean electrostatic_force = inf: expected a force"),
    "frequency": ({"want": "electrostatic_force at 2 Hz = 1 N"}, "at = 2 Hz: expected a time.*drive.freq"),
    "late": ({"want": "electrostatic_force at 9 s = 1 N"}, "at = 9 s: expected a time from 0 s to"),
    "no such path": ({"free": "drive.amplitud"}, "drive.amplitud: .*Did you mean 'drive.amplitude'"),
    "several": ({"free": [FREE]}, r"free = \['drive.amplitude'\]: expected the dotted path of one"),
    "no number": ({"free": "drive"}, "drive: no physical parameter has this path"),
    "absent": ({"free": "limits.voltage"}, "limits.voltage: the scenario gives it no value; add one"),
    "a grid": ({"free": "frequency.high"}, "frequency.high: the frequencies of the output are no"),
    "no range": (
        {"between": "10"},
        "free = drive.amplitude=10: expected PATH=LOW:HIGH, for instance drive.amplitude=0 V:100 kV",
    ),
    "turned": ({"between": "20:10"}, "free = drive.amplitude=20:10: expected two values, the smaller first"),
    "beyond": ({"between": "1V:1GV"}, "drive.amplitude allows 0 V to 100 kV"),
    "range in m": ({"between": "1m:2V"}, "drive.amplitude = 1m: expected a voltage"),
    "no influence": ({"free": "friction.coefficient"}, "friction.coefficient: mean .* does not depend on it"),
    "no such limit": ({"limits": {"voltag": 1.0}}, "limits.voltag: .*voltage"),
    "no such file": ({"limits": "none.toml"}, "none.toml: No such file"),
    "two at once": ({"want": "mean electrostatic_forc = 1 N", "free": "drive.amplitud"}, "drive.amplitud"),
}


@pytest.mark.parametrize("wrong", REFUSED)
def test_a_mistake_is_one_sentence(wrong):
    options, words = REFUSED[wrong]
    with pytest.raises(InputError, match=words) as caught:
        design(**options)
    assert len(caught.value.problems) == (2 if wrong == "two at once" else 1)


def test_more_than_the_budget_is_refused_as_soon_as_it_shows():
    with (
        budget(time=1e-3),
        pytest.raises(ElectrovibError, match=r"would .* evaluations for drive\.amplitude"),
    ):
        design()
    slow = {"want": f"{MEAN} = 40 mN", "free": "drive.frequency", "scenario": LEAKY, "space": AREA}
    with budget(time=2), pytest.raises(ElectrovibError, match=r"for 5000 draws, of .*Choose a smaller n"):
        for_share(**slow, n=5000)
    with pytest.raises(ElectrovibError, match=r"TB, for 1000000000000 draws; .*Choose a smaller n"):
        for_share(space=AREA, n=10**12)


def test_everything_as_tables_without_numbers_that_json_does_not_have():
    found = design(limits={"voltage": 30.0})
    table = json.loads(json.dumps(found.to_dict(), allow_nan=False))
    assert table["value"] is None
    assert table["obtainable_within_limits"]["at"] == pytest.approx(30)
    assert table["solutions"][0]["is_allowed"] is False
    everything = found.document.shown(everything=True)
    assert all(line in everything for line in table["text"])
    assert str(found) == found.document.text


@pytest.mark.slow
def test_a_parameter_is_held_within_what_the_amplifier_has():
    """Of a sine on a stack that does not conduct the current is 2 pi f C V: the amplitude ends where it is the largest."""
    own = {"circuit.amplifier": {"source_current": 1e-5}, "time": {"duration": "16 ms"}}
    limited, peak = IDEAL.replace(own), "peak electrostatic_force"
    slope = ev.check(limited.replace({FREE: 1.0})).value("asked peak current")
    beyond = force(IDEAL.replace({"time": own["time"]}), peak, {FREE: 2 * 1e-5 / slope})
    found = design(f"{peak} = {beyond} N", scenario=limited)
    assert not found.is_achieved
    assert found.obtainable.value == pytest.approx(1e-5 / slope, rel=1e-6)
    assert "the current that the drive asks of the amplifier" in found.document.shown(everything=True)
