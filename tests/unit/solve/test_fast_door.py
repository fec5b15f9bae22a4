"""The fast methods behind the public functions agree with the readable ones, and compute each part once."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from plain_recursion import march_loop

import electrovib as ev
from electrovib.core.errors import InputError
from electrovib.physics.drive.parts import TOGETHER, Linear, Tones, cosine_and_sine
from electrovib.solve.diagnostics import memory, peaks
from electrovib.solve.diagnostics import probes as at_probes
from electrovib.solve.diagnostics.peaks import MOST_CORNERS
from electrovib.solve.electrics import straight
from electrovib.solve.electrics.fading import FEW_TIMES, fading
from electrovib.solve.electrics.straight import SharedModes
from electrovib.solve.electrics.transient import transient
from electrovib.solve.recursion import March, blocks, march, states_at, uneven
from electrovib.solve.stack.transfer import Transfer


def largest(values):
    return np.max(np.abs(values))


@settings(max_examples=60, deadline=None)
@given(
    count=st.integers(1, 1000),
    seed=st.integers(0, 1000),
    jitter=st.sampled_from([0.0, 0.2, 0.49]),
    jump=st.booleans(),
    span=st.sampled_from([(0.05, 3e7), (1e4, 1e5), (1e6, 1e9)]),
    every=st.sampled_from([1, 7, 300]),
)
def test_values_lags_and_states_of_a_march_are_those_of_the_loop(count, seed, jitter, jump, span, every):
    rng = np.random.default_rng(seed)
    steps = 1e-6 * (1 + rng.uniform(-jitter, jitter, count)) if jitter else 1e-6
    values = np.cumsum(rng.normal(size=count + 1))
    starts, ends = values[:-1].copy(), values[1:].copy()
    if jump:
        starts[count // 3 :] += 30.0
        ends[count // 3 :] += 30.0
        ends[-1] += 7.0
    poles, gains, rest = -np.geomspace(*span, 9), rng.normal(size=(3, 9)), rng.normal(size=9)
    drive, lag = (starts, ends, steps, rest), np.array([False, True, False])
    scale = 1e-11 * largest(np.concatenate([starts, ends, rest]))
    found, state = march(poles, gains, [0.3, -2.0, 0.0], *drive, lag=lag)
    expected, last = march_loop(poles, gains, [0.3, -2.0, 0.0], *drive, lag=lag)
    assert largest(found - expected) < scale
    assert largest(state - last) < scale
    places = np.unique(np.append(np.arange(0, count + 1, every), [count // 3, count]))
    each = march_loop(poles, np.eye(9), np.zeros(9), *drive)[0][:, places]
    assert largest(states_at(poles, *drive, places) - each) < scale


def test_lags_that_decay_before_the_next_place_are_not_missed(monkeypatch):
    """Of places far apart, of which each needs only slow modes for most of the way, as of all places."""
    pytest.importorskip("numba")
    monkeypatch.setattr(uneven, "_WORTH", 1)
    monkeypatch.setattr(uneven, "PRODUCT", 4000)
    rng = np.random.default_rng(6)
    steps, volts = 1e-6 * (1 + rng.uniform(-0.3, 0.3, 3000)), rng.normal(size=3001)
    drive = -np.geomspace(10, 1e8, 15), volts[:-1], volts[1:], steps, rng.normal(size=15)
    places = np.array([0, 3, 900, 1777, 1778, 3000])
    every = states_at(*drive, np.arange(3001))
    assert largest(states_at(*drive, places) - every[:, places]) < 1e-14


@pytest.mark.parametrize("worth", [1, 10**12])
def test_many_slow_modes_follow_from_a_few(worth, monkeypatch):
    """Also over discontinuities, a long pause, and between points that are close together or far apart."""
    monkeypatch.setattr(uneven, "_WORTH", worth)
    rng, count = np.random.default_rng(7), 40_000
    steps, volts = 1e-6 * (1 + rng.uniform(-0.3, 0.3, count)), np.cumsum(rng.normal(size=count + 1))
    steps[7000] = 1e-4
    starts, ends = volts[:-1].copy(), volts[1:].copy()
    starts[9000:] += 50.0
    ends[9000:] += 50.0
    poles = rng.permutation(-np.geomspace(1e-3, 1e7, 60))
    given_ = poles, starts, ends, steps, rng.normal(size=60), np.array([0, 1, 700, 9000, 9001, 30_000, count])
    found = states_at(*given_)
    monkeypatch.setattr(uneven, "_LEAST", count)
    each = states_at(*given_)
    assert np.max(np.abs(found - each) / np.max(np.abs(each), axis=1, keepdims=True)) < 1e-12
    assert not np.array_equal(found, each)


@pytest.mark.parametrize("jitter", [0.0, 0.4])
@pytest.mark.parametrize("jump", [0.0, 3.0])
@pytest.mark.parametrize("cuts", [[0, 320, 999, 1000], [0, 7, 8, 500, 1000]])
def test_a_record_in_parts_has_the_outputs_of_the_whole(jitter, jump, cuts):
    """A drop of the drive between two parts counts once, and a small lag is carried on without a difference of large numbers."""
    rng = np.random.default_rng(5)
    drive = 1e6 + np.cumsum(rng.normal(size=1001))
    starts, ends = drive[:-1] + jump * rng.normal(size=1000), drive[1:]
    steps = 1e-5 * (1 + rng.uniform(-jitter, jitter, 1000)) if jitter else 1e-5
    poles, lag = -np.geomspace(1.0, 1e9, 9), np.array([False, True])
    gains = rng.normal(size=(2, 9)) * np.array([np.ones(9), poles < -1e6])
    given_ = poles, gains, [0.3, 0.0], starts, ends, steps, np.full(9, starts[0])
    whole, state = march(*given_, lag=lag)
    one = March(*given_, lag=lag)
    parts, states = zip(*((one.through(slice(*cut)), one.state) for cut in pairwise(cuts)), strict=True)
    found = np.concatenate(parts, axis=1)
    scale = np.max(np.abs(whole), axis=1, keepdims=True)
    assert largest((found - whole) / scale) < 1e-13
    assert largest(one.state - state) < 1e-13 * largest(state)
    at_cuts = states_at(poles, *given_[3:], np.array(cuts[1:]))
    assert largest(np.array(states).T - at_cuts) < 1e-13 * largest(at_cuts)


@pytest.mark.parametrize("steps", [1e-6, None])
def test_a_drive_that_jumps_everywhere_is_followed_from_stretch_to_stretch(steps, monkeypatch):
    monkeypatch.setattr(blocks, "_HELD", 1)
    monkeypatch.setattr(uneven, "PRODUCT", 1)
    rng = np.random.default_rng(5)
    starts, ends = rng.normal(size=(2, 400))
    steps = rng.uniform(0.5e-6, 2e-6, 400) if steps is None else steps
    poles, gains, lag = -np.geomspace(1.0, 1e8, 8), rng.normal(size=(2, 8)), [True, False]
    given_ = (poles, gains, [1.0, 0.0], starts, ends, steps, np.zeros(8))
    assert largest(march(*given_, lag=lag)[0] - march_loop(*given_, lag=lag)[0]) < 1e-12


def test_a_lag_that_a_fast_mode_has_is_no_difference_of_two_large_numbers():
    """A ramp of 1e-9 V a step on 1e6 V: a mode lags behind by slope/rate, known to all digits."""
    rise = 2.0**-30
    values = 2.0**20 + rise * np.arange(101)
    found, _ = march([-1e9], [[1.0]], [0.0], values[:-1], values[1:], 1e-6, [values[0]], lag=True)
    assert found[0, -1] == pytest.approx(-rise / 1e-6 / 1e9, rel=1e-12)


@pytest.mark.parametrize("modes", [1, 40])
def test_what_fades_is_read_from_polynomials_to_rounding(modes):
    rng = np.random.default_rng(modes)
    rates, weights = np.append(0.0, 10 ** rng.uniform(-3, 9, modes)), rng.normal(size=(2, modes + 1))
    since = np.sort(np.concatenate([[0.0], 10 ** rng.uniform(-11, 1, 3000), np.linspace(0.1, 2, 30000)]))
    expected, size = weights @ np.exp(-np.outer(rates, since)), np.sum(np.abs(weights))
    assert largest(np.array(fading(weights, rates, since)) - expected) < 3e-14 * size
    # a direct sum of few, whose order depends on the processor
    few = np.array(fading(weights, rates, since[:FEW_TIMES]))
    assert largest(few - expected[:, :FEW_TIMES]) < 1e-15 * size
    alike = np.repeat([1e-3, 2e-3], 10 * FEW_TIMES)
    (found,) = fading(np.array([[2.0]]), np.array([500.0]), alike)
    np.testing.assert_allclose(found, 2 * np.exp(-500 * alike), rtol=1e-14)


@pytest.mark.parametrize("jitter", [0.0, 1e-5])
def test_a_tone_at_many_times_is_cosine_and_sine(jitter):
    times = np.linspace(0.3, 1.7, 30_001)
    times[1:-1] += np.random.default_rng(0).uniform(-jitter, jitter, len(times) - 2)
    cosine, sine = cosine_and_sine(250.0, times)
    phase = 2 * np.pi * 250 * times
    assert largest(cosine - np.cos(phase)) < 2e-12
    assert largest(sine - np.sin(phase)) < 2e-12


def test_tones_at_very_many_times_are_those_at_each():
    tones = Tones(np.array([0.0, 250.0]), np.array([3.0, 2 - 1j]))
    times = np.linspace(0, 1, 2 * TOGETHER + 5)
    each = [float(tones.value(np.array(moment))) for moment in times[:: TOGETHER // 2 - 1]]
    assert largest(tones.value(times)[:: TOGETHER // 2 - 1] - each) < 1e-11
    assert np.min(np.abs(tones.value(times))) > 0.5


def test_the_probes_are_judged_times():
    judged = np.ones(50_000, bool)
    judged[[0, 7, 300]] = False
    probes = memory._probes_among(judged)
    assert np.all(judged[probes])
    assert probes[-1] == len(judged) - 1


def test_few_long_pieces_at_very_many_uneven_times_are_what_each_time_says(monkeypatch):
    breaks, before, after = ([0.0, 0.1, 0.4, 1.0], [0.0, 5.0, -3.0, 1.0], [2.0, 5.0, 4.0, 1.0])
    part = Linear(np.array(breaks), np.array(before), np.array(after))
    times = np.sort(np.random.default_rng(3).uniform(0, 1.3, 60_000))
    rates, gains = np.geomspace(0.1, 1e6, 8), np.random.default_rng(4).normal(size=(2, 8))
    modes = SharedModes(rates, gains, np.array([0.5, 0.0]), np.array([False, True]))
    many = np.array(modes.straight(part, times, np.zeros(8)))
    monkeypatch.setattr(straight, "_LONG", 10**9)
    each = np.array(modes.straight(part, times, np.zeros(8)))
    assert largest(many - each) < 1e-12 * largest(each)


@pytest.mark.parametrize("lag", [True, False])
def test_at_a_jump_at_the_last_output_the_value_after_it_counts(lag):
    part = Linear(np.array([0.0, 1.0, 3.0]), np.array([0.0, 2.0, 4.0]), np.array([1.0, 2.0, -6.0]))
    modes = SharedModes(np.array([0.7, 20.0]), np.array([[2.0, -1.0]]), np.array([0.5]), np.array([lag]))
    marched = modes.straight(part, part.times, np.zeros(2))
    each = modes.straight(part, np.array([0.0, 1.0, 2.0, 3.0]), np.zeros(2))
    np.testing.assert_allclose(marched[0], each[0][[0, 1, 3]], rtol=1e-13)


STAMPS = np.array([float(f"{place}e-6") for place in range(12_000)])
VOLTS = np.round(100 * np.sin(2 * np.pi * 500e-6 * np.arange(12_000)), 2)


def measured(stamps=STAMPS):
    drive = {"model": "Sampled", "time_samples": stamps, "voltage_samples": VOLTS[: len(stamps)]}
    return ev.load("vezzoli_2014/fig6_gap").replace({"drive": drive})


@pytest.mark.parametrize("factor", [1.0, 1e-3])
@pytest.mark.parametrize("start", [0.0, 12.345678])
def test_stamps_written_as_decimal_numbers_are_even(factor, start):
    stamps = np.array([float(f"{(start + place * 1e-6) / factor:.9f}") for place in range(3000)]) * factor
    assert measured(stamps).drive.parts()[0].step == pytest.approx(1e-6, rel=1e-9)
    stamps[1500] += 1e-9
    assert measured(stamps).drive.parts()[0].step is None


def test_one_march_for_all_signals_of_a_measured_drive(monkeypatch):
    """Values and lags of one set of modes; the times between need states at few samples, and no recursion."""
    marches, states = [], []

    def march_counted(poles, gains, *more, **options):
        marches.append(np.shape(gains))
        return March(poles, gains, *more, **options)

    def states_counted(*given, **options):
        states.append(len(given[-1]))
        return states_at(*given, **options)

    monkeypatch.setattr(straight, "March", march_counted)
    monkeypatch.setattr(straight, "states_at", states_counted)
    even = ev.simulate(measured())
    assert len(VOLTS) > MOST_CORNERS
    assert len(marches) == 1
    assert all(count < 500 for count in states)
    # even stamps and the same stamps by themselves give one answer
    monkeypatch.setattr("electrovib.physics.drive.sampled.even_step", lambda *_, **__: None)
    each = ev.simulate(measured())
    for name in ("electrostatic_force", "current", "field"):
        size = float(np.abs(each[name]).max())
        np.testing.assert_allclose(even[name], each[name], rtol=0, atol=1e-8 * size)


@pytest.mark.parametrize("jitter", [0.0, 0.4])
def test_states_passed_on_the_way_serve_other_times(jitter):
    rng = np.random.default_rng(4)
    times = 1e-6 * (np.arange(12_000) + jitter * np.append(0, rng.random(11_999)))
    volts = np.cumsum(rng.normal(size=12_000))
    part = Linear(times, volts, volts, step=None if jitter else 1e-6)
    rates, gains = np.geomspace(10, 1e7, 8), rng.normal(size=(2, 8))
    given_, lag = (rates, gains, np.array([0.3, 0.0])), np.array([False, True])
    passed, rest = SharedModes(*given_, lag), rng.normal(size=8)
    through = passed.along(part, times, rest)
    for first in range(0, 12_000, 4096):
        through(slice(first, min(first + 4096, 12_000)))
    moments = np.sort(rng.choice(times, 9, replace=False)) + 3e-7
    assert sorted(passed.passed[id(part)]) == [0, 4096, 8192]
    for one, other in zip(
        passed.straight(part, moments, rest),
        SharedModes(*given_, lag).straight(part, moments, rest),
        strict=True,
    ):
        assert largest(one - other) < 1e-11 * largest(other)


def test_an_output_that_is_a_multiple_of_another_is_that_multiple():
    modes = {"rates": np.array([1.0, 1e3]), "gains": np.array([0.5, -0.2])}
    one, less = Transfer(**modes, direct=0.1), Transfer(**modes, direct=0.2)
    lagging = Transfer(**modes, direct=0.1, static=0.1)
    transfers = {"one": one, "other": one * 3.0, "less": less, "lag": lagging}
    drive = measured(np.arange(12_000) * 1e-6).drive
    found = transient(transfers, drive, drive.time_stamps)
    np.testing.assert_allclose(found["other"], 3 * found["one"], rtol=1e-15)
    np.testing.assert_allclose(found["less"] - found["one"], 0.1 * VOLTS, atol=1e-12)
    np.testing.assert_allclose(found["one"] - found["lag"], 0.3 * VOLTS, atol=1e-12)


def test_chosen_signals_are_those_of_the_whole_trace():
    scenario = ev.load("vezzoli_2014/fig6")
    whole, force = ev.simulate(scenario), ev.simulate(scenario, signals=["electrostatic_force"])
    assert list(force.data_vars) == ["electrostatic_force"]
    np.testing.assert_array_equal(force["electrostatic_force"], whole["electrostatic_force"])
    assert force.attrs["validity"] == whole.attrs["validity"]
    for name, words in (
        ("electrostatic_forces", "electrostatic_force"),
        ("skin_speed", "does not have this"),
    ):
        with pytest.raises(InputError, match=words):
            ev.simulate(scenario, signals=[name])


@pytest.mark.parametrize("seed", range(6))
def test_an_error_judged_by_stretches_is_that_of_every_time(seed, monkeypatch):
    rng = np.random.default_rng(seed)
    times = np.linspace(0, 1, 30_001)
    row = np.cos(40 * times) * np.exp(-seed * times) if seed < 4 else rng.normal(size=len(times))
    probes = np.unique(np.append(rng.integers(0, len(times), 300), [0, len(times) - 1]))
    given_ = row[None], times[None], probes, 1e-5 * rng.random((1, len(probes))), np.ones(len(times), bool)
    found = at_probes.judge(*given_)
    in_stretches = at_probes.Extremes(times, probes)
    for first in range(0, len(times), 4000):
        in_stretches.take(first, {"row": row[first : first + 4000]})
    noted = at_probes.judge(*given_, "row", in_stretches)
    monkeypatch.setattr(at_probes, "MANY", 10**9)
    assert found == noted == at_probes.judge(*given_)


@pytest.mark.parametrize("unjudged", [[0], [0, 30_000], [700]])
def test_times_at_corners_do_not_count_in_stretches(unjudged, monkeypatch):
    """A probe at a corner is an interval of its own; any other time is looked at by itself."""
    rng = np.random.default_rng(3)
    times = np.linspace(0, 1, 30_001)
    row, judged = 2 + np.cos(40 * times), np.ones(len(times), bool)
    row[unjudged], judged[unjudged] = 0.01, False
    probes = np.unique(np.append(rng.integers(1000, len(times), 300), [0, 1, len(times) - 1]))
    bounds = 1e-5 * rng.random((1, len(probes)))
    bounds[0, 0] = 2e-5
    given_ = row[None], times[None], probes, bounds, judged
    found = at_probes.judge(*given_)
    monkeypatch.setattr(at_probes, "MANY", 10**9)
    assert found == at_probes.judge(*given_)


@pytest.mark.parametrize("begin", [0.0, 30.0])
def test_errors_of_several_cases_are_those_of_a_plain_loop(begin):
    """From 30 s on a case of 1 s never looks back before its beginning."""
    rng = np.random.default_rng(3)
    times = begin + np.array([np.linspace(0, 1, 40), np.linspace(0, 0.5, 40)])
    rows = rng.normal(size=(2, 40)) * np.exp(-5 * np.linspace(0, 1, 40))
    probes, judged = np.array([2, 3, 9, 20, 36]), np.ones(40, bool)
    judged[[0, 1, 12, 37, 38, 39]] = False
    bounds = 2e-3 * rng.random((2, len(probes)))
    every = at_probes.judge(rows, times, probes, bounds, judged)
    for row, own, bound, found in zip(rows, times, bounds, every, strict=True):
        peak, errors, shares, larger, lost = max(abs(row[judged])), [], [], [], np.inf
        for place in np.flatnonzero(judged):
            larger.append(max(bound[probes <= place][-1], bound[probes >= place][0]))
            left = max(abs(row[judged & (own >= at_probes.LOOKING_BACK * own[place])]))
            errors.append(larger[-1] / abs(row[place]) if abs(row[place]) > at_probes.TAIL * peak else 0.0)
            shares.append(larger[-1] / left)
            if shares[-1] > at_probes.LARGEST:
                lost = min(lost, own[place])
        expected = (max(errors), max(shares), lost, max(larger) / peak)
        assert found[:4] == pytest.approx(expected, rel=1e-12)
        assert found.jump == 0.0
        assert begin or np.isfinite(lost)


@pytest.mark.parametrize("stretch", [5001, 640])
def test_few_of_very_many_times_decide_on_the_largest_values(stretch, monkeypatch):
    """Also of a record that comes in stretches, with a value that is not known."""
    monkeypatch.setattr(peaks, "_MANY", 1000)
    times = np.linspace(0, 1, 5001)
    rows = {"across": np.sin(7 * times), "current": -np.cos(90 * times) * times}
    rows["current"][700] = np.nan
    whole, moments = peaks.PeakRecord(times, rows), np.array([0.2501, 0.90005])
    largest = peaks.Largest()
    for first in range(0, 5001, stretch):
        largest.take(first, {name: row[first : first + stretch] for name, row in rows.items()})
    kept = largest.kept(times, moments)
    assert len(kept) < 30
    few = peaks.PeakRecord(times[kept], {name: row[kept] for name, row in rows.items()})
    other = peaks.PeakRecord(moments, {name: np.array([0.0, 2.0]) for name in rows})
    assert few.joined(other).peaks() == whole.joined(other).peaks()
    assert few.peaks() == whole.peaks()
    beside = largest.just_beside(times)
    for name, peak in few.peaks().items():
        place = int(np.nanargmax(np.abs(rows[name])))
        assert peak >= abs(rows[name][place])
        assert np.min(np.abs(beside - times[place])) < 1e-8
