"""Estimates of functions and of models linear in their amplitudes, what derivatives determine, profiles with known ends."""

import math
import re
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from electrovib.core.errors import InputError
from electrovib.recordings.fit.identifiability import identifiability
from electrovib.recordings.fit.least_squares import FreeParameter, aicc, bic, least_squares
from electrovib.recordings.fit.of_scenario import curvature_bias
from electrovib.recordings.interval import profile_interval
from electrovib.recordings.transitions.modes import ONE, Separable, Whitening, fit_modes, resonance_parameters
from electrovib.recordings.transitions.relaxation import EXPONENTIAL, Sensor

X = np.linspace(0.1, 2.0, 20)


def fit_function(function, x, y, *, start, noise=None):
    """Fit by least squares with differences of sixth order, one-sided where a bound is nearer than the step."""
    free = {
        name: each if isinstance(each, FreeParameter) else FreeParameter(start=each)
        for name, each in start.items()
    }

    def residual(values):
        return (function(x, **values) - y) / (noise or 1.0)

    def sloped(values):
        columns = []
        for name, value in values.items():
            step = 1e-3 * abs(value)

            def at(shift, name=name, value=value):
                return residual({**values, name: value + shift})

            if free[name].lower < value - 3 * step and value + 3 * step < free[name].upper:
                pairs = [(at(k * step) - at(-k * step)) / (2 * k * step) for k in (1, 2, 3)]
                columns.append(1.5 * pairs[0] - 0.6 * pairs[1] + 0.1 * pairs[2])
            else:
                small = (1 if value + 1e-5 * step < free[name].upper else -1) * 1e-5 * step
                columns.append((at(small) - at(0.0)) / small)
        return np.column_stack(columns)

    return least_squares(residual, free, derivatives=sloped, noise_is_known=noise is not None)


RATE = 2e6


def decay(x, time):
    """Not analytic in `time`."""
    return np.exp(-x / (RATE * np.abs(time)))


def slope(time):
    return X / (RATE * time**2) * decay(X, time)


@pytest.mark.parametrize("value", [1.0, -1.0], ids=["positive", "negative"])
def test_a_function_that_is_not_analytic_is_fitted(value):
    found = fit_function(lambda x, a: np.abs(a) * x, X, 3.0 * X, start={"a": value})
    assert abs(found.values["a"]) == pytest.approx(3.0, rel=1e-9)


@pytest.mark.parametrize(
    ("start", "lower", "upper"),
    [(1e-6, 0.0, math.inf), (1.5e-6, 5e-7, 1.5e-6), (5e-7, 5e-7, 1.0)],
    ids=["free", "from the upper bound", "from the lower bound"],
)
def test_a_function_is_evaluated_within_the_bounds_only(start, lower, upper):
    """The derivative at the estimate gives the covariance."""
    seen = []

    def within(x, time):
        seen.append(np.real(time))
        return decay(x, time)

    free = FreeParameter(start=start, lower=lower, upper=upper)
    found = fit_function(within, X, decay(X, 1e-6), start={"time": free}, noise=1e-3)
    assert lower <= min(seen) <= max(seen) <= upper
    assert found.values["time"] == pytest.approx(1e-6, rel=1e-6)
    expected = 1e-3 / np.linalg.norm(slope(1e-6))
    assert np.sqrt(found.covariance[0, 0]) == pytest.approx(expected, rel=1e-6)
    if upper == math.inf:
        assert np.sqrt(found.covariance[0, 0]) == pytest.approx(expected, rel=1e-11)


def test_a_search_that_ended_at_0_begins_where_it_began():
    free = FreeParameter(start=1e-4, lower=0.0, upper=5e-3, logarithmic=True)
    assert free.starting_at(0.0) == free
    assert free.starting_at(1.0).start == 5e-3
    assert FreeParameter(start=1.0, lower=0.0).starting_at(0.0).start == 0.0


def test_criteria_by_hand_and_where_the_correction_has_no_meaning():
    assert aicc(10.0, counted=3, data=20) == pytest.approx(10 + 6 + 24 / 16, rel=1e-15)
    assert bic(10.0, counted=3, data=20) == pytest.approx(10 + 3 * math.log(20), rel=1e-15)
    assert aicc(10.0, counted=3, data=4) == math.inf
    assert math.isfinite(aicc(10.0, counted=3, data=5))


@pytest.mark.parametrize(("noise", "counted"), [(None, 3), (0.1, 2)], ids=["estimated", "stated"])
def test_the_noise_is_one_of_the_parameters_that_a_criterion_counts_where_it_is_estimated(noise, counted):
    y = 2.0 + 3.0 * X + 0.1 * np.cos(40 * X)
    _, (squares, *_), *_ = np.polyfit(X, y, 1, full=True)
    found = fit_function(lambda x, a, b: a + b * x, X, y, start={"a": 1.0, "b": 1.0}, noise=noise)
    deviance = squares / 0.01 if noise else X.size * math.log(squares / X.size)
    few = 2 * counted * (counted + 1) / (X.size - counted - 1)
    assert found.aicc == pytest.approx(deviance + 2 * counted + few, rel=1e-12)
    assert found.bic == pytest.approx(deviance + counted * math.log(X.size), rel=1e-12)


@pytest.mark.parametrize("far", [1e-3, 1e3])
def test_a_start_beyond_the_bounds_is_moved_between_them(far):
    seen = []

    def columns(at):
        seen.append(at["rate"])
        return np.exp(-at["rate"] * X)[:, None]

    free = {"rate": FreeParameter(start=1.0, lower=0.5, upper=2.0, logarithmic=True)}
    problem = Separable(columns=columns, data=3 * np.exp(-X), free=free, names=["a"], ranges={})
    assert free["rate"].starting_at(far).start == {1e-3: 0.5, 1e3: 2.0}[far]
    starts = problem.best_starts([{"rate": far}], 1)
    assert problem.minimum(starts).values == pytest.approx({"rate": 1.0, "a": 3.0}, rel=1e-6)
    assert 0.499 < min(seen) <= max(seen) < 2.001  # but for the steps of derivatives


GRID = np.linspace(0, 1, 50)
DETERMINED = {
    "by the deviation of its logarithm": ([[20.0, 0, 0], [0, 2, 0], [0, 0, 0.2]], "1 1 1", "deviation 5,"),
    "whatever its scale": ([[20e9, 0], [0, 2e-9]], "1e-9 1e9", ""),
    "a product": (1e3 * np.column_stack([GRID / 2, GRID / 5, GRID**2]), "2 5 1", r"(a \* b|b \* a) only$"),
    "a product of powers": (1e3 * np.column_stack([2 * GRID, GRID]), "1 1", r"a \* b\^0.5 only"),
    "three together": (1e3 * np.column_stack([GRID, GRID**2, GRID + GRID**2]), "1 1 1", "fix one of"),
    "one without influence": (np.column_stack([100 * GRID, 0 * GRID]), "1 2", "data do not determine b"),
}
STATES = ["well weakly not", "well weakly", "not not well", "not not", "not not not", "well not"]
"""Derivatives after a, b and c, their values, and the words for what is not determined."""


@pytest.mark.parametrize(("name", "states"), list(zip(DETERMINED, STATES, strict=True)))
def test_what_derivatives_determine(name, states):
    slopes, values, words = DETERMINED[name]
    values = dict(zip("abc", map(float, values.split()), strict=False))
    found = identifiability(np.asarray(slopes), values)
    assert list(found.states.values()) == states.split()
    assert np.isinf(np.diag(found.covariance)).tolist() == [each == "not" for each in states.split()]
    assert "not" not in states or re.search(words, found.undetermined[0].sentence)
    if name.startswith("by the deviation"):
        assert np.sqrt(np.diag(found.covariance))[:2] == pytest.approx([0.05, 0.5])
        assert found.undetermined[0].deviation == pytest.approx(5.0)
    if name == "a product":
        (worst,) = found.undetermined
        assert math.isinf(worst.deviation)
        assert sorted(worst.exponents.values()) == pytest.approx([-1.0, 1.0])


def rising(rise):
    """Data that rise by a share r are a constant to the share r/sqrt(12): a zero is ten times as uncertain at r = 0.34."""
    shape = 1 + rise * (GRID - 0.5)
    weak = 0.5 / np.linalg.norm(shape - shape.mean())  # the logarithm of a has the standard deviation 2
    return np.column_stack([weak * shape, np.ones(50)])


@pytest.mark.parametrize(
    ("slopes", "states"),
    [
        (np.column_stack([100 * (1 + 1e-3 * GRID), np.ones(50)]), "not not"),
        # c has a small influence, so that only it is lost; the constant is another shape
        (np.column_stack([100 * GRID, 0.1 * GRID**2, np.ones(50)]), "well not well"),
        (rising(0.3), "not not"),
        (rising(0.6), "not well"),
    ],
    ids=["with what it takes", "another shape", "rise of 0.3", "rise of 0.6"],
)
def test_a_zero_is_lost_with_what_it_takes_information_from(slopes, states):
    values = dict.fromkeys("ab"[: slopes.shape[1] - 1], 1.0) | {"zero": 0.0}
    found = identifiability(slopes, values, zeros=["zero"])
    assert list(found.states.values()) == states.split()
    assert math.isinf(found.covariance[-1, -1]) == states.endswith("not")


def problem(predicted, sloped, noise):
    return SimpleNamespace(
        prediction=lambda values: np.asarray(predicted(**values)),
        derivatives=lambda values, names: np.asarray(sloped(**values))[:, : len(names)] / noise,
        weights=1 / noise,
    )


def test_the_bias_of_the_root_of_a_noisy_square_and_of_a_line():
    """Of y = p^2 the estimate sqrt(y) is too small by s^2/(8 p^3) on average, which is s/(4 p^2) of its deviation."""
    p, s = 3.0, 0.2
    square = problem(lambda p: [p**2], lambda p: [[2 * p]], s)
    found = curvature_bias(square, {"p": p}, ["p"], np.array([[(s / (2 * p)) ** 2]]))
    assert found["p"] == pytest.approx(-s / (4 * p**2), rel=1e-9)
    x = np.linspace(0, 1, 9)
    slopes = np.column_stack([x, np.ones(9)])
    line = problem(lambda a, b: a * x + b, lambda **_: slopes, 0.1)
    found = curvature_bias(line, {"a": 2.0, "b": 1.0}, ["a", "b"], 0.01 * np.linalg.inv(slopes.T @ slopes))
    assert found == pytest.approx({"a": 0.0, "b": 0.0}, abs=1e-9)


def test_two_correlated_parameters_as_simulated():
    x, s = np.linspace(0.1, 2, 30), 0.02
    model = lambda a, b: a * np.exp(-b * x)  # noqa: E731
    sloped = lambda a, b: np.column_stack([np.exp(-b * x), -a * x * np.exp(-b * x)])  # noqa: E731
    covariance = s**2 * np.linalg.inv(sloped(0.1, 1.0).T @ sloped(0.1, 1.0))
    found = curvature_bias(problem(model, sloped, s), {"a": 0.1, "b": 1.0}, ["a", "b"], covariance)
    rng, estimates = np.random.default_rng(1), []
    for _ in range(300):
        noise = s * rng.normal(size=x.size)
        for side in (1, -1):  # pairs of opposite noise cancel all but the bias
            at = np.array([0.1, 1.0])
            for _ in range(12):
                step, *_ = np.linalg.lstsq(sloped(*at), model(0.1, 1.0) + side * noise - model(*at))
                at = at + step
            estimates.append(at)
    bias = (np.mean(estimates, axis=0) - [0.1, 1.0]) / np.sqrt(np.diag(covariance))
    assert [found["a"], found["b"]] == pytest.approx(bias, rel=0.3)


def test_where_there_is_no_prediction_the_bias_is_unknown():
    def refused(p):
        if p != 1.0:
            raise InputError("no such value")
        return [1.0]

    made = problem(refused, lambda p: [[1.0]], 1.0)  # noqa: ARG005
    assert math.isinf(curvature_bias(made, {"p": 1.0}, ["p"], np.eye(1))["p"])


def test_ends_of_a_profile_are_those_of_its_closed_form():
    parabola = profile_interval(
        lambda x: ((x - 2) / 0.5) ** 2, 2.0, deviation=0.3, bounds=(-math.inf, math.inf), allowed=3.8415
    )
    assert (parabola.lower, parabola.upper) == pytest.approx((2 - 1.96 * 0.5, 2 + 1.96 * 0.5), rel=1e-3)
    settings = {"deviation": math.inf, "bounds": (0.0, math.inf), "logarithmic": True}
    factors = profile_interval(lambda x: (math.log(x / 3) / 2) ** 2, 3.0, allowed=4.0, **settings)
    assert (factors.lower, factors.upper) == pytest.approx((3 * math.exp(-4), 3 * math.exp(4)), rel=1e-2)
    ends = profile_interval(
        lambda x: math.inf if x > 2 else (x - 1) ** 2, 1.0, deviation=0.4, bounds=(0.0, 9.0), allowed=3.0
    )
    assert ends.open_above  # where there is no prediction
    assert 1 < ends.upper <= 2
    assert (ends.lower, ends.open_below) == (0.0, True)


@pytest.mark.parametrize("logarithmic", [True, False])
def test_what_saturates_or_meets_a_bound_is_open(logarithmic):
    saturating = lambda x: 3 * (1 - 1 / x) if x > 1 else 100 * (1 - x) ** 2  # noqa: E731
    settings = {"deviation": 0.1, "bounds": (0.5, 1e9), "allowed": 4.0, "logarithmic": logarithmic}
    found = profile_interval(saturating, 1.0, **settings)
    assert (found.upper, found.open_above) == (1e9, True)
    assert (found.lower, found.open_below) == (pytest.approx(0.8, rel=1e-2), False)


FOLDER = Path(__file__).parent.parent.parent / "data" / "nist_strd"


def lanczos(x, b1, b2, b3, b4, b5, b6):
    return b1 * np.exp(-b2 * x) + b3 * np.exp(-b4 * x) + b5 * np.exp(-b6 * x)


def gauss(x, b1, b2, b3, b4, b5, b6, b7, b8):
    bells = b3 * np.exp(-(((x - b4) / b5) ** 2)) + b6 * np.exp(-(((x - b7) / b8) ** 2))
    return b1 * np.exp(-b2 * x) + bells


def thurber(x, b1, b2, b3, b4, b5, b6, b7):
    return (b1 + b2 * x + b3 * x**2 + b4 * x**3) / (1 + b5 * x + b6 * x**2 + b7 * x**3)


FUNCTIONS = {
    **{f"Lanczos{n}": lanczos for n in (1, 2, 3)},
    **{f"Gauss{n}": gauss for n in (1, 2, 3)},
    "MGH09": lambda x, b1, b2, b3, b4: b1 * (x**2 + x * b2) / (x**2 + x * b3 + b4),
    "MGH10": lambda x, b1, b2, b3: b1 * np.exp(b2 / (x + b3)),
    "MGH17": lambda x, b1, b2, b3, b4, b5: b1 + b2 * np.exp(-x * b4) + b3 * np.exp(-x * b5),
    "Thurber": thurber,
}


def certified(name):
    """Rows (start 1, start 2, value, standard deviation), then x and y."""
    lines = (FOLDER / f"{name}.dat").read_text(encoding="ascii").splitlines()
    rows = [re.match(r"\s*b\d+\s*=\s*(\S+)\s+(\S+)\s+(\S+)\s+(\S+)", line) for line in lines]
    first = max(at for at, line in enumerate(lines) if line.startswith("Data:")) + 1
    data = np.array([[float(word) for word in line.split()] for line in lines[first:] if line.strip()])
    return np.array([[float(word) for word in row.groups()] for row in rows if row]), data[:, 1], data[:, 0]


@pytest.mark.parametrize("start", [0, 1], ids=["start 1", "start 2"])
@pytest.mark.parametrize("name", FUNCTIONS)
def test_certified_values_to_six_digits_and_deviations_to_four(name, start):
    rows, x, y = certified(name)
    names = [f"b{at + 1}" for at in range(len(rows))]
    found = fit_function(FUNCTIONS[name], x, y, start=dict(zip(names, rows[:, start], strict=True)))
    np.testing.assert_allclose([found.values[each] for each in names], rows[:, 2], rtol=1e-6)
    # the residuals of Lanczos1 are the rounding of its 14 digits: doubles cannot give its deviations better
    digits = 1e-2 if name == "Lanczos1" else 1e-4
    np.testing.assert_allclose([found.standard_deviations[each] for each in names], rows[:, 3], rtol=digits)


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
        columns=lambda at: EXPONENTIAL.columns(
            STAMPS, at, Sensor(frequency=at["frequency"], quality=at["quality"])
        ),
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


def test_what_is_held_is_no_unknown():
    whole, held = seen(), seen(time_constant=AT["time_constant"])
    assert "time_constant" not in held.free
    np.testing.assert_array_equal(held.jacobian(AT), np.delete(whole.jacobian(AT), 1, axis=1))
    np.testing.assert_array_equal(held.predicted(AT), whole.predicted(AT))


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


def test_the_errors_of_a_damped_sine_are_those_of_its_scatter():
    rng, rate = np.random.default_rng(1), np.pi * 200.0 / 0.8
    time = np.arange(0, 12e-3, 1e-4)
    clean = 0.3 + np.exp(-rate * time) * np.cos(2 * np.pi * 200.0 * time + 0.5)
    none = 0.005 * rng.standard_normal(time.size)
    records = [clean + 0.005 * rng.standard_normal(time.size) for _ in range(60)]
    found = [fit_modes(time, each, (ONE,), noise=none)[ONE].parameters() for each in records]
    natural = np.hypot(200.0, rate / (2 * np.pi))
    for name, exact in (("frequency", natural), ("quality", 0.8 * natural / 200.0)):
        values = np.array([each[name].value for each in found])
        stated = np.sqrt(np.mean([each[name].standard_error ** 2 for each in found]))
        assert values.mean() == pytest.approx(exact, rel=0.02)
        assert values.std() == pytest.approx(stated, rel=0.25)
