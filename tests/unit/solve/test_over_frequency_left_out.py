"""What the values over frequency leave out is stated: rectification, and the limits of an amplifier."""

from __future__ import annotations

import numpy as np
import pytest

import electrovib as ev
from electrovib.core.diagnostics import read_diagnostics

GAP = {"thickness": 2e-6, "material": {"model": "Constant", "permittivity": 1.0}}
RECTIFIES = {"model": "PolarityConduction", "conductivity_positive": 6e-9, "conductivity_negative": 2e-9}
EVEN = {"model": "FieldConduction", "conductivity": 4e-9, "onset_field": 1e12}
SINE = {"model": "Sine", "amplitude": 1.0, "frequency": 30.0}


def scenario(changes):
    layers = ev.load("vezzoli_2014/fig6").stack.to_dict()
    film = {"thickness": 1e-5, "material": {"model": "Constant", "permittivity": 3.0}}
    stack = {"insulator": film, "gap": GAP, "stratum_corneum": layers["stratum_corneum"]}
    band = {"frequency": {"low": 30.0, "high": 3e3, "samples": 3}}
    return ev.load("vezzoli_2014/fig6").replace(
        {"force.model": "MaxwellStressInGap", "stack": stack, "drive": SINE} | band | changes
    )


def said(trace):
    found = read_diagnostics(trace.attrs["validity"])
    return {each.name: each for each in found if each.name.startswith("over frequency")}


@pytest.mark.parametrize(("leak", "ratio"), [(RECTIFIES, 1.62), (EVEN, 1.0)], ids=["rectifies", "even"])
def test_mean_force_of_a_leak_in_time_and_over_frequency(leak, ratio):
    """A rectifying gap behind a film charges: the mean of the late periods, by harmonic collocation 1.62 times as large."""
    times = np.linspace(0, 3 / 30, 301)
    trace = ev.simulate(scenario({"stack.gap.leak": leak}), time=times)
    late = trace.electrostatic_force.values[-101:]
    mean = np.trapezoid(late, dx=0.01)
    assert mean / trace.mean_force.values[0] == pytest.approx(ratio, rel=0.02)
    assert ("over frequency, gap" in said(trace)) == (leak is RECTIFIES)


@pytest.mark.parametrize(
    ("amplifier", "words"),
    [
        ({"gain": 3.0, "saturation": 2.5}, "reaches 3 V, above the saturation of 2.5 V"),
        ({"source_current": 1e-8, "stray_capacitance": 1e-10}, "above 10 nA, from 30 Hz on"),
        ({"saturation": 1.5, "source_current": 1.0}, ""),
        ({"gain": 3.0, "bandwidth": 100.0}, ""),
    ],
    ids=["saturates", "current", "within", "unlimited"],
)
def test_limits_of_an_amplifier_that_the_mean_force_leaves_out(amplifier, words):
    trace = ev.simulate(scenario({"circuit.amplifier": amplifier}), time=np.array([1e-3]))
    found = said(trace).get("over frequency, amplifier")
    assert (found is not None) == bool(words)
    assert found is None or words in found.text
