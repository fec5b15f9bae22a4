"""Intervals of fits to recordings that are rounded more coarsely than their noise."""

import numpy as np
import pytest

import electrovib as ev
from electrovib.core.signals import make_trace
from electrovib.recordings.fit.measured import MeasuredTrace
from electrovib.recordings.fit.of_scenario import fit_scenario
from electrovib.recordings.fit.rounding import coherence_of, least_noise, resolution_of, rounding_amplitudes

FRICTION, FILM = "friction.coefficient", "stack.insulator.thickness"
TIMES = np.linspace(1e-3, 49e-3, 400)
SINE = {"model": "Sine", "amplitude": "150 V", "frequency": "200 Hz"}
STEP = {"model": "Trapezium", "high": "150 V", "rise": "100 us", "hold": "100 ms", "fall": "100 us"}
"""Forces that pass 20 steps of a converter again and again, and that pass two slowly."""


class Twin:
    """A scenario with its friction, its exact force, and the step of its converter."""

    def __init__(self, drive, free):
        grid = {"model": "TimeGrid", "duration": "50 ms"}
        self.scenario, self.free = ev.load("bau_2010/sine").replace({"drive": drive, "time": grid}), free
        self.prepared = ev.prepare(self.scenario, free=free)
        self.truth = {path: float(value) for path, value, _ in self.scenario.parameters() if path in free}
        force = self.force(self.truth)
        self.step = np.ptp(force) / 20 if drive is SINE else force.mean() / 50

    def force(self, values):
        return self.prepared.signals(values, names=["lateral_force"], time=TIMES)["lateral_force"]

    def fit(self, seed, *, ratio, stated=False):
        """Fit a recording whose step is `ratio` times its noise, for parameters near the start."""
        rng = np.random.default_rng([17, seed])
        true = {name: value * (1 + 0.05 * rng.uniform(-1, 1)) for name, value in self.truth.items()}
        noise = self.step / ratio
        values = np.round((self.force(true) + noise * rng.normal(size=TIMES.size)) / self.step) * self.step
        trace = make_trace({"lateral_force": (("time",), values)}, {"time": TIMES}, {})
        recording = MeasuredTrace(trace=trace, noise={"lateral_force": noise} if stated else {})
        return true, fit_scenario(self.scenario, recording, free=self.free)

    def coverage(self, count, **settings):
        covered = np.zeros(len(self.free))
        for seed in range(count):
            true, found = self.fit(seed, **settings)
            covered += [np.clip(true[name], *found.interval(name)) == true[name] for name in self.free]
        return covered / count


@pytest.fixture(scope="module")
def fast():
    return Twin(SINE, [FRICTION, FILM])


@pytest.fixture(scope="module")
def slow():
    return Twin(STEP, [FRICTION])


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        (0.3 + 2e-3 * np.round(np.random.default_rng(1).normal(size=200)), 2e-3),
        (1e-6 * np.round(1e3 * np.random.default_rng(1).normal(size=9000)), 1e-6),
        (np.random.default_rng(1).normal(size=200), 0.0),
        (np.round(np.random.default_rng(1).normal(size=200)) ** 3 * 1.1 + 0.3 * (np.arange(200) > 100), 0.0),
        (np.ones(200), 0.0),
        (np.arange(19.0) // 5, 0.0),
    ],
)
def test_the_resolution_is_found_where_values_repeat_on_even_steps(values, expected):
    assert resolution_of(values) == pytest.approx(expected, rel=1e-9)
    assert resolution_of(values * 7e-9 + 2) == pytest.approx(7e-9 * expected, rel=1e-5)


@pytest.mark.parametrize("noise", [0.0, 0.1, 0.2, 0.4])
def test_the_mean_rounding_error_is_that_of_many_rounded_values(noise):
    places = np.linspace(-0.45, 0.45, 19)
    draws = noise * np.random.default_rng(2).normal(size=(200_000, 1))
    expected = np.mean(np.round(places + draws) - places, axis=0)
    order = np.arange(1, 65)
    series = rounding_amplitudes(noise, 1.0) @ np.sin(2 * np.pi * np.outer(order, places))
    assert series == pytest.approx(expected, abs=0.04 if noise == 0 else 4e-3)


@pytest.mark.parametrize("place", [0.5, 0.25, None])
@pytest.mark.parametrize("noise", [0.2, 0.5, 2.0])
def test_the_noise_is_at_most_that_before_rounding(place, noise):
    rng = np.random.default_rng(3)
    places = rng.uniform(0, 20, 100_000) if place is None else np.full(100_000, place)
    scatter = np.std(np.round(places + noise * rng.normal(size=100_000)) - places)
    found = least_noise(scatter, coherence_of(places))
    assert found <= 1.02 * noise
    if place is None or (place == 0.5 and noise > 0.3):
        assert found == pytest.approx(noise, rel=0.06)


def test_coherence_of_constant_and_of_changing_signals():
    assert coherence_of(np.full(50, 3.2)) == 1
    assert coherence_of(np.linspace(0, 100, 5000)) < 0.01
    assert coherence_of(np.linspace(0, 0.49, 500)) == 1
    assert coherence_of(np.linspace(0, 0.9, 500)) == pytest.approx((5**2 + 4**2) / 9**2, rel=0.01)
    # whole steps apart: the same rounding error
    assert coherence_of(np.arange(200) % 10 + 0.3) == pytest.approx(1)


def test_the_interval_of_a_coarse_recording_includes_its_rounding_and_states_it(fast):
    true, found = fast.fit(2, ratio=8)
    plain = found.estimate.interval(FRICTION)
    lower, upper = found.interval(FRICTION)
    assert upper - lower > 1.1 * np.ptp(plain)
    assert lower < true[FRICTION] < upper
    (signal,) = found.rounding.signals
    assert signal.resolution == pytest.approx(fast.step, rel=1e-9)
    assert signal.noise == pytest.approx(fast.step / 8, rel=0.5)
    result = ev.fit(fast.scenario, found.problem.prediction.measured[0], free=fast.free)
    row = result.rows[0]
    assert (row.lower, row.upper) == pytest.approx((lower, upper), rel=1e-9)
    assert row.standard_error == pytest.approx(found.deviation(FRICTION))
    assert row.standard_error > 1.08 * found.estimate.standard_deviations[FRICTION]
    share = 1 - (found.rounding.deviations[FRICTION] / row.standard_error) ** 2
    assert row.note.startswith(f"{share:.0%} of the variance is that of rounding errors")
    assert "is rounded to steps of" in row.note
    assert "is rounded to steps of" in " ".join(result.document.sentences)


def test_scatter_that_rounding_causes_is_not_counted_as_noise_too_and_fine_steps_are_none(fast):
    _, found = fast.fit(5, ratio=100)
    plain = found.estimate.standard_deviations[FRICTION]
    assert found.rounding.deviations[FRICTION] < 0.5 * plain
    assert found.rounding.deviation(FRICTION) > plain
    _, found = fast.fit(1, ratio=0.5)
    assert found.rounding is None
    assert found.interval(FRICTION) == found.estimate.interval(FRICTION)
    assert found.residuals[0].observed.resolution == pytest.approx(fast.step, rel=1e-9)


def test_a_stated_noise_gets_the_variance_of_rounding_where_the_step_is_larger(fast):
    _, found = fast.fit(2, ratio=2, stated=True)
    noise = fast.step / 2
    assert found.residuals[0].noise == pytest.approx(np.hypot(noise, fast.step / np.sqrt(12)))
    assert found.residuals[0].observed.noise_alone == noise
    assert found.estimate.sum_of_squares == pytest.approx(TIMES.size, rel=0.2)
    _, found = fast.fit(2, ratio=0.9, stated=True)
    assert found.residuals[0].noise == pytest.approx(fast.step / 0.9)


def test_without_noise_the_error_is_that_of_one_step(slow):
    """A force that hardly changes is known to a part of a step, however many samples there are."""
    true, found = slow.fit(3, ratio=100)
    lower, upper = found.interval(FRICTION)
    assert lower < true[FRICTION] < upper
    step = true[FRICTION] / 50
    assert 0.1 * step < (upper - lower) / 2 < 0.5 * step
    assert "shows no noise beside the rounding" in found.rounding.sentence


def test_a_weakly_determined_parameter_has_its_profile_widened(fast):
    _, found = fast.fit(4, ratio=5)
    profiled = found.profile(FILM)
    lower, upper = found.interval(FILM)
    assert profiled.upper - profiled.lower == pytest.approx(upper - lower, rel=0.1)


@pytest.mark.slow
@pytest.mark.parametrize("ratio", [0.5, 2, 5])
def test_intervals_cover(fast, slow, ratio):
    """Of a stated noise in 90 to 99 %; an unknown noise of a fifth of a step cannot be told from none in a slow signal."""
    for covered in (fast.coverage(200, ratio=ratio), slow.coverage(200, ratio=ratio, stated=True)):
        assert np.all(np.abs(covered - 0.945) <= 0.045)
    assert np.all(slow.coverage(200, ratio=ratio) >= 0.9)
