"""Forces that are no straight lines through mechanics and rig: against closed forms, with the error it states."""

from __future__ import annotations

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
    for name, output in outputs.items():
        exact = answer(FILTERS[name], times, since=times[0])
        if times[0] > 0:  # nothing before the first time: the force began with a jump there
            assert squared(times[:1])[0] > 0
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


def test_where_the_pieces_do_not_suffice_the_error_says_so():
    _, error = respond_mechanically(squared, FILTERS, EVEN, tolerance=1e-9, most=20_000)
    assert 1e-9 < error < 1e-3


def test_a_jump_that_is_named_costs_nothing():
    def step(time):
        return np.where(time < 0.0123, 0.0, 1.0)

    for times in (EVEN, UNEVEN):
        filters = {"sensor": FILTERS["sensor"], "pass": high_pass(0.1)}
        outputs, error = respond_mechanically(step, filters, times, corners=[0.0123], held=0.0)
        since = times - 0.0123
        exact = filtered_step(filters["sensor"], since)
        assert error < 1e-12
        assert (
            np.abs(outputs["sensor"] - exact).max() < 1e-9
        )  # the jump is looked at 1e-6 of a piece too early
        assert outputs["pass"] == pytest.approx(np.where(since >= 0, np.exp(-since / 0.1), 0.0), abs=1e-9)
        _, unnamed = respond_mechanically(step, filters, times, held=0.0, most=100_000)
        assert unnamed > 1e-4


def filtered_step(filter_, since):
    shown = np.zeros(len(since))
    for pole, gain in zip(filter_.poles, filter_.gains, strict=True):
        shown += 2 * (gain * -np.expm1(pole * np.maximum(since, 0))).real
    return shown


def test_jumps_at_wanted_times_and_at_the_last():
    times = np.linspace(0.0, 1e-2, 11)

    def stairs(time):
        return np.floor(time * 1e3 + 1e-9)

    filters = {"sensor": FILTERS["sensor"], "pass": high_pass(0.1)}
    outputs, error = respond_mechanically(stairs, filters, times, corners=times, held=0.0)
    assert error < 1e-12
    for name, shape in (
        ("sensor", lambda since: filtered_step(filters["sensor"], since)),
        ("pass", lambda since: np.where(since >= -1e-12, np.exp(-np.maximum(since, 0) / 0.1), 0.0)),
    ):
        exact = sum(shape(times - jump) for jump in times[1:])
        assert outputs[name] == pytest.approx(exact, abs=1e-8)


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


def test_one_time():
    outputs, error = respond_mechanically(lambda time: 2.0 + 0 * time, FILTERS, [0.3])
    assert error == 0.0
    assert outputs["sensor"].tolist() == pytest.approx([2.0])


def test_skin_in_the_steady_state_of_a_sine():
    """Amplitude and phase of displacement and speed are those of the declared compliance."""
    finger = MassSpringDamper(mass=2e-4, stiffness=800.0, damping=0.5)
    times = np.linspace(0.2, 0.21, 100)  # long after the beginning, 5 ms a time constant
    all_times = np.concatenate([np.linspace(0.0, 0.19, 20), times])
    outputs, _ = respond_mechanically(lambda time: np.cos(OMEGA * time), finger_filters(finger), all_times)
    wave = finger.compliance(120.0) * np.exp(1j * OMEGA * times)
    assert outputs["skin_displacement"][20:] == pytest.approx(
        wave.real, abs=2e-6 * abs(finger.compliance(120.0))
    )
    speed = (1j * OMEGA * wave).real
    assert outputs["skin_speed"][20:] == pytest.approx(speed, abs=2e-6 * np.abs(speed).max())


SENSORS = {
    "normal": PiezoSensor(natural_frequency=2e3, damping_ratio=0.2, time_constant=0.5),
    "lateral": LateralSensor(
        natural_frequency=500.0, damping_ratio=0.1, bandwidth=5e3, creep=SensorCreep(share=-0.05, time=0.02)
    ),
}
RIG = Tribometer(**SENSORS)


def digitised(**changes):
    content = {"sampling_rate": 1e4, "bits": 16, "normal_range": 2.0, "lateral_range": 1.0, "seed": 7}
    return Digitiser(**(content | changes))


def test_rig_without_digitiser_is_its_filters():
    found = measured(RIG, EVEN, squared, squared, held=0.0, shortest=1 / 240)
    assert set(found.signals) == {"normal_force_measured", "lateral_force_measured"}
    assert found.diagnostics == []
    assert 0 < found.error <= 1e-6
    for name, stages in (("normal", RIG.normal_stages()), ("lateral", RIG.lateral_stages())):
        exact = answer(of_stages(stages), EVEN)
        assert np.abs(found.signals[f"{name}_force_measured"] - exact).max() <= 1e-6 * np.abs(exact).max()


@pytest.mark.parametrize("held", [0.0, math.inf])
def test_samples_are_followed_exactly(held):
    samples = np.random.default_rng(5).normal(size=EVEN.size)
    found = measured(RIG, EVEN, samples, samples, held=held)
    assert found.error == 0.0
    for name, stages in (("normal", RIG.normal_stages()), ("lateral", RIG.lateral_stages())):
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
    quiet = LateralSensor(natural_frequency=500.0, damping_ratio=0.1)
    sensors = {
        "normal": SENSORS["normal"].replace({"noise": 2e-3}),
        "lateral": quiet.replace({"noise": 5e-3}),
    }
    times = np.arange(20_000) * 1e-4
    force = np.full(times.size, 0.2)
    one = measured(Tribometer(**sensors, digitiser=digitised()), times, force, force).signals
    same = measured(Tribometer(**sensors, digitiser=digitised()), times, force, force).signals
    other = measured(Tribometer(**sensors, digitiser=digitised(seed=8)), times, force, force).signals
    normal, lateral = one["normal_force_measured"], one["lateral_force_measured"] - 0.2
    # 20 000 readings give a deviation to 0.5 %; levels of 30 to 60 uN add nothing to 2 mN
    assert np.std(normal) == pytest.approx(2e-3, rel=0.02)
    assert np.std(lateral) == pytest.approx(5e-3, rel=0.02)
    assert abs(np.mean(lateral)) < 5 * 5e-3 / math.sqrt(20_000)
    assert abs(np.corrcoef(normal, lateral)[0, 1]) < 5 / math.sqrt(20_000)
    assert all(np.array_equal(one[name], same[name]) for name in one)
    assert not np.array_equal(one["lateral_force_measured"], other["lateral_force_measured"])


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: respond_mechanically(squared, FILTERS, [0.0, 0.0]), "times that increase"),
        (lambda: respond_mechanically(squared, FILTERS, []), "at least one"),
        (
            lambda: respond_mechanically(squared, FILTERS, EVEN, most=500),
            "Choose a shorter time.duration, fewer",
        ),
        (lambda: respond_mechanically(lambda time: time / 0.0 * 0, FILTERS, EVEN), "is nan"),
        (lambda: measured(RIG, EVEN, np.ones(4), np.ones(4)), "normal_force: 4 samples for 301 times"),
        (
            lambda: measured(
                Tribometer(**SENSORS, digitiser=digitised(sampling_rate=1e9)), EVEN, squared, squared
            ),
            "Lower the rate",
        ),
    ],
)
@pytest.mark.filterwarnings("ignore:invalid value:RuntimeWarning")
@pytest.mark.filterwarnings("ignore:divide by zero:RuntimeWarning")
def test_what_cannot_be_followed_is_refused(call, message):
    with pytest.raises(InputError, match=message):
        call()
