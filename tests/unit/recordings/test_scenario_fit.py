"""The fit of a scenario's parameters to recordings of known parameters."""

import numpy as np
import pytest
from twins import FILM, FREE, FREQUENCIES, GAP, LEAK, SIGNALS, TIMES, exact, noisy, plate, truth

import electrovib as ev
from electrovib.core.errors import ElectrovibError, InputError
from electrovib.recordings.fit.measured import MeasuredTrace
from electrovib.recordings.fit.of_scenario import fit_scenario
from electrovib.recordings.fit.prediction import signals_over_frequency
from electrovib.recordings.fit.problem import CancelledError
from electrovib.recordings.fit.result import parameter_table

SKIN, INSULATOR = "stack.stratum_corneum.material.conductivity", "stack.insulator.material.permittivity"
ELSEWHERE = {GAP: 4e-6, LEAK: 4e-9, FILM: 1.5e-6}
PLATE = plate()
EXACT = {kind: exact(PLATE, kind) for kind in SIGNALS}
FORCE = "electrostatic_force"
THICK = plate(**{FILM: "100 um", "drive.high": "3 kV"})
"""With a film of 0.1 mm the gap discharges through its own leak: the skin's conduction is too large to count."""


def recorded(*kinds, seed=1, **settings):
    rng = np.random.default_rng(seed)
    return [MeasuredTrace(trace=noisy(EXACT[kind], rng), name=kind, **settings) for kind in kinds]


@pytest.mark.parametrize("kinds", [*[(kind,) for kind in SIGNALS], tuple(SIGNALS)])
def test_known_parameters_come_back_from_other_starting_values(kinds):
    found = fit_scenario(PLATE, recorded(*kinds), free=FREE, start=ELSEWHERE)
    expected = truth(PLATE)
    assert found.estimate.converged
    for name, deviation in found.estimate.standard_deviations.items():
        assert abs(found.estimate.values[name] - expected[name]) < 4 * deviation < 0.6 * expected[name]
    assert set(found.states.values()) <= ({"well"} if "impedance" in kinds else {"well", "weakly"})
    for each in found.residuals:
        assert each.noise == pytest.approx(
            0.01 * (1 if each.observed.parts == 2 else each.observed.y.max()), rel=0.3
        )


def test_joint_recordings_determine_more_than_each():
    alone = fit_scenario(PLATE, recorded("step"), free=FREE).estimate.standard_deviations
    together = fit_scenario(PLATE, recorded(*SIGNALS), free=FREE).estimate.standard_deviations
    assert all(together[name] < 0.5 * alone[name] for name in FREE)


def with_missing(trace, **places):
    found = trace.copy(deep=True)
    for name, place in places.items():
        found[name].values[place] = np.nan
    return found


HALF = exact(plate(**{"drive.high": "50 V"}), "step")
WITHOUT_NOISE = {
    "a sweep": (EXACT["sweep"], FREQUENCIES.size),
    "settings of their own": (
        [
            MeasuredTrace(trace=EXACT["step"], name="a"),
            MeasuredTrace(trace=HALF, name="b", changes={"drive.high": "50 V"}),
        ],
        2 * TIMES.size,
    ),
    "missing samples": (with_missing(EXACT["step"], electrostatic_force=np.s_[10:20]), TIMES.size - 10),
    "of one signal each": (
        with_missing(EXACT["sweep"].merge(EXACT["impedance"]), mean_force=3, impedance=7),
        3 * (FREQUENCIES.size - 1),
    ),
    "a long one": (exact(PLATE, "step", times=np.linspace(0, 30e-3, 4000)), 4000),
}


@pytest.mark.parametrize("name", WITHOUT_NOISE)
def test_without_noise_the_parameters_are_exact_and_in_the_scenario(name):
    trace, count = WITHOUT_NOISE[name]
    seen = []
    report = lambda number, _: seen.append(number) or False  # noqa: E731
    found = fit_scenario(PLATE, trace, free=FREE, start=ELSEWHERE, progress=report)
    assert found.estimate.count == count
    assert found.estimate.values == pytest.approx(truth(PLATE), rel=1e-7 if name == "a sweep" else 1e-5)
    assert truth(found.scenario) == pytest.approx(found.estimate.values, rel=1e-9)
    # a long recording is searched with few samples first, which is reported as well
    assert name != "a long one" or len(seen) > found.estimate.evaluations


def test_signals_without_noise_or_that_are_zero_are_fitted_together():
    trace = exact(PLATE, "step", times=np.linspace(0, 30e-3, 900))
    stack = ev.prepare(PLATE, free=[GAP]).signals([3e-6], names=["stack_voltage"], time=trace["time"].values)
    voltage = (("time",), stack["stack_voltage"])
    trace = trace.assign(current=(("time",), np.zeros(900)), stack_voltage=voltage)
    found = fit_scenario(
        PLATE, trace, free=[GAP], start={GAP: 4e-6}, signals=["electrostatic_force", "stack_voltage"]
    )
    assert found.estimate.values[GAP] == pytest.approx(3e-6, rel=1e-6)
    assert [each.noise for each in found.residuals] == pytest.approx([0.38e-9, 1e-7], rel=0.05)
    silent = fit_scenario(PLATE, trace, free=[GAP], signals=["electrostatic_force", "current"])
    assert silent.estimate.values[GAP] == pytest.approx(3e-6, rel=1e-2)


def test_an_unknown_zero_is_fitted_beside_the_parameters():
    trace = noisy(EXACT["step"], np.random.default_rng(2))
    trace[FORCE].values[:] += 0.05
    recording = MeasuredTrace(trace=trace, name="a", offsets=(FORCE,))
    found = fit_scenario(PLATE, recording, free=[GAP, LEAK])
    assert found.estimate.values[f"a: zero of {FORCE}"] == pytest.approx(0.05, abs=0.005)
    assert found.estimate.values[GAP] == pytest.approx(3e-6, rel=0.05)
    biased = fit_scenario(PLATE, MeasuredTrace(trace=trace), free=[GAP, LEAK])
    assert biased.residuals[0].root_mean_square > 1.5 * found.residuals[0].root_mean_square
    trace = EXACT["impedance"].copy(deep=True)
    trace["impedance"].values[:] += 500.0  # of a complex signal it shifts the real part
    found = fit_scenario(PLATE, MeasuredTrace(trace=trace, name="z", offsets=("impedance",)), free=FREE)
    assert found.estimate.values["z: zero of impedance"] == pytest.approx(500.0, rel=1e-6)


def test_stated_noise_scales_the_deviations_and_settles_the_sum_of_squares():
    peak = EXACT["step"][FORCE].values.max()
    small, large = (
        fit_scenario(PLATE, recorded("step", noise={FORCE: factor * peak}), free=[GAP, LEAK])
        for factor in (0.01, 0.02)
    )
    assert 30 < small.estimate.sum_of_squares < 95  # 58 degrees of freedom
    for name, deviation in small.estimate.standard_deviations.items():
        assert large.estimate.standard_deviations[name] == pytest.approx(2 * deviation, rel=1e-4)
    assert small.residuals[0].noise == 0.01 * peak


@pytest.mark.parametrize("after", [1, 3])
def test_the_callback_cancels(after):
    with pytest.raises(CancelledError, match="cancelled"):
        fit_scenario(PLATE, recorded("sweep"), free=FREE, progress=lambda count, _: count >= after)


SWEEP = recorded("sweep")


@pytest.mark.parametrize(
    ("recordings", "settings", "words"),
    [
        (SWEEP, {"free": ["stack.gap.thicknes"]}, r"stack\.gap\.thicknes: .*stack\.gap\.thickness"),
        (SWEEP, {"free": []}, "at least one parameter"),
        (SWEEP, {"free": [GAP, GAP]}, "named twice"),
        (SWEEP, {"varying": [LEAK]}, "not among the free"),
        (SWEEP, {"varying": [GAP]}, "all recordings are of one"),
        (SWEEP, {"free": ["stack.insulator.material.conductivity"]}, r"is 0, .* no scale"),
        (SWEEP, {"start": {GAP: 10.0}}, "expected a number from"),
        (SWEEP, {"signals": ["impedance"]}, "quantity = 'impedance': the recording has no such signal"),
        (recorded("step", offsets=(FORCE,)) * 2, {}, "own"),
        (recorded("step", noise={"force": 1.0}), {}, r"'force'.*no such signal"),
        (recorded("step", noise={FORCE: 0.0}), {}, "above 0"),
        (exact(PLATE, "step", times=TIMES[5:7]), {"free": FREE}, "at least as many"),
        ([], {}, "at least one recording"),
        (
            ev.simulate(PLATE),
            {"signals": [FORCE, "drive_voltage"]},
            "signals = 'drive_voltage': the scenario pre",
        ),
    ],
)
def test_mistakes_are_named(recordings, settings, words):
    with pytest.raises(InputError, match=words):
        fit_scenario(PLATE, recordings, **{"free": [GAP]} | settings)


def test_a_product_that_alone_is_determined_is_named():
    found = fit_scenario(PLATE, recorded("impedance"), free=[FILM, INSULATOR, GAP])
    assert found.states == {FILM: "not", INSULATOR: "not", GAP: "well"}
    (worst,) = found.undetermined
    assert worst.exponents == pytest.approx({FILM: 1.0, INSULATOR: 1.0}, rel=0.02)
    assert f"of {FILM} and {INSULATOR} they determine" in found.why_no_interval(FILM)
    assert f"{FILM} * {INSULATOR}^-1 only" in worst.sentence
    assert np.isnan(found.interval(FILM)).all()
    assert found.why_no_interval(GAP) == ""
    lower, upper = found.interval(GAP)
    assert lower < 3e-6 < upper < 1.1 * lower


def test_the_decay_on_a_thick_film_determines_the_leak_and_not_the_skin():
    found = fit_scenario(THICK, noisy(exact(THICK, "step"), np.random.default_rng(3)), free=[LEAK, SKIN])
    assert found.states == {LEAK: "well", SKIN: "not"}
    assert found.interval(LEAK)[0] < 2e-9 < found.interval(LEAK)[1]
    assert SKIN in found.why_no_interval(SKIN)


def test_a_parameter_with_a_bias_counts_as_weakly_determined():
    rough, fine = (
        fit_scenario(PLATE, noisy(EXACT["sweep"], np.random.default_rng(11), noise=noise), free=FREE)
        for noise in (0.01, 0.003)
    )
    assert rough.estimate.standard_deviations[GAP] < 0.01 * 3e-6
    assert (rough.states[GAP], fine.states[GAP]) == ("weakly", "well")
    assert fine.bias[GAP] == pytest.approx(0.3 * rough.bias[GAP], rel=0.2)  # proportional to the noise


def test_weights_of_a_proportional_noise_do_not_follow_the_noise():
    """Weights from the moduli of the data would bias the gap by 0.07 deviations; those from the model by 0.001."""
    true, values = truth(PLATE)[GAP], []
    for number in range(10):
        for sign in (1, -1):  # whose linear parts cancel
            trace = noisy(EXACT["impedance"], np.random.default_rng([11, number]), noise=sign * 0.03)
            values.append(fit_scenario(PLATE, trace, free=[GAP]).estimate)
    mean = np.mean([each.values[GAP] for each in values])
    assert abs(mean - true) < 0.02 * values[0].standard_deviations[GAP]


def test_a_parameter_on_its_bound_has_no_interval():
    sweep = EXACT["sweep"].copy(deep=True)
    sweep["mean_force"].values[:] *= 1e-9  # a force that small needs the widest gap
    found = fit_scenario(PLATE, sweep, free=[GAP])
    assert found.determined[GAP] == "bound"
    assert found.states[GAP] == "misfit"  # the widest gap still attracts too much
    assert "bound" in found.why_no_interval(GAP)
    assert np.isnan(found.interval(GAP)).all()


def test_the_profile_agrees_with_the_symmetric_interval_where_that_holds():
    found = fit_scenario(PLATE, recorded("sweep"), free=[GAP, LEAK])
    profiled, (lower, upper) = found.profile(GAP), found.interval(GAP)
    assert (profiled.lower, profiled.upper) == pytest.approx((lower, upper), rel=2e-4)
    assert not profiled.open_below
    assert not profiled.open_above


@pytest.mark.slow
def test_the_profile_of_what_is_not_determined_is_open_and_may_still_give_a_limit():
    found = fit_scenario(THICK, noisy(exact(THICK, "step"), np.random.default_rng(3)), free=[LEAK, SKIN])
    profiled, problem, values = found.profile(SKIN), found.problem, found.estimate.values
    assert (profiled.lower, profiled.open_below, profiled.open_above) == (0.0, True, False)
    rise = problem.rise(SKIN, profiled.upper, values, problem.prediction.free) - found.estimate.sum_of_squares
    assert rise / found.estimate.variance == pytest.approx(4.007, rel=1e-2)  # F(1, 58) at 95 %
    assert profiled.upper > 1.8e-6


@pytest.mark.parametrize("stated", [0, 1])
def test_criteria_count_each_noise_that_is_estimated(stated):
    trace = noisy(exact(PLATE, "step"), np.random.default_rng(3))
    own = {name: float(trace[name].std()) / 100 for name in list(trace.data_vars)[:stated]}
    found = fit_scenario(PLATE, MeasuredTrace(trace=trace, noise=own), free=[GAP])
    counted, data = 1 + len(found.residuals) - stated, found.estimate.count
    few = 2 * counted * (counted + 1) / (data - counted - 1)
    assert found.aicc - found.deviance == pytest.approx(2 * counted + few, rel=1e-9)
    assert found.bic - found.deviance == pytest.approx(counted * np.log(data), rel=1e-9)


@pytest.mark.slow
def test_criteria_choose_the_leak_where_there_is_one():
    without = plate(**{LEAK: 0.0})
    for scenario in (PLATE, without):
        data = [
            MeasuredTrace(trace=noisy(exact(scenario, kind), np.random.default_rng(seed)), name=kind)
            for seed, kind in ((4, "step"), (5, "impedance"))
        ]
        leaky, tight = fit_scenario(PLATE, data, free=[GAP, LEAK]), fit_scenario(without, data, free=[GAP])
        assert (leaky.aicc < tight.aicc) == (leaky.bic < tight.bic) == (scenario is PLATE)


@pytest.mark.parametrize("count", [2, 6])
def test_parameters_that_differ_between_sessions(count):
    rng = np.random.default_rng(7)
    gaps = {f"day {at}": gap for at, gap in enumerate(3e-6 * (1 + 0.1 * rng.normal(size=count)))}
    data = [
        MeasuredTrace(trace=noisy(exact(plate(**{GAP: gap}), "sweep"), rng), name=day, session=day)
        for day, gap in gaps.items()
    ]
    found = fit_scenario(PLATE, data, free=[GAP, FILM], varying=[GAP])
    spread, values = found.sessions[GAP], np.array([*gaps.values()])
    assert [*spread.values.values()] == pytest.approx(values, rel=0.05)
    assert spread.mean == pytest.approx(values.mean(), rel=0.03)
    assert spread.between == pytest.approx(values.std(ddof=1), rel=0.2)
    assert spread.within < 0.3 * spread.between
    assert "too narrow" in spread.in_words("m")
    assert found.scenario.stack.layers["gap"].thickness == spread.mean


@pytest.mark.parametrize("name", ["lateral_forces", "electrostatic_force", "field_gain"])
def test_what_is_not_predicted_over_frequency_alone_is_refused(name):
    """No signal, one over time, and one over frequency and layer."""
    with pytest.raises(ElectrovibError, match=f"'{name}' is not predicted over frequency .* Known: "):
        signals_over_frequency(plate(), np.array([1e2, 1e3]), [name])


@pytest.mark.parametrize("samples", [101, 1001])
def test_exact_data_have_an_interval_of_rounding(samples):
    """Without any residual the covariance would be that of residuals of 1."""
    scenario = ev.load("vezzoli_2014/fig6")
    recorded = ev.simulate(scenario.replace({"time.samples": samples}))
    found = fit_scenario(scenario, recorded, free=["friction.coefficient"], signals=["lateral_force"])
    (row,) = parameter_table(found)
    assert (row.value, row.lower, row.upper) == pytest.approx((0.5, 0.5, 0.5), rel=1e-9)
