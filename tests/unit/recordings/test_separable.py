"""Models that are linear in their amplitudes: slopes against differences of the model, and intervals by causes."""

import numpy as np
import pytest

from electrovib.recordings.fit.least_squares import FreeParameter
from electrovib.recordings.fit.separable import Separable, Whitening, resonance_parameters
from electrovib.recordings.interval import from_causes
from electrovib.recordings.transitions.modes import damped_sine
from electrovib.recordings.transitions.relaxation import EXPONENTIAL

STAMPS = np.linspace(-2e-3, 10e-3, 150)
AT = {
    "start": 0.3e-3, "time_constant": 0.2e-3, "frequency": 350.0, "quality": 3.0, "change": 0.65, "after": 0.05,
}  # fmt: skip


def seen(data=None, **held):
    """Make a release seen by a resonance."""
    free = {
        "start": FreeParameter(start=0.0, lower=-1e-3, upper=5e-3),
        "time_constant": FreeParameter(start=1e-4, lower=1e-6, upper=5e-3, logarithmic=True),
        **resonance_parameters(10e-3, 8e-5),
    }
    problem = Separable(
        columns=lambda at: EXPONENTIAL.columns(STAMPS, at, (at["frequency"], at["quality"])),
        data=np.zeros(150) if data is None else data,
        free=free,
        names=EXPONENTIAL.amplitudes,
        ranges={"start": 10e-3},
    )
    return problem.holding(**held)


@pytest.mark.parametrize("name", AT)
@pytest.mark.parametrize("whitening", [None, Whitening((-0.6, 0.2))])
def test_a_slope_is_the_change_of_the_model(name, whitening):
    problem = seen()
    columns = problem.jacobian(AT, whitening)
    step = 1e-4 * AT[name]
    more, less = (problem.predicted({**AT, name: AT[name] + sign * step}) for sign in (1, -1))
    difference = (more - less) / (2 * step)
    if whitening is not None:
        difference = whitening(difference)
    own = columns[:, list(AT).index(name)]
    np.testing.assert_allclose(own, difference, rtol=0, atol=1e-4 * np.max(np.abs(difference)))
    assert np.max(np.abs(difference)) > 0


def test_what_is_held_is_no_unknown_and_a_part_has_the_same_model():
    whole, held = seen(), seen(time_constant=AT["time_constant"])
    assert "time_constant" not in held.free
    np.testing.assert_array_equal(held.jacobian(AT), np.delete(whole.jacobian(AT), 1, axis=1))
    np.testing.assert_array_equal(held.predicted(AT), whole.predicted(AT))
    rows = STAMPS > 0
    part = whole.part(rows)
    np.testing.assert_array_equal(part.jacobian(AT), whole.jacobian(AT)[rows])
    assert part.data.size == rows.sum()


@pytest.mark.parametrize("whitening", [None, Whitening((-0.6, 0.2))])
def test_the_parameters_of_a_computed_record_come_back(whitening):
    record = seen(seen().predicted(AT))
    start = {"start": 0.2e-3, "time_constant": 0.3e-3, "frequency": 320.0, "quality": 2.0}
    found = record.solve([{**start, "frequency": 900.0}, start], whitening=whitening)
    assert dict(found.values) == pytest.approx(AT, rel=1e-5)
    assert np.abs(record.predicted(found.values) - record.data).max() < 1e-8


def test_correlated_noise_increases_a_variance_by_what_monte_carlo_finds():
    problem = seen(**{name: AT[name] for name in ("time_constant", "frequency", "quality")})
    inverse = np.linalg.pinv(problem.jacobian(AT))
    white = np.random.default_rng(1).standard_normal((4000, 151))
    alike = np.array([1.25, 0.5])  # of e_k + e_(k-1)/2
    noise = white[:, 1:] + 0.5 * white[:, :-1]
    ratio = np.var(noise @ inverse[0]) / (1.25 * inverse[0] @ inverse[0])
    assert problem.inflation(AT, "start", alike) == pytest.approx(max(ratio, 1.0), rel=0.1)
    assert problem.inflation(AT, "start", alike) > 1.1
    assert problem.inflation(AT, "start", alike, without=["start"]) == 1.0


def test_components_add_as_squares():
    found = from_causes(10.0, {"noise": 3.0, "window": 4.0})
    assert found.standard_error == 5
    assert found.ends == pytest.approx((0.2, 19.8), abs=1e-3)
    assert dict(found.components) == {"noise": 3.0, "window": 4.0}


def test_the_errors_of_a_damped_sine_are_those_of_its_scatter():
    rng, rate = np.random.default_rng(1), np.pi * 200.0 / 0.8
    time = np.arange(0, 12e-3, 1e-4)
    clean = 0.3 + np.exp(-rate * time) * np.cos(2 * np.pi * 200.0 * time + 0.5)
    found = [damped_sine(time, clean + 0.005 * rng.standard_normal(time.size), start=0.0) for _ in range(60)]
    for name, exact in (("frequency", 200.0), ("quality", 0.8)):
        values = np.array([getattr(each, name).value for each in found])
        stated = np.sqrt(np.mean([getattr(each, name).standard_error ** 2 for each in found]))
        assert values.mean() == pytest.approx(exact, rel=0.02)
        assert values.std() == pytest.approx(stated, rel=0.25)
