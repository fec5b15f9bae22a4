"""Currents and spectra of drives: integrators and repeating drives against closed forms, phasors and the FFT."""

import numpy as np
import pytest
from scipy.special import fresnel

from electrovib.core.errors import InputError
from electrovib.core.model import read_model
from electrovib.physics.circuit import SeriesElement
from electrovib.physics.drive.base import Drive
from electrovib.scenario import load
from electrovib.solve.electrics.transient import drive_voltage, transient
from electrovib.solve.stack.expand import current_section, per_ampere, reduce_material
from electrovib.solve.stack.harmonics import count_harmonics, settled_integral, spectrum
from electrovib.solve.stack.section import phasor_section
from electrovib.solve.stack.transfer import INTEGRATING, Transfer

EPS0 = 8.8541878128e-12
AREA = 1e-4
EXACT = 1e-12
"""Relative to the largest: closed forms and modes differ by the rounding of a dozen operations."""
INTEGRATOR = Transfer(rates=np.array([INTEGRATING]), gains=np.array([1 / INTEGRATING]))
"""1/s: its response is the charge."""


def amplifier(**command):
    return read_model(Drive, {"model": "CurrentAmplifier", "sense_resistance": 1.0, "command": command})


def sine(**given):
    return read_model(Drive, {"model": "CurrentSine"} | given)


SILENT = sine(amplitude=0, frequency=1e3)


def charge(drive, time, *, settled=False):
    return transient({"charge": INTEGRATOR}, drive, time, settled=settled)["charge"]


def close(found, expected, share=EXACT):
    return np.max(np.abs(found - expected)) < share * np.max(np.abs(expected))


@pytest.mark.parametrize("samples", [301, 30_001], ids=["closed form of segments", "block scan"])
def test_a_trapezium_of_current_fills_in_parabolas(samples):
    drive = amplifier(model="Trapezium", high=2.0, rise=1e-3, hold=2e-3, fall=1e-3)
    time = np.linspace(0, 6e-3, samples)
    ramp, held, falling = np.minimum(time, 1e-3), np.clip(time - 1e-3, 0, 2e-3), np.clip(time - 3e-3, 0, 1e-3)
    assert close(charge(drive, time), ramp**2 * 1e3 + 2 * held + 2 * falling - falling**2 * 1e3)


@pytest.mark.parametrize("phase", [0.0, np.pi / 2, 1.0])
def test_a_sine_from_rest_leaves_what_it_began_with(phase):
    drive, time = sine(amplitude=2.0, frequency=50, phase=phase), np.linspace(0, 0.1, 1001)
    angular = 100 * np.pi
    periodic = -2 / angular * np.cos(angular * time + phase)
    assert close(charge(drive, time), 2 / angular * np.cos(phase) + periodic)
    assert close(charge(drive, time, settled=True), periodic)
    assert not close(charge(drive, time), periodic) or phase == np.pi / 2


def test_a_burst_ends_with_no_charge_and_a_chirp_is_integrated_too():
    burst = amplifier(model="Burst", amplitude=3.0, frequency=250, cycles=4, delay=1e-3)
    time, angular = np.linspace(0, 0.04, 4001), 2 * np.pi * 250
    inside = np.clip(time - 1e-3, 0, 4 / 250)
    assert close(charge(burst, time), 3 / angular * (1 - np.cos(angular * inside)))
    chirp = amplifier(model="Chirp", amplitude=1.0, first=0, last=400, length=0.2)
    time, rate = np.linspace(0, 0.2, 801), np.sqrt(2 * 400 / 0.2)  # sin(pi (rate t)^2/2), phase 2 pi 1000 t^2
    assert close(charge(chirp, time), fresnel(rate * time)[0] / rate, 1e-9)  # polynomials of degree 6


@pytest.mark.parametrize(
    "command",
    [
        {"model": "Square", "high": 1, "low": -1, "frequency": 60},
        {"model": "Square", "high": 1, "low": -1, "frequency": 60, "edge": 2e-3},
        {"model": "PulseTrain", "high": 3, "low": -1, "width": 2.5e-3, "frequency": 100},
    ],
    ids=["square", "trapezia", "pulses"],
)
def test_the_settled_integral_is_periodic_without_mean(command):
    drive = amplifier(**command)
    time = np.linspace(0, drive.period, 2001)
    found = settled_integral(drive, time)
    assert np.ptp(found - charge(drive, time)) < EXACT * np.ptp(found)  # apart by a constant only
    inner = (found[1:] + found[:-1]) / 2
    assert abs(np.mean(inner)) < 1e-3 * np.ptp(found)  # of the trapezoidal rule
    assert found[0] == pytest.approx(found[-1], abs=EXACT * np.ptp(found))


def test_settled_straight_pieces_are_the_sum_of_their_harmonics():
    """The series of a square over 1/(j w)^2 falls as 1/n^2, so 4000 terms leave 1e-4 of the triangle."""
    drive = amplifier(model="Square", high=1, low=-1, frequency=60)
    time, order = np.linspace(0, 1 / 60, 101), np.arange(1, 4001, 2)
    angular = 2 * np.pi * 60 * order
    triangle = -np.sum(4 / (np.pi * order * angular) * np.cos(np.outer(time, angular)), axis=1)
    assert close(settled_integral(drive, time), triangle, 2e-4)


@pytest.mark.parametrize(
    "command",
    [
        {"model": "Square", "high": 1, "low": -0.5, "frequency": 60},
        {"model": "Step", "level": 1},
        {"model": "Offset", "level": 1e-6, "drive": {"model": "Sine", "amplitude": 1, "frequency": 60}},
    ],
    ids=["square", "constant", "offset"],
)
def test_a_settled_mean_current_into_a_blocking_layer_is_refused(command):
    drive, time = amplifier(**command), np.linspace(0, 0.1, 11)
    with pytest.raises(InputError, match="mean of"):
        charge(drive, time, settled=True)
    leaky = Transfer(rates=np.array([50.0]), gains=np.array([1.0]))
    found = transient({"field": leaky}, drive, time, settled=True)["field"]
    assert np.all(np.isfinite(found))  # what conducts has a periodic state


def layers_of(**changes):
    layers = load("vezzoli_2014/fig6_gap", changes=changes).stack.layers
    return layers, {key: reduce_material(layer.material).debye for key, layer in layers.items()}


DEBYE = {
    "model": "Debye",
    "permittivity_high": 50,
    "strength": 1500,
    "relaxation_time": 1e-3,
    "conductivity": 2e-6,
}
BODY = SeriesElement(resistance=1e4, elastance=1 / 150e-12, rate=3.0)


def test_modes_are_phasors_per_ampere():
    layers, debye = layers_of(**{"stack.stratum_corneum.material": DEBYE})
    frequency = np.geomspace(0.1, 1e6, 40)
    phasors = phasor_section(layers, area=AREA, element=BODY, second=0.3, frequency=frequency)
    exact, section = per_ampere(phasors, area=AREA), current_section(layers, debye, area=AREA)
    for name in layers:
        for what in ("field", "displacement"):
            given, modal = getattr(exact[name], what), getattr(section[name], what).at(frequency)
            assert np.max(np.abs(modal / given - 1)) < EXACT
    assert np.max(np.abs(section.voltage.at(frequency) / exact.voltage - 1)) < EXACT
    np.testing.assert_allclose(exact.current_density, 1 / AREA, rtol=1e-15)


def test_charge_in_the_layers_stays_where_it_cannot_go():
    density = 1e-5
    changes = {"stack.gap.material.conductivity": 0.0, "stack.insulator.initial_charge": density}
    layers, debye = layers_of(**changes)
    section, time = current_section(layers, debye, area=AREA), np.linspace(0, 0.05, 11)
    wanted = {name: section[name].field for name in layers}
    found = transient(wanted, SILENT, time)
    skin = layers["stratum_corneum"].material
    tau = EPS0 * skin.permittivity / skin.conductivity
    assert np.all(found["insulator"] == 0)  # the plate carries only what a current has brought
    np.testing.assert_allclose(found["gap"], density / EPS0, rtol=1e-14)
    relaxing = density / (EPS0 * skin.permittivity) * np.exp(-time / tau)
    np.testing.assert_allclose(found["stratum_corneum"], relaxing, rtol=1e-12)
    settled = transient(wanted, SILENT, time, settled=True)
    np.testing.assert_allclose(settled["gap"], found["gap"], rtol=1e-14)
    assert np.all(settled["stratum_corneum"] == 0)


def test_the_amplifier_gives_what_stack_body_and_resistor_take():
    drive, angular = sine(amplitude=1e-3, frequency=1e3, phase=np.pi / 2), 2 * np.pi * 1e3
    time, floating = np.linspace(0, 3e-3, 301), SeriesElement(resistance=2e3, elastance=1 / 100e-12, rate=0.0)
    found = drive_voltage(np.full(301, 5.0), drive, time, element=floating, second=0.5, settled=False)
    expected = 7.5 + 2.0 * np.cos(angular * time) + 1e-3 / (angular * 100e-12) * np.sin(angular * time)
    assert close(found, expected)
    # the voltage of a charged body counts and leaks away
    given = {"element": BODY, "second": 0.0, "settled": False, "charge": 3e-9}
    found = drive_voltage(np.full(301, 7.0), SILENT, 100 * time, **given)
    np.testing.assert_allclose(found, 7.0 + 3e-9 / 150e-12 * np.exp(-300.0 * time), rtol=1e-13)


def drive(model, **content):
    return read_model(Drive, {"model": model} | content)


def modulated(model, carrier, modulation, depth):
    return drive(model, amplitude=80, carrier=carrier, modulation=modulation, depth=depth)


AM, ROOT = "AmplitudeModulation", "SquareRootModulation"
SINE = drive("Sine", amplitude=100, frequency=125, phase=0.7)
TONES = {
    "sine": SINE,
    "offset": drive("Offset", level=30, drive=SINE.to_dict()),
    "modulated": modulated(AM, 2000, 125, 0.6),
    "carrier below the modulation": modulated(AM, 125, 500, 1),
    "carrier at the modulation": modulated(AM, 250, 250, 1),
    "root": modulated(ROOT, 2000, 125, 0.9),
    "full root": modulated(ROOT, 2000, 250, 1),
    "root below its sidebands": modulated(ROOT, 250, 125, 0.7),
    "sum": drive("Sum", drives=[SINE.to_dict(), {"model": "Sine", "amplitude": 20, "frequency": 375}]),
}
RISING = {"delay": 1e-3, "rise": 2e-3, "hold": 4e-3, "fall": 3e-3, "repeat": 0.02}
EDGES = {
    "triangle": drive("Square", high=100, low=-20, frequency=50, edge=0.01),
    "square": drive("Square", high=100, low=-20, frequency=50),
    "edges": drive("Square", high=100, frequency=50, edge=1e-3),
    "pulses": drive("PulseTrain", high=100, low=5, width=3e-3, frequency=50, edge=1e-3),
    "trapezium": drive("Trapezium", high=100, low=-7, **RISING),
    "full": drive("Trapezium", high=100, rise=0.005, hold=0.01, fall=0.005, repeat=0.02),
}


@pytest.mark.parametrize("name", TONES)
def test_tones_against_the_transform(name):
    """Exact: every frequency of the drive lies on a line of the transform over 8 ms, up to 512 kHz."""
    one, count = TONES[name], 8192
    lines = np.fft.rfft(one.voltage(np.arange(count) * 8e-3 / count)) / count
    lines[1:] *= 2
    frequencies, amplitudes = spectrum(one, harmonics=1)
    assert np.all(np.diff(frequencies) > 0)
    assert np.all(frequencies >= 0)
    found = np.zeros(len(lines), complex)
    places = np.round(frequencies * 8e-3).astype(int)
    assert frequencies * 8e-3 == pytest.approx(places, abs=1e-9)
    inside = places < count // 2
    np.add.at(found, places[inside], np.where(places == 0, amplitudes.real, amplitudes)[inside])
    assert np.max(np.abs(found - lines)) < 1e-12 * 100


@pytest.mark.parametrize("name", EDGES)
def test_edges_against_the_transform(name):
    """A transform of straight pieces folds harmonics 2**18 apart: below 1e-9 for bends, 1e-5 at a jump."""
    count = 1 << 18
    # breaks between
    lines = np.fft.rfft(EDGES[name].voltage((np.arange(count) + 0.5) * 0.02 / count)) / count
    lines[1:] *= 2
    lines *= np.exp(-1j * np.pi * np.arange(len(lines)) / count)
    frequencies, amplitudes = spectrum(EDGES[name], harmonics=40)
    assert frequencies == pytest.approx(50 * np.arange(41), rel=1e-12)
    assert np.max(np.abs(amplitudes - lines[:41])) < 1e-8 * 100


def test_square_wave_of_the_textbook():
    frequencies, amplitudes = spectrum(EDGES["square"], harmonics=9)
    order = np.arange(1, 10)
    expected = np.where(order % 2, -1j * 4 * 60 / (np.pi * order), 0)  # 40 V +- 60 V, sines
    assert amplitudes[0] == pytest.approx(40, rel=1e-14)
    assert np.max(np.abs(amplitudes[1:] - expected)) < 1e-13 * 100
    assert frequencies[-1] == 450


@pytest.mark.parametrize(
    ("count", "ones"),
    [
        (1, [SINE, drive("Offset", level=0, drive=SINE.to_dict()), modulated(AM, 2000, 125, 0)]),
        (2, [TONES["offset"], TONES["full root"], TONES["sum"]]),
        (2, [drive("Sum", drives=[SINE.to_dict(), {"model": "Step", "level": 5}])]),
        (3, [TONES["modulated"]]),
        (
            None,
            [EDGES["square"], drive("Step", level=10), drive("Burst", amplitude=1, frequency=10, cycles=3)],
        ),
    ],
)
def test_number_of_harmonics(count, ones):
    for one in ones:
        assert count_harmonics(one) == count


def test_a_part_that_does_not_repeat_is_refused():
    with pytest.raises(InputError, match="does not repeat"):
        spectrum(drive("Chirp", amplitude=1, first=1, last=2, length=1), harmonics=3)
