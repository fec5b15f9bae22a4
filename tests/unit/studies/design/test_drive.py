"""Drives for a target of the force and gains of a carrier, compared with the full model, closed forms and brute force."""

import json
import math
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.optimize import minimize
from typer.testing import CliRunner

import electrovib as ev
from electrovib.apps.cli import app
from electrovib.core.errors import InputError, NotCausalError
from electrovib.studies.check import cleared_for_output
from electrovib.studies.design.drive.carrier import carrier_gain, chosen_carrier
from electrovib.studies.design.drive.direct import Trade, best_factor
from electrovib.studies.design.drive.direct import _held as held_start
from electrovib.studies.design.drive.function import drive_for_force
from electrovib.studies.design.drive.target import read_target
from electrovib.studies.design.limits import Bounds

FIG6, GAP, FIG7 = "vezzoli_2014/fig6", "vezzoli_2014/fig6_gap", "vezzoli_2014/fig7"
LIMITS = {"voltage": "1 kV", "current": "250 uA"}
CAUSAL = ev.load(FIG7, changes={"force": {"model": "Vezzoli2014Causal"}})
BEHIND_GAP, FILM = ev.load(GAP), ev.load(FIG6)


def design(scenario, target, method="carrier", **options):
    return drive_for_force(scenario, target=target, method=method, **{"limits": LIMITS} | options)


def simulated_means(designed):
    """Return the mean of the simulated force over each interval, by `ev.simulate` at two Gauss points of each step."""
    edges = designed.edges
    steps = max(8, round((edges[1] - edges[0]) * designed.rate))
    nodes = ((np.arange(steps)[:, None] + 0.5 + np.array([-1, 1]) / math.sqrt(12)) / steps).ravel()
    times = (edges[:-1, None] + np.diff(edges)[:, None] * nodes).ravel()
    trace = ev.simulate(designed.scenario, time=times)
    return trace.electrostatic_force.values.reshape(-1, len(nodes)).mean(axis=1)


def misfit(force, wanted):
    return math.sqrt(np.mean((force - wanted) ** 2) / np.mean(wanted**2))


@pytest.mark.slow
def test_carrier_tracks_a_tenth_of_its_frequency_to_1_percent_and_without_correction_dispersion_remains():
    """Leak, dispersion and sampling are compensated; a square-root modulation, exact in v^2, departs and says so."""
    target = "sine 100 Hz 0.2 mN for 20 ms"
    designed = design(CAUSAL, target, carrier="1 kHz")
    wanted, found = read_target(target), simulated_means(designed)
    own = np.array([np.mean(wanted.force(np.linspace(a, a + 1e-3, 2001))) for a in designed.edges[:-1]])
    assert misfit(found, own) < 1e-3
    assert misfit(found, wanted.force((designed.edges[:-1] + designed.edges[1:]) / 2)) < 0.01
    assert designed.is_achieved
    assert designed.misfit < 1e-4
    assert designed.values[0] == 0
    assert abs(designed.values[-1]) < 1e-9
    designed = design(CAUSAL, target, "sqrt-am", carrier=1000.0)
    assert designed.misfit == pytest.approx(misfit(simulated_means(designed), designed.wanted), rel=1e-2)
    assert 1e-3 < designed.misfit < 0.05
    assert designed.harmonics[1] == pytest.approx(1, abs=0.05)
    assert any("at 2 to 4 times that frequency" in line for line in designed.document.sentences)


def test_square_root_modulation_squares_to_the_target_and_twice_the_carrier():
    """v^2 = F*(1 - cos 2wt)/(2 g) to 1e-9."""
    designed = design(BEHIND_GAP, "sine 50 Hz 30 mN", "sqrt-am", carrier="3 kHz")
    gain = carrier_gain(BEHIND_GAP, [3000.0]).force[0]
    wanted = 15e-3 * (1 - np.cos(2 * np.pi * 50 * designed.times)) / gain
    squares = wanted * (1 - np.cos(2 * np.pi * 6000 * designed.times)) / 2
    assert designed.values**2 == pytest.approx(squares, abs=1e-9 * np.max(squares))


def test_limits_of_a_carrier_are_used_and_not_exceeded():
    """A constant force above what 250 uA gives at 3 kHz: the drive is at the limit all the time."""
    designed = design(FILM, "constant 5 mN for 50 ms", carrier="3 kHz")
    check = cleared_for_output(designed.scenario, limits=LIMITS)
    assert check.value("peak current") == pytest.approx(250e-6, rel=3e-4)
    assert (designed.binding, designed.limited_share) == (("current",), 1)
    assert designed.scale == pytest.approx(4.63 / 5, rel=5e-3)
    assert not designed.is_achieved
    assert "0.92" in designed.document.shown(everything=True)


def test_periods_beside_a_limit_keep_the_envelope_of_the_target():
    """Where the target is within the limits the envelope is sqrt(F*/g) to a few percent, also beside a period at the limit."""
    options = {"carrier": "1 kHz", "rate": 32e3, "limits": {"voltage": 200}}
    designed = design(BEHIND_GAP, "sine 100 Hz 30 mN for 20 ms", **options)
    gain = carrier_gain(BEHIND_GAP, [1e3]).force[0]
    envelope = np.abs(designed.target.root(designed.times)) / math.sqrt(gain)
    crest = np.abs(np.sin(2 * np.pi * 1e3 * designed.times)) > 0.99
    inside = crest & (envelope < 190)
    assert np.abs(designed.values[inside]) == pytest.approx(envelope[inside], rel=0.04, abs=5)
    assert 0.3 < designed.limited_share < 0.8


def test_limits_of_a_carrier_are_traded_as_by_brute_force():
    """Three envelope values under a voltage limit, against SLSQP on the full model with the same freedom."""
    times, forces = np.arange(4) * 1e-3, np.array([2e-3, 6e-3, 9e-3, 3e-3])
    options = {"carrier": 1000.0, "rate": 16e3, "limits": {"voltage": 350.0}}
    designed = design(FILM, (times, forces), **options)
    grid, phase = designed.times, np.sin(2 * np.pi * 1000 * designed.times)
    ends = np.linspace(0, 3e-3, 7)

    def loss(knots):
        volts = np.clip(np.interp(grid, ends, knots * 350), 0, 350) * phase
        drive = {"model": "Sampled", "time_samples": grid, "voltage_samples": volts}
        trace = ev.simulate(FILM.replace({"drive": drive}), time=(np.arange(384) + 0.5) / 384 * 3e-3)
        return misfit(trace.electrostatic_force.values.reshape(3, -1).mean(axis=1), designed.wanted)

    gain = carrier_gain(FILM, [1e3]).force[0]
    starts = np.minimum(np.sqrt(np.interp(ends, times, forces) / gain) / 350, 1), np.full(7, 340 / 350)
    options = {"method": "SLSQP", "bounds": [(0, 1)] * 7, "options": {"maxiter": 40}}
    assert designed.binding == ("voltage",)
    assert designed.misfit <= 1.01 * min(minimize(loss, each, **options).fun for each in starts)
    assert designed.predicted == pytest.approx(simulated_means(designed), rel=1e-4)


def test_dc_holds_a_constant_force_by_a_ramp():
    """With the leak of the skin the force of V0 is held by v = V0 (1 + t/tau): 3.3 uN for 1 s inside 1 kV."""
    designed = design(FILM, "constant 3 uN for 1 s", "dc")
    start, end = designed.edges[[0, -1]]
    inside = (designed.times >= start) & (designed.times <= end)
    volts, since = designed.values[inside], designed.times[inside] - start
    skin, film = FILM.stack.stratum_corneum, FILM.stack.insulator
    series = skin.material.permittivity + film.material.permittivity * skin.thickness / film.thickness
    tau = 8.8541878128e-12 * series / skin.material.conductivity
    level = 1000 * math.sqrt(3e-6 / 56.55e-3)
    assert volts == pytest.approx(volts[0] + level * since / tau, rel=1e-3)
    assert level < volts[0] < 1.5 * level  # a part has leaked during the ramp from 0 V
    assert designed.is_achieved
    assert 3e-6 * designed.scale == pytest.approx(56.55e-3 * (1000 / (1 + 1 / tau) / 1000) ** 2, rel=0.02)
    assert misfit(simulated_means(designed), np.full(len(designed.wanted), 3e-6)) < 1e-3
    assert designed.values[[0, -1]] == pytest.approx([0, 0])


def test_dc_without_a_leak_is_the_square_root_and_behind_a_lag_does_not_oscillate():
    """Behind 20 Mohm, whose lag of 0.7 ms is several samples, the inverse stays smooth: one rise and one fall."""
    target = "sine 20 Hz 10 mN to 30 mN"
    designed = design(FILM.replace({"force": {"model": "EffectiveMedium"}}), target, "dc")
    volts = np.interp(designed.edges, designed.times, designed.values)
    wanted = read_target(target).force(designed.edges - designed.edges[0])
    assert volts == pytest.approx(1000 * np.sqrt(wanted / 56.55e-3), rel=1e-3)
    assert designed.is_achieved
    scenario = ev.load(GAP, changes={"circuit.source_resistance": "20 Mohm"})
    designed = design(scenario, "constant 1 mN for 20 ms", "dc")
    assert designed.misfit < 1e-3
    assert np.sum(np.abs(np.diff(designed.values))) < 2.5 * np.max(designed.values)
    assert designed.edges[0] > 3 * 20e6 * 33e-12


@pytest.mark.slow
@pytest.mark.parametrize(
    ("forces", "limits"),
    [
        ([5e-3, 5e-3, 5e-3, 5e-3, 5e-3, 5e-3], {"voltage": 500.0}),
        ([1e-3, 8e-3, 2e-3, 9e-3, 9e-3, 1e-3], {"voltage": 600.0, "current": 1.1e-6}),
        ([1e-3, 6e-3, 1e-3, 7e-3, 1e-3, 8e-3, 1e-3, 8.5e-3], {"voltage": 500.0}),
        ([4e-3, 9e-3, 1e-3, 1e-3, 9e-3, 5e-3], {"voltage": 500.0, "current": 0.8e-6}),
        ([1e-3, 8e-3, 8e-3, 0, 0, 0, 0, 9e-3, 9e-3, 0, 6e-3, 6e-3], {"voltage": 400.0}),
    ],
)
def test_limits_of_dc_are_traded_as_by_brute_force(forces, limits):
    """6 to 12 voltages under the limits of voltage and current, against SLSQP from many starts with an own model."""
    count = len(forces)
    designed = design(FILM, (np.arange(count) * 4e-3, np.array(forces)), "dc", rate=250.0, limits=limits)
    lead, grid = round(designed.edges[0] * 250), designed.times
    ramp = np.arange(lead) / lead

    def response(inside, name, at):
        volts = np.concatenate([inside[0] * ramp, inside, inside[-1] * ramp[::-1]])
        drive = {"model": "Sampled", "time_samples": grid, "voltage_samples": volts}
        return ev.simulate(FILM.replace({"drive": drive}), time=at)[name].values

    looks = np.unique(np.concatenate([designed.edges, (designed.edges[1:] + designed.edges[:-1]) / 2]))
    beside = np.sort(np.concatenate([grid[1:] - 1e-6, grid[:-1] + 1e-6]))
    fields = np.array([response(row, "effective_voltage", looks) for row in np.eye(count)]).T
    currents = np.array([response(row, "current", beside) for row in np.eye(count)]).T
    per_square = response(np.eye(count)[0], "electrostatic_force", looks)[0] / fields[0, 0] ** 2

    def loss(scaled):
        force = per_square * (fields @ scaled * 1e3) ** 2
        return misfit((force[:-1:2] + 4 * force[1::2] + force[2::2]) / 6, designed.wanted)

    rows = np.concatenate([currents, -currents]) * 1e3 / limits.get("current", 1.0)
    held = [{"type": "ineq", "fun": lambda x: 1 - rows @ x}, {"type": "ineq", "fun": lambda x: fields @ x}]
    random, most, best = np.random.default_rng(1), limits["voltage"] / 1e3, math.inf
    for _ in range(25):
        options = {"method": "SLSQP", "bounds": [(0, most)] * count, "constraints": held}
        found = minimize(loss, random.uniform(0, most, count), **options)
        best = min(best, found.fun) if found.success else best
    assert len(grid) == count + 2 * lead
    assert designed.binding
    assert designed.misfit <= 1.01 * best
    assert 1 <= designed.agreeing <= designed.searches == 14
    agreeing = f"{designed.agreeing} of 14 searches from different starts end within 1 %"
    assert designed.document.text.split("\n")[-1].startswith(agreeing)


@pytest.mark.slow
def test_searches_over_many_samples_take_over_what_those_over_few_values_find():
    """Forces at random, of which the voltage serves some: the first three starts alone end at 79.32 %."""
    random = np.random.default_rng(2)
    count = int(random.integers(6, 12))
    peaks = random.uniform(0, 9, count) * (random.uniform(size=count) < 0.7)
    peaks[-1] += 1
    times = np.arange(33) / 32 * 4e-3 * (count - 1)
    target = times, np.interp(times, np.arange(count) * 4e-3, peaks * 1e-3)
    designed = ev.drive_for_force(
        FIG6, target=target, method="dc", rate=32 / times[-1], limits={"voltage": 350.0}
    )
    assert designed.misfit < 0.787
    assert designed.agreeing < designed.searches == 14
    assert designed.to_dict()["searches"] == {"made": 14, "agreeing": designed.agreeing}


def test_the_best_of_several_searches_is_that_of_a_grid_and_the_same_at_each_call():
    wanted, bounded = np.array([1.0, 0.5]), np.array([[1.0, 1.0, 1.0]])
    trade = Trade(knots=np.eye(3), middles=np.zeros((2, 3)), wanted=wanted, bounded=bounded)
    found, again = best_factor(trade, 1 / 9), best_factor(trade, 1 / 9)
    assert found.searches == 14
    assert trade.scale(found.factor) >= 1 - 1e-12
    every = np.stack(np.meshgrid(*[np.linspace(0, 1, 41)] * 3), axis=-1).reshape(-1, 3)
    brute = min(trade.misfit(each) for each in every[every.sum(axis=1) <= 1 + 1e-9])
    assert trade.misfit(found.factor) <= brute + 1e-12
    np.testing.assert_array_equal(found.factor, again.factor)
    assert found.agreeing == again.agreeing == 5


@pytest.mark.parametrize(("level", "held"), [(1.0, 2), (0.5, 4), (3.0, 0)])
def test_a_search_begins_at_a_level_that_is_held_as_long_as_the_limits_allow(level, held):
    """The sum of all factors may be 2.5."""
    limited = np.ones((1, 4)) / 2.5
    trade = Trade(knots=np.eye(4), middles=np.zeros((3, 4)), wanted=np.ones(3), bounded=limited)
    assert list(held_start(trade, level)) == [level] * held + [0.0] * (4 - held)


SLOW = {"method": "dc", "rate": 1e4}
FAST = {"carrier": "3 kHz", "rate": 48e3}


@pytest.mark.parametrize(
    ("limits", "options"),
    [
        ({"charge": 3e-9}, FAST),
        ({"stored_energy": 1e-7}, FAST),
        ({"rms_voltage": 60.0}, FAST),
        ({"charge": 2e-9}, SLOW),
        ({"stored_energy": 1e-7}, SLOW),
        ({"rms_voltage": 30.0}, SLOW),
        ({"slew_rate": 5e5}, FAST),
        ({"slew_rate": 3e4}, SLOW),
    ],
)
def test_other_declared_limits_are_held(limits, options):
    designed = design(BEHIND_GAP, "constant 20 mN for 3 ms", limits=limits, **options)
    ((name, limit),) = limits.items()
    assert name in designed.binding
    value = designed.check.value(name.replace("_", " "))
    assert value == pytest.approx(limit, rel=1e-3)
    assert value <= limit


def test_an_amplifier_behind_its_bandwidth_is_not_saturated_and_its_limits_count_as_declared():
    """Its output of 95 V at 3 kHz follows from an input that would aim at 300 V."""
    amplifier = {"gain": 100.0, "saturation": "300 V", "bandwidth": "1 kHz"}
    scenario = ev.load(GAP, changes={"circuit.amplifier": amplifier})
    designed = design(scenario, "constant 20 mN for 5 ms", carrier="3 kHz", limits=None)
    assert np.max(np.abs(designed.values)) == pytest.approx(3.0, rel=1e-3)
    assert designed.binding == ("voltage",)
    assert chosen_carrier(scenario, designed.target, Bounds.of(scenario, None)) == 1000
    amplifier = {"gain": 100.0, "source_current": "100 uA", "saturation": "800 V"}
    amplifier["stray_capacitance"] = "50 pF"
    scenario = ev.load(GAP, changes={"circuit.amplifier": amplifier})
    designed = design(scenario, "constant 20 mN for 10 ms", carrier="2 kHz", limits=None)
    assert designed.binding == ("current",)
    assert designed.check.value("peak current") == pytest.approx(100e-6, rel=1e-3)
    unlimited = carrier_gain(scenario, [2e3]).peaks["current"][0] * np.max(np.abs(designed.values))
    assert unlimited == pytest.approx(100e-6, rel=0.01)  # the amplifier itself limits nothing
    assert misfit(simulated_means(designed), designed.predicted) < 2e-3


def test_a_current_drive_gives_the_force_too():
    designed = design(BEHIND_GAP, "sine 100 Hz 20 mN for 30 ms", "current", carrier="2 kHz")
    assert designed.quantity == designed.scenario.drive.quantity == "current"
    charge = np.append(0.0, np.cumsum((designed.values[1:] + designed.values[:-1]) / 2)) / designed.rate
    assert np.max(np.abs(charge[::64])) < 1e-3 * np.max(np.abs(charge)), "it returns to 0 in each period"
    assert misfit(simulated_means(designed), designed.wanted) < 1e-3


@pytest.mark.parametrize("method", ["dc", "carrier"])
def test_no_force_needs_no_voltage(method):
    designed = design(BEHIND_GAP, "constant 0 mN for 2 ms", method)
    assert np.all(designed.values == 0)
    assert designed.is_achieved
    assert (designed.misfit, designed.scale) == (0, math.inf)
    assert designed.document.text.split("\n")[-1] == "no limit binds"
    found = designed.to_dict()
    assert (found["form"], found["is_achieved"], found["scale"]) == ("drive", True, None)
    assert found["text"] == str(designed).split("\n")


def test_chosen_carrier_allows_the_largest_force():
    """On fig6 the current binds above 1.2 kHz: of equal carriers the lowest, at least ten times the target's frequency."""
    bounds = Bounds.of(FILM, LIMITS)
    found = chosen_carrier(FILM, read_target("constant 5 mN"), bounds)
    assert found == 1000
    largest = carrier_gain(FILM, [found]).largest_amplitude(bounds)[0]
    assert largest == pytest.approx(1000, rel=0.05)
    slower = Bounds.of(BEHIND_GAP, LIMITS | {"current": "1 mA"})
    assert chosen_carrier(BEHIND_GAP, read_target("constant 5 mN"), slower) == 1000
    assert chosen_carrier(FILM, read_target("sine 300 Hz 1 mN"), bounds) == pytest.approx(3000)


def test_targets_are_read_from_text_file_and_arrays(tmp_path):
    sine = read_target("Sine 50 Hz 10 mN to 30 mN for 0.1 s")
    assert (sine.low, sine.high, sine.frequency, sine.duration) == (10e-3, 30e-3, 50, 0.1)
    assert sine.force(np.array([0.0, 0.01])) == pytest.approx([10e-3, 30e-3])
    assert sine.means(np.array([0.0, 0.02])) == pytest.approx([20e-3])
    path = tmp_path / "force.csv"
    path.write_text("time [ms],force [mN]\n0,1\n10,3\n20,1\n")
    ramp = read_target(path)
    assert ramp.means(np.array([0.0, 0.01, 0.02])) == pytest.approx([2e-3, 2e-3])
    assert ramp.highest_frequency == pytest.approx(250)  # its fifth harmonic
    held = read_target("constant 5 mN")
    assert (held.duration, held.highest_frequency) == (1.0, 0.0)
    assert held.means(np.array([0.0, 0.9, 1.2])) == pytest.approx([5e-3, 5e-3])
    smooth, times = read_target("sine 50 Hz 30 mN"), np.linspace(0, 0.1, 37)
    assert smooth.root(times) ** 2 == pytest.approx(smooth.force(times), abs=1e-15)


@pytest.mark.parametrize(
    ("target", "words"),
    [
        ("sine 50 Hz", "expected 'sine 50 Hz 30 mN'"),
        ("sine 50 Hz 30 mN to 10 mN", "the lower one first"),
        ("sine 0 Hz 30 mN", "a frequency above 0 Hz"),
        ("sine 50 V 30 mN", "expected a frequency"),
        ("constant -5 mN", "0 N or more"),
        ("constant 5 mN for 0 s", "a duration above 0 s"),
        (([0, 1], [1e-3, -1e-3]), "is never negative"),
        (([0, 0], [1e-3, 1e-3]), "times have to increase"),
        (([0, 1], [1e-3]), "same length"),
        (3.0, "expected 'sine 50 Hz 30 mN'"),
    ],
)
def test_mistakes_in_a_target_are_named(target, words):
    with pytest.raises(InputError, match=words):
        read_target(target)


REFUSED = {
    "method": (FILM, "carier", {}, "carrier"),
    "carrier of none": (FILM, "dc", {"carrier": "1 kHz"}, "has no carrier"),
    "carrier in volts": (FILM, "carrier", {"carrier": "1 V"}, "expected a frequency"),
    "rate": (FILM, "carrier", {"carrier": 1e3, "rate": "10.5 kHz"}, "whole multiple"),
    "samples": (FILM, "carrier", {"carrier": 1e8}, "are more than"),
    "values": (FILM, "dc", {"rate": 1e6}, "2 to 4000 are allowed"),
    "not causal": (ev.load(FIG7), "carrier", {"carrier": 1e3}, "not causal"),
    "leak": (ev.load("kaczmarek_2006/gap_positive"), "dc", {}, "not ohmic"),
    "charge": (ev.load("nakamura_2017/charged"), "dc", {}, r"initial_charge: has to be 0"),
    "law": (FILM.replace({"force": {"model": "MaxwellStressInInsulator"}}), "dc", {}, "2 amplitudes"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_cannot_be_designed_is_refused(case):
    scenario, method, arguments, words = REFUSED[case]
    with pytest.raises(NotCausalError if case == "not causal" else InputError, match=words):
        design(scenario, "sine 20 Hz 1 mN", method, **arguments)


def test_the_command_writes_a_drive_that_check_passes(tmp_path):
    """The file states target, misfit and limits; without declared limits nothing is written."""
    limits, out, numbers = tmp_path / "limits.toml", tmp_path / "drive.csv", tmp_path / "all.json"
    limits.write_text('limits = { voltage = "1 kV", current = "250 uA" }\n')
    words = ["drive-for-force", GAP, "--target", "sine 100 Hz 30 mN for 20 ms"]
    words += ["--method", "carrier", "--carrier", "2 kHz"]
    written = ["--limits", str(limits), "--edge", "line", "-o", str(out)]
    assert CliRunner().invoke(app, [*words, *written]).exit_code == 0
    head = "".join(line for line in out.read_text().splitlines() if line.startswith("#"))
    assert "departs from the target by" in head
    assert "target: a force between 0 N and 30 mN at 100 Hz" in head
    assert CliRunner().invoke(app, ["check", str(out), GAP, "--limits", str(limits)]).exit_code == 0
    checked = ev.check(str(out), GAP, limits=str(limits))
    assert checked.value("peak voltage") == pytest.approx(325, rel=0.01)
    assert CliRunner().invoke(app, [*words, "--rate", "32 kHz", "-o", str(numbers)]).exit_code == 0
    found = json.loads(numbers.read_text())
    assert (found["rate"], found["misfit"] < 1e-4) == (32e3, True)
    assert len(found["samples"]["voltage"]) == 32 * 20 + 1
    refused = CliRunner().invoke(app, [*words, "-o", str(tmp_path / "other.csv")])
    assert isinstance(refused.exception, InputError)
    assert not (tmp_path / "other.csv").exists()


# the gain of a carrier, compared with the simulated force, currents and voltages of a sine

SINE = {"model": "Sine", "amplitude": 7.0, "frequency": 3000.0}
CURRENT = {"model": "CurrentSine", "amplitude": 1e-5, "frequency": 3000.0}
AMPLIFIER = {"stray_capacitance": "200 pF", "bandwidth": "5 kHz", "gain": 100.0}
MEAN = "mean electrostatic_force"


@pytest.mark.parametrize(
    ("name", "drive", "changes"),
    [
        (FIG6, SINE, {}),
        ("vezzoli_2014/fig7", SINE, {"force": {"model": "MaxwellStressInInsulator"}}),
        (GAP, SINE, {"circuit.amplifier": AMPLIFIER}),
        (GAP, SINE, {"circuit.source_resistance": "20 Mohm"}),
        (GAP, CURRENT, {}),
    ],
)
def test_gain_is_that_of_the_simulated_sine_in_its_steady_state(name, drive, changes):
    settled = {"drive": drive, "time": {"initial_state": {"model": "PeriodicState"}}}
    scenario = ev.load(name, changes=settled | changes)
    amplified = "circuit.amplifier" in changes
    voltage = "peak plate_voltage" if amplified else "peak stack_voltage"
    current = "peak amplifier_current" if amplified else "peak current"
    names = list({MEAN: 0, voltage: 0, current: 0, "peak current": 0})
    found = ev.prepare(scenario, free=["load.normal_force"], quantity=names)([scenario.load.normal_force])
    gain, peak = carrier_gain(scenario, [3000.0]), drive["amplitude"]
    exact = 1e-3 if name.endswith("fig7") else 1e-9
    assert gain.force[0] * peak**2 == pytest.approx(found[MEAN], rel=exact)
    assert gain.peaks["current"][0] * peak == pytest.approx(found[current], rel=1e-3)
    assert gain.peaks["body_current"][0] * peak == pytest.approx(found["peak current"], rel=1e-3)
    if amplified or drive is CURRENT:
        assert gain.peaks["voltage"][0] * peak == pytest.approx(found[voltage], rel=1e-3)


def test_largest_amplitude_is_that_of_the_limit_that_binds():
    """Equation (1) of Vezzoli et al. 2014 on the finger alone: 250 uA at 3 kHz is 404 V and 4.6 mN."""
    gain = carrier_gain(ev.load("vezzoli_2014/fig6_static"), [30.0, 3000.0])

    def allowed(**limits):
        return gain.largest_amplitude(SimpleNamespace(value=limits.get))

    volts = allowed(voltage=1000.0, current=250e-6)
    assert volts[0] == 1000.0
    assert volts[1] == pytest.approx(404, rel=2e-3)
    assert (gain.force * volts**2)[1] == pytest.approx(4.623e-3, rel=1e-3)
    assert allowed(voltage=1000.0, slew_rate=1e6)[1] == pytest.approx(1e6 / (2 * np.pi * 3000))
    assert allowed(body_current=1e-6)[1] == pytest.approx(volts[1] / 250)
    assert allowed()[0] == np.inf


def test_gain_falls_below_the_leak_of_the_skin():
    """The force of the law of Vezzoli et al. 2014 is filtered by tau s/(1 + tau s): a half at 1/(2 pi tau)."""
    gains = carrier_gain(ev.load(FIG6), [20.67, 1e5]).force
    assert gains[0] / gains[1] == pytest.approx(0.5, rel=0.01)


GROWING = {"model": "GrowingArea", "area": 1e-4, "at_force": 0.5, "exponent": 2 / 3}
ROUGH = {"model": "PerssonSurface", "modulus": 2e7, "rms_slope": 1.0, "rms_gap": 2e-5}
ROUGH |= {"pressure_factor": 0.5, "decay_factor": 0.5}
CLOSING = {"model": "FixedArea", "area": 1e-4, "surface": ROUGH, "closing": {"damping": 1e6}}
SLIDING = {"speed": 0.03, "renews_film": True}
WITHOUT_GAIN = {
    "leak": ("kaczmarek_2006/gap_positive", {}, r"stack\.\w+\.leak: the conduction is not ohmic"),
    "tremor": ("vezzoli_2014/fig2_tremor", {}, r"motion\.distance: the gap changes"),
    "area": (
        GAP,
        {"contact": GROWING},
        "MaxwellStressInGap on GrowingArea is not proportional to the square",
    ),
    "surface": (GAP, {"contact": CLOSING}, "the gap follows load and attraction"),
    "film": (FIG6, {"motion": SLIDING}, "the sliding film leaves the contact with its charge"),
}


@pytest.mark.parametrize("case", WITHOUT_GAIN)
def test_scenarios_without_a_gain_are_refused(case):
    name, changes, words = WITHOUT_GAIN[case]
    with pytest.raises(InputError, match=words):
        carrier_gain(ev.load(name, changes=changes), [1e3])


@pytest.mark.parametrize("wrong", [0.0, -1.0, np.nan, [[1.0]]])
def test_frequencies_are_above_0(wrong):
    with pytest.raises(InputError, match="above 0 Hz"):
        carrier_gain(ev.load(FIG6), wrong)
