"""From force to level: against closed forms, against the published direction, and against a second route."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from scenario_parts import FINGER, constant, model, polarity, sine, square, step

from electrovib.core.errors import InputError
from electrovib.core.signals import make_trace
from electrovib.papers import vardar_2017
from electrovib.physics.perception import ElasticSkin, ElasticViscousSkin, Pacinian, Perception
from electrovib.scenario import load
from electrovib.solve.electrics.attraction import mean_force
from electrovib.solve.simulate import simulate
from electrovib.solve.stack.expand import phasors
from electrovib.studies.felt_spectrum import (
    Lines,
    Stimulus,
    just_felt,
    lines,
    sensation_of,
    threshold_over_frequency,
    threshold_ratio,
)
from electrovib.studies.perceive import compare_percepts, perceive

SINE = vardar_2017.scenarios()["sine"]
ALONE = Perception(channels=(Pacinian(),))
ONE_VOLT = {"sine": sine(1.0, 100.0)}


def db(ratio):
    return 20 * math.log10(ratio)


def interval(found):
    return found.sensation - found.uncertainty, found.sensation + found.uncertainty


def measured(**signals):
    time = np.linspace(0, 1, 8001)[:-1]
    variables = {name: (("time",), function(time)) for name, function in signals.items()}
    return make_trace(variables, {"time": time}, {"title": "a rig"})


def wave(amplitude, frequency):
    return lambda time: amplitude * np.sin(2 * np.pi * frequency * time)


@pytest.mark.parametrize("frequency", [15.0, 62.5, 125.0, 250.0, 480.0])
def test_a_sine_is_felt_at_twice_its_frequency(frequency):
    """All moving force is one line, so its relative level is the weight there; at 125 Hz it is the best there is."""
    found = perceive(SINE.replace({"drive.frequency": frequency}), perception=ALONE)
    expected = db(float(Pacinian().weight(2 * frequency)))
    assert found.relative == pytest.approx(expected, abs=1e-5)  # swing is read off 8192 samples
    assert abs(found.numerical_error) < 1e-9


def test_level_is_that_of_the_friction():
    """Without dispersion the force moves by its own mean: friction times that, by phasors and not by marching."""
    skin = vardar_2017.first_order_skin(time_constant=7.7e-3)
    plain = SINE.replace({"stack.stratum_corneum.material": skin})
    mean = float(mean_force(plain, phasors(plain, np.array([30.0])), amplitude=plain.drive.amplitude)[0])
    found = perceive(plain, perception=ALONE)
    assert found.level == pytest.approx(db(0.5 * mean * float(Pacinian().weight(60.0))), abs=1e-6)
    assert found.swing == pytest.approx(0.5 * mean, rel=1e-6)
    louder = perceive(plain, perception=ALONE, set={"drive.amplitude": 200.0})
    assert louder.level - found.level == pytest.approx(40 * math.log10(2), abs=1e-9)
    assert louder.relative == pytest.approx(found.relative, abs=1e-9)


def test_the_skin_acts_before_the_weight():
    skin = ElasticViscousSkin(stiffness=800.0, corner=90.0)
    with_skin = perceive(SINE, perception=ALONE.model_copy(update={"compliance": skin}))
    without = perceive(SINE, perception=ALONE)
    gain = db(abs(complex(skin.compliance(60.0))))
    assert with_skin.level - without.level == pytest.approx(gain, abs=1e-9)
    best = db(abs(complex(skin.compliance(60.0) / skin.compliance(250.0))))
    assert with_skin.relative - without.relative == pytest.approx(best, abs=1e-9)
    assert (with_skin.unit, without.unit) == ("m", "N")
    assert "skin elastic to 100 Hz, then viscous (cited from memory, unverified)" in without.alternatives
    assert not any("unverified" in name for name in with_skin.alternatives)
    values = [without.relative, *without.alternatives.values()]
    assert without.interval == (min(values), max(values))
    assert without.interval[1] > without.interval[0]


@pytest.mark.parametrize(
    ("offset", "verdict"), [(-7.0, "detectable"), (-5.0, "within the uncertainty"), (7.0, "not detectable")]
)
def test_a_calibrated_threshold_decides(offset, verdict):
    skin = ElasticSkin(stiffness=1000.0)
    level = perceive(SINE, perception=Perception(compliance=skin)).level
    person = Perception(compliance=skin, threshold=10 ** ((level + offset) / 20), threshold_uncertainty=6.0)
    found = perceive(SINE, perception=person)
    assert found.sensation == pytest.approx(-offset, abs=1e-9)
    assert found.verdict == verdict
    assert any("by the user" in text for text in found.calibrated_on)


def test_a_threshold_without_mechanics_takes_the_published_skins():
    """One line at 60 Hz: 323.2 N/m, without and with 15.8 N s/m over 400 mm2 for 1 cm2; 3 dB of the threshold besides."""
    found = perceive(SINE, set={"perception.threshold": "0.1 um", "perception.threshold_uncertainty": 3})
    soft, stiff = 323.2, abs(323.2 + 2j * math.pi * 60 * 15.8 / 4)
    level = db(found.swing * float(Pacinian().weight(60.0)) / 1e-7)
    ends = level - db(stiff) - 3, level - db(soft) + 3
    assert interval(found) == pytest.approx(ends, abs=1e-3)
    assert found.left == {"perception.compliance": pytest.approx(3.0)}
    assert any("arXiv:2505.11162" in text for text in found.calibrated_on)


@pytest.mark.parametrize(
    ("amplitude", "frequency", "end"), [(0.03e-6, 150.0, 1), (0.13e-6, 300.0, 0), (26e-6, 10.0, 0)]
)
def test_a_vibration_at_the_lowest_or_highest_published_threshold_is_at_that_end(amplitude, frequency, end):
    """Brisben 1999, Bolanowski 1988, and Israr et al. 2006 at 10 Hz, where the Pacinian channel feels nothing."""
    found = perceive(measured(skin_displacement=wave(amplitude, frequency)))
    assert interval(found)[end] == pytest.approx(0.0, abs=1e-3)
    assert found.verdict == "within the uncertainty"
    assert list(found.left) == ["perception.threshold"], "the displacement was measured"
    assert found.felt_by == ("NonPacinian" if frequency < 100 else "Pacinian")
    for factor, verdict in ((100, "detectable"), (0.01, "not detectable")):
        trace = measured(skin_displacement=wave(factor * amplitude, frequency))
        assert perceive(trace).verdict == verdict


def test_without_a_calibration_the_spread_is_that_of_thresholds_and_skins():
    """250 Hz, one line: the ends are extremes over 3 thresholds and 2 skins, and measuring one leaves the spread of the other."""
    found = perceive(SINE, set={"drive.frequency": 125.0})
    weight = Pacinian().weight
    thresholds = [0.03e-6 * weight(150.0), 0.06e-6 * weight(320.0), 0.13e-6 * weight(300.0)]
    skins = [323.2, abs(323.2 + 2j * math.pi * 250 * 3.95)]
    levels = [db(found.swing / skin / each) for skin in skins for each in thresholds]
    assert interval(found) == pytest.approx((min(levels), max(levels)), abs=1e-3)
    halves = [10 * math.log10(max(each) / min(each)) for each in (skins, thresholds)]
    assert found.left == pytest.approx(
        {"perception.threshold": halves[0], "perception.compliance": halves[1]}, abs=1e-3
    )
    assert sum(found.left.values()) == pytest.approx(found.uncertainty)
    person = {"perception.threshold": "50 nm", "perception.threshold_uncertainty": 0}
    own = perceive(SINE, set={"drive.frequency": 125.0, **person})
    assert own.uncertainty == pytest.approx(found.left["perception.threshold"])


@pytest.mark.parametrize("given", [None, ElasticSkin(stiffness=700.0)])
def test_a_sine_that_is_just_felt_is_at_an_end(given):
    """The curve over frequency is the inverse of the level of one line."""
    for frequency in (20.0, 60.0, 250.0):
        own = {"frequency": np.array([frequency]), "amplitude": np.array([1.0]), "swing": 1.0}
        line = Lines(**own, samples=1, signal="lateral_force", how="")
        for end, amplitude in enumerate(
            just_felt(Stimulus(line, Perception(), given), np.array([frequency]))
        ):
            felt = sensation_of(Stimulus(replace(line, amplitude=amplitude), Perception(), given))
            assert (felt.high, felt.low)[end] == pytest.approx(0.0, abs=1e-9)


def test_just_noticeable_is_in_decibels_of_the_voltage():
    quiet = perceive(SINE)
    for level, noticeable in ((1.2, False), (1.22, True), (-1.22, True)):
        loud = perceive(SINE, set={"drive.amplitude": 100 * 10 ** (level / 20)})
        found = compare_percepts(loud, quiet)
        assert found.difference == pytest.approx(level, abs=1e-9)
        assert found.noticeable is noticeable
    moved = perceive(SINE, perception=Perception(compliance=ElasticSkin(stiffness=1e3)))
    with pytest.raises(InputError, match=r"perception\.compliance"):
        compare_percepts(moved, quiet)
    with pytest.raises(InputError, match="nothing moves"):
        compare_percepts(perceive(SINE, set={"drive": step(0.0)}), quiet)


def test_nothing_that_moves_is_not_felt_and_a_percept_is_plain_content():
    found = perceive(SINE, set={"drive": step(0.0)})
    assert (found.loudest, found.level, found.verdict) == ("", -math.inf, "relative only")
    assert json.loads(json.dumps(found.to_dict(), allow_nan=False))["level"] is None
    again = json.loads(json.dumps(perceive(SINE).to_dict(), allow_nan=False))
    assert again["spectrum"]["frequency"][0] == pytest.approx(30.0)
    assert again["channels"][0]["channel"] == "Pacinian"


# spectrum


def test_a_record_that_ends_elsewhere_gets_no_jump():
    """A decay after a jump: its Fourier integral is known, F/(rate + j w)."""
    span, count, rate = 0.5, 1 << 15, 40.0
    time = (np.arange(count) + 0.5) * span / count
    found = lines(np.exp(-rate * time), span=span, before=0.0, signal="lateral_force", how="")
    low = found.frequency < 1000
    expected = 2 / span / np.abs(rate + 2j * np.pi * found.frequency)
    # a sample is the middle of its step: w step/2 is 5e-2 at 1 kHz, its square 2e-3; 1e-9 of the decay is left
    np.testing.assert_allclose(found.amplitude[low], expected[low], rtol=2e-3)
    assert found.swing == pytest.approx(0.5, rel=1e-3)
    wrapped = lines(np.exp(-rate * time / 40), span=span, before=0.0, signal="lateral_force", how="")
    slow = 2 / span / np.abs(2j * np.pi * found.frequency)
    np.testing.assert_allclose(wrapped.amplitude[low][10:], slow[low][10:], rtol=0.5)


def test_a_period_gives_its_fourier_series():
    count, period = 1 << 10, 0.02
    phase = 2 * np.pi * (np.arange(count) + 0.5) / count
    values = 3.0 + 2e-3 * np.cos(phase) + 5e-4 * np.sin(7 * phase)
    found = lines(values, span=period, before=float(values[-1]), signal="lateral_force", how="")
    assert found.frequency[[0, 6]] == pytest.approx([50.0, 350.0])
    assert found.amplitude[[0, 6]] == pytest.approx([2e-3, 5e-4], rel=1e-9)
    assert np.max(np.delete(found.amplitude, [0, 6])) < 1e-12


def test_a_burst_counts_by_its_share_of_the_window():
    """125 Hz over half of the window: half the power of the lasting sine, and a little at its ends."""
    blocking = SINE.replace({"stack.stratum_corneum.material": constant()})
    person = ALONE.model_copy(update={"window": 0.48})
    bursts = [model("Burst", amplitude=100.0, frequency=125.0, cycles=cycles) for cycles in (30, 60)]
    short, lasting = (perceive(blocking, set={"drive": drive}, perception=person) for drive in bursts)
    # switched at its zeros; what spreads besides the line at 250 Hz is within the channel as well
    assert lasting.level - short.level == pytest.approx(10 * math.log10(2), abs=0.1)
    assert "from rest, window of 0.48 s" in short.spectrum.how


def test_a_leak_is_followed_from_rest_and_says_so():
    """A leak in proportion to the field is a conductivity, whose steady state is known exactly."""
    skin = "stack.stratum_corneum"
    ohmic = SINE.replace({f"{skin}.material": constant(1560.0, 1e-5)})
    leaking = SINE.replace({f"{skin}.material": constant(), f"{skin}.leak": polarity(1e-5, 1e-5)})
    found, exact = perceive(leaking, set={"perception.window": 0.07}), perceive(ohmic)
    assert "not known to be steady" in found.spectrum.how
    assert found.level == pytest.approx(exact.level, abs=0.02)
    with pytest.raises(InputError, match="leak"):
        threshold_over_frequency(leaking, [30.0], ONE_VOLT)


@pytest.mark.parametrize(
    ("changes", "path"),
    [
        ({"friction": model("PowerLaw", coefficient=0.5, at_force=1.0, exponent=-0.5)}, "friction"),
        ({"contact": model("GrowingArea", area=1e-4, at_force=0.5, exponent=0.5)}, "contact"),
        ({"circuit.amplifier": {"saturation": 50.0}}, "circuit.amplifier"),
    ],
    ids=["power law", "growing area", "saturation"],
)
def test_a_threshold_from_one_run_needs_a_friction_proportional_to_the_square(changes, path):
    """With a PowerLaw of exponent -0.5 a run at 1000 V would give 42 V in the place of 28 V."""
    refused = f"^{path}: with it the change of the friction is not proportional"
    with pytest.raises(InputError, match=refused):
        threshold_over_frequency(SINE.replace(changes), [30.0], ONE_VOLT)
    for pair in ((SINE, SINE.replace(changes)), (SINE.replace(changes), SINE)):
        with pytest.raises(InputError, match=refused):
            threshold_ratio(*pair, Perception())


# Traces


def test_a_trace_is_felt_as_its_scenario_and_a_measured_displacement_needs_no_mechanics():
    assert perceive(simulate(SINE)).level == perceive(SINE).level
    changes = {"perception.threshold": "0.5 um", "perception.threshold_uncertainty": 3}
    found = perceive(measured(skin_displacement=wave(1e-6, 250)), set=changes)
    assert found.level == pytest.approx(-120.0, abs=1e-3)
    assert found.sensation == pytest.approx(db(2), abs=1e-3)
    assert (found.verdict, found.unit, found.title) == ("detectable", "m", "a rig")


def test_the_loudest_window_of_a_measurement_counts():
    found = perceive(measured(lateral_force=lambda time: np.where(time < 0.5, 1, 3) * wave(1e-3, 250)(time)))
    assert found.level == pytest.approx(db(3e-3), abs=1e-2)
    assert "from 0.5 s on" in found.spectrum.how


def test_uneven_times_are_said():
    time = np.sort(np.random.default_rng(1).uniform(0, 0.5, 40_000))
    trace = make_trace({"lateral_force": (("time",), np.sin(2 * np.pi * 100 * time))}, {"time": time}, {})
    trace = trace.isel(time=np.flatnonzero(np.diff(time, prepend=-1) > 2e-6))
    found = perceive(trace, perception=ALONE)
    assert "even times" in found.spectrum.how
    # 100 Hz does not fit the record exactly: leakage
    assert found.level == pytest.approx(db(float(Pacinian().weight(100.0))), abs=0.1)


FORCE = measured(lateral_force=np.sin)
REFUSED = [
    (measured(plate_voltage=np.sin), None, "no signal to feel"),
    (measured(lateral_force=lambda time: np.where(time > 0.5, np.nan, time)), None, "finite"),
    (FORCE.expand_dims(frequency=[1.0, 2.0]), None, "dimensions frequency, time"),
    (FORCE.assign_attrs(over='{"drive.rise": [1.0]}'), None, "sweep"),
    (FORCE, {"drive.high": 3}, "carries no scenario"),
    (SINE, {"perception.treshold": 1}, r"perception\.treshold.*Did you mean 'threshold'"),
    (SINE, {"perception": 3}, "perception = 3: expected a table"),
    (SINE, {"perception.threshold": "1 um"}, r"perception = .*threshold_uncertainty"),
    (SINE, {"drive.amplitud": 3}, "Did you mean 'amplitude'"),
]


@pytest.mark.parametrize(("felt", "changes", "sentence"), REFUSED)
def test_what_cannot_be_felt_is_refused(felt, changes, sentence):
    with pytest.raises(InputError, match=sentence):
        perceive(felt, set=changes)


# thresholds


def test_two_routes_to_a_threshold_voltage():
    """A drive at the voltage that one run foretells is felt at 0 dB."""
    skin = ElasticViscousSkin(stiffness=1000.0, corner=100.0)
    person = Perception(compliance=skin, threshold=2e-7, threshold_uncertainty=6.0)
    drives = {"sine": model("Sine", amplitude=30.0), "square": model("Square", high=70.0, low=-70.0)}
    curves = threshold_over_frequency(SINE, [15.0, 125.0, 480.0], drives, perception=person)
    voltage = curves.voltage
    for place, frequency in enumerate(curves.frequency.tolist()):
        level, peak = float(voltage["sine"][place]), float(voltage["square"][place])
        found = perceive(SINE, set={"drive": sine(level, frequency)}, perception=person)
        assert found.sensation == pytest.approx(0.0, abs=1e-6)
        found = perceive(SINE, set={"drive": square(peak, frequency, low=-peak)}, perception=person)
        # twice the samples or more of a square with jumps
        assert found.sensation == pytest.approx(0.0, abs=0.03)
        ratio = curves.level["sine"][place] - curves.level["square"][place]
        assert ratio == pytest.approx(db(level / peak), abs=1e-9)
    relative = threshold_over_frequency(SINE, [15.0, 125.0], drives, perception=ALONE)
    assert not relative.voltage
    assert min(float(np.min(row)) for row in relative.level.values()) == 0.0


def test_a_finger_is_the_mechanics_where_the_person_gives_none():
    """The displacement through mass, spring and damper: the line at twice the drive's frequency, by hand."""
    changes = {"drive": sine(1000.0, 125.0), "perception": {"channels": [model("Pacinian")]}}
    scenario = load("vezzoli_2014/fig6").replace(changes)
    sprung = scenario.replace({"finger": FINGER})
    bare, moved = perceive(scenario), perceive(sprung)
    # all of the alternating force is at 250 Hz, the best frequency: the same relative level, another displacement
    compliance = abs(sprung.finger.compliance(np.array(250.0)))
    assert moved.channels[0].level - bare.channels[0].level == pytest.approx(db(compliance), abs=0.02)
    assert "MassSpringDamper" in " ".join(moved.calibrated_on)
