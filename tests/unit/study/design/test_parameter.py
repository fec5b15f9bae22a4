"""The parameter that gives a wanted quantity: closed forms, limits, uncertainty, and every mistake in one sentence."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import electrovib as ev
from electrovib.core.budget import budget
from electrovib.core.errors import ElectrovibError, InputError

SINE = ev.load("bau_2010/sine")
MEAN = "mean electrostatic_force"
FREE = "drive.amplitude"
AREA = {"contact.area": {"model": "LogNormal", "median": "1 cm2", "factor": 1.5}}
IDEAL = SINE.replace({"circuit.return_path.resistance": 0.0})
"""The voltage at the finger does not depend on its area."""
LEAKY = {"stack.gap.material.conductivity": 1e-8, "circuit.return_path.resistance": "1 Mohm"}


def force(scenario=SINE, quantity=MEAN, **at):
    paths = {path.replace("__", "."): value for path, value in at.items()}
    return ev.prepare(scenario, free=list(paths) or [FREE], quantities=[quantity])(paths)[quantity]


def test_the_amplitude_of_a_force_that_is_proportional_to_the_square_of_the_voltage():
    found = ev.design(SINE, want="mean electrostatic_force = 50 mN", free=FREE)
    assert found.value == pytest.approx(100 * math.sqrt(0.05 / force()), rel=1e-10)
    assert found.values == (found.value,)
    assert found.is_achieved
    assert force(found.scenario) == pytest.approx(0.05, rel=1e-10)
    assert found.lines[0] == "drive.amplitude = 50.8183 V gives mean electrostatic_force = 50 mN."


def test_the_area_is_proportional_to_the_force():
    found = ev.design(IDEAL, want={MEAN: 0.05}, free="contact.area")
    assert found.value == pytest.approx(1e-4 * 0.05 / force(IDEAL), rel=1e-9)


def test_the_offset_has_two_signs():
    """Mean of (offset + amplitude sin)^2, offset^2 + amplitude^2/2, without layers that conduct."""
    wanted = 1.8 * force()
    found = ev.design(SINE, want={MEAN: wanted}, free="drive.offset", set={"drive.frequency": "1 kHz"})
    assert len(found.values) == 2
    assert found.values[0] == pytest.approx(-found.values[1], rel=1e-9)
    for each in found.values:
        assert force(found.base, drive__offset=each) == pytest.approx(wanted, rel=1e-9)


def test_the_minimum_over_the_offset_is_one_solution():
    found = ev.design(SINE, want={MEAN: force(drive__offset=0.0)}, free="drive.offset")
    assert len(found.solutions) == 1
    assert found.value == pytest.approx(0, abs=0.01)
    assert "an extreme value" in found.lines[0]


def test_two_frequencies_where_the_force_has_a_maximum():
    """Below, the gap conducts; above, the series resistance takes the voltage. The number is that of a dense sweep."""
    base = SINE.replace(LEAKY)
    wanted = 0.6 * force(base)
    found = ev.design(base, want={MEAN: wanted}, free="drive.frequency")
    dense = np.geomspace(1e-3, 1e8, 300)
    values = ev.prepare(base, free=["drive.frequency"], quantities=[MEAN])([dense])[MEAN]
    crossed = dense[:-1][np.diff(np.sign(values - wanted)) != 0]
    assert len(found.values) == len(crossed) == 2
    for value, near in zip(sorted(found.values), crossed, strict=True):
        assert near <= value <= near * (dense[1] / dense[0])
        assert force(base, drive__frequency=value) == pytest.approx(wanted, rel=1e-9)
    assert found.lines[1].startswith("Other solutions: ")


def test_beyond_the_maximum_the_nearest_reachable_value_is_stated():
    base = SINE.replace(LEAKY)
    found = ev.design(base, want="mean electrostatic_force = 1 N", free="drive.frequency")
    (at, highest), dense = found.explored.highest, np.geomspace(1e-3, 1e8, 300)
    values = ev.prepare(base, free=["drive.frequency"], quantities=[MEAN])([dense])[MEAN]
    assert not found.is_achieved
    assert found.scenario is None
    assert math.isnan(found.value)
    assert np.max(values) <= highest == pytest.approx(np.max(values), rel=1e-2)
    assert found.lines[0].startswith("No value of drive.frequency from 1 mHz to 100 MHz gives")
    assert found.lines[1].startswith("Nearest: ")
    assert force(base, drive__frequency=at) == pytest.approx(highest, rel=1e-12)


def test_a_narrow_range_has_no_solution_beside_it():
    found = ev.design(SINE, want="mean electrostatic_force = 50 mN", free=FREE, between="60 V:0.1 kV")
    assert (found.wanted.low, found.wanted.high) == (60, 100)
    assert found.explored.lowest == (60, pytest.approx(force() * 0.36, rel=1e-9))
    assert not found.solutions
    found = ev.design(SINE, want="mean electrostatic_force = 50 mN", free=FREE, between=(50, "60 V"))
    assert len(found.solutions) == 1


@pytest.mark.parametrize("limit", ["voltage", "current", "body_current", "charge"])
def test_a_limit_that_forbids_is_named_with_what_it_leaves(limit):
    """All of these grow with the amplitude, so that 70 V are left where 100 V exceed the limit by 1/0.7."""
    row = next(
        each for each in ev.check(SINE).rows if each.quantity.removeprefix("peak ").replace(" ", "_") == limit
    )
    bound = {"voltage": 70.0}.get(limit, 0.7 * row.value)
    wanted = 0.9 * force()
    found = ev.design(SINE, want={MEAN: wanted}, free=FREE, limits={limit: bound})
    assert not found.is_achieved
    assert found.solutions[0].value == pytest.approx(100 * math.sqrt(0.9), rel=1e-9)
    assert found.obtainable.value == pytest.approx(70, rel=1e-6)
    assert found.obtainable.value <= 70
    assert found.obtainable.reached == pytest.approx(0.49 * force(), rel=1e-6)
    assert f"limits.{limit} of limits" in found.lines[1]
    assert "Within the limits mean electrostatic_force is at most" in found.lines[2]
    assert ev.check(SINE.replace({FREE: found.obtainable.value}), limits={limit: bound}).state != "fail"


def test_a_value_in_the_scenario_that_is_at_its_limit_is_named_with_the_limit():
    found = ev.design(SINE, want="mean electrostatic_force = 1 N", free=FREE, limits={"voltage": 100.0})
    assert (found.obtainable.value, found.obtainable.reached) == (pytest.approx(100), pytest.approx(force()))
    assert "where the voltage of the plate reaches 100 V, within 100 V" in found.lines[2]


@pytest.mark.slow
def test_of_two_signs_that_of_the_scenario_is_obtained():
    for high in (900.0, -900.0):
        found = ev.design(
            "vezzoli_2014/fig6",
            want="mean electrostatic_force = 9 mN",
            free="drive.high",
            set={"drive.high": high},
            limits={"voltage": "1 kV"},
        )
        assert found.obtainable.value == pytest.approx(math.copysign(1000, high), rel=1e-9)


def test_breakdown_of_the_film_forbids_too():
    set_ = {"stack.insulator.breakdown_field": "2 MV/m"}
    found = ev.design(SINE, want="mean electrostatic_force = 50 mN", free=FREE, set=set_)
    assert not found.is_achieved
    field = ev.sweep(SINE, {}, quantities=["peak field in insulator"])["peak field in insulator"].item()
    assert found.obtainable.value == pytest.approx(100 * 2e6 / field, rel=1e-6)
    assert "the field in 'insulator'" in found.lines[1]


def test_the_strictest_of_several_limits_counts():
    found = ev.design(
        SINE,
        want="mean electrostatic_force = 50 mN",
        free=FREE,
        set={"limits.voltage": "45 V"},
        limits=[{"voltage": 30.0}, {"voltage": 40.0}],
    )
    assert found.obtainable.value == pytest.approx(30, rel=1e-9)


def test_more_solutions_than_are_listed_are_counted_where_they_are_listed():
    """sin(2 pi f 20 ms)^2 is small twice at each multiple of 25 Hz, once at the ends: 40 times."""
    grounded = {"circuit.return_path": {"model": "Grounded", "resistance": 0.0}}
    found = ev.design(
        "bau_2010/sine",
        want="electrostatic_force at 20 ms = 0.1 mN",
        free="drive.frequency",
        between="100 Hz:600 Hz",
        set=grounded,
    )
    assert len(found.solutions) + found.explored.beyond == 40
    (line,) = [each for each in found.lines if each.startswith("Other solutions")]
    assert line.startswith(
        "Other solutions (30 with the first, of 40; a narrower range, between, finds the others): "
    )


def test_a_forbidden_solution_does_not_hide_an_allowed_one():
    """A thin gap gives the force too, but its current is larger."""
    base = SINE.replace(LEAKY)
    wanted = 0.6 * force(base)
    free = ev.design(base, want={MEAN: wanted}, free="drive.frequency")
    currents = [ev.check(base, set={"drive.frequency": each}).value("peak current") for each in free.values]
    bound = math.sqrt(currents[0] * currents[1])
    found = ev.design(base, want={MEAN: wanted}, free="drive.frequency", limits={"current": bound})
    assert found.values == (min(free.values),)
    assert [each.is_allowed for each in found.solutions] == [True, False]
    assert "(forbidden: the current into the contact" in found.lines[1]


def test_an_allowed_value_of_the_other_sign_comes_before_a_forbidden_one():
    """The offset of 500 V adds to the amplitude for one sign and not for the other."""
    found = ev.design(
        "vezzoli_2014/fig6",
        want="mean electrostatic_force = 5 mN",
        free=FREE,
        between="-3 kV:3 kV",
        set={"limits.current": "10 A"},
        limits={"voltage": "1.9 kV"},
    )
    assert [each.is_allowed for each in found.solutions] == [True, False]
    assert found.value == found.solutions[0].value < 0 < found.solutions[1].value


def test_no_value_is_within_the_limits():
    found = ev.design(
        SINE, want="mean electrostatic_force = 50 mN", free="contact.area", limits={"voltage": "1 V"}
    )
    assert not found.is_achieved
    assert found.obtainable is None
    assert "Every value that could be computed exceeds a limit." in found.lines


def test_elasticities_of_the_square_law():
    found = ev.design(IDEAL, want="mean electrostatic_force = 50 mN", free=FREE)
    by_path = {each.path: each.value for each in found.influences}
    assert by_path["contact.area"] == pytest.approx(-0.5, rel=1e-8)
    assert by_path["friction.coefficient"] == 0
    assert FREE not in by_path
    sizes = [abs(each.value) for each in found.influences]
    assert sizes == sorted(sizes, reverse=True)


@pytest.mark.parametrize("path", ["stack.gap.thickness", "stack.stratum_corneum.thickness"])
def test_an_elasticity_is_that_of_solutions_nearby(path):
    found = ev.design(SINE, want="mean electrostatic_force = 50 mN", free=FREE)
    at = SINE.replace({FREE: found.value})
    value = next(each.at for each in found.influences if each.path == path)
    step = 1e-3
    low, high = (
        ev.design(at, want="mean electrostatic_force = 50 mN", free=FREE, set={path: value * ratio}).value
        for ratio in (math.exp(-step), math.exp(step))
    )
    stated = next(each.value for each in found.influences if each.path == path)
    assert stated == pytest.approx(math.log(high / low) / (2 * step), rel=1e-5)


@pytest.mark.parametrize("linear", [False, True])
def test_the_distribution_of_a_power_law(linear):
    """The amplitude is proportional to the area to the power -1/2, so that the area's percentiles give its own."""
    found = ev.design(
        IDEAL, want="mean electrostatic_force = 50 mN", free=FREE, space=AREA, n=40, seed=3, linear=linear
    )
    area = ev.read_space(IDEAL, AREA).draw(3, 0, 40)["contact.area"]
    expected = ev.design(IDEAL, want="mean electrostatic_force = 50 mN", free=FREE).value * np.sqrt(
        1e-4 / area
    )
    assert found.distribution.values == pytest.approx(expected, rel=1e-5 if linear else 1e-7)
    assert found.distribution.percentiles()[5] == pytest.approx(np.percentile(expected, 5), rel=1e-5)
    line = next(each for each in found.lines if each.startswith("Distribution"))
    assert ("linear propagation" if linear else "each draw solved anew") in line
    assert not found.influences


@pytest.mark.parametrize("linear", [False, True])
def test_draws_without_a_solution_are_counted(linear):
    space = {"contact.area": {"model": "Uniform", "low": "0.2 cm2", "high": "2 cm2"}}
    found = ev.design(
        SINE,
        want="mean electrostatic_force = 50 mN",
        free=FREE,
        space=space,
        seed=1,
        n=12,
        linear=linear,
        between="1 V:55 V",
    )
    area = ev.read_space(SINE, space).draw(1, 0, 12)["contact.area"]
    beyond = 100 * np.sqrt(0.05 / force() * 1e-4 / area) > 55
    assert 0 < np.sum(beyond) < 12
    assert np.array_equal(~np.isfinite(found.distribution.values), beyond)
    assert any(line.startswith(f"{np.sum(beyond)} of 12 draws have no value") for line in found.lines)


def test_the_free_parameter_is_not_drawn():
    space = AREA | {FREE: {"model": "Uniform", "low": "20 V", "high": "90 V"}}
    found = ev.design(SINE, want="mean electrostatic_force = 50 mN", free=FREE, space=space, seed=1, n=5)
    alone = ev.design(SINE, want="mean electrostatic_force = 50 mN", free=FREE, space=AREA, seed=1, n=5)
    assert found.distribution.values == pytest.approx(alone.distribution.values, rel=1e-7)
    assert "drive.amplitude is not drawn: it is the parameter that is sought" in found.lines


@pytest.mark.slow
def test_a_level_of_perception_can_be_wanted():
    """The level grows by 20 dB for ten times the force, and the force with the square of the amplitude."""
    skin = {"model": "ElasticViscousSkin", "stiffness": 1000.0, "corner": 100.0}
    calibrated = {"perception": {"compliance": skin, "threshold": 1e-7, "threshold_uncertainty": 3.0}}
    narrow = {"free": FREE, "between": "1 V:10 kV"}
    first = ev.design(SINE, want="detection level = 6 dB", set=calibrated, **narrow)
    second = ev.design(SINE, want="detection level = 16 dB", set=calibrated, **narrow)
    assert second.value / first.value == pytest.approx(10 ** (10 / 40), rel=1e-6)
    published = [ev.design(SINE, want=f"detection level = {level} dB", **narrow).value for level in (6, 16)]
    assert published[1] / published[0] == pytest.approx(10 ** (10 / 40), rel=1e-6)
    with pytest.raises(InputError, match="relative level does not depend on it"):
        ev.design(SINE, want="relative level = -3 dB", **narrow)


def test_a_signal_at_one_time_can_be_wanted():
    found = ev.design(
        "vezzoli_2014/fig6", want="electrostatic_force at 20 ms = 1 mN", free="drive.high", between="0:2 kV"
    )
    prepared = ev.prepare("vezzoli_2014/fig6", free=["drive.high"])
    forces = prepared.signals([found.value], time=np.linspace(0, 0.1, 6))["electrostatic_force"]
    assert forces[1] == pytest.approx(1e-3, rel=1e-6)
    assert found.wanted.meaning.endswith("at 20 ms")


def test_a_field_at_one_time_is_that_of_its_layer():
    found = ev.design(SINE, want="field in gap at 2 ms = 1 MV/m", free=FREE)
    fields = ev.prepare(SINE, free=[FREE]).signals([found.value], names=["field"], time=[2e-3])["field"]
    assert fields[list(SINE.stack.layers).index("gap"), 0] == pytest.approx(1e6, rel=1e-9)


def test_a_current_drive_and_a_peak_of_a_layer():
    found = ev.design("kim_2015/current", want="peak field in gap = 1 MV/m", free=FREE)
    assert ev.sweep(found.scenario, {}, quantities=["peak field in gap"])[
        "peak field in gap"
    ].item() == pytest.approx(1e6)


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
    wanted = force(base, quantity, **{free.replace(".", "__"): value})
    found = ev.design(base, want={quantity: wanted}, free=free, between=(low, high))
    assert any(each.value == pytest.approx(value, rel=1e-5) for each in found.solutions)
    for each in found.solutions:
        assert force(base, quantity, **{free.replace(".", "__"): each.value}) == pytest.approx(
            wanted, rel=1e-6
        )


SPACES = {
    "area": AREA,
    "layers": {
        "stack.gap.thickness": {"model": "Uniform", "low": "2 um", "high": "4 um"},
        "stack.stratum_corneum.thickness": {"model": "LogNormal", "median": "200 um", "factor": 1.2},
    },
    "fingers": "fingers",
}


def combinations():
    for i, (space, free) in enumerate((space, free) for space in SPACES for free in RANGES):
        for j, quantity in enumerate(QUANTITIES):
            yield pytest.param(space, free, quantity, marks=() if (i + j) % 13 == 0 else pytest.mark.slow)


@pytest.mark.parametrize(("space", "free", "quantity"), [*combinations()])
def test_every_draw_gives_what_is_wanted(space, free, quantity):
    wanted = 0.7 * force(quantity=quantity)
    found = ev.design(
        SINE, want={quantity: wanted}, free=free, between=RANGES[free], space=SPACES[space], seed=1, n=4
    )
    if found.distribution is None:
        assert not found.solutions
        return
    drawn = ev.read_space(SINE, SPACES[space]).draw(1, 0, 4)
    drawn.pop(free, None)
    paths = [free, *drawn]
    prepared = ev.prepare(SINE, free=paths, quantities=[quantity])
    for i, value in enumerate(found.distribution.values):
        if math.isfinite(value):
            point = {free: value} | {path: values[i] for path, values in drawn.items()}
            assert prepared(point)[quantity] == pytest.approx(wanted, rel=1e-6)


WANT = "mean electrostatic_force = 50 mN"
REFUSED = {
    "nothing": ({}, "design: state what is wanted: a parameter by want="),
    "no free": ({"want": WANT}, "free: not given, but the design of a parameter needs it, for instance want="),
    "no want": ({"free": FREE}, "want: not given"),
    "no value": ({"want": MEAN, "free": FREE}, "want = mean electrostatic_force: expected one quantity and its value"),
    "two values": ({"want": f"{MEAN} = 1 = 2", "free": FREE}, "want = .*: expected one quantity and its value"),
    "not a text": ({"want": 3, "free": FREE}, "want = 3: expected one quantity"),
    "no such quantity": ({"want": "mean electrostatic_forc = 1 N", "free": FREE}, "Did you mean 'electrostatic_force'"),
    "another unit": ({"want": f"{MEAN} = 50 mV", "free": FREE}, "want: mean electrostatic_force = 50 mV: expected a force"),
    "not finite": ({"want": {MEAN: math.inf}, "free": FREE}, "want: mean electrostatic_force = inf: expected a force"),
    "a frequency": ({"want": "electrostatic_force at 200 Hz = 1 N", "free": FREE}, "at = 200 Hz: expected a time.*drive.freq"),
    "after the end": ({"want": "electrostatic_force at 9 s = 1 N", "free": FREE}, "at = 9 s: expected a time from 0 s to"),
    "no such path": ({"want": WANT, "free": "drive.amplitud"}, "drive.amplitud: .*Did you mean 'drive.amplitude'"),
    "several": ({"want": WANT, "free": [FREE]}, r"free = \['drive.amplitude'\]: expected the dotted path of one"),
    "no number": ({"want": WANT, "free": "drive"}, "drive: no physical parameter has this path"),
    "absent": ({"want": WANT, "free": "limits.voltage"}, "limits.voltage: the scenario gives it no value; add one by --set"),
    "a grid": ({"want": WANT, "free": "frequency.high"}, "frequency.high: the frequencies of the output are no input"),
    "no range": ({"want": WANT, "free": FREE, "between": "10"}, "between = 10: expected LOW:HIGH, for instance 0 V:100 kV"),
    "turned": ({"want": WANT, "free": FREE, "between": "20:10"}, "between = 20:10: expected two values, the smaller first"),
    "beyond": ({"want": WANT, "free": FREE, "between": "1V:1GV"}, "drive.amplitude allows 0 V to 100 kV"),
    "range in m": ({"want": WANT, "free": FREE, "between": "1m:2V"}, "between = 1m: expected a voltage"),
    "no influence": ({"want": WANT, "free": "friction.coefficient"}, "friction.coefficient: mean .* does not depend on it"),
    "draws of nothing": ({"want": WANT, "free": FREE, "n": 5}, "n: belongs to the draws from a space"),
    "one draw": ({"want": WANT, "free": FREE, "space": AREA, "n": 1}, "n = 1: expected a whole number of draws"),
    "no seed": ({"want": WANT, "free": FREE, "space": AREA}, "seed: missing.*add one, for instance 1"),
    "no such space": ({"want": WANT, "free": FREE, "space": "finger"}, "finger"),
    "no such limit": ({"want": WANT, "free": FREE, "limits": {"voltag": 1.0}}, "limits.voltag: .*voltage"),
    "no such file": ({"want": WANT, "free": FREE, "limits": "none.toml"}, "none.toml: No such file"),
}  # fmt: skip


@pytest.mark.parametrize("wrong", REFUSED)
def test_a_mistake_is_one_sentence(wrong):
    options, words = REFUSED[wrong]
    with pytest.raises(InputError, match=words) as caught:
        ev.design(SINE, **options)
    assert len(caught.value.problems) == 1


def test_all_mistakes_at_once():
    with pytest.raises(InputError) as caught:
        ev.design(SINE, want="mean electrostatic_forc = 1 N", free="drive.amplitud")
    assert len(caught.value.problems) == 2


def test_more_than_the_budget_is_refused_as_soon_as_it_shows():
    with (
        budget(time=1e-3),
        pytest.raises(ElectrovibError, match=r"this design would .* evaluations for drive\.amplitude"),
    ):
        ev.design(SINE, want=WANT, free=FREE)
    with (
        budget(time=2),
        pytest.raises(ElectrovibError, match=r"for 5000 draws, of which .*Choose a smaller n"),
    ):
        ev.design(SINE, want=WANT, free=FREE, space=AREA, seed=1, n=5000)
    for more in ({}, {"share": 0.9}):
        with pytest.raises(ElectrovibError, match=r"TB, for 1000000000000 draws; .*Choose a smaller n"):
            ev.design(SINE, want=WANT, free=FREE, space=AREA, seed=1, n=10**12, **more)


def test_everything_as_tables_without_numbers_that_json_does_not_have():
    import json

    found = ev.design(SINE, want=WANT, free=FREE, space=AREA, seed=1, n=5, limits={"voltage": 30.0})
    table = json.loads(json.dumps(found.to_dict(), allow_nan=False))
    assert table["value"] is None
    assert table["obtainable_within_limits"]["at"] == pytest.approx(30)
    assert table["solutions"][0]["is_allowed"] is False
    assert len(table["distribution"]["draws"]) == 5
    assert table["text"] == list(found.lines)
    assert str(found) == "\n".join(found.lines)
