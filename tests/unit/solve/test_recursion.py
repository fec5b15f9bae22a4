"""The exact recursion against closed forms in 50 digits, against its plain loop, and across hand-overs."""

import subprocess
import sys

import mpmath
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from plain_recursion import march_loop

from electrovib.core.errors import InputError
from electrovib.solve.recursion import hold_weights, march

SAME = 1e-12  # of the largest possible output; some hundred roundings of 1.1e-16 stay far below
WEIGHT = 1e-15  # relative; a weight is about five roundings of 1.1e-16
both_ways = pytest.mark.parametrize("way", [march, march_loop])

POLES = -np.array([1e-3, 1.0, 37.0, 9e2, 4e4, 5e6, 1e12])  # z from -1e-9 to -1e6 at a step of 2**-20
GAINS = np.array([[0.2, 0.1, 0.05, 0.25, 0.1, 0.15, 0.05], [3.0, -2.0, 1.0, 0.0, -1.0, 0.5, 0.25]])
DIRECT = np.array([0.1, -0.4])
STEP = 2.0**-20  # a power of two, so that every multiple is exact


def exact_weights(z):
    """decay, first and last in 50 digits beyond those that the cancellation at small z eats."""
    fall = -mpmath.mpf(z)
    with mpmath.workdps(50 + max(0, int(-2 * mpmath.log10(fall)))):
        decay = mpmath.exp(-fall)
        mean = (1 - decay) / fall
        return decay, mean - decay, 1 - mean


def exact_output(time, gains, direct, pieces):
    """Output at ``time`` from rest, in 50 digits: a step for every jump, a ramp for every change of slope.

    Pieces are (begin, end, value at begin, value at end), each beginning where the last ended.
    """
    with mpmath.workdps(50):
        total, slope, value = mpmath.mpf(0), mpmath.mpf(0), mpmath.mpf(0)
        for begin, end, start, finish in (map(mpmath.mpf, piece) for piece in pieces):
            if time < begin:
                break
            since, steeper = time - begin, (finish - start) / (end - begin)
            for gain, pole in zip(gains, POLES, strict=True):
                left = mpmath.expm1(mpmath.mpf(pole) * since)
                total += gain * (start - value) * -left
                total += gain * (steeper - slope) * (since + -left / mpmath.mpf(pole))
            total += direct * ((start - value) + (steeper - slope) * since)
            slope, value = steeper, finish
        return float(total)


def sampled(pieces, stamps):
    """Values just after and just before the stamps, for a drive whose corners are all among them."""
    starts, ends = np.empty(stamps.size - 1), np.empty(stamps.size - 1)
    for begin, end, start, finish in pieces:
        inside = (stamps[:-1] >= begin) & (stamps[1:] <= end)
        slope = (finish - start) / (end - begin)
        starts[inside] = start + slope * (stamps[:-1][inside] - begin)
        ends[inside] = start + slope * (stamps[1:][inside] - begin)
    return starts, ends


DRIVES = {
    "step": [(0, 512 * STEP, 100.0, 100.0)],
    "ramp": [(0, 512 * STEP, 0.0, 128.0)],
    "trapezium": [
        (0, 32 * STEP, 0.0, 64.0),
        (32 * STEP, 224 * STEP, 64.0, 64.0),
        (224 * STEP, 288 * STEP, 64.0, -64.0),
        (288 * STEP, 512 * STEP, -64.0, -64.0),
    ],
    "square": [(0, 128 * STEP, 50.0, 50.0), (128 * STEP, 512 * STEP, -50.0, -50.0)],
}


def stamps_of(kind):
    """Even stamps, or stamps with gaps of one to four steps that keep every corner of the drives."""
    even = np.arange(513) * STEP
    if kind == "even":
        return even
    kept = np.random.default_rng(3).random(513) < 0.4
    kept[::32] = True
    return even[kept]


@both_ways
@pytest.mark.parametrize("kind", ["even", "uneven"])
@pytest.mark.parametrize("drive", DRIVES)
def test_closed_form(way, kind, drive):
    """The response to step, ramp, trapezoidal pulse and square is exact, for modes from very slow to very fast."""
    stamps, pieces = stamps_of(kind), DRIVES[drive]
    starts, ends = sampled(pieces, stamps)
    steps = STEP if kind == "even" else np.diff(stamps)
    output, _ = way(POLES, GAINS, DIRECT, starts, ends, steps, np.zeros(POLES.size))
    exact = np.array(
        [
            [exact_output(stamp, gains, direct, pieces) for stamp in stamps[::5]]
            for gains, direct in zip(GAINS, DIRECT, strict=True)
        ]
    )
    scale = np.abs(exact).max()
    assert np.abs(output[:, ::5] - exact).max() < SAME * scale
    assert np.abs(output[:, ::5] * (1 + 1e-9) - exact).max() > SAME * scale


@both_ways
def test_output_at_a_jump_is_the_value_just_after(way):
    """The direct share follows the drive over the jump; the modes do not jump."""
    output, final = way([-1.0], [[1.0]], [2.0], [0.0, 10.0, 10.0], [0.0, 10.0, 3.0], 0.0, [4.0])
    assert output[0].tolist() == [4.0, 24.0, 24.0, 10.0]
    assert final.tolist() == [4.0]


def test_weights_over_six_hundred_decades():
    """No cancellation at small z, no overflow at large z."""
    decades = np.arange(-300.0, 301.0)
    z = -np.concatenate([10.0**decades, np.geomspace(1e-3, 700.0, 800), [1.0, np.nextafter(1.0, 0.0)]])
    got = np.array(hold_weights(z))
    for column, pole_step in zip(got.T, z, strict=True):
        for value, exact in zip(column, exact_weights(pole_step), strict=True):
            if exact > 1e-307:  # below, decay has fewer digits
                assert abs(mpmath.mpf(value) - exact) <= WEIGHT * exact
                assert abs(mpmath.mpf(value) * (1 + 3 * WEIGHT) - exact) > WEIGHT * exact


@settings(deadline=None, max_examples=200)
@given(st.floats(-300, 300).map(lambda decade: -(10.0**decade)))
def test_weights_anywhere(z):
    decay, first, last = hold_weights(z)
    exact = exact_weights(z)
    assert abs(mpmath.mpf(float(first)) - exact[1]) <= WEIGHT * exact[1]
    assert abs(mpmath.mpf(float(last)) - exact[2]) <= WEIGHT * exact[2]
    assert decay + first + last == pytest.approx(1.0, abs=5e-16)


def test_weights_without_time_or_for_ever():
    assert [float(each) for each in hold_weights(0.0)] == [1.0, 0.0, 0.0]
    assert [float(each) for each in hold_weights(-np.inf)] == [0.0, 0.0, 1.0]


@st.composite
def records(draw):
    """Random modes, a drive with or without jumps, one step or many, from any state."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    count, outputs = draw(st.integers(0, 9)), draw(st.integers(1, 3))
    pieces = draw(st.one_of(st.integers(1, 400), st.sampled_from([63, 64, 65, 128, 4096, 4097])))
    step = 10.0 ** draw(st.floats(-9, 2))
    poles = -(10.0 ** rng.uniform(-9, 6, count)) / step
    values = rng.uniform(-100, 100, pieces + 1)
    starts, ends = values[:-1], values[1:]
    if draw(st.booleans()):
        ends = np.where(rng.random(pieces) < 0.2, rng.uniform(-100, 100, pieces), ends)
    steps = step * rng.choice([0.0, 0.5, 1.0, 3.0], pieces) * rng.uniform(0.9, 1.1, pieces)
    gains, direct = rng.normal(size=(outputs, count)), rng.normal(size=outputs)
    many = draw(st.booleans())
    return poles, gains, direct, starts, ends, steps if many else step, rng.uniform(-100, 100, count)


@settings(deadline=None, max_examples=120)
@given(records())
def test_fast_way_equals_the_loop(record):
    _, gains, direct, *_ = record
    output, final = march(*record)
    expected, expected_final = march_loop(*record)
    scale = 100.0 * (np.abs(gains).sum(axis=1) + np.abs(direct)).max()
    assert output.shape == expected.shape
    assert np.abs(output - expected).max() <= SAME * scale
    assert np.abs(final - expected_final).max(initial=0.0) <= SAME * 100.0


@settings(deadline=None, max_examples=60)
@given(records(), st.floats(0.01, 0.99))
def test_two_parts_equal_one(record, share):
    poles, gains, direct, starts, ends, steps, state = record
    assume(starts.size > 1)
    cut = min(max(1, int(share * starts.size)), starts.size - 1)
    parts = [slice(None, cut), slice(cut, None)]
    whole, end = march(*record)
    outputs, scale = [], 100.0 * (np.abs(gains).sum(axis=1) + np.abs(direct)).max()
    for part in parts:
        some = steps[part] if np.ndim(steps) else steps
        output, state = march(poles, gains, direct, starts[part], ends[part], some, state)
        outputs.append(output)
    joined = np.concatenate([outputs[0][:, :-1], outputs[1]], axis=1)
    assert np.abs(joined - whole).max() <= SAME * scale
    assert np.abs(state - end).max(initial=0.0) <= SAME * 100.0


@pytest.mark.parametrize(("way", "kind"), [(march, "even"), (march, "uneven"), (march_loop, "even")])
def test_slow_mode_does_not_drift(way, kind):
    """Multiplying 1e5 times by the decay of z = -3.3e-8, rounded next to 1, would be off by 5e-12."""
    pieces = 100_000
    steps = 1.0 if kind == "even" else np.random.default_rng(5).choice([0.5, 1.5], pieces)
    time = float(np.sum(np.broadcast_to(steps, (pieces,))))
    nothing = np.zeros(pieces)
    output, final = way([-3.3e-8, -1e6], [[1.0, 0.0]], [0.0], nothing, nothing, steps, [1.0, 1.0])
    assert final[0] == pytest.approx(np.exp(-3.3e-8 * time), rel=SAME)
    assert output[0, -1] == final[0]
    assert abs(final[1]) < 1e-15


def test_slow_modes_keep_their_digits():
    """The response to 1 V from rest after very many samples is one exponential for each mode."""
    count, step = 1_000_000, 1e-6
    rates = np.array([0.3, 0.7, 1.1, 13.0])
    drive = np.ones(count)
    found, state = march(-rates, np.eye(4), np.zeros(4), drive[:-1], drive[1:], step, np.zeros(4))
    expected = -np.expm1(-rates[:, np.newaxis] * step * np.arange(count))
    assert np.max(np.abs(found - expected)) < 5e-14
    assert np.max(np.abs(state - expected[:, -1])) < 5e-14


def test_equal_durations_and_copied_ends_change_nothing():
    """An array of equal steps is one step; ends in their own memory are the same drive."""
    values = np.random.default_rng(7).normal(size=1001)
    rest = np.zeros(POLES.size)
    output, final = march(POLES, GAINS, DIRECT, values[:-1], values[1:], STEP, rest)
    for ends, steps in ((values[1:], np.full(1000, STEP)), (values[1:].copy(), STEP)):
        again, again_final = march(POLES, GAINS, DIRECT, values[:-1], ends, steps, rest)
        assert np.array_equal(again, output)
        assert np.array_equal(again_final, final)


def test_arguments_are_left_alone():
    values, state = np.linspace(0.0, 1.0, 200), np.ones(1)
    march([-1.0], [[1.0]], [0.0], values[:-1], values[1:], 0.1, state)
    march([-1.0], [[1.0]], [0.0], values[:-1], values[1:], np.linspace(0.1, 0.2, 199), state)
    assert np.array_equal(values, np.linspace(0.0, 1.0, 200))
    assert state.tolist() == [1.0]


@both_ways
@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"poles": [-1.0, 0.0]}, "every pole must be negative"),
        ({"poles": [-1.0, np.nan]}, "every pole must be negative"),
        ({"gains": [1.0, 2.0]}, r"march.gains has shape \(2,\), expected \(1, 2\)"),
        ({"ends": [1.0]}, r"march.ends has shape \(1,\), expected \(3,\)"),
        ({"steps": [0.1, 0.1]}, r"march.steps has shape \(2,\), expected \(3,\)"),
        ({"steps": [0.1, -0.1, 0.1]}, "sort the time stamps"),
        ({"steps": np.nan}, "sort the time stamps"),
        ({"initial_state": [0.0]}, r"march.initial_state has shape \(1,\), expected \(2,\)"),
        ({"starts": [], "ends": []}, "at least one piece"),
    ],
)
def test_what_does_not_fit_is_refused(way, wrong, message):
    right = {
        "poles": [-1.0, -2.0],
        "gains": [[1.0, 2.0]],
        "direct": [0.0],
        "starts": [0.0, 0.0, 0.0],
        "ends": [0.0, 0.0, 0.0],
        "steps": 0.1,
        "initial_state": [0.0, 0.0],
    }
    way(**right)
    with pytest.raises(InputError, match=message):
        way(**(right | wrong))


def test_needs_numpy_only():
    """One finger at the command line must not wait for compilers or for scipy."""
    heavy = "scipy numba xarray pandas matplotlib pint pydantic"
    code = f"""
import sys, numpy as np, electrovib.solve.recursion as recursion
drive = np.ones(100_000)
recursion.march([-1.0] * 40, [[1.0] * 40], [0.0], drive[1:], drive[1:], 1.0, [0.0] * 40)
print([name for name in {heavy.split()} if name in sys.modules])
"""
    answer = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert answer.stdout.strip() == "[]"
