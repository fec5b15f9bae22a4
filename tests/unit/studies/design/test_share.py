"""Value of a parameter for a share of a population, against exact quantiles of static laws."""

import math

import numpy as np
import pytest
from scipy.stats import beta, binom, norm

import electrovib as ev
from electrovib.core.constants import eps0
from electrovib.core.errors import InputError
from electrovib.studies.design.search import inside_band
from electrovib.studies.design.share import function as share
from electrovib.studies.design.share.result import Covered, DrawnFingers, by_gain, by_solution, needed_draws
from electrovib.studies.design.wanted import read_wanted
from electrovib.studies.widths import clopper_pearson, quantile_ranks

PERMITTIVITY, GAP, AREA, MEDIAN, FACTOR = 3.0, 20e-6, 1e-4, 5e-6, 1.5
PATH, VOLTS, MEAN = "stack.insulator.thickness", "drive.amplitude", "mean electrostatic_force"
MATERIAL = {"model": "Constant", "permittivity": PERMITTIVITY}
INSULATOR = {"thickness": MEDIAN, "material": MATERIAL, "breakdown_field": 1e9}
GROUNDED = {"circuit.return_path": {"model": "Grounded", "resistance": 0.0}}
STATIC = ev.load(
    "bau_2010/sine", changes={"stack": {"insulator": INSULATOR, "gap": {"thickness": GAP}}} | GROUNDED
)
THICKNESS = {PATH: {"model": "LogNormal", "median": MEDIAN, "factor": FACTOR}}
WANT, BAND = 5e-3, (4.7e-3, 5.3e-3)


def of_thickness(thickness):
    return norm.cdf(np.log(np.maximum(thickness, 1e-12) / MEDIAN) / math.log(FACTOR))


def quantile(share):
    """Thickness that a share of the fingers does not exceed."""
    return MEDIAN * FACTOR ** norm.ppf(share)


def voltage(force, thickness):
    """Amplitude at which eps0 A V^2/(4 (T/eps + g)^2) is a force."""
    return math.sqrt(4 * force / (eps0 * AREA)) * (thickness / PERMITTIVITY + GAP)


def thickest(value, force):
    """Thickness up to which an amplitude gives a force."""
    return PERMITTIVITY * (value / math.sqrt(4 * force / (eps0 * AREA)) - GAP)


def drawn(seed, first, last):
    return ev.read_space(STATIC, THICKNESS).draw(seed, first, last)[PATH]


def at_least(share=0.9, **options):
    given = {"want": f"{MEAN} = 5 mN", "free": VOLTS, "space": THICKNESS, "seed": 3}
    return ev.value_for_share(STATIC, share=share, **given | options)


def within(band, share, **options):
    return at_least(share, want={MEAN: band}, **options)


@pytest.mark.parametrize("share", [0.1, 0.5, 0.9])
def test_the_interval_holds_the_exact_quantile_of_a_log_normal_thickness(share):
    found = at_least(share, n=2000)
    exact = voltage(WANT, quantile(share))
    low, high = found.value_interval
    assert low < found.value < high
    assert low < exact < high
    assert found.value == pytest.approx(exact, rel=5e-3)
    assert found.found.share == pytest.approx(share, abs=1e-3)
    assert found.found.interval[0] < of_thickness(thickest(found.value, WANT)) < found.found.interval[1]


def test_the_value_is_the_order_statistic_of_the_draws_and_further_draws_confirm_the_share():
    found = at_least(0.9, n=100)
    thicknesses = np.sort(drawn(3, 0, 100))
    assert found.value == pytest.approx(voltage(WANT, thicknesses[89]), rel=1e-9)
    assert found.ranges == ((pytest.approx(found.value), 1e5),)
    expected = [voltage(WANT, thicknesses[rank - 1]) for rank in quantile_ranks(0.9, 100)]
    assert found.value_interval == pytest.approx(expected, rel=1e-9)
    number = int(np.count_nonzero(voltage(WANT, drawn(3, 100, 200)) <= found.value))
    assert (found.found.fresh_share, found.found.interval) == (number / 100, clopper_pearson(number, 100))
    again, other = (at_least(0.9, n=100, seed=seed).value for seed in (3, 2))
    assert found.value == again != other


def exact_share(value):
    """Share of the thicknesses with which the force lies in the band at an amplitude."""
    return of_thickness(thickest(value, BAND[0])) - of_thickness(thickest(value, BAND[1]))


def test_the_largest_share_of_a_band_against_the_exact_one():
    found = within("4.7 mN:5.3 mN", 0.5, n=2000)
    amplitudes = np.linspace(90, 120, 3001)
    exact = exact_share(amplitudes)
    low, high = found.value_interval
    assert low < amplitudes[np.argmax(exact)] < high
    assert found.found.share == pytest.approx(np.max(exact), abs=0.04)
    assert found.found.interval[0] < exact_share(found.value) < found.found.interval[1]
    for edge in found.ranges[0]:
        assert exact_share(edge) == pytest.approx(0.5, abs=0.05)


def test_a_share_that_is_not_reached_states_the_largest_one():
    found = within(("4.7 mN", 5.3e-3), 0.9, n=500)
    assert (found.found, found.scenario, found.is_achieved) == (None, None, False)
    assert math.isnan(found.value)
    assert 0.6 < found.top.share < 0.8
    assert "is not reached for 90 % of the population: the largest share is" in found.document.sentences[0]
    exact = voltage(WANT, quantile(0.5))
    found = at_least(0.9, free={VOLTS: (10.0, exact)}, n=500)
    assert found.found is None
    assert found.top.value == pytest.approx(exact)
    assert found.top.share == pytest.approx(0.5, abs=0.07)
    found = at_least(0.5, free=f"{VOLTS}=1 V:10 V", n=50)
    assert (found.found, found.top, found.check) == (None, None, None)
    assert found.document.sentences[0].startswith(
        "No draw has a mean electrostatic force of at least 5 mN for drive.amplitude"
    )


def test_an_open_end_and_an_end_of_the_search_are_not_given_as_an_end_of_the_answer():
    """At least a force is reached by every larger voltage: the upper end is that of the range that was searched."""
    found = at_least(0.99, n=50)
    assert math.isinf(found.value_interval[1])
    assert "no bound (too few draws)" in found.document.sentences[1]
    reached = at_least(n=50).document.sentences[1].partition("The share is reached from ")[2]
    assert reached.endswith(" V to the end of the searched range, 100 kV.")
    inside = within("5 mN:50 mN", 0.5, n=50).document.sentences[1]
    assert "reached from" in inside
    assert "end of the searched" not in inside
    least = at_least(n=50, free={VOLTS: ("1 kV", "2 kV")}).document.sentences[1]
    assert "reached from the beginning of the searched range, 1 kV to the end" in least


@pytest.mark.parametrize(("low", "high"), [(WANT, math.inf), (4e-3, 6e-3)])
def test_the_gain_of_each_finger_gives_what_the_general_solution_gives(low, high):
    wanted = read_wanted(STATIC, want={MEAN: low}, free={VOLTS: (50.0, 200.0)})
    draws = ev.read_space(STATIC, THICKNESS).draw(4, 0, 6)
    fingers = DrawnFingers(STATIC, wanted, draws)
    assert fingers.is_quadratic()
    assert not DrawnFingers(STATIC.replace({"drive.offset": 50.0}), wanted, draws).is_quadratic()
    quick, general = by_gain(fingers, low, high), by_solution(fingers, low, high)
    np.testing.assert_array_equal(quick.members, general.members)
    np.testing.assert_allclose(quick.starts, general.starts, rtol=1e-7)
    np.testing.assert_allclose(quick.ends, general.ends, rtol=1e-7)


@pytest.mark.parametrize("quantity", [MEAN, "swing lateral_force"])
@pytest.mark.parametrize("name", ["bau_2010/sine", "meyer_2013/first_order"])
@pytest.mark.parametrize(("free", "at"), [(VOLTS, 80.0), ("drive.frequency", 200.0)])
def test_quantities_in_arrays_are_those_of_the_general_solution(monkeypatch, name, quantity, free, at):
    scenario = ev.load(name)
    wanted = read_wanted(scenario, want={quantity: 1e-3}, free=free)
    fingers = DrawnFingers(scenario, wanted, ev.read_space(scenario, "fingers").draw(1, 0, 40))
    expected = [fingers.one_at(finger, at) for finger in fingers.some()]
    monkeypatch.setattr(DrawnFingers, "one_at", None)  # none by itself
    np.testing.assert_allclose(fingers.each_at(at)[fingers.some()], expected, rtol=1e-9)


@pytest.mark.slow
def test_intervals_from_arrays_are_those_of_the_general_solution(monkeypatch):
    scenario = ev.load("bau_2010/sine")
    wanted = read_wanted(scenario, want={MEAN: 5e-3}, free={PATH: (1e-6, 2e-5)})
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
    found = at_least(want=f"{MEAN} = 0.5 mN", free="stack.gap.thickness = 10 um:1 mm", n=20)
    thickness = np.sort(drawn(3, 0, 20))[17]
    expected = 100 * math.sqrt(eps0 * AREA / (4 * 0.5e-3)) - thickness / PERMITTIVITY
    assert found.value == pytest.approx(expected, rel=1e-6)
    assert found.ranges[0] == (pytest.approx(10e-6), pytest.approx(expected, rel=1e-6))
    assert "Brent" in found.document.remarks[-1]


def test_limits_are_compared_and_the_share_within_them_is_stated():
    exact = voltage(WANT, quantile(0.3))
    found = at_least(0.9, limits={"voltage": exact}, n=300)
    assert not found.is_achieved
    assert [row.quantity for row in found.failed] == ["peak voltage"]
    assert found.within.value == pytest.approx(exact, rel=1e-5)
    assert found.within.value <= exact
    assert found.within.share == pytest.approx(0.3, abs=0.06)
    text = found.document.shown(everything=True)
    assert text.startswith(str(found))
    assert "It exceeds the limits: peak voltage" in text
    assert "Within the limits" in text
    held = at_least(0.9, limits={"voltage": 150.0}, n=100)
    assert held.is_achieved
    assert held.scenario.drive.amplitude == held.value
    none = at_least(0.9, n=100, limits={"voltage": 95.0}).within
    assert none.share == 0, "of equal shares the value nearest to the one that was found is stated"
    assert none.value == pytest.approx(95.0, rel=1e-9)
    assert none.value <= 95


def test_limits_hold_for_the_draws_with_the_largest_quantity_and_where_not_compared_are_told(monkeypatch):
    """The current of the thinnest film is above that of the scenario as it is."""
    value = at_least(0.9, n=200).value
    nominal = ev.check(None, STATIC.replace({VOLTS: value})).value("peak current")
    held = at_least(0.9, n=200, limits={"current": 1.001 * nominal})
    assert [row.quantity for row in held.failed] == ["peak current"]

    def refused(*_, **__):
        raise InputError("drive: cannot be checked")

    monkeypatch.setattr(share, "checked", refused)
    found = at_least(0.5, n=20)
    assert found.check is None
    assert "The limits could not be compared: drive: cannot be checked" in found.document.sentences
    assert found.to_dict()["limits"] is None


def test_sample_intervals_by_brute_force():
    """Share over the variable against counting, for random intervals with shared ends."""
    random = np.random.default_rng(5)
    for _ in range(20):
        starts = random.integers(0, 12, 15).astype(float)
        covered = Covered(starts, starts + random.integers(0, 6, 15), np.arange(15), 20)
        grid = np.arange(-1, 20, 0.25)
        counts = np.array([covered.number_at(at) for at in grid])
        value, most = covered.best()
        assert most == counts.max() == covered.number_at(value)
        for least in range(1, 16):
            inside = np.zeros(len(grid), bool)
            for start, end in covered.where(least):
                inside |= (start <= grid) & (grid <= end)
            np.testing.assert_array_equal(inside, counts >= least)
    several = Covered(np.array([0.0, 5.0, 1.0]), np.array([1.0, 6.0, 2.0]), np.array([0, 0, 2]), 3)
    again = several.resampled(np.array([0, 0, 1]))
    assert (sorted(again.starts), again.count) == ([0, 0, 5, 5], 3), "a member keeps all its intervals"


def test_intervals_of_a_function_that_enters_and_leaves_the_band():
    found = inside_band(lambda x: (x - 3) ** 2, np.linspace(0, 6, 13), 1.0, 4.0)
    assert np.ravel(found) == pytest.approx([1, 2, 4, 5], rel=1e-7)
    assert inside_band(lambda x: x, np.linspace(1, 2, 5), 0.0, math.inf) == [(1.0, 2.0)]
    assert inside_band(lambda x: x, np.linspace(1, 2, 5), 3.0, math.inf) == []


def test_clopper_pearson_and_the_number_of_draws_have_their_closed_forms():
    assert clopper_pearson(0, 10) == (0.0, pytest.approx(1 - 0.025**0.1))
    assert clopper_pearson(10, 10) == (pytest.approx(0.025**0.1), 1.0)
    low, high = clopper_pearson(7, 20)
    assert beta.cdf(low, 7, 14) == pytest.approx(0.025)
    assert 1 - beta.cdf(high, 8, 13) == pytest.approx(0.025)
    asked = ((0.9, 100), (0.9, 101), (0.001, 100), (0.3, 10))
    assert [needed_draws(share, count) for share, count in asked] == [90, 91, 1, 3]


@pytest.mark.parametrize(("share", "count"), [(0.9, 100), (0.5, 30), (0.1, 200)])
def test_order_statistics_cover_the_quantile_in_at_least_95_of_100(share, count):
    low, high = quantile_ranks(share, count)
    samples = np.sort(np.random.default_rng(1).random((4000, count)), axis=1)
    bounded = np.pad(samples, ((0, 0), (1, 1)), constant_values=(0.0, 1.0))
    covered = np.mean((bounded[:, low] <= share) & (share <= bounded[:, high]))
    assert 0.94 < covered < 0.995
    assert binom.cdf(high - 1, count, share) >= 0.975 > binom.cdf(high - 2, count, share)
    assert binom.cdf(low - 1, count, share) < 0.025 <= binom.cdf(low, count, share)


WRONG = {
    "seed": ({"seed": None}, "seed"),
    "space": ({"space": None}, "space"),
    "share of 1": ({"share": 1.0}, r"share = 1\.0: expected a number above 0 and below 1"),
    "share in per cent": ({"share": 90}, "share = 90"),
    "free in the space": ({"free": PATH}, "differs between the fingers of the space"),
    "few draws": ({"n": 5}, "n = 5: expected a whole number of draws, 20 or more"),
    "band reversed": ({"want": f"{MEAN} = 2 mN:1 mN"}, "= 2 mN:1 mN: expected LOW:HIGH"),
    "band of none": ({"want": {MEAN: []}}, "expected LOW:HIGH, for instance '20 mN:60 mN'"),
    "band of three": ({"want": {MEAN: (1, 2, 3)}}, "expected LOW:HIGH, for instance '20 mN:60 mN'"),
    "no value": ({"want": MEAN}, "expected one quantity and its value"),
    "band unit": ({"want": f"{MEAN} = 2 V:3 V"}, "electrostatic_force = 2 V: expected a force"),
    "quantity": ({"want": "mean electrostatic_farce = 1 mN"}, "electrostatic_farce"),
    "limits": ({"limits": {"voltage": -1.0}}, "limits.voltage"),
    "four at once": ({"share": 2.0, "n": 1, "seed": -1, "space": "nobody"}, "nobody"),
}


@pytest.mark.parametrize("wrong", WRONG)
def test_mistakes_are_refused(wrong):
    changed, words = WRONG[wrong]
    with pytest.raises(InputError, match=words) as caught:
        at_least(**changed)
    assert len(caught.value.problems) == len(changed) or wrong != "four at once"


SPACES = {
    "thickness": THICKNESS,
    "two": {**THICKNESS, "stack.gap.thickness": {"model": "Uniform", "low": "10 um", "high": "30 um"}},
}


@pytest.mark.parametrize("space", SPACES)
@pytest.mark.parametrize("high", [math.inf, 9e-3], ids=["at least", "band"])
def test_combinations_reach_the_share_among_brute_force_draws(space, high):
    """Every combination: the share at the value among many draws in closed form is in the interval that is stated."""
    want = f"{MEAN} = 2 mN" if math.isinf(high) else {MEAN: (2e-3, high)}
    found = at_least(0.8, space=SPACES[space], seed=7, n=400, want=want)
    draws = ev.read_space(STATIC, SPACES[space]).draw(99, 0, 100_000)
    gap = draws.get("stack.gap.thickness", GAP)
    forces = eps0 * AREA * (found.value / (draws[PATH] / PERMITTIVITY + gap)) ** 2 / 4
    low, most = found.found.interval
    assert low <= np.mean((forces >= 2e-3) & (forces <= high)) <= most
    assert found.is_achieved
