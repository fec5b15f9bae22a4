"""Forces that are no straight lines through mechanics and rig: against closed forms, with the error it states."""

import math

import numpy as np
import pytest

from electrovib.core.errors import InputError
from electrovib.physics.finger import MassSpringDamper
from electrovib.physics.rig import Digitiser, LateralSensor, PiezoSensor, SensorCreep, Tribometer
from electrovib.solve.mechanics.filters import (
    cascade,
    filtered,
    first_order,
    high_pass,
    of_stages,
    second_order,
)
from electrovib.solve.mechanics.response import respond_mechanically
from electrovib.solve.mechanics.rig import finger_filters, measured

OMEGA = 2 * np.pi * 120.0
FILTERS = {
    "sensor": second_order(natural_frequency=900.0, damping_ratio=0.3),
    "stiff": second_order(natural_frequency=2e6, damping_ratio=0.7),
    "lag": cascade(first_order(50.0), high_pass(0.2)),
    **finger_filters(MassSpringDamper(mass=1.5e-4, stiffness=1e3, damping=1.0)),
}
EVEN = np.linspace(0.0, 0.05, 301)
UNEVEN = np.cumsum(np.random.default_rng(2).exponential(2e-4, 250))


def squared(time):
    """Force of a sine squared: constant and twice the frequency."""
    return 0.3 * np.sin(OMEGA * time) ** 2


def answer(filter_, time, *, since=0.0):
    """From rest to 0.15 (1 - cos 2wt), mode by mode in closed form."""
    time = time - since
    total = filter_.direct * squared(time + since).astype(complex)
    for pole, gain in zip(filter_.poles, filter_.gains, strict=True):
        state = np.zeros(len(time), complex)
        tones = ((0.15, 0.0), (-0.075, 2 * OMEGA), (-0.075, -2 * OMEGA))
        for height, angular in tones:
            ratio = -pole / (1j * angular - pole) * np.exp(1j * angular * since)
            state += height * ratio * (np.exp(1j * angular * time) - np.exp(pole * time))
        total += gain * state if not pole.imag else 2 * (gain * state).real
    return total.real


@pytest.mark.parametrize("times", [EVEN, UNEVEN], ids=["even", "uneven"])
def test_error_is_stated_and_kept(times):
    outputs, error = respond_mechanically(squared, FILTERS, times, held=0.0, shortest=1 / 240)
    assert 0 < error <= 1e-6
    assert list(outputs) == list(FILTERS)
    for name, output in outputs.items():  # nothing before the first time: the force begins with a jump there
        exact = answer(FILTERS[name], times, since=times[0])
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

        _, error = respond_mechanically(counted, slow, EVEN, tolerance=tolerance, held=0.0, shortest=1 / 4800)
        assert error <= tolerance
        counts[tolerance] = pieces[-1]
    assert 2 <= counts[1e-10] / counts[1e-5] <= 8
    _, error = respond_mechanically(squared, FILTERS, EVEN, tolerance=1e-9, most=20_000)
    assert 1e-9 < error < 1e-3  # where the pieces do not suffice the error says so


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
    outputs, error = respond_mechanically(stairs, filters, times, corners=jumps, held=0.0)
    assert error < 1e-12
    for name, output in outputs.items():
        exact = sum(answer_to_a_step(name, times - jump) for jump in jumps)
        assert output == pytest.approx(exact, abs=1e-9 * len(jumps))
    if len(jumps) == 1:
        _, unnamed = respond_mechanically(stairs, filters, times, held=0.0, most=100_000)
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
    times = np.linspace(1.0, 1.1, 50)
    for held, expected in ((0.0, 1.0), (0.1, math.exp(-1.0)), (math.inf, 0.0)):
        outputs, _ = respond_mechanically(np.ones_like, {"pass": high_pass(0.1)}, times, held=held)
        exact = expected * np.exp(-(times - 1.0) / 0.1)
        assert outputs["pass"] == pytest.approx(exact, abs=1e-12)
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
STAGES = (("normal", RIG.normal_stages()), ("lateral", RIG.lateral_stages()))


def digitised(**changes):
    content = {"sampling_rate": 1e4, "bits": 16, "normal_range": 2.0, "lateral_range": 1.0, "seed": 7}
    return Digitiser(**(content | changes))


def test_rig_without_digitiser_is_its_filters_and_samples_are_followed_exactly():
    found = measured(RIG, EVEN, squared, squared, held=0.0, shortest=1 / 240)
    assert set(found.signals) == {"normal_force_measured", "lateral_force_measured"}
    assert found.diagnostics == []
    assert 0 < found.error <= 1e-6
    for name, stages in STAGES:
        exact = answer(of_stages(stages), EVEN)
        assert np.abs(found.signals[f"{name}_force_measured"] - exact).max() <= 1e-6 * np.abs(exact).max()
    samples = np.random.default_rng(5).normal(size=EVEN.size)
    for held in (0.0, math.inf):
        found = measured(RIG, EVEN, samples, samples, held=held)
        assert found.error == 0.0
        for name, stages in STAGES:
            expected = filtered(of_stages(stages), samples, step=EVEN[1], settled=math.isinf(held))
            assert found.signals[f"{name}_force_measured"] == pytest.approx(expected, abs=1e-11)


def test_readings_are_held_rounded_and_clipped():
    rig = Tribometer(**SENSORS, digitiser=digitised(sampling_rate=1e3, bits=8, lateral_range=0.1))
    found = measured(rig, EVEN, squared, squared, held=0.0)
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
    times, force = np.arange(20_000) * 1e-4, np.full(20_000, 0.2)
    one, same, other = (
        measured(Tribometer(**sensors, digitiser=digitised(seed=seed)), times, force, force).signals
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
        (lambda: measured(RIG, EVEN, np.ones(4), np.ones(4)), "normal_force: 4 samples for 301 times"),
        (lambda: measured(FAST, EVEN, squared, squared), "Lower the rate"),
    ],
)
def test_what_cannot_be_followed_is_refused(call, message):
    with pytest.raises(InputError, match=message):
        call()
