"""Linear layers behind an amplifier: closed forms of slewing, the exact path without limits, the reference."""

from dataclasses import replace
from itertools import pairwise, product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import electrovib as ev
from electrovib.core.errors import ElectrovibError, InputError
from electrovib.physics.amplifier import Amplifier
from electrovib.physics.circuit import SeriesElement
from electrovib.solve.electrics import amplifier as amplifier_module
from electrovib.solve.electrics.amplifier import CheckTimes, LimitedMarch, LimitedPlate
from electrovib.solve.electrics.amplifier import amplified_response as behind_limits
from electrovib.solve.electrics.slewing import Network, overlap
from electrovib.solve.electrics.transient import linear_response, transient
from electrovib.solve.nonlinear.finger import follow_finger
from electrovib.solve.stack.keys import FieldOf

EPS0 = 8.8541878128e-12
FILM = EPS0 * 3.35 / 90e-6 * 1e-4
END = 30e-3
EQUAL = 1e-7
"""Of the largest value of each signal, against the general reference; measured 1.7e-8 here, 7e-8 over random ones."""
CURRENT = {"gain": 3.0, "source_current": 1e-6, "sink_current": 0.4e-6}
STRAY = {"stray_capacitance": 5e-11}
LIMITED = {
    "current": CURRENT,
    "current and stray": CURRENT | STRAY,
    "current and pole": {"gain": 3.0, "bandwidth": 1e3, "source_current": 1e-6},
    "saturation": {"gain": -3.0, "saturation": 100.0},
    "everything": {"gain": 3.0, "bandwidth": 1e3, "saturation": 150.0, "source_current": 1e-6} | STRAY,
    "pole alone": {"gain": 2.0, "bandwidth": 500.0, "stray_capacitance": 1e-11},
}
ELEMENTS = ("bare", "body", "floating")
STRAIGHT = ("trapezium", "square")
FAST = [("sine", "current and pole", "body"), ("sine", "everything", "body")]
OSCILLATING = ("sine", "burst", "chirp", "both")
SLOW = [case for case in product(STRAIGHT + OSCILLATING, LIMITED, ELEMENTS) if case not in FAST]


GAP = ev.load("vezzoli_2014/fig6_gap")


def amplified_response(wanted, drive, time, *, amplifier, **settled):
    """Response behind an amplifier with or without limits."""
    solver = behind_limits if amplifier.is_limited else linear_response
    return solver(wanted, drive, time, amplifier=amplifier, **settled)


@pytest.fixture
def film_alone(finger):
    return lambda element="bare": finger(element, names=["insulator"]).wanted


@pytest.mark.parametrize(
    ("name", "limits", "element"), [*FAST, *(pytest.param(*case, marks=pytest.mark.slow) for case in SLOW)]
)
def test_general_reference(name, limits, element, finger, drive, worst):
    """A drive that oscillates counts as it is, not as straight pieces."""
    given, one, times = LIMITED[limits], drive(name), np.linspace(0, END, 61)
    amplifier, held = Amplifier(**given), finger(element, charge=1e-5)
    answer = amplified_response(held.wanted, one, times, amplifier=amplifier)
    reference = follow_finger(held.space, one, times, amplifier=amplifier)
    assert set(reference.found) == set(answer.found)
    assert worst(reference.found, answer.found) < EQUAL
    if limits == "pole alone" or (name, limits) == ("trapezium", "current and pole"):
        return  # no limit is met
    assert answer.events or limits == "saturation"
    if name in STRAIGHT:
        unlimited = Amplifier(gain=amplifier.gain, bandwidth=amplifier.bandwidth)
        free = amplified_response(held.wanted, one, times, amplifier=unlimited)
        assert worst(free.found, answer.found) > 1e4 * EQUAL


def powers(low, high):
    return st.floats(low, high).map(lambda power: 10.0**power)


def amplifier_of(source, sink, **others):
    """A sink limits beside a source only."""
    return Amplifier(source_current=source, sink_current=sink if source else None, **others)


@pytest.mark.slow
@settings(max_examples=12)
@given(
    amplifier=st.builds(
        amplifier_of,
        gain=st.sampled_from([-2.0, 1.0, 3.0]),
        bandwidth=st.none() | powers(1, 5),
        saturation=st.none() | st.floats(20, 200),
        source=st.none() | powers(-8, -4),
        sink=st.none() | powers(-8, -4),
        stray_capacitance=st.just(0.0) | powers(-12, -9),
    ),
    charge=st.sampled_from([0.0, 1e-5, -3e-5]),
    gap=st.sampled_from([0.0, 1e-9, 1e-6]),
    element=st.sampled_from(ELEMENTS),
    name=st.sampled_from(STRAIGHT),
)
def test_any_amplifier(amplifier, charge, gap, element, name, finger, drive, worst):
    """Measured over 160 drawn at random: 7e-8 at most."""
    held, times = finger(element, charge=charge, gap=gap), np.linspace(0, END, 31)
    answer = amplified_response(held.wanted, drive(name), times, amplifier=amplifier)
    reference = follow_finger(held.space, drive(name), times, amplifier=amplifier)
    assert worst(reference.found, answer.found) < EQUAL
    if np.isfinite(amplifier.current_limits[1]):
        lowest, highest = amplifier.current_limits
        current = answer.found["amplifier_current"]
        assert np.all((current <= highest * (1 + 1e-9)) & (current >= lowest * (1 + 1e-9)))


@pytest.mark.parametrize("element", ELEMENTS)
def test_a_gain_alone_is_the_exact_path(element, finger, drive):
    """Scaled drive, and C dv/dt into the stray capacitance."""
    one, times, wanted = drive("trapezium"), np.linspace(0, END, 3001), finger(element).wanted
    answer = amplified_response(wanted, one, times, amplifier=Amplifier(gain=7.0, stray_capacitance=3e-11))
    for name, row in transient(wanted, one, times).items():
        size = np.max(np.abs(row))
        np.testing.assert_allclose(answer.found[name], 7 * row, rtol=1e-12, atol=1e-12 * size)
    stray = 3e-11 * 7 * one.slope(times)
    found = answer.found["amplifier_current"] - answer.found["current"]
    np.testing.assert_allclose(found, stray, atol=1e-14 * np.max(stray))
    np.testing.assert_allclose(answer.found["plate_voltage"], 7 * one.voltage(times))


def test_a_pole_on_a_rate_of_the_stack(finger, drive):
    """Where both coincide the partial fractions would divide by zero."""
    wanted, times, key = finger().wanted, np.linspace(0, END, 61), FieldOf("gap")
    rate = float(wanted[key].rates[0])
    poles = [Amplifier(bandwidth=rate * factor / (2 * np.pi)) for factor in (1.0, 1.0 + 1e-4)]
    found = [
        amplified_response(wanted, drive("trapezium"), times, amplifier=pole).found[key] for pole in poles
    ]
    assert np.max(np.abs(found[0] - found[1])) < 1e-3 * np.max(np.abs(found[1]))
    assert np.all(np.isfinite(found[0]))


def test_a_periodic_state_behind_a_gain_and_a_pole(finger, drive):
    times, sine = np.linspace(0, 20e-3, 41), drive({"model": "Sine", "amplitude": 10, "frequency": 100})
    amplifier, wanted = Amplifier(gain=3.0, bandwidth=100.0), finger("body").wanted
    found = amplified_response(wanted, sine, times, amplifier=amplifier, settled=True).found["plate_voltage"]
    expected = (3 / (1 + 1j) * -10j * np.exp(2j * np.pi * 100 * times)).real
    np.testing.assert_allclose(found, expected, atol=1e-12 * 30)


@pytest.mark.parametrize(("sink", "ratio"), [(None, 1.0), (100e-6, 2.5)])
def test_a_capacitor_is_charged_at_its_current_over_its_capacitance(sink, ratio, film_alone, drive):
    """Slewing at I/(C + stray) to the aim, exactly, and the ends of the ramps at their times."""
    high, current, stray = 1000.0, 250e-6, 50e-12
    slew = current / (FILM + stray)
    square = drive({"model": "Square", "high": high, "low": 0.0, "frequency": 50})
    times = np.linspace(0, END, 3001)
    amplifier = Amplifier(source_current=current, sink_current=sink, stray_capacitance=stray)
    answer = amplified_response(film_alone(), square, times, amplifier=amplifier)
    since = times % 20e-3
    falls = (since >= 10e-3 - 1e-12) & (since < 20e-3 - 1e-12)
    up, down = np.minimum(high, slew * since), np.maximum(0.0, high - slew / ratio * (since - 10e-3))
    expected = np.where(falls, down, np.where(since > 20e-3 - 1e-12, 0.0, up))
    inside = (np.abs(since - 20e-3) > 1e-9) | (times == 0)
    np.testing.assert_allclose(answer.found["plate_voltage"][inside], expected[inside], atol=1e-9 * high)
    reached = high / slew
    ends = [0.0, reached, 10e-3, 10e-3 + ratio * reached, 20e-3, 20e-3 + reached]
    np.testing.assert_allclose(answer.events[:6], ends, rtol=1e-12)
    slewing = (times > 0) & (times < 0.9 * reached)
    np.testing.assert_allclose(answer.found["amplifier_current"][slewing], current, rtol=1e-12)
    share = FILM / (FILM + stray)
    np.testing.assert_allclose(answer.found["current"][slewing], share * current, rtol=1e-9)


def test_behind_a_resistance_the_plate_jumps_as_far_as_the_current_allows(film_alone, drive):
    """v = R I + I t/C at once where no stray capacitance holds it."""
    resistance, current, times = 1e6, 100e-6, np.linspace(0, 1e-4, 11)
    wanted, step = film_alone(SeriesElement(resistance=resistance)), drive({"model": "Step", "level": 1000.0})
    answer = amplified_response(wanted, step, times, amplifier=Amplifier(source_current=current))
    expected = current * (resistance + times / FILM)
    np.testing.assert_allclose(answer.found["plate_voltage"], expected, rtol=1e-12)


def test_overlap_where_rates_meet():
    """The integral of a product of two exponentials, also where they are the same."""
    time = np.array([0.0, 1e-3, 1.0, 30.0])
    found = overlap(np.array([0.0, 2.0]), np.array([0.0, 2.0, 2.0 + 1e-12, 5.0]), time)
    np.testing.assert_allclose(found[0, 0], time)
    np.testing.assert_allclose(found[0, 1], -np.expm1(-2 * time) / 2, rtol=1e-14)
    np.testing.assert_allclose(found[1, 1], time * np.exp(-2 * time), rtol=1e-14)
    np.testing.assert_allclose(found[1, 2], time * np.exp(-2 * time), rtol=1e-10)
    expected = (np.exp(-2 * time) - np.exp(-5 * time)) / 3
    np.testing.assert_allclose(found[1, 3], expected, rtol=1e-12, atol=1e-30)


def test_refusals():
    square = {"model": "Square", "high": 10.0, "frequency": 100.0}
    limited = {"drive": square, "circuit.amplifier": {"source_current": 1e-6}}
    with pytest.raises(InputError, match="PeriodicState: behind an amplifier with limits"):
        ev.simulate(GAP.replace(limited | {"time.initial_state": {"model": "PeriodicState"}}))
    current = {"model": "CurrentSine", "amplitude": 1e-6, "frequency": 100.0}
    with pytest.raises(InputError, match="prescribes the current"):
        ev.simulate(GAP.replace({"drive": current, "circuit.amplifier": {"gain": 2.0}}))


def test_a_limit_that_is_never_met_changes_nothing_and_costs_nothing(monkeypatch):
    """Ten thousand periods: the answer without limits to rounding, and no march from period to period."""
    windows, watched = [], LimitedMarch._watched

    def counted(self, span, checked):
        windows.append(len(checked))
        return watched(self, span, checked)

    monkeypatch.setattr(LimitedMarch, "_watched", counted)
    slow = {"model": "Sine", "amplitude": 100.0, "frequency": 500.0}
    scenario = GAP.replace({"drive": slow, "time.duration": 20.0})
    free, limited = (
        ev.simulate(scenario.replace({"circuit.amplifier": {"gain": 2.0, "bandwidth": 1e4} | limits}))
        for limits in ({}, {"source_current": 1e-3, "saturation": 1e3})
    )
    for name in ("electrostatic_force", "field", "amplifier_current", "plate_voltage"):
        size = float(np.max(np.abs(free[name])))  # the same sums, taken at other times beside them
        np.testing.assert_allclose(limited[name], free[name], rtol=0, atol=1e-14 * size)
    assert len(windows) < 30
    assert "0 changes" in limited.attrs["solver_reason"]
    assert "step_error" not in limited.attrs


@pytest.mark.parametrize(("share", "changes"), [(1 - 2e-5, 2), (1 + 2e-5, 0)])
def test_a_limit_met_between_two_looks_is_seen(share, changes, finger, drive):
    """Two hundredths of a per mille above the largest current of a whole cycle, and below it."""
    wanted, sine, fine = finger("body").wanted, drive("sine"), np.linspace(0.006, 0.012, 200_001)
    free = amplified_response(wanted, sine, fine, amplifier=Amplifier(gain=1.0))
    lowest = np.min(free.found["amplifier_current"])  # once before 12 ms: there the current is negative
    amplifier = Amplifier(gain=1.0, source_current=1.0, sink_current=-lowest * share)
    answer = amplified_response(wanted, sine, np.linspace(0, 0.012, 11), amplifier=amplifier)
    assert len(answer.events) == changes


def test_every_crest_is_seen(monkeypatch, film_alone, drive):
    """Fifty of them, a tenth of a per mille above the limit; windows of looks overlap, so that none lies between two."""
    watched, seen = LimitedMarch._watched, []

    def kept(self, *given):
        seen.append(watched(self, *given)[0])
        return watched(self, *given)

    peak = 2 * np.pi * 60 * 100 * FILM
    limits = Amplifier(source_current=1.0, sink_current=peak * (1 - 1e-4))
    times = np.linspace(0, 50 / 60, 11)
    assert len(amplified_response(film_alone("body"), drive("sine"), times, amplifier=limits).events) == 100
    monkeypatch.setattr(LimitedMarch, "_watched", kept)
    free = Amplifier(source_current=1.0)
    amplified_response(film_alone("body"), drive("sine"), np.linspace(0, 1, 3), amplifier=free)
    assert len(seen) > 3
    for checked, following in pairwise(seen):
        np.testing.assert_array_equal(checked[-2:], following[:2])
    # a change may follow another within a small share of the time to the next corner
    first = next(CheckTimes(drive("sine"), 1.0).after(0.31))
    assert 0 < first[0] - 0.31 < 1e-8
    assert np.all(np.diff(first) > 0)


def test_a_current_that_stays_near_the_limit_it_has_left_does_not_chatter(monkeypatch):
    """Behind a pole it passes from one limit to the other in 40 ns, of 150 V: rounding took it back without end."""
    monkeypatch.setattr("electrovib.solve.electrics.amplifier.MOST_CHANGES", 1000)
    sine = {"model": "Sine", "amplitude": 300.0, "frequency": 777.0}
    amplifier = {"gain": 1.0, "source_current": 1e-8, "bandwidth": 1e4}
    changes = {"drive": sine, "time.duration": 4e-3, "circuit.amplifier": amplifier}
    trace = ev.simulate(ev.load("vezzoli_2014/fig2", changes=changes))
    assert "13 changes" in trace.attrs["solver_reason"]
    assert float(np.abs(trace.amplifier_current).max()) <= 1e-8 * (1 + 1e-8)


def test_a_sine_behind_a_limit_needs_as_many_steps_as_it_has_changes(monkeypatch):
    """It was cut into a thousand pieces a period."""
    calls, begun = [], LimitedPlate.span
    monkeypatch.setattr(
        LimitedPlate, "span", lambda self, **given: calls.append(given) or begun(self, **given)
    )
    drive = {"drive": {"model": "Sine", "amplitude": 100.0, "frequency": 777.0}, "time.duration": 4e-3}
    trace = ev.simulate(GAP.replace(drive | {"circuit.amplifier": {"gain": 1.0, "source_current": 2e-6}}))
    assert 20 < len(calls) < 40  # of two runs: the second one is for the values around the changes
    slope = np.gradient(trace.plate_voltage.values, trace.time.values)
    assert np.max(np.abs(slope)) < 2 * np.pi * 777 * 100  # slower than the drive


@pytest.mark.parametrize("bandwidth", [None, 2e3])
def test_a_long_wait_before_a_burst_and_its_return(bandwidth, finger, drive, worst):
    """What is looked at in growing windows: a burst late in a long time is met, and left, when it is there."""
    burst = drive({"model": "Burst", "amplitude": 80, "frequency": 2e3, "cycles": 2, "delay": 0.9})
    held, times = finger("body"), np.append(0.0, 0.9 + np.linspace(0, 3.1e-3, 31))
    amplifier = Amplifier(gain=1.0, bandwidth=bandwidth, source_current=5e-7, stray_capacitance=5e-11)
    answer = amplified_response(held.wanted, burst, times, amplifier=amplifier)
    reference = follow_finger(held.space, burst, times, amplifier=amplifier)
    assert worst(reference.found, answer.found) < EQUAL
    assert answer.events[0] == pytest.approx(0.9, abs=2e-5)


def test_a_charge_that_fades_as_fast_as_a_mode_is_the_limit_of_one_that_nearly_does():
    """Equal rates are moved apart by 1e-8; the course differs by as much as the rates do."""

    def network(*free_rates):
        rates, conductances = np.array([10.0, 300.0]), np.array([1e-6, 2e-6])
        free = {"free_rates": np.array(free_rates), "free": np.full(len(free_rates), 1e-3)}
        loads = {"static": 1e-7, "capacitance": 1e-9, "stray": 1e-9}
        return Network(rates=rates, conductances=conductances, **loads, **free)

    def course(rate):
        slewed = network(rate).slewed(current=1e-5, voltage=2.0, states=np.array([1.0, 0.5]), time=0.01)
        return slewed.voltage(np.linspace(0, 0.1, 50))

    for mode in network().modes.rates:
        found = course(mode)
        for share in (1 + 1e-5, 1 - 1e-5):
            assert found == pytest.approx(course(mode * share), abs=2e-5 * np.max(np.abs(found)))


@pytest.mark.parametrize("gain", [2.0, -2.0])
def test_a_corner_exactly_at_the_saturation(gain, film_alone, drive):
    """A capacitor: its voltage is cut off, on the way up, down and at a turn; its current is C times the slope."""
    stamps, volts = [0, 5e-3, 10e-3, 12e-3, 20e-3, 30e-3], [0, 50, 100, 50, -50, 0]
    record = drive({"model": "Sampled", "time_samples": stamps, "voltage_samples": volts})
    times, amplifier = np.linspace(0, END, 301), Amplifier(gain=gain, saturation=100.0)
    found = amplified_response(film_alone(), record, times, amplifier=amplifier).found
    expected = np.clip(gain * record.voltage(times), -100, 100)
    np.testing.assert_allclose(found["plate_voltage"], expected, rtol=0, atol=1e-9)
    between = times + 1e-9
    slope = np.where(np.abs(gain * record.voltage(between)) < 100, gain * record.slope(between), 0.0)
    inside = np.abs(times[:, None] - np.array(stamps)).min(axis=1) > 1e-6
    charging = FILM * slope[inside]
    np.testing.assert_allclose(found["current"][inside], charging, rtol=1e-9, atol=1e-9 * FILM * 1e4)


@pytest.mark.parametrize("gain", [2.0, -2.0])
def test_rounding_at_the_largest_voltage_is_no_change_of_the_regime(gain, film_alone, drive):
    """A target within 1e-12 of the saturation neither holds the plate there nor releases it; one beyond does."""
    for beyond, released, changes in (
        (-0.9e-12, 0.9e-12, 0), (0.9e-12, 1.3e-12, 0), (1.3e-12, 0.9e-12, 2), (1.3e-12, 1.3e-12, 4),
    ):  # fmt: skip
        levels = [0, 50 * (1 + beyond), 50 * (1 - released), 50 * (1 + beyond), 0]
        record = drive({"model": "Sampled", "time_samples": [0, 1, 2, 3, 4], "voltage_samples": levels})
        march = LimitedMarch(film_alone(), Amplifier(gain=gain, saturation=100.0), record, 4.0)
        march.run(np.linspace(0, 4, 9))
        assert len(march.kinks) == changes


@pytest.mark.parametrize("limits", ["saturation", "everything"])
def test_regimes_that_contradict_each_other_end_with_an_error(monkeypatch, limits, finger, drive):
    """A fault: the target is taken to be held at the largest voltage of the wrong sign, which no regime outlasts."""
    held, changed, calls = LimitedPlate.held, LimitedMarch._changed, []

    def turned(self, span, when, kind):
        calls.append(when)
        following = changed(self, span, when, kind)
        return replace(following, held=-following.held)

    monkeypatch.setattr(LimitedPlate, "held", lambda self, when: -held(self, when))
    monkeypatch.setattr(LimitedMarch, "_changed", turned)
    times, amplifier = np.linspace(0, END, 31), Amplifier(**LIMITED[limits])
    with pytest.raises(ElectrovibError, match="the amplifier changed more than 16 times at"):
        amplified_response(finger("body").wanted, drive("trapezium"), times, amplifier=amplifier)
    assert len(calls) < 100


@pytest.mark.parametrize("gain", [3.0, -3.0])
@pytest.mark.parametrize("element", ["bare", "body"])
def test_a_current_within_the_hysteresis_changes_nothing_at_either_limit(
    element, gain, finger, drive, monkeypatch
):
    """Both currents exceed their limits by less than a fifth: at a corner without resistance, between corners with one."""
    monkeypatch.setattr(amplifier_module, "HYSTERESIS", 0.2)
    wanted, one, times = finger(element).wanted, drive("trapezium"), np.linspace(0, END, 601)
    free = linear_response(wanted, one, times, amplifier=Amplifier(gain=gain)).found["amplifier_current"]
    for share in (1.17, 1.3):
        limits = {"source_current": free.max() / share, "sink_current": -free.min() / share}
        found = behind_limits(wanted, one, times, amplifier=Amplifier(gain=gain, **limits))
        seen = found.found["amplifier_current"]
        for limit in (limits["source_current"], -limits["sink_current"]):
            assert (limit in seen) == (share > 1.2)
