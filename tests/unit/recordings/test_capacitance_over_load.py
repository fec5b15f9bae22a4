"""The capacitance of a contact over the load, at one frequency, determines the law of its area and its gap."""

import math

import numpy as np
import pytest
from twins import GAP, plate

import electrovib as ev
from electrovib.core.constants import eps0
from electrovib.core.errors import InputError
from electrovib.core.signals import make_trace
from electrovib.recordings.fit.measured import MeasuredTrace
from electrovib.recordings.fit.of_scenario import fit_scenario
from electrovib.view.plots import over_time

AREA, EXPONENT, FREQUENCY = 1e-4, 0.4, 1e4
PATH = "contact.exponent"
LOADS = np.geomspace(0.1, 2.0, 12)
SINE = {"drive": {"model": "Sine", "frequency": FREQUENCY, "amplitude": "1 V"}}
AREA_LAW = {
    "contact": {"model": "GrowingArea", "area": AREA, "at_force": "0.5 N", "exponent": EXPONENT},
    "load.normal_force": "0.5 N",
}
TRUE = {PATH: EXPONENT, GAP: 3e-6}
START = plate(**AREA_LAW).replace(SINE | {PATH: 0.7, GAP: "2 um"})
TURNS = 2j * math.pi * FREQUENCY


def admittance(scenario, loads, *, resistance=0.0):
    """By hand: thicknesses over complex permittivities of all layers, over the area at each load, behind the body."""
    area = AREA * (np.asarray(loads) / 0.5) ** EXPONENT
    thicknesses = sum(
        each.thickness / each.material.complex_permittivity(np.array([FREQUENCY]))[0]
        for each in scenario.stack.layers.values()
    )
    return area / (thicknesses / (TURNS * eps0) + area * resistance)


def by_hand(scenario, loads):
    return admittance(scenario, loads, resistance=scenario.circuit.return_path.resistance).imag / TURNS.imag


def assert_true(found):
    for path, true in TRUE.items():
        width = found.estimate.standard_deviations[path]
        assert abs(found.estimate.values[path] - true) < 4 * width < 0.2 * true


def table(loads, values):
    columns = {"normal_force": loads, "capacitance": values}
    time = np.arange(len(loads), dtype=float)
    return make_trace({name: (("time",), row) for name, row in columns.items()}, {"time": time}, {})


def in_any_order(seed=1, noise=2e-3):
    rng = np.random.default_rng(seed)
    loads = rng.permutation(np.tile(LOADS, 5))
    values = by_hand(plate(**AREA_LAW), loads)
    return table(loads, values + noise * values.mean() * rng.normal(size=loads.size))


@pytest.mark.slow
def test_one_impedance_at_each_load_determines_exponent_and_gap():
    rng = np.random.default_rng(1)
    noise = 1e-3 * (rng.normal(size=LOADS.size) + 1j * rng.normal(size=LOADS.size))
    values = (1 + noise) / admittance(plate(**AREA_LAW), LOADS)
    recordings = [
        MeasuredTrace(
            trace=make_trace({"impedance": (("frequency",), [value])}, {"frequency": [FREQUENCY]}, {}),
            name=f"{load:.3g} N",
            changes={"load.normal_force": load},
            noise={"impedance": 1e-3},
            proportional=["impedance"],
        )
        for load, value in zip(LOADS, values, strict=True)
    ]
    start = plate(**AREA_LAW).replace({PATH: 0.7, GAP: "2 um"})
    assert_true(fit_scenario(start, recordings, free=[PATH, GAP]))


def test_without_loss_it_is_that_of_a_plate_capacitor_under_the_load_of_each_time():
    rising = {"load.time_profile": {"model": "Press", "rise": "10 ms"}}
    scenario = plate(**AREA_LAW).replace(SINE | rising | {"circuit.return_path.resistance": 0.0})
    lossless = {"model": "Constant", "permittivity": 4}
    scenario = scenario.replace({f"stack.{name}.material": lossless for name in scenario.stack.layers})
    trace = ev.simulate(scenario, time=np.linspace(0, 12e-3, 25))
    np.testing.assert_allclose(trace.capacitance, by_hand(scenario, trace.normal_force), rtol=1e-12)
    assert float(trace.capacitance[0]) == 0 < float(trace.capacitance[-1])


FLOATING = {"model": "Floating", "capacitance": "150 pF", "resistance": "20 kohm"}
AMPLIFIER = {"model": "CurrentAmplifier", "sense_resistance": "1 kohm", "command": dict(SINE["drive"])}


@pytest.mark.parametrize(
    "changes",
    [
        {"circuit.return_path": FLOATING},
        {"circuit.return_path": {"model": "SecondElectrode", "area": "0.3 cm2"}, "drive.offset": "5 V"},
        {"drive": AMPLIFIER},
    ],
    ids=["floating", "second electrode", "amplifier"],
)
def test_it_is_the_imaginary_part_of_one_over_the_impedance(changes):
    scenario = plate(**AREA_LAW).replace(SINE).replace(changes | {"load.normal_force": "1.3 N"})
    whole = scenario.replace({"frequency": {"model": "FrequencyGrid", "low": 1e3, "high": 1e5, "samples": 3}})
    trace = ev.simulate(whole, time=np.array([0.0, 1e-3]))
    admittance = 1 / complex(trace.impedance.sel(frequency=FREQUENCY, method="nearest"))
    np.testing.assert_allclose(trace.capacitance, admittance.imag / (2 * math.pi * FREQUENCY), rtol=1e-9)


def test_loads_in_any_order_determine_it_and_the_intervals_hold_the_truth():
    inside = []
    for seed in range(30):
        found = fit_scenario(START, in_any_order(seed), free=[PATH, GAP]).estimate
        for path, true in TRUE.items():
            width = found.standard_deviations[path]
            inside.append(abs(found.values[path] - true) < 2 * width)
            assert width < 0.02 * true
    assert 51 <= sum(inside) <= 60  # 57 expected
    ax = over_time(in_any_order(), "capacitance")
    assert ax.get_ylabel() == "capacitance $C$ [pF]"


def test_under_one_load_it_determines_the_gap_and_a_thin_one_trades_with_the_area():
    rng = np.random.default_rng(1)
    scenario = plate(contact={"model": "FixedArea", "area": AREA}).replace(SINE | {GAP: "2 um"})
    values = by_hand(plate(**AREA_LAW), [0.5]) * (1 + 1e-3 * rng.normal(size=50))
    found = fit_scenario(scenario, table(np.full(50, 0.5), values).drop_vars("normal_force"), free=[GAP])
    assert found.estimate.values[GAP] == pytest.approx(3e-6, rel=3e-3)
    rng, area = np.random.default_rng(1), "contact.area"
    scenario = plate(**AREA_LAW).replace({"stack.insulator.thickness": "100 um"})
    values = by_hand(scenario, LOADS) * (1 + 1e-3 * rng.normal(size=LOADS.size))
    begin = scenario.replace(SINE | {GAP: "0.5 um"})
    found = fit_scenario(begin, table(LOADS, values), free=[PATH, GAP, area])
    assert found.determined == {PATH: "well", GAP: "not", area: "not"}
    assert area in found.undetermined[0].sentence


def test_a_stray_capacitance_is_its_zero():
    recorded = in_any_order(2, noise=1e-3)
    recorded.capacitance.values[:] += 7e-12
    measured = MeasuredTrace(trace=recorded, name="a", offsets=["capacitance"])
    found = fit_scenario(START, measured, free=[PATH, GAP])
    assert found.estimate.values["a: zero of capacitance"] == pytest.approx(7e-12, rel=0.2)
    assert_true(found)


TREMBLING = {"model": "TremblingDistance", "mean": 1e-5, "amplitude": 1e-6, "frequency": 8}


@pytest.mark.parametrize(
    "changes",
    [
        {"drive": plate().drive.to_dict()},
        {"drive": {"model": "Burst", "frequency": FREQUENCY, "amplitude": "1 V", "cycles": 10}},
        {"motion.distance": TREMBLING},
    ],
    ids=["a step", "a burst", "a gap that trembles"],
)
def test_without_one_sine_and_a_constant_gap_there_is_none(changes):
    with pytest.raises(InputError, match=r"constant gap at the frequency of one sine: set drive = \{ model"):
        fit_scenario(START.replace(changes), in_any_order(), free=[PATH])
    assert "capacitance" not in ev.simulate(START.replace(changes))


def test_a_recorded_drive_that_is_no_sine_and_a_negative_capacitance_are_refused():
    recorded = in_any_order()
    recorded["drive_voltage"] = ("time", np.full(recorded.time.size, 1.0))
    with pytest.raises(InputError, match="--keep drive"):
        fit_scenario(START, recorded, free=[PATH, GAP])
    assert_true(fit_scenario(START, recorded, free=[PATH, GAP], keep=["drive"]))
    recorded = in_any_order()
    recorded.capacitance.values[:] *= -1
    with pytest.raises(InputError, match=r"'capacitance' is -\d.* pF in the mean, and none is below 0"):
        fit_scenario(START, recorded, free=[PATH])
