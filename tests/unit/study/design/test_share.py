"""Value of a parameter for a share of a population, against exact quantiles of static laws."""

from __future__ import annotations

import itertools
import json
import math

import numpy as np
import pytest
from scipy.stats import beta, binom, norm
from typer.testing import CliRunner

import electrovib as ev
from electrovib.apps.cli import app
from electrovib.core.constants import eps0
from electrovib.core.errors import InputError
from electrovib.study.design import share
from electrovib.study.design.fingers import (
    Covered,
    DrawnFingers,
    by_gain,
    by_solution,
    clopper_pearson,
    needed,
    quantile_ranks,
)
from electrovib.study.design.search import inside_band
from electrovib.study.design.wanted import read_wanted

PERMITTIVITY, GAP, AREA, MEDIAN, FACTOR = 3.0, 20e-6, 1e-4, 5e-6, 1.5
STATIC = ev.load(
    "bau_2010/sine",
    changes={
        "stack": {
            "insulator": {
                "thickness": MEDIAN,
                "material": {"model": "Constant", "permittivity": PERMITTIVITY},
                "breakdown_field": 1e9,
            },
            "gap": {"thickness": GAP},
        },
        "circuit.return_path": {"model": "Grounded", "resistance": 0.0},
    },
)
THICKNESS = {"stack.insulator.thickness": {"model": "LogNormal", "median": MEDIAN, "factor": FACTOR}}
MEAN = "mean electrostatic_force"
WANT = 5e-3


def quantile(share):
    """Thickness that a share of the fingers does not exceed."""
    return MEDIAN * FACTOR ** norm.ppf(share)


def voltage(force, thickness):
    """Amplitude at which eps0 A V^2/(4 (T/eps + g)^2) is a force."""
    return math.sqrt(4 * force / (eps0 * AREA)) * (thickness / PERMITTIVITY + GAP)


def at_least(share=0.9, *, seed=3, **options):
    return ev.design(
        STATIC,
        want=f"{MEAN} = 5 mN",
        free="drive.amplitude",
        space=THICKNESS,
        share=share,
        seed=seed,
        **options,
    )


@pytest.mark.parametrize("share", [0.1, 0.5, 0.9])
def test_the_interval_holds_the_exact_quantile_of_a_log_normal_thickness(share):
    found = at_least(share, n=2000)
    exact = voltage(WANT, quantile(share))
    low, high = found.value_interval
    assert low < found.value < high
    assert low < exact < high
    assert found.value == pytest.approx(exact, rel=5e-3)
    assert found.found.share == pytest.approx(share, abs=1e-3)
    thickness = PERMITTIVITY * (found.value / math.sqrt(4 * WANT / (eps0 * AREA)) - GAP)
    reached = norm.cdf(math.log(thickness / MEDIAN) / math.log(FACTOR))
    assert found.found.interval[0] < reached < found.found.interval[1]


def test_the_value_is_the_order_statistic_of_the_draws():
    found = at_least(0.9, n=100)
    thicknesses = np.sort(ev.read_space(STATIC, THICKNESS).draw(3, 0, 100)["stack.insulator.thickness"])
    assert found.value == pytest.approx(voltage(WANT, thicknesses[89]), rel=1e-9)
    assert found.ranges == ((pytest.approx(found.value), 1e5),)
    low, high = quantile_ranks(0.9, 100)
    expected = [voltage(WANT, thicknesses[rank - 1]) for rank in (low, high)]
    assert found.value_interval == pytest.approx(expected, rel=1e-9)


def test_further_draws_confirm_the_share():
    found = at_least(0.9, n=100)
    thicknesses = ev.read_space(STATIC, THICKNESS).draw(3, 100, 200)["stack.insulator.thickness"]
    number = np.count_nonzero(voltage(WANT, thicknesses) <= found.value)
    assert found.found.fresh_share == number / 100
    assert found.found.interval == clopper_pearson(int(number), 100)


def exact_share(value, low, high):
    """Share of the thicknesses with which the force lies in a band at an amplitude."""
    edges = [PERMITTIVITY * (value / math.sqrt(4 * force / (eps0 * AREA)) - GAP) for force in (high, low)]
    return float(
        np.diff([norm.cdf(math.log(max(edge, 1e-12) / MEDIAN) / math.log(FACTOR)) for edge in edges])[0]
    )


def test_the_largest_share_of_a_band_against_the_exact_one():
    found = ev.design(
        STATIC,
        want=MEAN,
        band="4.7 mN:5.3 mN",
        free="drive.amplitude",
        space=THICKNESS,
        share=0.5,
        seed=3,
        n=2000,
    )
    amplitudes = np.linspace(90, 120, 3001)
    exact = np.array([exact_share(each, 4.7e-3, 5.3e-3) for each in amplitudes])
    low, high = found.value_interval
    assert low < amplitudes[np.argmax(exact)] < high
    assert found.found.share == pytest.approx(np.max(exact), abs=0.04)
    assert found.found.interval[0] < exact_share(found.value, 4.7e-3, 5.3e-3) < found.found.interval[1]
    (start, end), *_ = found.ranges
    for edge in (start, end):
        assert exact_share(edge, 4.7e-3, 5.3e-3) == pytest.approx(0.5, abs=0.05)


def test_a_share_that_is_not_reached_states_the_largest_one():
    found = ev.design(
        STATIC,
        want=MEAN,
        band=("4.7 mN", 5.3e-3),
        free="drive.amplitude",
        space=THICKNESS,
        share=0.9,
        seed=3,
        n=500,
    )
    assert found.found is None
    assert not found.is_achieved
    assert math.isnan(found.value)
    assert found.scenario is None
    assert 0.6 < found.top.share < 0.8
    assert "is not reached for 90 % of the population: the largest share is" in found.lines[0]


def test_nothing_reached_in_the_range():
    found = at_least(0.5, between="1 V:10 V", n=50)
    assert (found.found, found.top, found.check) == (None, None, None)
    assert found.lines[0].startswith(
        "No draw has a mean electrostatic force of at least 5 mN for drive.amplitude"
    )


def test_the_range_ends_the_share():
    exact = voltage(WANT, quantile(0.5))
    found = at_least(0.9, between=(10.0, exact), n=500)
    assert found.found is None
    assert found.top.value == pytest.approx(exact)
    assert found.top.share == pytest.approx(0.5, abs=0.07)


def test_too_few_draws_leave_an_end_open():
    found = at_least(0.99, n=50)
    assert math.isinf(found.value_interval[1])
    assert "no bound (too few draws)" in found.lines[1]


@pytest.mark.parametrize(("low", "high"), [(WANT, math.inf), (4e-3, 6e-3)])
def test_the_gain_of_each_finger_gives_what_the_general_solution_gives(low, high):
    wanted = read_wanted(STATIC, want={MEAN: low}, free="drive.amplitude", between=(50.0, 200.0))
    draws = ev.read_space(STATIC, THICKNESS).draw(4, 0, 6)
    fingers = DrawnFingers(STATIC, wanted, draws)
    assert fingers.is_quadratic()
    quick, general = by_gain(fingers, low, high), by_solution(fingers, low, high)
    np.testing.assert_array_equal(quick.members, general.members)
    np.testing.assert_allclose(quick.starts, general.starts, rtol=1e-7)
    np.testing.assert_allclose(quick.ends, general.ends, rtol=1e-7)


@pytest.mark.parametrize("quantity", [MEAN, "swing lateral_force"])
@pytest.mark.parametrize("name", ["bau_2010/sine", "meyer_2013/first_order"])
@pytest.mark.parametrize(("free", "at"), [("drive.amplitude", 80.0), ("drive.frequency", 200.0)])
def test_quantities_in_arrays_are_those_of_the_general_solution(monkeypatch, name, quantity, free, at):
    scenario = ev.load(name)
    wanted = read_wanted(scenario, want={quantity: 1e-3}, free=free)
    fingers = DrawnFingers(scenario, wanted, ev.read_space(scenario, "fingers").draw(1, 0, 40))
    expected = [fingers.one_at(finger, at) for finger in fingers.some()]
    monkeypatch.setattr(DrawnFingers, "one_at", None)  # none by itself
    np.testing.assert_allclose(fingers.each_at(at)[fingers.some()], expected, rtol=1e-9)


def test_intervals_from_arrays_are_those_of_the_general_solution(monkeypatch):
    scenario = ev.load("bau_2010/sine")
    wanted = read_wanted(scenario, want={MEAN: 5e-3}, free="stack.insulator.thickness", between=(1e-6, 2e-5))
    fingers = DrawnFingers(scenario, wanted, ev.read_space(scenario, "fingers").draw(1, 0, 33))
    seen = []
    quick = by_solution(fingers, 5e-3, math.inf, progress=lambda *at: seen.append(at))
    assert seen == sorted(seen)
    monkeypatch.setattr(DrawnFingers, "together_at", lambda *_, **__: None)
    general = by_solution(fingers, 5e-3, math.inf)
    assert len(general.members) > 10
    np.testing.assert_array_equal(quick.members, general.members)
    np.testing.assert_allclose(quick.ends, general.ends, rtol=1e-8)


def test_a_parameter_that_is_not_quadratic_is_solved_in_general():
    """The gap is largest at V sqrt(eps0 A/(4 F)) - T/eps, so thick films need a small gap."""
    found = ev.design(
        STATIC,
        want=f"{MEAN} = 0.5 mN",
        free="stack.gap.thickness",
        between="10 um:1 mm",
        space=THICKNESS,
        share=0.9,
        seed=3,
        n=20,
    )
    thicknesses = np.sort(ev.read_space(STATIC, THICKNESS).draw(3, 0, 20)["stack.insulator.thickness"])
    expected = 100 * math.sqrt(eps0 * AREA / (4 * 0.5e-3)) - thicknesses[17] / PERMITTIVITY
    assert found.value == pytest.approx(expected, rel=1e-6)
    assert found.ranges[0] == (pytest.approx(10e-6), pytest.approx(expected, rel=1e-6))
    assert "Brent" in found.lines[-1]


def test_a_drive_with_an_offset_is_not_quadratic_in_its_amplitude():
    wanted = read_wanted(STATIC, want={MEAN: 1e-3}, free="drive.amplitude", between=(10.0, 500.0))
    draws = ev.read_space(STATIC, THICKNESS).draw(1, 0, 3)
    assert not DrawnFingers(STATIC.replace({"drive.offset": 50.0}), wanted, draws).is_quadratic()


def test_limits_are_compared_and_the_share_within_them_is_stated():
    exact = voltage(WANT, quantile(0.3))
    found = at_least(0.9, limits={"voltage": exact}, n=300)
    assert not found.is_achieved
    assert [row.quantity for row in found.failed] == ["peak voltage"]
    assert found.within.value == pytest.approx(exact, rel=1e-5)
    assert found.within.value <= exact
    assert found.within.share == pytest.approx(0.3, abs=0.06)
    text = "\n".join(found.lines)
    assert "It exceeds the limits: peak voltage" in text
    assert "Within the limits" in text
    held = at_least(0.9, limits={"voltage": 150.0}, n=100)
    assert held.is_achieved
    assert held.scenario.drive.amplitude == held.value


def test_limits_hold_for_the_draws_with_the_largest_quantity():
    """The current of the thinnest film is above that of the scenario as it is."""
    found = at_least(0.9, n=200)
    value = found.value
    nominal = ev.check(None, STATIC.replace({"drive.amplitude": value})).value("peak current")
    held = at_least(0.9, n=200, limits={"current": 1.001 * nominal})
    assert [row.quantity for row in held.failed] == ["peak current"]


def test_the_same_seed_gives_the_same_and_another_one_another_result():
    first, again, other = (at_least(n=50, seed=seed).value for seed in (1, 1, 2))
    assert first == again != other


def test_sample_intervals_by_brute_force():
    """Share over the variable against counting, for random intervals with shared ends."""
    random = np.random.default_rng(5)
    for _ in range(20):
        starts = random.integers(0, 12, 15).astype(float)
        ends = starts + random.integers(0, 6, 15)
        covered = Covered(starts, ends, np.arange(15), 20)
        grid = np.arange(-1, 20, 0.25)
        counts = np.array([covered.number_at(at) for at in grid])
        value, most = covered.best()
        assert most == counts.max() == covered.number_at(value)
        for least in range(1, 16):
            inside = np.zeros(len(grid), bool)
            for start, end in covered.where(least):
                inside |= (start <= grid) & (grid <= end)
            np.testing.assert_array_equal(inside, counts >= least)


def test_resampled_members_keep_all_their_intervals():
    covered = Covered(np.array([0.0, 5.0, 1.0]), np.array([1.0, 6.0, 2.0]), np.array([0, 0, 2]), 3)
    again = covered.resampled(np.array([0, 0, 1]))
    assert sorted(again.starts) == [0, 0, 5, 5]
    assert again.count == 3


def test_intervals_of_a_function_that_enters_and_leaves_the_band():
    found = inside_band(lambda x: (x - 3) ** 2, np.linspace(0, 6, 13), 1.0, 4.0)
    assert np.ravel(found) == pytest.approx([1, 2, 4, 5], rel=1e-7)
    whole = inside_band(lambda x: x, np.linspace(1, 2, 5), 0.0, math.inf)
    assert whole == [(1.0, 2.0)]
    assert inside_band(lambda x: x, np.linspace(1, 2, 5), 3.0, math.inf) == []


def test_clopper_pearson_covers_at_least_nominally_and_has_its_closed_forms():
    assert clopper_pearson(0, 10) == (0.0, pytest.approx(1 - 0.025**0.1))
    assert clopper_pearson(10, 10) == (pytest.approx(0.025**0.1), 1.0)
    low, high = clopper_pearson(7, 20)
    assert beta.cdf(low, 7, 14) == pytest.approx(0.025)
    assert 1 - beta.cdf(high, 8, 13) == pytest.approx(0.025)


@pytest.mark.parametrize(("share", "count"), [(0.9, 100), (0.5, 30), (0.1, 200)])
def test_order_statistics_cover_the_quantile_in_at_least_95_of_100(share, count):
    low, high = quantile_ranks(share, count)
    random = np.random.default_rng(1)
    samples = np.sort(random.random((4000, count)), axis=1)
    ends = [
        samples[:, low - 1] if low > 0 else np.zeros(len(samples)),
        samples[:, high - 1] if high <= count else np.ones(len(samples)),
    ]
    covered = np.mean((ends[0] <= share) & (share <= ends[1]))
    assert 0.94 < covered < 0.995
    assert binom.cdf(high - 1, count, share) >= 0.975 > binom.cdf(high - 2, count, share)
    assert binom.cdf(low - 1, count, share) < 0.025 <= binom.cdf(low, count, share)


@pytest.mark.parametrize(
    ("share", "count", "expected"), [(0.9, 100, 90), (0.9, 101, 91), (0.001, 100, 1), (0.3, 10, 3)]
)
def test_number_of_draws_for_a_share(share, count, expected):
    assert needed(share, count) == expected


GIVEN = {"want": f"{MEAN} = 5 mN", "free": "drive.amplitude", "space": THICKNESS, "share": 0.9, "seed": 1}
WRONG = {
    "seed": ({"seed": None}, "seed"),
    "space": ({"space": None}, "space"),
    "share of 1": ({"share": 1.0}, r"share = 1\.0: expected a number above 0 and below 1"),
    "share in per cent": ({"share": 90}, "share = 90"),
    "free in the space": ({"free": "stack.insulator.thickness"}, "differs between the fingers of the space"),
    "few draws": ({"n": 5}, "n = 5: expected a whole number of draws, 20 or more"),
    "band and value": ({"band": "1 mN:2 mN"}, "with a band, name the quantity alone"),
    "band reversed": ({"want": MEAN, "band": "2 mN:1 mN"}, "the smaller value first"),
    "band of one": ({"want": MEAN, "band": "2 mN"}, "expected LOW:HIGH"),
    "no value": ({"want": MEAN}, "expected one quantity and its value"),
    "band unit": ({"want": MEAN, "band": "2 V:3 V"}, "electrostatic_force"),
    "quantity": ({"want": "mean electrostatic_farce = 1 mN"}, "electrostatic_farce"),
    "linear": ({"linear": True}, "linear: does not belong"),
    "limits": ({"limits": {"voltage": -1.0}}, "limits.voltage"),
}  # fmt: skip


@pytest.mark.parametrize("wrong", WRONG)
def test_mistakes_are_refused(wrong):
    changed, words = WRONG[wrong]
    with pytest.raises(InputError, match=words):
        ev.design(STATIC, **{key: each for key, each in (GIVEN | changed).items() if each is not None})


def test_all_mistakes_are_reported_at_once():
    with pytest.raises(InputError) as caught:
        ev.design(STATIC, **GIVEN | {"share": 2.0, "n": 1, "seed": -1, "space": "nobody"})
    assert len(caught.value.problems) == 4


SPACES = {
    "thickness": THICKNESS,
    "two": {**THICKNESS, "stack.gap.thickness": {"model": "Uniform", "low": "10 um", "high": "30 um"}},
}


@pytest.mark.parametrize(("space", "kind"), list(itertools.product(SPACES, ["at least", "band"])))
def test_combinations_reach_the_share_among_brute_force_draws(space, kind):
    """Every combination: the share at the value among many draws in closed form is in the interval that is stated."""
    band = {} if kind == "at least" else {"band": (2e-3, 9e-3)}
    found = ev.design(
        STATIC,
        want=f"{MEAN} = 2 mN" if kind == "at least" else MEAN,
        free="drive.amplitude",
        space=SPACES[space],
        share=0.8,
        seed=7,
        n=400,
        **band,
    )
    draws = ev.read_space(STATIC, SPACES[space]).draw(99, 0, 100_000)
    gap = draws.get("stack.gap.thickness", GAP)
    forces = eps0 * AREA * (found.value / (draws["stack.insulator.thickness"] / PERMITTIVITY + gap)) ** 2 / 4
    inside = (forces >= 2e-3) & (forces <= (math.inf if kind == "at least" else 9e-3))
    low, high = found.found.interval
    assert low <= np.mean(inside) <= high
    assert found.is_achieved


def test_the_command_prints_the_answer_and_writes(tmp_path):
    (tmp_path / "space.toml").write_text(
        '[space]\n"stack.insulator.thickness" = { model = "LogNormal", median = "1 um", factor = 1.5 }\n',
        encoding="utf-8",
    )
    out = tmp_path / "found.json"
    arguments = [
        "design",
        "bau_2010/sine",
        "--want",
        f"{MEAN} = 20mN:400mN",
        "--free",
        "drive.amplitude",
    ]
    arguments += [
        "--space",
        str(tmp_path / "space.toml"),
        "--share",
        "0.8",
        "--seed",
        "1",
        "-n",
        "50",
        "-o",
        str(out),
    ]
    done = CliRunner().invoke(app, arguments)
    assert done.exit_code == 0, done.output
    assert "of the draws; wanted: 80 %" in " ".join(done.output.split())
    table = json.loads(out.read_text(encoding="utf-8"))
    assert table["share"] == 0.8
    assert table["found"]["share"] >= 0.8
    failed = CliRunner().invoke(app, [*arguments[:-2], "--free", "drive.amplitude=1V:2V"])
    assert failed.exit_code == 1


def test_an_end_of_the_search_is_not_given_as_an_end_of_the_answer():
    """At least a force is reached by every larger voltage: the upper end is that of the range that was searched."""
    reached = at_least(n=50).lines[1].partition("The share is reached from ")[2]
    assert reached.endswith(" V to the end of the searched range, 100 kV.")
    inside = ev.design(
        STATIC,
        want=MEAN,
        free="drive.amplitude",
        space=THICKNESS,
        share=0.5,
        band="5 mN:50 mN",
        n=50,
        seed=3,
    ).lines[1]
    assert "reached from" in inside
    assert "end of the searched" not in inside
    least = at_least(n=50, between=("1 kV", "2 kV")).lines[1]
    assert "reached from the beginning of the searched range, 1 kV to the end" in least


def test_limits_that_cannot_be_compared_are_told(monkeypatch):
    def refused(*_, **__):
        msg = "drive: cannot be checked"
        raise InputError(msg)

    monkeypatch.setattr(share, "checked", refused)
    found = at_least(0.5, n=20)
    assert found.check is None
    assert "The limits could not be compared: drive: cannot be checked" in found.verdict
    assert found.to_dict()["limits"] is None


def test_of_equal_shares_within_the_limits_the_value_nearest_to_the_one_that_was_found_is_stated():
    """No draw has 5 mN at 95 V; of all values with this share the last one within the limit is stated."""
    found = at_least(0.9, n=100, limits={"voltage": 95.0})
    assert found.within.share == 0
    assert found.within.value == pytest.approx(95.0, rel=1e-9)
    assert found.within.value <= 95
    assert "\n".join(found.lines) == str(found)
