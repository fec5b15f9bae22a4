"""Response over time against closed forms and an ODE, whatever the grid it is asked on; under a chirp in closed form."""

from itertools import pairwise

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

import electrovib as ev
from electrovib.core.errors import InputError
from electrovib.core.model import read_model
from electrovib.physics.drive.base import Drive
from electrovib.physics.drive.parts import MANY_TIMES, Chirped, Linear, Smooth
from electrovib.solve.electrics.formulas import GONE, chirp_response, smooth_states
from electrovib.solve.electrics.straight import MANY_SAMPLES, SharedModes
from electrovib.solve.electrics.transient import ALONE, transient
from electrovib.solve.expanded import Expanded
from electrovib.solve.stack.transfer import Transfer

RATES = np.array([0.3, 40.0, 130.0, 2.5e3, 7e6])
HIGH_PASS = Transfer(rates=RATES, gains=np.array([0.2, -0.7, 0.1, 0.5, -0.05]), direct=0.3)
OTHER = Transfer(rates=RATES, gains=np.array([0.0, 0.4, 0.0, -0.2, 0.6]), direct=-0.1)
BOTH = {"first": HIGH_PASS, "second": OTHER}
PRECISION = 1e-12  # of the largest drive: exponentials and the sum over five modes lose a few roundings


def drive(model, **content):
    return read_model(Drive, {"model": model} | content)


def one_of(transfer, one, time, **how):
    return transient({"x": transfer}, one, time, **how)["x"]


TRAPEZIUM = drive("Trapezium", high=100, low=-20, delay=1e-3, rise=2e-3, hold=5e-3, fall=0)
SQUARE = drive("Square", high=100, low=-40, frequency=60)
BURST = drive("Burst", amplitude=100, frequency=250, cycles=3, delay=2e-3)
SINE = drive("Sine", amplitude=100, frequency=125, phase=0.7)
CHIRP = drive("Chirp", amplitude=100, first=10, last=400, length=0.02)
EVERY = {"trapezium": TRAPEZIUM, "square": SQUARE, "burst": BURST, "sine": SINE, "chirp": CHIRP}
ANGULAR = 2 * np.pi * 125
"""Of the sine."""


def by_ramps(transfer, part, time):
    """Sum the closed forms of a ramp that begins at each break and of a jump there."""
    slopes = (part.before[1:] - part.after[:-1]) / np.diff(part.times)
    bends = np.diff(slopes, prepend=0.0, append=0.0)
    jumps = part.after - part.before
    total = np.zeros(len(time))
    for start, jump, bend in zip(part.times, jumps, bends, strict=True):
        since = np.maximum(time - start, 0.0)
        on = time >= start
        total += transfer.direct * (jump + bend * since) * on
        for rate, gain in zip(transfer.rates, transfer.gains, strict=True):
            rise = -np.expm1(-rate * since)
            total += gain * (jump * rise + bend * (since - rise / rate)) * on
    return total


def close(found, expected, scale=100.0):
    return np.max(np.abs(found - expected)) < PRECISION * scale


def test_step():
    time = np.concatenate([[0.0], np.geomspace(1e-9, 30, 60)])
    found = transient(BOTH, drive("Step", level=100), time)
    expected = 30 - 100 * np.expm1(-np.outer(time, RATES)) @ HIGH_PASS.gains
    assert close(found["first"], expected)
    assert found["first"][0] == 30  # at the jump the value after it
    assert not close(found["first"] * (1 + 1e-11), expected)


EVEN = np.linspace(0, 0.02, MANY_SAMPLES + 1)
GRIDS = {
    "even": np.linspace(0, 0.02, 2001),
    "uneven": np.sort(np.random.default_rng(5).uniform(0, 0.02, 777)),
    "block scan": EVEN,
    "almost even": EVEN * (1 + 1e-7 * (EVEN - 0.02) / 0.02),  # steps differ by less than 1e-7
}


STAMPS = np.cumsum(np.random.default_rng(11).uniform(0.2e-3, 1.8e-3, 200))
VOLTS = np.random.default_rng(12).uniform(-100, 100, 200)
RECORD = drive("Sampled", time_samples=STAMPS.tolist(), voltage_samples=VOLTS.tolist())


@pytest.mark.parametrize(
    ("one", "time", "share"),
    [*((TRAPEZIUM, time, PRECISION) for time in GRIDS.values())]
    # two hundred ramps of up to 1e6 V/s add their roundings
    + [(RECORD, time, 1e-10) for time in (RECORD.time_stamps, 11 * GRIDS["uneven"])],
    ids=[*GRIDS, "record", "record at other times"],
)
def test_straight_pieces_with_jumps(one, time, share):
    """Jumps and corners of the trapezium (1, 3, 8 ms) on the even grids, off the others; a record with jitter."""
    (part,), found = one.parts(), transient(BOTH, one, time)
    for name, transfer in BOTH.items():
        assert np.max(np.abs(found[name] - by_ramps(transfer, part, time))) < share * 100


@pytest.mark.parametrize("shift", [1e-9, 1e-10, -1e-9, 3e-7])
def test_jump_almost_on_an_even_grid(shift):
    """A break off the grid by a billionth counts: the fast mode moves by 7e6 s^-1 times the shift."""
    almost = drive("Trapezium", high=100, delay=0.01 * (1 + shift), rise=0, hold=1e-3, fall=0)
    away = np.abs(EVEN - 0.01) > 1e-8  # at the jump itself which side a sample is on is a matter of rounding
    expected = by_ramps(OTHER, almost.parts()[0], EVEN)
    assert close(one_of(OTHER, almost, EVEN)[away], expected[away])


ON_GRIDS = [(name, False) for name in EVERY] + [("square", True), ("sine", True)]


@pytest.mark.parametrize(("name", "settled"), ON_GRIDS)
def test_answer_does_not_depend_on_the_grid(name, settled):
    """Any subset of the times gets the same numbers; 40 001 samples go through the block scan."""
    many = np.linspace(0, 0.02, 2 * MANY_SAMPLES + 1)
    chosen = np.unique(np.random.default_rng(3).integers(0, len(many), 60))
    grids = many, many[chosen], many[-1:]
    found, few, last = (transient(BOTH, EVERY[name], times, settled=settled) for times in grids)
    # interpolation of a chirp depends on the samples between which it is refined
    tolerance = 3e-9 if name == "chirp" else PRECISION * 100
    for quantity in BOTH:
        assert np.max(np.abs(found[quantity][chosen] - few[quantity])) < tolerance
        assert abs(last[quantity][0] - found[quantity][-1]) < tolerance


@pytest.mark.parametrize("settled", [False, True])
def test_linear_in_the_drive(settled):
    """A sum of drives gives the sum of the answers; twice a drive twice the answer."""
    time = np.linspace(0, 0.05, 301)
    parts = [SINE, SQUARE, drive("AmplitudeModulation", amplitude=30, carrier=900, modulation=60, depth=0.5)]
    together = drive("Sum", drives=[one.to_dict() for one in parts])
    found = transient(BOTH, together, time, settled=settled)
    apart = [transient(BOTH, one, time, settled=settled) for one in parts]
    double = transient(BOTH, SQUARE.replace({"high": 200, "low": -80}), time, settled=settled)
    for name in BOTH:
        assert close(found[name], sum(one[name] for one in apart))
        assert close(double[name], 2 * apart[1][name])


SLOW_RAMP = drive("Trapezium", low=1000.0, high=1000.001, rise=1.0, hold=1.0, fall=1.0)


def test_a_current_keeps_its_digits_beside_a_large_voltage():
    """A capacitor behind a resistor passes slope/rate of a slow ramp, whatever the voltage it starts from."""
    rate, time = 1e6, np.linspace(0.0, 0.9, 901)
    current = Transfer(rates=np.array([rate]), gains=np.array([-1.0]), direct=1.0, static=0.0)
    found = one_of(current, SLOW_RAMP, time)
    assert np.allclose(found[2:], (1000.001 - 1000.0) / rate, rtol=1e-11, atol=0)


CASES = np.random.default_rng(5)
OF_CASES = {
    "first": {
        "rates": 10 ** CASES.uniform(0, 7, (5, 4)),
        "gains": CASES.normal(size=(5, 4)),
        "direct": CASES.normal(size=(5, 1)),
    },
    "shared modes": {"rates": RATES, "gains": CASES.normal(size=(5, 5)), "free": CASES.normal(size=(5, 5))},
    "lag": {
        "rates": 10 ** CASES.uniform(0, 7, (5, 4)),
        "gains": CASES.normal(size=(5, 4)),
        "static": CASES.normal(size=(5, 1)),
    },
    "slope": {"rates": RATES, "gains": CASES.normal(size=5), "slope": 1e-3 * CASES.normal(size=(5, 1))},
    "shared": {"rates": RATES, "gains": CASES.normal(size=5), "direct": 0.3},
}
STAMPS = np.linspace(0.0, 0.05, 1500)
OTHERS = {
    "sum": drive("Sum", drives=[SINE.to_dict(), SQUARE.to_dict()]),
    "record": drive(
        "Sampled", time_samples=STAMPS.tolist(), voltage_samples=np.sin(1e6 * STAMPS**2).tolist()
    ),
}
TIMES_OF_CASES = {
    "stamps": STAMPS,
    "even": np.linspace(0, 0.05, 501),
    "dense": np.linspace(0, 0.012, ALONE - 1),
    "late": np.linspace(0.03, 0.05, 300),
    "uneven": np.unique([0.0, *np.geomspace(1e-7, 0.05, 150), 0.01 / 3]),
    "one": np.array([7e-3]),
    "long": np.linspace(0, 0.05, ALONE),
}


@pytest.mark.parametrize("times", TIMES_OF_CASES)
@pytest.mark.parametrize(("name", "settled"), [*ON_GRIDS, ("sum", True), ("sum", False), ("record", False)])
def test_cases_at_once_are_those_of_each_alone(name, settled, times):
    """Rates, shares and charges that differ between cases, or that all share."""
    time, transfers = TIMES_OF_CASES[times], {key: Transfer(**each) for key, each in OF_CASES.items()}
    one = OTHERS.get(name) or EVERY[name]
    found = transient(transfers, one, time, settled=settled)
    for case in range(5):
        own = {
            key: Transfer(**{name: _of_case(number, case, name) for name, number in each.items()})
            for key, each in OF_CASES.items()
        }
        some = slice(None, None, 1 + len(time) // 150)  # so few that each is computed by itself
        alone = transient(own, one, time[some], settled=settled)
        for key, row in found.items():
            mine = (row if row.ndim == 1 else row[case])[some]
            assert np.max(np.abs(mine - alone[key])) <= 1e-13 * max(100.0, np.max(np.abs(alone[key]))), key


@pytest.mark.parametrize("static", [None, 0.3], ids=["of modes", "of lags"])
def test_a_response_from_rest_begins_at_exactly_0(static):
    """Not at the rounding of a level and its exponentials."""
    random = np.random.default_rng(7)
    ramp = drive("Trapezium", high=100, rise=0.01, hold=0.01, fall=0.01)
    for shape in ((12,), (12,), (12,), (40, 12)):
        one = Transfer(
            rates=10 ** random.uniform(0, 7, shape), gains=random.normal(size=shape), static=static
        )
        found = one_of(one, ramp, np.linspace(0, 0.009, 4000))
        assert np.all(found[..., 0] == 0.0)


def test_a_mode_far_slower_than_the_times_keeps_its_digits():
    """Its state is no difference of the level of the drive and of what is left to it."""
    slow = Transfer(rates=np.array([1e-9]), gains=np.array([1e9]))
    time = np.linspace(0, 1.0, 4001)
    found = one_of(slow, drive("Step", level=100), time)
    np.testing.assert_allclose(found, 100e9 * -np.expm1(-1e-9 * time), rtol=1e-12)


def test_even_times_long_after_a_sine_is_switched_on_show_what_still_fades():
    """For modes that have faded before the first time, that fade meanwhile, and that hardly fade."""
    burst = drive("Burst", amplitude=100, frequency=125, cycles=1000, delay=0.0)
    whole = np.arange(2 * MANY_TIMES) * 1.0 / MANY_TIMES
    found, late = one_of(HIGH_PASS, burst, whole), one_of(HIGH_PASS, burst, whole[MANY_TIMES // 2 :])
    assert np.max(np.abs(found[MANY_TIMES // 2 :] - late)) < 100 * PRECISION


def _of_case(number, case, name):
    """Return the number of one case, a level as a number."""
    own = number[case] if np.ndim(number) == 2 else number
    return float(own[0]) if name in ("direct", "static", "slope") and np.ndim(own) else own


EDGES = st.just(0.0) | st.floats(1e-12, 0.01)


@settings(max_examples=40, deadline=None)
@given(
    shift=st.floats(0, 0.05),
    rise=EDGES,
    hold=st.floats(1e-4, 0.01),
    fall=EDGES,
    times=st.lists(st.floats(0, 0.1), min_size=1, max_size=20),
)
def test_later_drive_later_answer(shift, rise, hold, fall, times):
    early = drive("Trapezium", high=100, rise=rise, hold=hold, fall=fall)
    time = np.sort(np.array(times))
    late = early.replace({"delay": shift})
    found, moved = transient(BOTH, early, time), transient(BOTH, late, time + shift)
    away = np.all(np.abs(time[:, None] - early.parts()[0].times) >= 1e-12, axis=1)
    # shifting rounds the times: 1e-17 s of 7e6/s and of slopes up to 100 V in the shortest edge
    steepest = 100 / min([each for each in (rise, fall) if each > 0], default=1.0)
    slack = 1e-10 + steepest * 1e-16 + 100 * 7e6 * 1e-16
    for name in BOTH:
        assert np.all(np.abs(found[name] - moved[name])[away] < slack)


@pytest.mark.parametrize(
    ("one", "corners"), [(SINE, [0, 0.03]), (BURST, [0, 2e-3, 14e-3, 0.03])], ids=["sine", "burst"]
)
def test_against_an_ode(one, corners):
    """From rest; the switching times of a burst are corners."""
    rates, time = RATES[:4], np.linspace(0, 0.03, 151)
    slow = Transfer(rates=rates, gains=HIGH_PASS.gains[:4], direct=0.3)
    states = np.zeros((4, 1))
    for first, last in pairwise(corners):

        def rate(now, state, first=first, last=last):
            return rates * (one.voltage(np.clip(now, first + 1e-15, last - 1e-15)) - state)

        inside = time[(time > first) & (time <= last)]
        options = {"method": "DOP853", "t_eval": inside, "rtol": 1e-12, "atol": 1e-10}
        solution = solve_ivp(rate, (first, last), states[:, -1], **options)
        states = np.append(states, solution.y, axis=1)
    expected = slow.direct * one.voltage(time) + slow.gains @ states
    assert np.max(np.abs(one_of(slow, one, time) - expected)) < 1e-9 * 100


def test_charge_fades_by_itself():
    modes = {"rates": np.array([0.0, 50.0]), "gains": np.array([0.0, 0.4]), "free": np.array([3.0, -2.0])}
    free, time, zero = Transfer(**modes), np.linspace(0, 0.1, 11), drive("Step", level=0)
    assert close(one_of(free, zero, time), 3 - 2 * np.exp(-50 * time), 1.0)
    # only trapped charge is still there after for ever
    assert close(one_of(free, zero, time, settled=True), np.full(11, 3.0), 1.0)
    driven = one_of(free, drive("Step", level=10), time)
    assert close(driven, 3 - 2 * np.exp(-50 * time) - 4 * np.expm1(-50 * time), 10.0)


# a current through 1 ohm and capacitors: nothing at zero frequency, everything at high frequency
FAST = np.array([0.3, 40.0, 130.0, 2.5e3, 7e9])
MODES = {"rates": FAST, "gains": -np.array([1e-6, 1e-3, 0.1, 10, 1e7]), "direct": 10_000_010.101001}
CURRENT = Transfer(**MODES, slope=0.0, free=np.zeros(5), static=0.0)


def lag_by_ramps(part, time):
    """The closed form of each ramp and jump for the sum of gain (x - v): no term is larger than the answer."""
    slopes = (part.before[1:] - part.after[:-1]) / np.diff(part.times)
    bends, jumps = np.diff(slopes, prepend=0.0, append=0.0), part.after - part.before
    total = np.zeros(len(time))
    for start, jump, bend in zip(part.times, jumps, bends, strict=True):
        since = np.maximum(time - start, 0.0)
        for rate, gain in zip(FAST, CURRENT.gains, strict=True):
            ramp = bend * np.expm1(-rate * since) / rate
            total += np.where(time >= start, gain * (ramp - jump * np.exp(-rate * since)), 0.0)
    return total


@pytest.mark.parametrize("count", [2001, MANY_SAMPLES + 1])
def test_small_current_keeps_its_digits(count):
    """On a slow ramp the current is 1e-7 of what the drive would push at once."""
    time = np.linspace(0, 0.02, count)
    ramp = drive("Trapezium", high=100, delay=1e-3, rise=5e-3, hold=5e-3, fall=5e-3)
    expected = lag_by_ramps(ramp.parts()[0], time)
    assert np.max(np.abs(expected)) < 1e-6 * CURRENT.direct * 100
    assert np.max(np.abs(one_of(CURRENT, ramp, time) - expected)) < 1e-11 * np.max(np.abs(expected))


@pytest.mark.parametrize("count", [1601, 16 * MANY_SAMPLES // 10 + 1])
def test_current_at_jumps_and_breaks(count):
    """Every jump of the square is a sample: the current just after it."""
    time = np.linspace(0, 0.05, count)
    found, part = one_of(CURRENT, SQUARE, time), SQUARE.parts()[0].until(0.05)
    expected = lag_by_ramps(Linear(part.times[:-1], part.before[:-1], part.after[:-1]), time)
    assert found[0] == pytest.approx(100 * CURRENT.direct, rel=1e-12)
    inside = time < 0.05 - 1e-9
    assert np.max(np.abs(found - expected)[inside]) < PRECISION * 140 * CURRENT.direct
    settled = one_of(CURRENT, SQUARE, np.array([0.0, 1 / 60 - 1e-8, 1 / 60]), settled=True)
    assert settled[0] == pytest.approx(settled[2], rel=1e-9)
    assert settled[2] - settled[1] == pytest.approx(140 * CURRENT.direct, rel=1e-4)


@pytest.mark.parametrize("settled", [False, True])
def test_current_of_tones(settled):
    time = np.linspace(0, 0.05, 301)
    found = one_of(CURRENT, drive("Offset", level=60, drive=SINE.to_dict()), time, settled=settled)
    response = np.sum(-CURRENT.gains * 1j * ANGULAR / (FAST + 1j * ANGULAR))
    steady = 100 * np.abs(response) * np.sin(ANGULAR * time + 0.7 + np.angle(response))
    states = 100 * np.imag(np.exp(0.7j) * FAST / (FAST + 1j * ANGULAR))
    fading = np.exp(-np.outer(time, FAST)) @ (CURRENT.gains * (states + 60)) * (not settled)
    tolerance = 1e-12 * np.max(np.abs(steady)) + 1e-13 * np.max(np.abs(fading))
    assert np.max(np.abs(found - steady + fading)) < tolerance


@pytest.mark.parametrize("name", EVERY)
def test_both_forms_of_a_transfer_agree_also_beside_one_of_other_modes(name):
    time, alone = np.linspace(0, 0.03, 222), Transfer(rates=np.array([77.0]), gains=np.array([1.0]))
    found = transient({"lag": CURRENT, "plain": Transfer(**MODES), "alone": alone}, EVERY[name], time)
    assert np.max(np.abs(found["lag"] - found["plain"])) < PRECISION * 140 * CURRENT.direct
    # the order in which a product of matrices is summed depends on their size and on the processor
    separate = one_of(alone, EVERY[name], time)
    assert found["alone"] == pytest.approx(separate, rel=1e-15, abs=1e-15 * np.max(np.abs(separate)))


def test_rate_of_change():
    current = Transfer(rates=np.zeros(0), gains=np.zeros(0), direct=0.0, slope=2.0)
    time = np.array([0.5e-3, 2e-3, 5e-3, 0.01])
    assert one_of(current, TRAPEZIUM, time) == pytest.approx([0, 2 * 120 / 2e-3, 0, 0], rel=1e-12)
    expected = 200 * ANGULAR * np.cos(ANGULAR * time + 0.7)
    assert one_of(current, SINE, time, settled=True) == pytest.approx(expected, rel=1e-12)


def test_periodic_states_and_what_has_none():
    """Of a constant, that has been on for ever; of a square, high for half a period, by a geometric series."""
    found = transient(BOTH, drive("Step", level=10), np.array([0.0, 1e-9, 5.0]), settled=True)
    for name, transfer in BOTH.items():
        assert close(found[name], np.full(3, 10 * (transfer.direct + transfer.gains.sum())), 10.0)
    decay = np.exp(-RATES / 120)
    at_edge = -40 + 140 * (1 - decay) * decay / (1 - decay**2)
    edges = one_of(HIGH_PASS, SQUARE, np.array([0.0, 5 / 60]), settled=True)
    assert close(edges, HIGH_PASS.direct * 100 + HIGH_PASS.gains @ at_edge)
    for one in (TRAPEZIUM, BURST, CHIRP, drive("Sum", drives=[SINE.to_dict(), BURST.to_dict()])):
        with pytest.raises(InputError, match="does not repeat"):
            transient(BOTH, one, np.linspace(0, 0.02, 5), settled=True)


def test_straight_response_of_no_more_than_it_is_asked():
    part = Linear(np.array([0.0, 1.0]), np.array([0.0, 2.0]), np.array([1.0, 2.0]))
    modes = SharedModes(np.array([3.0]), np.ones((2, 1)), np.zeros(2), np.zeros(2, bool))
    found = modes.straight(part, np.array([0.5]), np.array([7.0]))
    expected = 7 * np.exp(-1.5) - np.expm1(-1.5) + 0.5 + np.expm1(-1.5) / 3
    assert np.array(found) == pytest.approx(np.full((2, 1), expected), rel=1e-14)


MARCHED = 5e-11
"""Of the amplitude, against the march; measured 9e-12 over 120 chirps drawn at random, which is the march's own."""
EXACT = 2e-13
"""Of the amplitude, against long arithmetic; measured 3e-14."""


def each(part, rates, time, *, lag=False):
    return chirp_response(part, rates, np.eye(len(rates)), time, lag=lag)


@settings(max_examples=15)
@given(
    first=st.one_of(st.just(0.0), st.floats(-1, 2.5).map(lambda power: 10.0**power)),
    last=st.floats(-1, 2.5).map(lambda power: 10.0**power),
    length=st.floats(0.01, 1.0),
    even=st.booleans(),
)
def test_the_march(first, last, length, even):
    """Rising, falling and of one frequency, beneath modes slower and faster than all of it, and after its end."""
    part = Chirped.between(1.0, last if even else first, last, length)
    crossed = np.sqrt(2 * GONE * np.pi * max(abs(part.sweep), 1e-3))
    rates = np.concatenate([[1e-30], np.geomspace(1e-2, 1e7, 10), crossed * np.array([0.3, 0.99, 1.01, 3.0])])
    time = np.unique(np.append(np.linspace(0, 1.3 * length, 300), length))
    marched, states = smooth_states(part, rates, time), each(part, rates, time)
    assert np.max(np.abs(states - marched)) < MARCHED
    np.testing.assert_allclose(states[0], marched[0], rtol=0, atol=1e-9 * np.max(np.abs(marched[0])))
    assert np.max(np.abs(each(part, rates, time, lag=True) - (marched - part.value(time)))) < MARCHED


@pytest.mark.slow
@pytest.mark.parametrize(("first", "last"), [(1.0, 60.0), (60.0, 0.5), (0.0, 40.0)])
def test_long_arithmetic(first, last):
    part = Chirped.between(1.0, first, last, 0.5)
    rates, time = np.array([2.0, 40.0, 180.0, 900.0, 2e5]), np.array([0.02, 0.21, 0.4999])
    found, lags = each(part, rates, time), each(part, rates, time, lag=True)
    with mpmath.workdps(30):
        a, b = mpmath.pi * mpmath.mpf(part.sweep), 2 * mpmath.pi * mpmath.mpf(first)
        for (row, column), value in np.ndenumerate(found):
            rate, end = float(rates[row]), mpmath.mpf(float(time[column]))

            def fading(u, rate=rate, end=end):
                return mpmath.exp(-rate * (end - u)) * mpmath.sin(b * u + a * u * u)

            expected = rate * mpmath.quad(fading, mpmath.linspace(max(0.0, end - 80 / rate), end, 40))
            assert abs(value - expected) < EXACT
            assert abs(lags[row, column] - (expected - mpmath.sin(b * end + a * end**2))) < EXACT
    assert np.max(np.abs(lags[-1])) > 1e4 * EXACT  # a fast mode lags by w over its rate


@pytest.mark.parametrize("lag", [False, True])
def test_many_times_read_what_few_do(lag):
    """Polynomials through the envelope: the same at a million times as at some of them, without and with lag."""
    part, time = Chirped.between(1.0, 1.0, 1e4, 100.0), np.linspace(0, 101, 200_001)
    rates = np.geomspace(1e-3, 1e9, 60)
    gains = np.array([np.ones(60), np.where(np.arange(60) % 2, 1.0, -1.0)])
    some = np.unique(np.concatenate([np.arange(40), np.arange(0, 200_001, 4999), [198_018, 198_020]]))
    many = chirp_response(part, rates, gains, time, lag=lag)[:, some]
    few = np.hstack([chirp_response(part, rates, gains, time[[place]], lag=lag) for place in some])
    assert np.max(np.abs(many - few)) < 1e-12
    assert np.max(np.abs(few)) > 1


def test_a_chirp_as_a_current_and_an_unknown_formula():
    """A divided chirp stays one; the same as a formula that says nothing of itself gives the same."""
    table = {"model": "Chirp", "amplitude": 3.0, "first": 200.0, "last": 10.0, "length": 0.05}
    drive = read_model(Drive, {"model": "CurrentAmplifier", "command": table, "sense_resistance": 1e3})
    (part,), (plain,) = drive.parts(), read_model(Drive, table).parts()
    assert isinstance(part, Chirped)
    assert part.bound() == pytest.approx(3e-3)
    rates, gains, time = np.array([5.0, 700.0]), np.array([1.0, -0.3]), np.linspace(0, 0.06, 41)
    wanted = Transfer(rates=rates, gains=gains, direct=0.2, slope=1e-4)
    unknown = Smooth(plain.formula, plain.derivative, plain.start, plain.stop, plain.highest_frequency)
    marched = gains @ smooth_states(unknown, rates, time) + 0.2 * plain.value(time) + 1e-4 * plain.slope(time)
    np.testing.assert_allclose(transient({"x": wanted}, drive, time)["x"], marched / 1e3, atol=1e-12)


def test_a_long_chirp_is_answered_without_its_cycles(monkeypatch):
    """5e5 cycles on a skin with a memory: nothing marches, and no array is as long as the chirp has cycles."""
    drive = {"model": "Chirp", "amplitude": 100, "first": 1, "last": 1e4, "length": 100}
    causal = {"force": {"model": "Vezzoli2014Causal"}, "time.initial_state": {"model": "AtRest"}}
    scenario = ev.load("vezzoli_2014/fig7", changes={"drive": drive} | causal)
    longest = []

    def counted(part, rates, gains, time, *, lag=False):
        longest.append(len(time))
        return chirp_response(part, rates, gains, time, lag=lag)

    monkeypatch.setattr("electrovib.solve.electrics.transient.smooth_states", None)
    monkeypatch.setattr("electrovib.solve.electrics.transient.chirp_response", counted)
    trace = ev.simulate(scenario)
    assert max(longest) < 50_000
    sure = ev.simulate(scenario, time=np.array([0.0, *trace.time.values[[700, 1999]]])).electrostatic_force
    force = trace.electrostatic_force.values
    np.testing.assert_allclose(sure[1:], force[[700, 1999]], rtol=1e-3, atol=1e-4 * force.max())
    expanded, time = Expanded(scenario), np.linspace(0, 100, 20_001)
    few = expanded.at(time[::1000]).solution.force
    many = expanded.at(time).solution.force[::1000]
    np.testing.assert_allclose(many, few, rtol=1e-9, atol=1e-10 * few.max())
