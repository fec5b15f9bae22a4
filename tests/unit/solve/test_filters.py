"""Filters of declared stages against closed forms; forces that are no straight lines through mechanics and rig."""

import math

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from electrovib.core.budget import BudgetError, budget
from electrovib.core.errors import InputError
from electrovib.physics.finger import MassSpringDamper
from electrovib.physics.relaxation import release_seen_by_sensor
from electrovib.physics.rig import Digitiser, LateralSensor, PiezoSensor, SensorCreep, Tribometer
from electrovib.physics.stages import CreepResponse, HighPass, LowPass, Resonance, response
from electrovib.solve.mechanics import filters
from electrovib.solve.mechanics import response as mechanics
from electrovib.solve.mechanics.filters import (
    Filter,
    cascade,
    first_order,
    high_pass,
    march_through,
    of_stages,
    relaxing,
    second_order,
)
from electrovib.solve.mechanics.response import finger_filters, measured, respond, respond_mechanically

SENSOR = 1e-10
"""Largest error of a second-order sensor allowed, of the input: the target of the project."""
ROUNDING = 2e-12
"""What it really is: some ten roundings times gains of up to 350 near critical damping."""
DAMPINGS = [0.01, 0.44, 0.999, 1 - 2e-6, 1 - 3e-7, 1.0, 1 + 1e-9, 1 + 8e-7, 1 + 2e-6, 1.5, 50.0]
NATURAL = 4400.0
FREQUENCY = np.geomspace(1.0, 1e6, 400)


def sensor_of(damping, frequency=NATURAL):
    return second_order(natural_frequency=frequency, damping_ratio=damping)


def filtered(filter_, samples, step, state):
    """Output for an input that is straight between samples."""
    return march_through(filter_, samples[:-1], samples[1:], steps=step, state=state)


def exact(time, damping, *, ramp=False):
    """Answer to a step of 1, or to a ramp of 1 per second, of w0^2/(s^2 + 2 zeta w0 s + w0^2), in 50 digits.

    Step: 1 - e^(-zeta x)(cosh(r x) + zeta sinh(r x)/r), r = sqrt(zeta^2 - 1), x = w0 t. Ramp: its integral,
    t - 2 zeta/w0 + e^(-zeta x)(2 zeta cosh(r x) + (2 zeta^2 - 1) sinh(r x)/r)/w0.
    """
    with mpmath.workdps(50):
        zeta, angular, time = mpmath.mpf(damping), 2 * mpmath.pi * mpmath.mpf(NATURAL), mpmath.mpf(time)
        x, r = angular * time, mpmath.sqrt(mpmath.mpc(zeta**2 - 1))
        even, odd = mpmath.cosh(r * x), mpmath.sinh(r * x) / r if r else x
        fade = mpmath.exp(-zeta * x)
        if not ramp:
            return float((1 - fade * (even + zeta * odd)).real)
        return float((time - (2 * zeta - fade * (2 * zeta * even + (2 * zeta**2 - 1) * odd)) / angular).real)


@pytest.mark.parametrize("damping", DAMPINGS)
@pytest.mark.parametrize("ramp", [False, True])
def test_second_order_sensor_against_closed_form(damping, ramp):
    """At even and at uneven times, and decimated; over frequency."""
    sensor, step, count = sensor_of(damping), 2.0**-20, 1500
    even = np.arange(count) * step
    wanted = np.array([exact(time, damping, ramp=ramp) for time in even[::7]])
    scale = np.abs(wanted).max()
    found = filtered(sensor, even if ramp else np.ones(count), step, sensor.state(0.0))
    assert np.abs(found[::7] - wanted).max() < ROUNDING * scale < SENSOR * scale
    assert np.abs(found[::7] * (1 + 1e-8) - wanted).max() > SENSOR * scale

    random = np.random.default_rng(4)
    uneven = np.append(0.0, np.cumsum(random.exponential(5e-6, 200)))
    wanted = np.array([exact(time, damping, ramp=ramp) for time in uneven])
    found = filtered(sensor, uneven if ramp else np.ones(201), np.diff(uneven), sensor.state(0.0))
    assert np.abs(found - wanted).max() < ROUNDING * np.abs(wanted).max()

    # gains of 350 cancel at high frequency, near critical
    formula = Resonance(NATURAL, damping).at(FREQUENCY)
    assert np.abs(sensor.at(FREQUENCY) - formula).max() < ROUNDING * np.abs(formula).max()


def test_interpolation_at_critical_damping_keeps_what_it_states(monkeypatch):
    """Error 0.6 CRITICAL^2 (the curvature is largest at w0/sqrt 2, 32/27): seen with a hundredfold CRITICAL."""
    monkeypatch.setattr(filters, "CRITICAL", 1e-4)
    off = np.abs(sensor_of(1.0).at(FREQUENCY) - Resonance(NATURAL, 1.0).at(FREQUENCY)).max()
    assert off == pytest.approx(16 / 27 * 1e-8, rel=1e-3)


STAGES = (
    Resonance(NATURAL, 0.44),
    Resonance(90.0, 3.0),
    LowPass(6.4e3),
    HighPass(0.7),
    CreepResponse((0.02, -0.01), (3.0, 0.05)),
)
CHAIN = of_stages(STAGES)


def test_stages_and_their_filter_agree_over_frequency_and_a_rate_is_the_derivative():
    frequency = np.concatenate([[0.0], np.geomspace(1e-3, 1e5, 500)])
    formula, found = response(STAGES, frequency), CHAIN.at(frequency)
    assert np.abs(found - formula).max() < 1e-13 * np.abs(formula).max()
    assert np.abs(found - response(STAGES[:-1], frequency)).max() > 1e-3
    assert of_stages(()).at(3.0) == 1.0
    sensor = cascade(sensor_of(0.3, 200.0), first_order(900.0))
    expected = 2j * np.pi * frequency * sensor.at(frequency)
    assert np.abs(sensor.rate().at(frequency) - expected).max() < 1e-12 * np.abs(expected).max()


@settings(deadline=None, max_examples=60)
@given(st.floats(0.05, 20.0), st.floats(0.0, 5.0), st.integers(0, 2**32 - 1))
def test_one_after_the_other_is_the_cascade(damping, ratio, seed):
    sensor, low = sensor_of(damping, 1000.0), first_order(100.0 * 10**ratio)
    try:
        both = cascade(sensor, low)
    except InputError:
        return
    frequency = 10 ** np.random.default_rng(seed).uniform(0, 6, 50)
    assert np.abs(both.at(frequency) - sensor.at(frequency) * low.at(frequency)).max() < 1e-9


def test_settled_is_what_a_long_hold_ends_in():
    found = filtered(CHAIN, np.full(100, 3.0), 1e-4, CHAIN.state(3.0))
    assert found == pytest.approx(3.0 * CHAIN.at_rest(), abs=1e-13)
    held = filtered(CHAIN, np.full(2, 3.0), 1e4, CHAIN.state(0.0))
    assert held[1] == pytest.approx(found[0], abs=1e-12)
    assert filtered(high_pass(1.0), np.ones(2), 1.0, np.zeros(1))[0] == 1.0


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Filter([1.0], [1.0]), "real parts must be negative"),
        (lambda: Filter([-1 - 1j], [1.0]), "positive imaginary part"),
        (lambda: Filter([-1.0], [1j]), "gain of a real pole must be real"),
        (lambda: Filter([-1.0], [1.0, 2.0]), "one for each pole"),
        (lambda: sensor_of(0.0), "must be positive"),
        (lambda: sensor_of(1.0, math.nan), "must be positive"),
        (lambda: cascade(first_order(10.0), first_order(10.0)), "too close to be separated"),
        (lambda: cascade(sensor_of(0.1), sensor_of(0.1)), "too close to be separated"),
        (lambda: relaxing([0.1], [-1.0]), "real parts must be negative"),
        (lambda: high_pass(1.0).rate(), "rate of a discontinuous output"),
    ],
)
def test_what_is_no_filter_is_refused(make, message):
    with pytest.raises(InputError, match=message):
        make()


def test_a_release_is_what_the_closed_form_of_the_resonance_says():
    """Two routes to one reading: the declared resonance behind straight pieces, and its closed form."""
    frequency, quality, start, fall = 390.0, 3.3, 2e-3, 0.5e-3
    stamps = np.concatenate([[0.0], start + np.linspace(0, 20e-3, 40_001)])
    force = np.where(stamps <= start, 1.0, np.exp(-(stamps - start) / fall))
    sensor = sensor_of(1 / (2 * quality), frequency)
    found = filtered(sensor, force, np.diff(stamps), sensor.state(1.0))
    declared = {"start": start, "fall_time": fall, "frequency": frequency, "quality": quality}
    expected = release_seen_by_sensor(stamps, **declared)
    # pieces of 0.5 us bend by 1e-7
    np.testing.assert_allclose(found, expected, atol=1e-6)


OMEGA = 2 * np.pi * 120.0
FILTERS = {
    "sensor": second_order(natural_frequency=900.0, damping_ratio=0.3),
    "stiff": second_order(natural_frequency=2e6, damping_ratio=0.7),
    "lag": cascade(first_order(50.0), high_pass(0.2)),
    **finger_filters(MassSpringDamper(mass=1.5e-4, stiffness=1e3, damping=1.0)),
}
EVEN = np.linspace(0.0, 0.05, 301)
UNEVEN = np.append(0.0, np.cumsum(np.random.default_rng(2).exponential(2e-4, 250)))


def squared(time):
    """Force of a sine squared: constant and twice the frequency."""
    return 0.3 * np.sin(OMEGA * time) ** 2


def answer(filter_, time):
    """From rest to 0.15 (1 - cos 2wt), mode by mode in closed form."""
    total = filter_.direct * squared(time).astype(complex)
    for pole, gain in zip(filter_.poles, filter_.gains, strict=True):
        state = np.zeros(len(time), complex)
        tones = ((0.15, 0.0), (-0.075, 2 * OMEGA), (-0.075, -2 * OMEGA))
        for height, angular in tones:
            ratio = -pole / (1j * angular - pole)
            state += height * ratio * (np.exp(1j * angular * time) - np.exp(pole * time))
        total += gain * state if not pole.imag else 2 * (gain * state).real
    return total.real


@pytest.mark.parametrize("times", [EVEN, UNEVEN], ids=["even", "uneven"])
def test_error_is_stated_and_kept(times):
    outputs, error = respond_mechanically(squared, FILTERS, times, shortest=1 / 240)
    assert 0 < error <= 1e-6
    assert list(outputs) == list(FILTERS)
    for name, output in outputs.items():
        exact = answer(FILTERS[name], times)
        off = np.abs(output - exact).max() / np.abs(exact).max()
        assert off <= error, name
        assert np.abs(output * 1.0001 - exact).max() / np.abs(exact).max() > 10 * error


def test_sixth_order_in_the_step():
    """A tolerance 10^5 times smaller takes some eight times the pieces, not three hundred."""
    counts = {}
    slow = {name: each for name, each in FILTERS.items() if name != "stiff"}
    for tolerance in (1e-5, 1e-10):
        pieces = []

        def counted(time, pieces=pieces):
            pieces.append(len(time) - 1)
            return np.sin(40 * OMEGA * time)

        _, error = respond_mechanically(counted, slow, EVEN, tolerance=tolerance, shortest=1 / 4800)
        assert error <= tolerance
        counts[tolerance] = pieces[-1]
    assert 2 <= counts[1e-10] / counts[1e-5] <= 8
    _, error = respond_mechanically(squared, FILTERS, EVEN, tolerance=1e-9, most=20_000)
    assert 1e-9 < error < 1e-3  # where the pieces do not suffice the error says so


@pytest.mark.parametrize("count", [1, 999, 1000, 1001, 2500])
def test_a_force_in_parts_is_that_at_all_times(count, monkeypatch):
    monkeypatch.setattr(mechanics, "PIECES", 1000)
    times, asked = np.linspace(0.0, 0.1, count), []

    def counted(some):
        asked.append(len(some))
        return squared(some)

    assert np.array_equal(mechanics._in_parts(counted, end=0.1)(times), squared(times))
    assert max(asked) <= 1000


def test_a_force_that_takes_longer_than_is_allowed_ends():
    with budget(time=1e-9), pytest.raises(BudgetError, match="motion of finger and rig"):
        respond_mechanically(squared, FILTERS, EVEN, shortest=1 / 240)


def answer_to_a_step(name, since):
    if name == "pass":
        return np.where(since >= -1e-12, np.exp(-np.maximum(since, 0) / 0.1), 0.0)
    shown = np.zeros(len(since))
    for pole, gain in zip(FILTERS[name].poles, FILTERS[name].gains, strict=True):
        shown += 2 * (gain * -np.expm1(pole * np.maximum(since, 0))).real
    return shown


@pytest.mark.parametrize(
    "times", [EVEN, UNEVEN, np.linspace(0.0, 1e-2, 11)], ids=["even", "uneven", "at jumps"]
)
def test_jumps_that_are_named_cost_nothing(times):
    """Between the wanted times, and at them and at the last; a jump is looked at 1e-6 of a piece too early."""
    jumps = times[1:] if len(times) == 11 else np.array([0.0123])

    def stairs(time):
        return np.sum(time >= jumps[:, None] - 1e-12, axis=0).astype(float)

    filters = {"sensor": FILTERS["sensor"], "pass": high_pass(0.1)}
    outputs, error = respond_mechanically(stairs, filters, times, corners=jumps)
    assert error < 1e-12
    for name, output in outputs.items():
        exact = sum(answer_to_a_step(name, times - jump) for jump in jumps)
        assert output == pytest.approx(exact, abs=1e-9 * len(jumps))
    if len(jumps) == 1:
        _, unnamed = respond_mechanically(stairs, filters, times, most=100_000)
        assert unnamed > 1e-4


def test_a_fast_oscillation_is_seen_when_it_is_named():
    """The first two grids meet it at the same phase: nothing seems to move."""

    def fast(time):
        return np.sin(2 * np.pi * 120_000 * time + 0.5)

    times = np.linspace(0.0, 0.05, 3001)
    quiet = {"sensor": first_order(20.0)}
    blind, error = respond_mechanically(fast, quiet, times)
    assert error < 1e-9
    seen, _ = respond_mechanically(fast, quiet, times, shortest=1 / 120_000)
    assert np.abs(seen["sensor"][-1]) < 0.1 * np.abs(blind["sensor"][-1])


def test_held_before_the_first_time():
    outputs, _ = respond_mechanically(np.ones_like, {"pass": high_pass(0.1)}, np.linspace(1.0, 1.1, 50))
    assert outputs["pass"] == pytest.approx(0.0, abs=1e-12)
    outputs, error = respond_mechanically(lambda time: 2.0 + 0 * time, FILTERS, [0.3])  # one time
    assert error == 0.0
    assert outputs["sensor"].tolist() == pytest.approx([2.0])


def test_skin_in_the_steady_state_of_a_sine():
    """Amplitude and phase of displacement and speed are those of the declared compliance."""
    finger = MassSpringDamper(mass=2e-4, stiffness=800.0, damping=0.5)
    times = np.linspace(0.2, 0.21, 100)  # long after the beginning, 5 ms a time constant
    all_times = np.concatenate([np.linspace(0.0, 0.19, 20), times])
    outputs, _ = respond_mechanically(lambda time: np.cos(OMEGA * time), finger_filters(finger), all_times)
    wave = finger.compliance(120.0) * np.exp(1j * OMEGA * times)
    for name, expected in (("skin_displacement", wave.real), ("skin_speed", (1j * OMEGA * wave).real)):
        assert outputs[name][20:] == pytest.approx(expected, abs=2e-6 * np.abs(expected).max())


QUIET = LateralSensor(natural_frequency=500.0, damping_ratio=0.1)
CREEP = SensorCreep(share=-0.05, time=0.02)
SENSORS = {
    "normal": PiezoSensor(natural_frequency=2e3, damping_ratio=0.2, time_constant=0.5),
    "lateral": QUIET.replace({"bandwidth": 5e3, "creep": CREEP}),
}
RIG = Tribometer(**SENSORS)
OF_RIG = (("normal", RIG.normal_stages()), ("lateral", RIG.lateral_stages()))


def digitised(**changes):
    content = {"sampling_rate": 1e4, "bits": 16, "normal_range": 2.0, "lateral_range": 1.0, "seed": 7}
    return Digitiser(**(content | changes))


def both(*forces, **options):
    """Return the responses of sensors to forces: numbers, or functions of time."""

    def under(force):
        if callable(force):
            return lambda sensor, moments: respond(force, sensor, moments, **options)
        return lambda sensor, moments: (np.full(len(moments), force * sensor.at_rest()), 0.0)

    return [under(force) for force in forces]


def test_rig_without_digitiser_is_its_filters():
    found = measured(RIG, EVEN, *both(squared, squared, shortest=1 / 240))
    assert set(found.signals) == {"normal_force_measured", "lateral_force_measured"}
    assert found.diagnostics == []
    assert 0 < found.error <= 1e-6
    for name, stages in OF_RIG:
        exact = answer(of_stages(stages), EVEN)
        assert np.abs(found.signals[f"{name}_force_measured"] - exact).max() <= 1e-6 * np.abs(exact).max()
    constant = measured(RIG, EVEN, *both(0.3, squared)).signals["normal_force_measured"]
    assert constant == pytest.approx(0.3 * of_stages(RIG.normal_stages()).at_rest(), abs=1e-15)


def test_readings_are_held_rounded_and_clipped():
    rig = Tribometer(**SENSORS, digitiser=digitised(sampling_rate=1e3, bits=8, lateral_range=0.1))
    found = measured(rig, EVEN, *both(squared, squared))
    moments = np.arange(51) * 1e-3
    exact = answer(of_stages(rig.normal_stages()), moments)
    expected = np.round(exact * 64) / 64
    place = np.floor(EVEN * 1e3 + 1e-6).astype(int)
    assert np.abs(found.signals["normal_force_measured"] - expected[place]).max() <= 1 / 64
    assert np.mean(found.signals["normal_force_measured"] != expected[place]) < 0.05  # but for a tie
    lateral = found.signals["lateral_force_measured"]
    assert lateral.max() == 0.1 * 127 / 128
    diagnostics = {diagnostic.name: diagnostic for diagnostic in found.diagnostics}
    assert diagnostics["normal range"].state == "ok"
    assert diagnostics["lateral range"].state == "warning"
    beyond = int(diagnostics["lateral range"].text.split(" of ")[0])
    exact = answer(of_stages(rig.lateral_stages()), moments)
    assert beyond == np.count_nonzero(np.round(exact * 1280) > 127)


def test_noise_is_as_declared_and_repeats():
    sensors = {
        "normal": SENSORS["normal"].replace({"noise": 2e-3}),
        "lateral": QUIET.replace({"noise": 5e-3}),
    }
    times = np.arange(20_000) * 1e-4
    one, same, other = (
        measured(Tribometer(**sensors, digitiser=digitised(seed=seed)), times, *both(0.2, 0.2)).signals
        for seed in (7, 7, 8)
    )
    normal, lateral = one["normal_force_measured"], one["lateral_force_measured"] - 0.2
    # 20 000 readings give a deviation to 0.5 %; levels of 30 to 60 uN add nothing to 2 mN
    assert np.std(normal) == pytest.approx(2e-3, rel=0.02)
    assert np.std(lateral) == pytest.approx(5e-3, rel=0.02)
    assert abs(np.mean(lateral)) < 5 * 5e-3 / math.sqrt(20_000)
    assert abs(np.corrcoef(normal, lateral)[0, 1]) < 5 / math.sqrt(20_000)
    assert all(np.array_equal(one[name], same[name]) for name in one)
    assert not np.array_equal(one["lateral_force_measured"], other["lateral_force_measured"])


FAST = Tribometer(**SENSORS, digitiser=digitised(sampling_rate=1e9))


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: respond_mechanically(squared, FILTERS, [0.0, 0.0]), "times that increase"),
        (lambda: respond_mechanically(squared, FILTERS, []), "at least one"),
        (
            lambda: respond_mechanically(squared, FILTERS, EVEN, most=500),
            "Choose a shorter time.duration, fewer",
        ),
        (lambda: respond_mechanically(lambda time: time + np.nan, FILTERS, EVEN), "is nan"),
        (lambda: measured(FAST, EVEN, *both(squared, squared)), "Lower the rate"),
    ],
)
def test_what_cannot_be_followed_is_refused(call, message):
    with pytest.raises(InputError, match=message):
        call()
