"""The exact recursion of real poles and conjugate pairs: closed forms in 50 digits, its plain loop, and compiled code."""

import functools
import subprocess
import sys

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from plain_recursion import march_loop

from electrovib.solve.recursion import hold_weights, march, states_at, uneven
from electrovib.solve.recursion.blocks import SLOW

SAME = 1e-12  # of the largest possible output; some hundred roundings of 1.1e-16 stay far below
WEIGHT = 1e-15  # relative; a weight is about five roundings of 1.1e-16
WEIGHT_OF_PAIR = 4e-15  # of its larger term: exp and expm1 of complex numbers are good to a few roundings
both_ways = pytest.mark.parametrize("way", [march, march_loop])

REAL = -np.array([1e-3, 1.0, 37.0, 9e2, 4e4, 5e6, 1e12])  # z from -1e-9 to -1e6 at a step of 2**-20
GAINS = np.array([[0.2, 0.1, 0.05, 0.25, 0.1, 0.15, 0.05], [3.0, -2.0, 1.0, 0.0, -1.0, 0.5, 0.25]])
PAIR = complex(-2e3, 2.5e4)  # 4 kHz, rings for ten periods
MODES = {
    "real": (REAL, GAINS),
    "a pair": (np.array([PAIR]), np.array([[1.0], [0.3 - 2j]])),
    "both": (np.append(REAL, PAIR), np.append(GAINS + 0j, [[1.0], [0.3 - 2j]], axis=1)),
}
DIRECT = np.array([0.1, -0.4])
STEP = 2.0**-20  # a power of two, so that every multiple is exact
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


def exact_weights(z):
    """decay, first and last in 50 digits beyond those that the cancellation at small z eats."""
    fall = -mpmath.mpmathify(z)
    with mpmath.workdps(50 + max(0, int(-2 * mpmath.log10(abs(fall))))):
        decay = mpmath.exp(-fall)
        mean = (1 - decay) / fall
        return decay, mean - decay, 1 - mean


def exact_output(time, modes, gains, direct, pieces):
    """Output at ``time`` from rest, in 50 digits: a step for every jump, a ramp for every change of slope.

    Pieces are (begin, end, value at begin, value at end), each beginning where the last ended.
    """
    with mpmath.workdps(50):
        total, slope, value = mpmath.mpf(0), mpmath.mpf(0), mpmath.mpf(0)
        for begin, end, start, finish in (map(mpmath.mpf, piece) for piece in pieces):
            if time < begin:
                break
            since, jump, steeper = time - begin, start - value, (finish - start) / (end - begin) - slope
            for gain, pole in zip(gains.tolist(), modes.tolist(), strict=True):
                left = mpmath.expm1(mpmath.mpmathify(pole) * since)
                answer = gain * (jump * -left + steeper * (since + -left / mpmath.mpmathify(pole)))
                total += 2 * answer.real if mpmath.im(pole) else answer.real
            total += direct * (jump + steeper * since)
            slope, value = slope + steeper, finish
        return float(total)


def stamps_of(kind):
    """Even stamps, or stamps with gaps of one to four steps that keep every corner of the drives."""
    even = np.arange(513) * STEP
    if kind == "even":
        return even
    kept = np.random.default_rng(3).random(513) < 0.4
    kept[::32] = True
    return even[kept]


def sampled(pieces, stamps):
    """Values just after and just before the stamps, for a drive whose corners are all among them."""
    starts, ends = np.empty(stamps.size - 1), np.empty(stamps.size - 1)
    for begin, end, start, finish in pieces:
        inside = (stamps[:-1] >= begin) & (stamps[1:] <= end)
        slope = (finish - start) / (end - begin)
        starts[inside] = start + slope * (stamps[:-1][inside] - begin)
        ends[inside] = start + slope * (stamps[1:][inside] - begin)
    return starts, ends


@functools.cache
def exact_outputs(modes, kind, drive):
    outputs = zip(MODES[modes][1], DIRECT, strict=True)
    given_ = [(MODES[modes][0], gains, direct, DRIVES[drive]) for gains, direct in outputs]
    return np.array([[exact_output(stamp, *each) for stamp in stamps_of(kind)[::5]] for each in given_])


@both_ways
@pytest.mark.parametrize("kind", ["even", "uneven"])
@pytest.mark.parametrize(
    ("modes", "drive"), [*[("real", drive) for drive in DRIVES], ("a pair", "ramp"), ("both", "trapezium")]
)
def test_closed_form(way, kind, modes, drive):
    """The response to step, ramp, trapezoidal pulse and square is exact, for modes from very slow to very fast."""
    stamps, (poles, gains) = stamps_of(kind), MODES[modes]
    starts, ends = sampled(DRIVES[drive], stamps)
    steps = STEP if kind == "even" else np.diff(stamps)
    output, _ = way(poles, gains, DIRECT, starts, ends, steps, np.zeros(poles.size))
    exact = exact_outputs(modes, kind, drive)
    assert np.abs(output[:, ::5] - exact).max() < SAME * np.abs(exact).max()
    assert np.abs(output[:, ::5] * (1 + 1e-9) - exact).max() > SAME * np.abs(exact).max()


@both_ways
def test_output_at_a_jump_is_the_value_just_after(way):
    """The direct share follows the drive over the jump; the modes do not jump."""
    output, final = way([-1.0], [[1.0]], [2.0], [0.0, 10.0, 10.0], [0.0, 10.0, 3.0], 0.0, [4.0])
    assert output[0].tolist() == [4.0, 24.0, 24.0, 10.0]
    assert final.tolist() == [4.0]


def test_weights_over_six_hundred_decades():
    """No cancellation at small z, no overflow at large z; without time, and for ever."""
    decades = np.arange(-300.0, 301.0)
    z = -np.concatenate([10.0**decades, np.geomspace(1e-3, 700.0, 800), [1.0, np.nextafter(1.0, 0.0)]])
    got = np.array(hold_weights(z))
    for column, pole_step in zip(got.T, z, strict=True):
        assert sum(column) == pytest.approx(1.0, abs=5e-16)
        for value, exact in zip(column, exact_weights(pole_step), strict=True):
            if exact > 1e-307:  # below, decay has fewer digits
                assert abs(mpmath.mpf(value) - exact) <= WEIGHT * exact
                assert abs(mpmath.mpf(value) * (1 + 3 * WEIGHT) - exact) > WEIGHT * exact
    assert [float(each) for each in hold_weights(0.0)] == [1.0, 0.0, 0.0]
    assert [float(each) for each in hold_weights(-np.inf)] == [0.0, 0.0, 1.0]
    real = -np.geomspace(1e-12, 600.0, 500)
    for pair, relaxing in zip(hold_weights(real + 0j), hold_weights(real), strict=True):
        assert np.all(pair.imag == 0)
        assert np.abs(pair.real / relaxing - 1).max() < 1e-14


@settings(deadline=None, max_examples=300)
@given(st.floats(-20, 2).map(lambda decade: 10.0**decade), st.floats(0.0, np.pi / 2))
def test_weights_of_a_ringing_mode(size, angle):
    z = complex(-size * np.cos(angle), size * np.sin(angle))
    for found, wanted in zip(hold_weights(z), exact_weights(z), strict=True):
        scale = abs(wanted) + (size >= 1)
        error = abs(mpmath.mpc(complex(found)) - wanted)
        # at |z| up to 100 the angle of exp(z) itself carries the rounding of z
        assert error <= WEIGHT_OF_PAIR * scale * max(1.0, size / 10)
    assert abs(sum(hold_weights(z)) - 1) < 2e-15


def durations(kind, generator, pieces):
    """Of the pieces, over the usual one."""
    if kind == "jitter":
        return 1 + generator.uniform(-0.4, 0.4, pieces)
    if kind == "pauses":
        return np.where(generator.random(pieces) < 0.02, 300.0, 1 + generator.uniform(-0.1, 0.1, pieces))
    if kind == "bursts":
        return generator.choice([1.0, 20.0], pieces)
    if kind == "repeats":
        return np.where(generator.random(pieces) < 0.1, 0.0, generator.exponential(1.0, pieces))
    return generator.choice([0.0, 0.5, 1.0, 3.0], pieces) * generator.uniform(0.9, 1.1, pieces)


@st.composite
def records(draw):
    """Random modes, real or of them pairs, a drive with or without jumps, one step or many, from any state."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    count, outputs, pairs = draw(st.integers(0, 9)), draw(st.integers(1, 3)), draw(st.booleans())
    pieces = draw(st.one_of(st.integers(1, 600), st.sampled_from([63, 64, 65, 128, 4096, 4097])))
    step = 10.0 ** draw(st.floats(-9, 2))
    size, angle = 10.0 ** rng.uniform(-9, 2 if pairs else 6, count) / step, rng.uniform(0, 1.5, count)
    angle[rng.random(count) < 0.3] = 0.0
    poles, gains, state = -size, rng.normal(size=(outputs, count)), rng.uniform(-100, 100, count)
    if pairs:
        poles = size * (-np.cos(angle) + 1j * np.sin(angle))
        gains = gains + 1j * rng.normal(size=gains.shape) * (angle != 0)
        state = state + 1j * rng.uniform(-100, 100, count) * (angle != 0)
    values = rng.uniform(-100, 100, pieces + 1)
    starts, ends = values[:-1], values[1:]
    if draw(st.booleans()):
        ends = np.where(rng.random(pieces) < 0.2, rng.uniform(-100, 100, pieces), ends)
    kind = draw(st.sampled_from(["even", "mixed", "jitter", "pauses", "bursts", "repeats"]))
    steps = step if kind == "even" else step * durations(kind, rng, pieces)
    return poles, gains, rng.normal(size=outputs), starts, ends, steps, state


@settings(deadline=None, max_examples=60)
@given(records(), st.floats(0.01, 0.99))
def test_fast_way_equals_the_loop_in_one_part_or_two(record, share):
    """Relaxing modes are also pairs without an imaginary part; unequal pieces go through compiled code, also for a lag."""
    poles, gains, direct, starts, ends, steps, state = record
    expected, expected_final = march_loop(*record)
    scale = 100.0 * (2 * np.abs(gains).sum(axis=1) + np.abs(direct)).max()

    def assert_those_of_the_loop(output, final):
        assert output.shape == expected.shape
        assert np.abs(output - expected).max() <= SAME * scale
        assert np.abs(final - expected_final).max(initial=0.0) <= SAME * 200.0

    assert_those_of_the_loop(*march(*record))
    if not np.iscomplexobj(poles):
        output, final = march(poles + 0j, *record[1:])
        assert_those_of_the_loop(output, final)
        assert np.all(np.imag(final) == 0)
        if np.ndim(steps):
            assert_compiled_is_the_loop(record, scale, share)
    if starts.size == 1:
        return
    cut, outputs = min(max(1, int(share * starts.size)), starts.size - 1), []
    for part in (slice(None, cut), slice(cut, None)):
        some = steps[part] if np.ndim(steps) else steps
        output, state = march(poles, gains, direct, starts[part], ends[part], some, state)
        outputs.append(output)
    assert_those_of_the_loop(np.concatenate([outputs[0][:, :-1], outputs[1]], axis=1), state)


def assert_compiled_is_the_loop(record, scale, share):
    """Outputs, lags, and states at places, which are those of the method without a compiler."""
    pytest.importorskip("numba")
    pieces, lag = record[3].size, np.arange(len(record[2])) > 0
    places = np.unique([0, 1, int(share * pieces), pieces - 1, pieces])
    at = record[0], *record[3:], places
    expected, final = march_loop(*record, lag=lag)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(uneven, "_WORTH", 10**12)
        at_places = states_at(*at)
        patch.setattr(uneven, "_WORTH", 0)
        patch.setattr(uneven, "PRODUCT", 800)  # twenty pieces of ten modes together
        found, state = march(*record, lag=lag)
        compiled_at_places = states_at(*at)
    assert np.max(np.abs(found - expected)) <= 2 * SAME * scale
    for some, its in ((state, final), (compiled_at_places, at_places)):
        assert np.max(np.abs(some - its), initial=0) <= 200 * SAME


@pytest.mark.parametrize("kind", ["even", "uneven"])
def test_slow_modes_keep_their_digits_over_very_many_pieces(kind):
    """The response to 1 V from rest is one exponential for each mode: a decay rounded next to 1 would be off by 5e-12."""
    count, rates = 1_000_000, np.array([0.3, 0.7, 1.1, 13.0, 2e4, 4e4])
    steps = 1e-6 if kind == "even" else 1e-6 * (1 + np.random.default_rng(3).uniform(-0.2, 0.2, count))
    time = 1e-6 * np.arange(count + 1) if kind == "even" else np.append(0.0, np.cumsum(steps))
    drive = np.ones(count + 1)
    found, state = march(-rates, np.eye(6), np.zeros(6), drive[:-1], drive[1:], steps, np.zeros(6))
    expected = -np.expm1(-rates[:, np.newaxis] * time)
    assert np.max(np.abs(found - expected)) < 5e-14
    assert np.max(np.abs(state - expected[:, -1])) < 5e-14


def test_equal_durations_and_copied_ends_change_nothing_and_arguments_are_left_alone():
    """An array of equal steps is one step; ends in their own memory are the same drive."""
    values, rest = np.random.default_rng(7).normal(size=1001), np.zeros(REAL.size)
    kept = values.copy()
    output, final = march(REAL, GAINS, DIRECT, values[:-1], values[1:], STEP, rest)
    for ends, steps in ((values[1:], np.full(1000, STEP)), (values[1:].copy(), STEP)):
        again, again_final = march(REAL, GAINS, DIRECT, values[:-1], ends, steps, rest)
        assert np.array_equal(again, output)
        assert np.array_equal(again_final, final)
    march(REAL, GAINS, DIRECT, values[:-1], values[1:], np.linspace(0.1, 0.2, 1000), rest)
    assert np.array_equal(values, kept)
    assert not np.any(rest)


def test_needs_numpy_only():
    """One finger at the command line waits neither for compilers, also not with unequal pieces, nor for scipy."""
    heavy = "scipy numba xarray pandas matplotlib pint pydantic"
    code = f"""
import sys, numpy as np, electrovib.solve.recursion as recursion
drive = np.ones(100_000)
recursion.march([-1.0] * 40, [[1.0] * 40], [0.0], drive[1:], drive[1:], 1.0, [0.0] * 40)
steps, drive = 1 + np.random.default_rng(1).random(5000), np.ones(5000)
recursion.march([-1.0] * 40, [[1.0] * 40], [0.0], drive, drive, steps, [0.0] * 40)
print([name for name in {heavy.split()} if name in sys.modules])
"""
    answer = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert answer.stdout.strip() == "[]"


@pytest.fixture
def compiled(monkeypatch):
    """Send every record of unequal pieces through the compiled recursion."""
    pytest.importorskip("numba")
    monkeypatch.setattr(uneven, "_WORTH", 0)


def test_a_lag_keeps_its_digits(compiled):
    """Of a mode far faster than the pieces the lag is the slope over its rate, to rounding of itself."""
    generator, rate = np.random.default_rng(2), 1e9
    steps = 1 + generator.uniform(-0.2, 0.2, 500)
    drive = generator.normal(size=501)
    state = np.array([drive[0]])
    found, _ = march([-rate], [[1.0]], [0.0], drive[:-1], drive[1:], steps, state, lag=[True])
    expected = -np.diff(drive) / steps / rate
    assert np.max(np.abs(found[0, 1:] / expected - 1)) < 1e-14


def test_what_goes_through_it(monkeypatch):
    """Many modes times pieces, and real ones."""
    pytest.importorskip("numba")
    poles = -np.ones(1000)
    assert uneven._compiled(poles, 1000) is not None
    assert uneven._compiled(poles.astype(complex), 1000) is None
    monkeypatch.setattr(uneven, "_WORTH", 1_000_001)
    assert uneven._compiled(poles, 1000) is None


@pytest.mark.parametrize("in_compiled_code", [False, True])
@pytest.mark.parametrize("rate", [1e-30, 1e-6, 1.0, 30.0])
def test_a_huge_drive_for_a_moment_leaves_what_its_moment_brings(monkeypatch, in_compiled_code, rate):
    """Steps over twelve decades: each keeps its own digits, however much longer the longest is."""
    if in_compiled_code:
        pytest.importorskip("numba")
    monkeypatch.setattr(uneven, "_WORTH", 0 if in_compiled_code else 10**12)
    steps = np.geomspace(1e-13, 0.1, 60)
    ends = 1e11 * np.exp(-np.arange(1, 61) * 2.0)
    starts = np.append(1e11, ends[:-1])
    places = np.array([0, 1, 10, 60])
    found = states_at(np.array([-rate]), starts, ends, steps, np.zeros(1), places)[0]
    decays, first, last = (np.asarray(each) for each in hold_weights(-rate * steps))
    expected = [0.0]
    for decay, early, late, begin, end in zip(decays, first, last, starts, ends, strict=True):
        expected.append(decay * expected[-1] + early * begin + late * end)
    np.testing.assert_allclose(found, np.array(expected)[places], rtol=1e-12)


@pytest.mark.parametrize("fall", [1e-9, 1e-3, 0.999 * SLOW, 1.001 * SLOW, 0.9, 7.0])
@pytest.mark.parametrize("share", [0.02, 0.3, 0.6, 0.99, 1.0, 50.0])
def test_what_one_ramp_leaves_is_its_weight(compiled, fall, share):
    """From rest, in a usual piece, in a short one, and in a pause among a hundred usual ones."""
    steps = np.append(share, np.ones(100))
    drive = np.append(0.0, np.ones(101))
    places = np.array([0, 1])
    found = states_at([-fall], drive[:-1], drive[1:], steps, [0.0], places)[0, 1]
    expected = hold_weights(-fall * share)[2]
    # some ten roundings of 1.1e-16 of a slow mode; of another one, the drive less its lag, of the drive
    assert abs(found - expected) < (4e-15 * expected if fall < SLOW else 1e-15)


@pytest.mark.parametrize("fall", [3.0, 10.0, 20.0, 40.0])
def test_what_is_left_of_a_lag_is_exact(compiled, fall):
    """Without a drive a lag decays by its exponential, wherever the piece lies between two of the table."""
    for share in np.linspace(0.31, 0.99, 41):
        found, _ = march([-fall], [[1.0]], [0.0], [0, 0], [0, 0], [share, 1.0], [1.0])
        assert abs(found[0, 1] - np.exp(-fall * share)) < 3e-16
