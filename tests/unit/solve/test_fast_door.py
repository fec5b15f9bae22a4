"""The fast methods behind the public functions agree with the readable ones, and compute each part once."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from plain_recursion import march_loop

import electrovib as ev
from electrovib.core.errors import InputError
from electrovib.core.samples import Samples
from electrovib.physics.drive.parts import circling
from electrovib.physics.drive.pieces import Linear
from electrovib.solve.diagnostics import memory, peaks
from electrovib.solve.diagnostics.peaks import MOST_CORNERS
from electrovib.solve.electrics import straight
from electrovib.solve.electrics.straight import FEW_TIMES, fading
from electrovib.solve.electrics.transient import transient
from electrovib.solve.recursion import blocks, march, states_at, uneven
from electrovib.solve.stack.transfer import Transfer

SAME = 1e-12


def record(count, seed, *, jitter=0.0, jump=False):
    """Starts, ends and stamps of a drive of so many pieces of 1 us."""
    rng = np.random.default_rng(seed)
    stamps = np.arange(count + 1) * 1e-6
    stamps[1:-1] += rng.uniform(-jitter, jitter, count - 1) * 1e-6
    values = np.cumsum(rng.normal(size=count + 1))
    starts, ends = values[:-1].copy(), values[1:].copy()
    if jump:
        starts[count // 3 :] += 30.0
        ends[count // 3 :] += 30.0
        ends[-1] += 7.0
    return starts, ends, stamps


@settings(max_examples=40, deadline=None)
@given(
    count=st.integers(1, 700),
    seed=st.integers(0, 1000),
    jitter=st.sampled_from([0.0, 0.2, 0.49]),
    jump=st.booleans(),
    span=st.sampled_from([(0.05, 3e7), (1e4, 1e5), (1e6, 1e9)]),
)
def test_values_and_lags_of_a_march_are_those_of_the_loop(count, seed, jitter, jump, span):
    rng = np.random.default_rng(seed)
    starts, ends, stamps = record(count, seed, jitter=jitter, jump=jump)
    poles, gains = -np.geomspace(*span, 9), rng.normal(size=(3, 9))
    lag, rest = np.array([False, True, False]), rng.normal(size=9)
    steps = 1e-6 if not jitter else np.diff(stamps)
    given_ = (poles, gains, [0.3, -2.0, 0.0], starts, ends, steps, rest)
    found, state = march(*given_, lag=lag)
    expected, last = march_loop(*given_, lag=lag)
    scale = np.max(np.abs(np.concatenate([starts, ends, rest]))) * 10
    assert np.max(np.abs(found - expected)) < SAME * scale
    assert np.max(np.abs(state - last)) < SAME * scale


@pytest.mark.parametrize("steps", [1e-6, None])
def test_a_drive_that_jumps_everywhere_is_followed_from_stretch_to_stretch(steps, monkeypatch):
    monkeypatch.setattr(blocks, "_HELD", 1)
    monkeypatch.setattr(uneven, "PRODUCT", 1)
    rng = np.random.default_rng(5)
    starts, ends = rng.normal(size=(2, 400))
    steps = rng.uniform(0.5e-6, 2e-6, 400) if steps is None else steps
    poles, gains, lag = -np.geomspace(1.0, 1e8, 8), rng.normal(size=(2, 8)), [True, False]
    given_ = (poles, gains, [1.0, 0.0], starts, ends, steps, np.zeros(8))
    assert np.max(np.abs(march(*given_, lag=lag)[0] - march_loop(*given_, lag=lag)[0])) < 1e-12


@settings(max_examples=40, deadline=None)
@given(
    count=st.integers(1, 1000),
    seed=st.integers(0, 1000),
    jitter=st.sampled_from([0.0, 0.3]),
    jump=st.booleans(),
    every=st.sampled_from([1, 7, 300]),
)
def test_states_at_some_points_are_those_of_the_loop(count, seed, jitter, jump, every):
    starts, ends, stamps = record(count, seed, jitter=jitter, jump=jump)
    poles, steps = -np.geomspace(0.1, 1e8, 7), 1e-6 if not jitter else np.diff(stamps)
    rest, places = np.linspace(-1, 1, 7), np.unique(np.append(np.arange(0, count + 1, every), count))
    expected = march_loop(poles, np.eye(7), np.zeros(7), starts, ends, steps, rest)[0][:, places]
    found = states_at(poles, starts, ends, steps, rest, places)
    assert np.max(np.abs(found - expected)) < SAME * np.max(np.abs(np.append(starts, ends))) * 10


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
    expected = weights @ np.exp(-np.outer(rates, since))
    assert np.max(np.abs(np.array(fading(weights, rates, since)) - expected)) < 3e-14 * np.sum(
        np.abs(weights)
    )
    few = np.array(
        fading(weights, rates, since[:FEW_TIMES])
    )  # a direct sum, whose order depends on the processor
    assert np.max(np.abs(few - expected[:, :FEW_TIMES])) < 1e-15 * np.sum(np.abs(weights))


@pytest.mark.parametrize("even", [True, False])
def test_a_tone_at_many_times_is_cosine_and_sine(even):
    times = np.linspace(0.3, 1.7, 30_001)
    if not even:
        times[1:-1] += np.random.default_rng(0).uniform(-1e-5, 1e-5, len(times) - 2)
    cosine, sine = circling(250.0, times)
    phase = 2 * np.pi * 250 * times
    assert np.max(np.abs(cosine - np.cos(phase))) < 2e-12
    assert np.max(np.abs(sine - np.sin(phase))) < 2e-12


def test_few_long_pieces_at_very_many_uneven_times_are_what_each_time_says(monkeypatch):
    part = Linear(
        np.array([0.0, 0.1, 0.4, 1.0]), np.array([0.0, 5.0, -3.0, 1.0]), np.array([2.0, 5.0, 4.0, 1.0])
    )
    times = np.sort(np.random.default_rng(3).uniform(0, 1.3, 60_000))
    rates, gains = np.geomspace(0.1, 1e6, 8), np.random.default_rng(4).normal(size=(2, 8))
    modes = straight.SharedModes(rates, gains, np.array([0.5, 0.0]), np.array([False, True]))
    many = np.array(modes.straight(part, times, np.zeros(8)))
    monkeypatch.setattr(straight, "_LONG", 10**9)
    each = np.array(modes.straight(part, times, np.zeros(8)))
    assert np.max(np.abs(many - each)) < 1e-12 * np.max(np.abs(each))


DECIMALS = [f"{place}e-6" for place in range(12_000)]
VOLTS = np.round(100 * np.sin(2 * np.pi * 500e-6 * np.arange(12_000)), 2)


def measured(stamps, volts=VOLTS):
    drive = {"model": "Sampled", "time_samples": stamps, "voltage_samples": volts}
    return ev.load("vezzoli_2014/fig6_gap").replace({"drive": drive})


@pytest.mark.parametrize("factor", [1.0, 1e-3])
@pytest.mark.parametrize("start", [0.0, 12.345678])
def test_stamps_written_as_decimal_numbers_are_even(factor, start):
    stamps = np.array([float(f"{(start + place * 1e-6) / factor:.9f}") for place in range(3000)]) * factor
    part = measured(stamps, VOLTS[:3000]).drive.parts()[0]
    assert part.step == pytest.approx(1e-6, rel=1e-9)
    stamps[1500] += 1e-9
    assert measured(stamps, VOLTS[:3000]).drive.parts()[0].step is None


def test_one_march_for_all_signals_of_a_measured_drive(monkeypatch):
    """Values and lags of one set of modes; the times between need states at few samples, and no recursion."""
    marches, states = [], []
    real_march, real_states = straight.march, states_at

    def march_counted(poles, gains, *more, **options):
        marches.append(np.shape(gains))
        return real_march(poles, gains, *more, **options)

    def states_counted(poles, starts, ends, steps, state, places):
        states.append(len(places))
        return real_states(poles, starts, ends, steps, state, places)

    monkeypatch.setattr(straight, "march", march_counted)
    monkeypatch.setattr("electrovib.solve.electrics.straight.states_at", states_counted)
    ev.simulate(measured(np.array([float(text) for text in DECIMALS])))
    assert len(VOLTS) > MOST_CORNERS
    assert len(marches) == 1
    assert all(count < 500 for count in states)


def test_even_stamps_and_the_same_stamps_by_themselves_give_one_answer(monkeypatch):
    stamps = np.array([float(text) for text in DECIMALS])
    even = ev.simulate(measured(stamps))
    monkeypatch.setattr("electrovib.physics.drive.sampled._even_step", lambda *_: None)
    each = ev.simulate(measured(stamps))
    for name in ("electrostatic_force", "current", "field"):
        np.testing.assert_allclose(
            even[name], each[name], rtol=0, atol=1e-8 * float(np.abs(each[name]).max())
        )


def test_an_output_that_is_a_multiple_of_another_is_that_multiple():
    rates = np.array([1.0, 1e3])
    one = Transfer(rates=rates, gains=np.array([0.5, -0.2]), direct=0.1)
    lagging = Transfer(rates=rates, gains=np.array([0.5, -0.2]), direct=0.1, static=0.1)
    less = Transfer(rates=rates, gains=np.array([0.5, -0.2]), direct=0.2)
    transfers = {"one": one, "other": one * 3.0, "less": less, "lagging": lagging}
    drive = measured(np.arange(12_000) * 1e-6).drive
    found = transient(transfers, drive, drive.time_stamps)
    np.testing.assert_allclose(found["other"], 3 * found["one"], rtol=1e-15)
    np.testing.assert_allclose(found["less"] - found["one"], 0.1 * VOLTS, atol=1e-12)
    np.testing.assert_allclose(found["one"] - found["lagging"], 0.3 * VOLTS, atol=1e-12)


@pytest.mark.parametrize("lag", [True, False])
def test_at_a_jump_at_the_last_output_the_value_after_it_counts(lag):
    part = Linear(np.array([0.0, 1.0, 3.0]), np.array([0.0, 2.0, 4.0]), np.array([1.0, 2.0, -6.0]))
    given_ = np.array([0.7, 20.0]), np.array([[2.0, -1.0]])
    modes = straight.SharedModes(*given_, np.array([0.5]), np.array([lag]))
    marched = modes.straight(part, part.times, np.zeros(2))
    each = modes.straight(part, np.array([0.0, 1.0, 2.0, 3.0]), np.zeros(2))
    np.testing.assert_allclose(marched[0], each[0][[0, 1, 3]], rtol=1e-13)


def test_chosen_signals_are_those_of_the_whole_trace():
    scenario = ev.load("vezzoli_2014/fig6")
    whole, force = ev.simulate(scenario), ev.simulate(scenario, signals=["electrostatic_force"])
    assert list(force.data_vars) == ["electrostatic_force"]
    np.testing.assert_array_equal(force["electrostatic_force"], whole["electrostatic_force"])
    assert force.attrs["validity"] == whole.attrs["validity"]
    with pytest.raises(InputError, match="electrostatic_force"):
        ev.simulate(scenario, signals=["electrostatic_forces"])
    with pytest.raises(InputError, match="does not have this signal"):
        ev.simulate(scenario, signals=["skin_speed"])


@settings(max_examples=60, deadline=None)
@given(
    whole=st.lists(st.integers(-(10**9), 10**9), min_size=1, max_size=50),
    places=st.integers(0, 9),
    minus=st.booleans(),
)
def test_decimal_numbers_travel_without_loss(whole, places, minus):
    values = np.array([float(f"{each}e-{places}") for each in whole])
    samples = Samples(-values if minus else values)
    packed = samples.packed()
    assert packed.startswith("decimals+zlib+base64:")
    assert Samples.read(packed) == samples


@pytest.mark.parametrize("seed", range(6))
def test_an_error_judged_by_stretches_is_that_of_every_time(seed, monkeypatch):
    rng = np.random.default_rng(seed)
    times = np.linspace(0, 1, 30_001)
    row = np.cos(40 * times) * np.exp(-seed * times) if seed < 4 else rng.normal(size=len(times))
    probes = np.unique(np.append(rng.integers(0, len(times), 300), [0, len(times) - 1]))
    bound, judged = 1e-5 * rng.random(len(probes)), np.ones(len(times), bool)
    found = memory.judge(row[None], times[None], probes, bound[None], judged)
    monkeypatch.setattr(memory, "_MANY", 10**9)
    assert found == memory.judge(row[None], times[None], probes, bound[None], judged)


@pytest.mark.parametrize("begin", [0.0, 30.0])
def test_errors_of_several_cases_are_those_of_a_plain_loop(begin):
    """From 30 s on a case of 1 s never looks back before its beginning."""
    rng = np.random.default_rng(3)
    times = begin + np.array([np.linspace(0, 1, 40), np.linspace(0, 0.5, 40)])
    rows = rng.normal(size=(2, 40)) * np.exp(-5 * np.linspace(0, 1, 40))
    probes, judged = np.array([2, 3, 9, 20, 36]), np.ones(40, bool)
    judged[[0, 1, 12, 37, 38, 39]] = False
    bounds = 2e-3 * rng.random((2, len(probes)))
    for row, own, bound, found in zip(
        rows, times, bounds, memory.judge(rows, times, probes, bounds, judged), strict=True
    ):
        peak = max(abs(row[judged]))
        errors, shares, lost = [], [], np.inf
        for place in np.flatnonzero(judged):
            before, after = bound[probes <= place][-1], bound[probes >= place][0]
            larger = max(before, after)
            left = max(abs(row[judged & (own >= memory.LOOKING_BACK * own[place])]))
            errors.append(larger / abs(row[place]) if abs(row[place]) > memory.TAIL * peak else 0.0)
            shares.append(larger / left)
            if larger / left > memory.LARGEST:
                lost = min(lost, own[place])
        largest = max(
            max(bound[probes <= place][-1], bound[probes >= place][0]) for place in np.flatnonzero(judged)
        )
        expected = (max(errors), max(shares), lost, largest / peak)
        assert tuple(found) == pytest.approx(expected, rel=1e-12)
        assert begin or np.isfinite(lost)


def test_few_of_very_many_times_decide_on_the_largest_values(monkeypatch):
    monkeypatch.setattr(peaks, "_MANY", 1000)
    times = np.linspace(0, 1, 5001)
    rows = {"across": np.sin(7 * times), "current": np.cos(90 * times) * times}
    whole, moments = peaks.PeakRecord(times, rows), np.array([0.2501, 0.90005])
    few = whole.among(moments)
    assert len(few.times) < 30
    assert few.whole is whole
    other = peaks.PeakRecord(moments, {name: np.array([0.0, 2.0]) for name in rows})
    assert few.joined(other).peaks() == whole.joined(other).peaks()
    assert few.peaks() == whole.peaks()


def test_relaxations_at_times_that_are_equal_to_rounding():
    since = np.repeat([1e-3, 2e-3], 10 * FEW_TIMES)
    (found,) = fading(np.array([[2.0]]), np.array([500.0]), since)
    np.testing.assert_allclose(found, 2 * np.exp(-500 * since), rtol=1e-14)
