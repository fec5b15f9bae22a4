"""Which model made a recording: evidence against closed forms, odds that no order changes, and laws that are alike."""

import math
import sys
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import gammaln
from twins import FILM, LEAK, exact, noisy, plate

from electrovib.core.errors import InputError
from electrovib.core.paths import value_at
from electrovib.recordings.fit.measured import MeasuredTrace
from electrovib.recordings.fit.of_scenario import fit_scenario
from electrovib.recordings.fit.prediction import Unknown
from electrovib.recordings.fit.weighing import Likelihood, MarginalLikelihood, cases_of, probabilities, weigh

SKIN = "stack.stratum_corneum.material.conductivity"


class Linear:
    """A fit of data that are linear in zeros, whose prior reaches up to the largest of the data."""

    def __init__(self, columns, data, *, noise=None, guess=0.3):
        sigma = noise or guess
        self.columns, self.data, self.weights = np.asarray(columns), data, np.full(data.size, 1 / sigma)
        observed = SimpleNamespace(y=data, size=data.size, noise=noise, scale=np.ones(data.size))
        self.noise, self.unknowns = (
            [sigma],
            [Unknown(f"zero {at}", "zero", "", 0, 0) for at in range(self.columns.shape[1])],
        )
        self.prediction = SimpleNamespace(
            pieces=lambda: iter([(0, 0, observed, slice(0, data.size))]), columns=[[observed]]
        )
        self.problem, self.determined = self, {}
        largest = np.max(np.abs(data))
        best = np.clip(np.linalg.lstsq(self.columns, data, rcond=None)[0], -largest, largest)
        self.best, self.width = best, 2 * largest
        self.estimate = SimpleNamespace(values=dict(zip(self.names, best.tolist(), strict=True)))

    @property
    def names(self):
        return [each.name for each in self.unknowns]

    def residual(self, values):
        return (self.columns @ [values[name] for name in self.names] - self.data) * self.weights

    def derivatives(self, values):
        del values
        return self.columns * self.weights[:, None]


def linear(count=40, unknowns=2, **asked):
    rng = np.random.default_rng(5)
    columns = np.stack([np.ones(count), np.linspace(-1, 1, count)], axis=1)[:, :unknowns]
    return Linear(columns, columns @ [1.0, -0.6][:unknowns] + 0.3 * rng.normal(size=count), **asked)


def closed_form(found):
    """ln of the Gaussian integral over all values, less that of the width of the prior, with the noise stated or not."""
    matrix = found.columns.T @ found.columns
    left = found.columns @ found.best - found.data
    squares, count = float(left @ left), len(found.best)
    spread = -0.5 * np.linalg.slogdet(matrix)[1] - count * math.log(found.width)
    (noise,) = found.noise
    if found.prediction.columns[0][0].noise is not None:
        scale = count * math.log(noise * math.sqrt(2 * math.pi)) - left.size * math.log(noise)
        return -squares / 2 / noise**2 + scale + spread
    half = left.size / 2
    scale = gammaln(half - count / 2) - gammaln(half) + count / 2 * math.log(math.pi)
    return scale + spread - (half - count / 2) * math.log(squares)


@pytest.mark.parametrize("unknowns", [pytest.param(1, marks=pytest.mark.slow), 2])
def test_the_evidence_of_a_linear_model_is_its_closed_form(unknowns):
    stated = linear(unknowns=unknowns, noise=0.3)
    told = Likelihood(stated, None).laplace()
    assert told.log == pytest.approx(closed_form(stated), abs=1e-3)
    assert (told.holds, told.method, told.error) == (True, "Laplace", 0.0)
    sampled = Likelihood(stated, None).sampled(seed=3)
    assert abs(sampled.log - closed_form(stated)) < 3 * sampled.error
    assert 0.05 < sampled.error < 0.3
    assert sampled.peak == pytest.approx(told.peak, abs=0.2)


@pytest.mark.parametrize("count", [12, pytest.param(400, marks=pytest.mark.slow)])
def test_noise_that_is_not_stated_is_integrated_out(count):
    unknown = linear(count=count)
    sampled = Likelihood(unknown, None).sampled(seed=3)
    assert abs(sampled.log - closed_form(unknown)) < 3 * sampled.error
    # Laplace has a Gaussian in place of Student's distribution
    assert Likelihood(unknown, None).laplace().log == pytest.approx(closed_form(unknown), abs=2.2 / count)
    other = linear(count=count, guess=0.02)  # the noise at which the search ended does not matter
    assert Likelihood(other, None).laplace().log == pytest.approx(
        Likelihood(unknown, None).laplace().log, abs=1e-9
    )


@pytest.mark.parametrize("share", [0.6, 1.0, 1.4])
def test_the_integral_ends_where_the_prior_ends(share):
    """An estimate inside, at and beyond the end of the prior; there its slope counts too."""
    rng = np.random.default_rng(2)
    data = np.append(rng.normal(size=20) * 0.1 + share * 2.0, 0.0)
    columns = np.append(np.ones(20), 0.0)[:, None]
    data[-1] = 2.0 / 1.0
    data[:20] = np.minimum(data[:20], 2.0) if share < 1 else data[:20]
    found = Linear(columns * 0.5, data, noise=2.0)
    density, end = Likelihood(found, None), found.width / 2

    def likelihood(value):
        return math.exp(density(np.array([(value + end) / (2 * end)])) - density.laplace().peak)

    points = [float(found.best[0])]
    expected = math.log(quad(likelihood, -end, end, points=points)[0] / (2 * end)) + density.laplace().peak
    assert density.laplace().log == pytest.approx(expected, abs=0.02)


def test_a_zero_beyond_its_prior_and_a_parameter_that_is_not_determined_make_it_doubtful():
    found = linear(noise=0.3)
    found.determined = {"zero 0": "not"}
    assert not Likelihood(found, None).laplace().holds
    outside = linear(noise=0.3)
    outside.estimate.values["zero 0"] = outside.width
    assert not Likelihood(outside, None).laplace().holds


def test_laws_count_alike_and_their_variants_share():
    laws = {"A": "A", "A without gap": "A", "B": "B"}
    shares = {"A": 0.25, "A without gap": 0.25, "B": 0.5}
    assert probabilities(dict.fromkeys(laws, 3.0), laws) == pytest.approx(shares, rel=1e-12)
    logs = {"A": -2.0, "A without gap": 1.0, "B": -math.inf}
    found = probabilities(logs, laws)
    assert found["B"] == 0
    assert found["A without gap"] / found["A"] == pytest.approx(math.exp(3))
    moved = probabilities({name: log + 700.0 for name, log in logs.items()}, laws)
    assert moved == pytest.approx(found, rel=1e-12)
    assert probabilities(dict(reversed(logs.items())), laws) == found


def leaky():
    return plate(**{LEAK: "2e-9 S/m"})


def test_the_cases_are_the_laws_with_and_without_gap_and_leak():
    found, refused = cases_of(leaky(), "all")
    own = type(leaky().force).__name__
    assert list(found)[:3] == [own, f"{own} without gap", f"{own} without leak"]
    assert found[own].scenario == leaky()
    assert "gap" not in found[f"{own} without gap"].scenario.stack.layers
    dry = found["EffectiveMedium without leak"]
    assert (dry.law, dry.zero, value_at(dry.scenario, LEAK)) == ("EffectiveMedium", (LEAK,), 0)
    assert value_at(dry.scenario, SKIN) == value_at(leaky(), SKIN) > 0
    assert type(dry.scenario.force).__name__ == "EffectiveMedium"
    assert set(refused) == {
        "Persson2018RoughGap",
        "TabulatedAttraction",
    }  # their values are not those of this set-up
    assert "mean_gap" in refused["Persson2018RoughGap"]
    tight, _ = cases_of(plate(**{LEAK: 0.0}), ["EffectiveMedium"])
    assert list(tight) == [own, f"{own} without gap", "EffectiveMedium", "EffectiveMedium without gap"]
    assert list(cases_of(leaky(), own)[0]) == [own, f"{own} without gap", f"{own} without leak"]


def test_a_law_stands_for_the_layers_that_it_replaces():
    rough = {"model": "Persson2018RoughGap", "mean_gap": 3e-6, "rms_gap": 1e-6}
    layers = {name: each for name, each in leaky().stack.layers.items() if name != "gap"}
    own = leaky().replace({"stack": layers, "force": rough})
    found, _ = cases_of(own, "MaxwellStressInGap")
    assert list(found) == ["Persson2018RoughGap", "MaxwellStressInGap"]
    assert found["Persson2018RoughGap"].scenario == own


@pytest.mark.parametrize(("laws", "words"), [(["EffectiveMediu"], "EffectiveMedium"), ([], "no force law")])
def test_what_is_no_law_is_refused(laws, words):
    with pytest.raises(InputError, match=words):
        cases_of(leaky(), laws)


def fitted(trace, free, laws, *, noise=None, scenario=None):
    scenario = scenario or leaky()
    cases, _ = cases_of(scenario, laws)
    recorded = MeasuredTrace(trace=trace, name="a", noise=noise or {})
    fits = {
        name: fit_scenario(each.scenario, recorded, free=own)
        for name, each in cases.items()
        if (own := [path for path in free if path not in each.zero and has(each.scenario, path)])
    }
    return scenario, fits, {name: cases[name].law for name in fits}


def has(scenario, path):
    return any(path == each for each, _, _ in scenario.parameters())


@pytest.mark.slow
def test_a_recording_that_no_law_enters_tells_none_apart_whatever_the_order():
    trace = noisy(
        exact(leaky(), "impedance", frequencies=np.geomspace(1e2, 1e5, 5)), np.random.default_rng(4)
    )
    laws = ["EffectiveMedium", "MaxwellStressInInsulator"]
    scenario, fits, of = fitted(trace, [LEAK, FILM], laws)
    fits = {name: each for name, each in fits.items() if "without" not in name}
    of = {name: of[name] for name in fits}
    found = weigh(fits, of, scenario, live=40)
    assert len({each.probability for each in found.candidates}) == 1
    assert found.candidates[0].probability == pytest.approx(1 / 3)
    assert {each.evidence.method for each in found.candidates} == {"nested sampling"}
    assert found.sentence == f"cannot be told apart by this recording: {', '.join(sorted(fits))}"
    assert [each.against for each in found.candidates] == ["", "", ""]
    assert weigh(dict(reversed(fits.items())), of, scenario, live=40) == found


@pytest.fixture(scope="module")
def sweep():
    """A mean force over frequency by the Maxwell stress in a gap that leaks."""
    trace = exact(leaky(), "sweep", frequencies=np.geomspace(1, 1e4, 20))
    return noisy(trace, np.random.default_rng(7))


def test_the_true_law_is_found_and_what_speaks_against_the_others_is_stated(sweep):
    scenario, fits, of = fitted(sweep, ["contact.area", LEAK], ["EffectiveMedium"])
    found = weigh(fits, of, scenario, refused={"C": "too wide"})
    first, second = found.candidates[:2]
    assert (first.name, first.against) == ("MaxwellStressInGap", "")
    assert first.probability > 0.999
    assert first.evidence.method == "Laplace"  # no other one is close
    assert first.aicc == 0 < second.aicc
    assert found.sentence == (
        f"MaxwellStressInGap is more than a million times as probable as the next, {second.name}"
    )
    assert all("no noise" in each.against for each in found.candidates[1:])
    assert (found.is_weighed, found.refused) == (True, {"C": "too wide"})
    wrong = {name: each for name, each in fits.items() if name != "MaxwellStressInGap"}
    told = weigh(wrong, {name: of[name] for name in wrong}, scenario, live=40).sentence
    assert told.startswith("no law describes this recording; of those that do not, ")


@pytest.mark.slow
def test_proportional_laws_cannot_be_told_apart_while_a_gain_is_free(sweep):
    flat = sweep.copy(deep=True)
    flat["mean_force"].values[:] = 0.03 * (1 + 0.05 * np.random.default_rng(1).normal(size=20))
    dry = plate(**{LEAK: 0.0, "contact.area": 1e-4})
    scenario, fits, of = fitted(flat, ["contact.area"], ["MaxwellStressInInsulator"], scenario=dry)
    fits = {name: each for name, each in fits.items() if "without" not in name}
    first, second = fits.values()
    areas = [each.estimate.values["contact.area"] for each in (second, first)]
    assert areas[0] / areas[1] == pytest.approx(3.9, rel=1e-3)  # the permittivity of the film
    found = weigh(fits, {name: of[name] for name in fits}, scenario, live=60)
    assert found.sentence.startswith("cannot be told apart by this recording: MaxwellStressIn")
    one, other = found.candidates
    assert abs(one.evidence.log - other.evidence.log) < 3 * math.hypot(
        one.evidence.error, other.evidence.error
    )
    exactly = [Likelihood(each, scenario).laplace().log for each in fits.values()]
    assert exactly[0] == pytest.approx(exactly[1], abs=0.01)


def test_the_prior_is_within_a_factor_of_100_of_the_scenario_and_the_declared_bounds(sweep):
    scenario, fits, _ = fitted(sweep, ["contact.area", LEAK], ["MaxwellStressInGap"])
    area, leak = Likelihood(fits["MaxwellStressInGap"], scenario).parameters.values()
    own = value_at(scenario, "contact.area")
    assert (area.lower, area.upper) == (pytest.approx(own / 100), pytest.approx(own * 100))
    assert (leak.lower, leak.upper) == (pytest.approx(2e-11), pytest.approx(2e-7))
    wide = plate(**{LEAK: "2e-9 S/m", "contact.area": 0.5})
    (area, _) = Likelihood(fits["MaxwellStressInGap"], wide).parameters.values()
    assert (area.lower, area.upper) == (pytest.approx(0.005), 1)
    density = Likelihood(fits["MaxwellStressInGap"], scenario)
    assert density.values(np.array([0.5, 1.0])) == pytest.approx({"contact.area": own, LEAK: 2e-7})


def test_dynesty_is_asked_for_with_the_line_that_installs_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "dynesty", None)
    with pytest.raises(InputError, match=r"dynesty: pip install 'electrovib\[fit\]'"):
        Likelihood(linear(noise=0.3), None).sampled(seed=0)


def weighed_by(monkeypatch, fit, **told):
    """Weigh candidates whose evidence by Laplace is given; sampling gives 0."""
    evidence = iter(told.values())
    monkeypatch.setattr(Likelihood, "laplace", lambda _: next(evidence))
    names = iter(range(9))
    monkeypatch.setattr(Likelihood, "alike", lambda _: (next(names),))
    sampled = MarginalLikelihood(log=0.0, peak=0.0, error=0.1, method="nested sampling")
    monkeypatch.setattr(Likelihood, "sampled", lambda *_, **__: sampled)
    found = weigh(dict.fromkeys(told, fit), {name: name for name in told}, leaky())
    return {each.name: each.evidence.method for each in found.candidates if each.evidence.error}


def test_only_those_within_odds_of_150_of_the_best_are_sampled(monkeypatch, sweep):
    """The largest likelihood, which no evidence exceeds, stands for the evidence of one whose approximation may be off."""
    _, fits, _ = fitted(sweep, [LEAK], ["MaxwellStressInGap"])
    fit = fits["MaxwellStressInGap"]

    def at(log, **more):
        return MarginalLikelihood(log=log, peak=0.0, **more)

    assert set(weighed_by(monkeypatch, fit, A=at(0.0), B=at(-5.0), C=at(-5.02))) == {"A", "B"}
    assert set(weighed_by(monkeypatch, fit, A=at(0.0), B=at(-5.02))) == set()
    doubtful = at(-50.0, holds=False)
    assert set(weighed_by(monkeypatch, fit, A=at(-4.0), B=doubtful)) == {"A", "B"}
    lost = MarginalLikelihood(log=-1.0, peak=-9.1, holds=False)
    assert set(weighed_by(monkeypatch, fit, A=at(-4.0), B=lost)) == set()
    assert set(weighed_by(monkeypatch, fit, A=doubtful, B=lost)) == {"A", "B"}


def test_the_sentence_says_by_how_much_and_names_all_above_5_percent(monkeypatch, sweep):
    _, fits, _ = fitted(sweep, [LEAK], ["MaxwellStressInGap"])
    fit = fits["MaxwellStressInGap"]

    def said(**logs):
        evidence = iter(logs.values())
        monkeypatch.setattr(
            Likelihood, "laplace", lambda _: MarginalLikelihood(log=(log := next(evidence)), peak=log)
        )
        monkeypatch.setattr(Likelihood, "sampled", lambda own, **_: own.laplace())
        monkeypatch.setattr("electrovib.recordings.fit.weighing.CLOSE", 1.0)
        return weigh(dict.fromkeys(logs, fit), {name: name for name in logs}, leaky())

    assert said(A=0.0, B=math.log(0.049)).sentence == "A is 20.4 times as probable as the next, B"
    assert said(A=math.log(0.06), B=0.0).sentence == "cannot be told apart by this recording: B, A"
    assert said(A=0.0).sentence == "A is the only one that could be fitted"
    assert "more than a million times" in said(A=0.0, B=-13.9).sentence
    told = said(A=0.0, B=-5.0)
    assert told.candidates[1].against == "its best fit is 148 times less likely than that of A"
    assert told.candidates[0].against == ""


@pytest.fixture(scope="module")
def twins():
    """Recordings of a drawn law and drawn parameters, weighed: each candidate's probability, and whether it is the true one."""
    grid, free = np.geomspace(1, 1e4, 8), "contact.area"
    base = leaky()
    cases, _ = cases_of(base, ["EffectiveMedium", "MaxwellStressInInsulator"])
    cases = {
        name: cases[name] for name in ("MaxwellStressInGap", "EffectiveMedium", "MaxwellStressInInsulator")
    }
    laws = {name: each.law for name, each in cases.items()}
    rng, found = np.random.default_rng(11), []
    for number in range(120):
        true = list(cases)[rng.integers(3)]
        area = value_at(base, free) * 100 ** rng.uniform(-1, 1)
        trace = exact(cases[true].scenario.replace({free: area}), "sweep", frequencies=grid)
        trace["mean_force"].values[:] += 0.03 * rng.normal(size=grid.size)
        recorded = MeasuredTrace(trace=trace, name="twin", noise={"mean_force": 0.03} if number % 2 else {})
        fits = {name: fit_scenario(each.scenario, recorded, free=[free]) for name, each in cases.items()}
        told = weigh(fits, laws, base, seed=number, live=25)
        found += [(each.probability, each.name == true) for each in told.candidates]
    return np.array(found, dtype=float)


@pytest.mark.slow
@pytest.mark.parametrize(("low", "high"), [(0.0, 0.02), (0.02, 0.3), (0.3, 0.4), (0.4, 0.9), (0.9, 1.01)])
def test_of_what_has_a_probability_that_share_is_true(twins, low, high):
    """Within three counting errors; benchmarks/laws.py does the same with 500 twins and two free parameters."""
    stated, seen = twins[(low <= twins[:, 0]) & (twins[:, 0] < high)].T
    error = math.sqrt(np.sum(stated * (1 - stated))) / stated.size
    assert stated.size > 10
    assert abs(np.mean(seen) - np.mean(stated)) < 3 * error + 0.005
