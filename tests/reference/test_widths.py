"""Widths of answers about people, against draws of thresholds, skins, laws and fingers in numpy alone.

The stack is an insulator and a gap. Under a sine of amplitude V the force is eps0 A V^2/(4 K^2) (1 - cos(4 pi f t)) with the
electrical thickness K, so that the friction has one line, at twice the frequency of the drive.
"""

import functools
import json
import math

import numpy as np
import pytest
from scipy.stats import norm

import electrovib as ev
from electrovib.studies import widths
from electrovib.studies.evidence.files import measurements
from electrovib.studies.evidence.function import evidence
from electrovib.studies.evidence.standing import typical_factor

EPS0, AREA, GAP, PERMITTIVITY, FRICTION = 8.8541878128e-12, 1e-4, 20e-6, 3.0, 0.5
MEDIAN, FACTOR, SHARE, LAW = 5e-6, 1.5, 0.9, 11.0
PATH, VOLTS = "stack.insulator.thickness", "drive.amplitude"
INSULATOR = {
    "thickness": MEDIAN,
    "material": {"model": "Constant", "permittivity": PERMITTIVITY},
    "breakdown_field": 1e9,
}
STATIC = ev.load(
    "bau_2010/sine",
    changes={
        "stack": {"insulator": INSULATOR, "gap": {"thickness": GAP}},
        "circuit.return_path": {"model": "Grounded", "resistance": 0.0},
        "contact.area": AREA,
        "friction": {"model": "Coulomb", "coefficient": FRICTION},
        "drive.frequency": 125.0,
    },
)
SPACE = {PATH: {"model": "LogNormal", "median": MEDIAN, "factor": FACTOR}}
ASKED = {"want": "detection level = 0 dB", "free": VOLTS, "space": SPACE, "share": SHARE, "n": 20}


@functools.cache
def of_people(seed):
    """Twenty fingers, of whom nine in ten feel the drive, solved once for all that look at them."""
    return ev.value_for_share(STATIC, seed=seed, **ASKED)


def weight(frequency):
    """12 dB per octave on both sides of 250 Hz."""
    ratio = frequency / 250.0
    return 4 * ratio**2 / (2 + 2 * ratio**4)


AMPLITUDES = [0.03e-6 * weight(150.0), 0.06e-6 * weight(320.0), 0.13e-6 * weight(300.0)]
SOFTEST, STIFFEST = 1 / 323.2, 1 / abs(323.2 * (1 + 250j / 13.022500660076092))
"""Compliance at 250 Hz of a spring of 323 N/m, alone and with a damper of 3.95 N s/m."""
THRESHOLDS = (min(AMPLITUDES) / SOFTEST, max(AMPLITUDES) / STIFFEST)
"""Amplitude of the friction that is just felt, the lowest and the highest one [N]."""


def thickness_of(share):
    """Thickness that a share of the fingers does not exceed."""
    return MEDIAN * FACTOR ** norm.ppf(share)


def voltage(thickness, threshold, law=1.0):
    """Amplitude at which the friction has the threshold, where the force is `law` times as large as the stress in the gap."""
    kappa = thickness / PERMITTIVITY + GAP
    return kappa * np.sqrt(4 * threshold / (FRICTION * EPS0 * AREA * law))


def between(random, low, high, count):
    return np.exp(random.uniform(math.log(low), math.log(high), count))


def by_name(found):
    return {each.name: each.interval for each in found.widths}


def drawn(seed, count):
    return np.sort(ev.read_space(STATIC, SPACE).draw(seed, 0, count)[PATH])


@pytest.mark.parametrize("seed", [5, pytest.param(6, marks=pytest.mark.slow)])
def test_each_width_holds_what_it_names_and_all_together_hold_the_voltage_of_any_nature(seed):
    """Nature has some threshold, skin and law and all fingers; the answer knows published ends, a factor and twenty fingers."""
    found, random = of_people(seed), np.random.default_rng(seed)
    spans, own = by_name(found), drawn(seed, 20)[17]
    middle = math.sqrt(THRESHOLDS[0] * THRESHOLDS[1])
    assert found.value == pytest.approx(voltage(own, middle), rel=1e-3)
    thresholds, laws = between(random, *THRESHOLDS, 10000), between(random, 1 / LAW, LAW, 10000)
    for name, values in (
        (widths.THRESHOLDS, voltage(own, thresholds)),
        (widths.LAW, voltage(own, middle, laws)),
    ):
        low, high = spans[name]
        assert low * (1 - 1e-3) < values.min() < 1.01 * low
        assert 0.99 * high < values.max() < high * (1 + 1e-3)
    ends = {widths.SAMPLING: voltage(thickness_of(SHARE), middle)}
    ends[widths.TOGETHER] = voltage(thickness_of(SHARE), thresholds, laws)
    for name, values in ends.items():
        low, high = spans[name]
        assert np.mean((low < values) & (values < high)) == 1.0, name
    assert spans[widths.TOGETHER][0] == pytest.approx(
        voltage(drawn(seed, 20)[14], THRESHOLDS[0], LAW), rel=1e-3
    )
    assert spans[widths.PEOPLE] is None


def test_the_widths_of_a_share_of_which_no_finger_is_left_out_hold_in_95_of_100_samples():
    """The ranks of the sampling, for natures whose threshold and law are at their ends: as the intervals are made, in numpy."""
    low, high = (rank - 1 for rank in widths.quantile_ranks(SHARE, 100))
    exact, held = thickness_of(SHARE), 0
    for seed in range(400):
        sample = drawn(seed, 100)
        held += sample[low] < exact < sample[high]
    assert 0.93 < held / 400 <= 1.0


@pytest.mark.slow
def test_a_share_contains_how_thresholds_differ_between_people_where_the_space_draws_them():
    spread = {"model": "LogNormal", "median": 1e-7, "factor": 2.0}
    person = {
        "threshold": 1e-7,
        "threshold_uncertainty": 0.0,
        "compliance": {"model": "ElasticSkin", "stiffness": 400.0},
    }
    given = STATIC.replace({"perception": person})
    asked = {**ASKED, "space": {**SPACE, "perception.threshold": spread}, "n": 60}
    found = ev.value_for_share(given, seed=3, **asked)
    random = np.random.default_rng(3)
    thickness = MEDIAN * FACTOR ** random.normal(size=200000)
    felt_from = voltage(thickness, 400.0 * 1e-7 * 2.0 ** random.normal(size=200000))
    exact = np.quantile(felt_from, SHARE)
    low, high = by_name(found)[widths.SAMPLING]
    assert low < exact < high
    # without that spread it is another value
    assert exact > 1.3 * np.quantile(voltage(thickness, 400.0 * 1e-7), SHARE)
    assert by_name(found)[widths.THRESHOLDS] == pytest.approx((found.value, found.value))
    assert widths.PEOPLE not in by_name(found)


@pytest.mark.slow
def test_the_intervals_of_a_study_are_order_statistics_and_hold_the_exact_percentiles():
    """Of 60 samples of 100 fingers, at the 90th percentile of the force: at least 95 % less the deviation of the count."""
    held, signal = 0, "electrostatic_force"
    exact = EPS0 * AREA * 100.0**2 / (2 * (thickness_of(0.1) / PERMITTIVITY + GAP) ** 2)
    for seed in range(60):
        found = ev.study(STATIC.replace({VOLTS: 100.0}), SPACE, n=100, seed=seed, percentiles=[90])
        at = int(np.argmax(found[f"{signal}_percentile"].values[0]))
        low, high = found[f"{signal}_percentile_interval"].values[0, :, at]
        peak = exact * found[f"{signal}_percentile"].values[0, at] / _percentile(seed)
        held += low < peak < high
    assert held >= 53
    ranks = [rank - 1 for rank in widths.quantile_ranks(0.9, 100)]
    forces = np.sort(1 / (drawn(59, 100) / PERMITTIVITY + GAP) ** 2)
    assert high / low == pytest.approx(forces[ranks[1]] / forces[ranks[0]], rel=1e-5)


def _percentile(seed):
    """The 90th percentile of the peak force of the sample at 100 V."""
    forces = EPS0 * AREA * 100.0**2 / (2 * (drawn(seed, 100) / PERMITTIVITY + GAP) ** 2)
    return np.quantile(forces, 0.9)


@pytest.mark.slow
def test_the_typical_factors_are_those_of_the_absolute_forces_that_were_measured_on_fingers():
    """What is quoted is computed again; of two forces, another seed of the draws changes it by less than a factor of 2.5."""
    words = widths.COMMAND.removeprefix("electrovib evidence ").split()
    every = measurements("").items()
    chosen = {name for name, each in every if (each.judges, each.unit, each.on) == ("force", "N", "finger")}
    assert chosen == {name for word in words for name in measurements(word)}
    found, other = ({}, {})
    for seed, factors in enumerate((found, other)):
        scores = evidence(words, seed=seed).scores
        for law in {each.model for each in scores}:
            own = [each for each in scores if each.model == law]
            assert (len(own), len({each.group for each in own})) == (2, 2)
            factors[law] = typical_factor(own)
    assert found.keys() == widths.TYPICAL_FACTORS.keys()
    for law, factor in widths.TYPICAL_FACTORS.items():
        assert float(f"{found[law]:.2g}") == factor
        assert 1 / 2.5 < other[law] / factor < 2.5


def test_the_record_and_the_sentences_have_the_same_ends():
    found = of_people(5)
    kept = json.loads(json.dumps(found.to_dict(), allow_nan=False))["widths"]
    assert [each["name"] for each in kept] == [each.name for each in found.widths]
    assert kept[1]["interval"] == list(found.widths[1].interval)
    for each in found.widths:
        assert sum(each.sentence in line for line in found.document.shown(everything=True).split("\n")) == 1
