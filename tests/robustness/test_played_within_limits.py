"""What a bench or an instrument plays, simulated from its held samples: equal to the plan, and never above a limit."""

import tomllib

import numpy as np
import pytest
from waveform_files import read_back

import electrovib as ev
from electrovib.bench.settings import default_text
from electrovib.core.errors import InputError

pytestmark = pytest.mark.filterwarnings(r"ignore:export_waveform\(largest_error=")

BASE = ev.load("vezzoli_2014/fig6").replace(
    {
        "stack.insulator.breakdown_field": "10 GV/m",
        "limits": {},
        "drive": {"model": "Trapezium", "high": 100.0, "rise": 2e-3, "hold": 3e-3, "fall": 2e-3},
    }
)
CASES = [  # film, voltage, rise, edge, stray capacitance, source resistance
    ("1 um", 1000, 36e-3, 2e-6, 0, 0),
    ("1 um", 1000, 36e-3, 1e-7, 0, 0),
    ("1 um", 1000, 36e-3, 17e-6, 0, 0),
    ("1 um", 300, 1e-3, 1e-7, 0, 1e3),
    ("5 um", 500, 5e-3, 1e-6, 200e-12, 0),
    ("20 um", 800, 2e-3, 1e-8, 0, 0),
    ("20 um", 800, 2e-3, 1e-7, 50e-12, 1e4),
    ("90 um", 1000, 10e-3, 5e-8, 20e-12, 0),
    ("90 um", -700, 0.5e-3, 2e-7, 0, 1e5),
    ("0.5 um", 50, 20e-3, 0, 0, 1e4),
]
"""Ten set-ups in which the held samples decide the current."""


def bench(edge, current, voltage=2e3):
    """The shipped set-up with limits and an edge [A, V, s]; without an edge for 0."""
    tables = tomllib.loads(default_text())
    tables["limits"] = {"voltage": voltage, "current": current}
    tables["current_limiter"]["current"] = current
    tables["burst"] |= {"resampling_error": 0.2}
    tables["edge"]["time"] = edge
    return tables if edge else {name: table for name, table in tables.items() if name != "edge"}


def of(film, high, rise, stray, resistance):
    changes = {
        "stack.insulator.thickness": film,
        "drive": BASE.drive.to_dict() | {"high": high, "low": 0.0, "rise": rise, "fall": rise},
        "circuit.source_resistance": resistance,
    }
    return BASE.replace(changes | ({"circuit.amplifier": {"stray_capacitance": stray}} if stray else {}))


def largest_current(scenario, voltages, level, edge):
    """The largest current under held levels, simulated as straight lines, at the ends of all edges and of all levels [A]."""
    edge = min(edge, level)
    if edge == 0:
        edge = 1e-6 * level  # as steep as a step behind the time constants of these set-ups
    begins = level * np.arange(len(voltages))
    before = np.append(0.0, voltages[:-1])
    times = np.column_stack([begins, begins + 0.999999 * edge]).ravel()
    values = np.column_stack([before, voltages]).ravel()
    drive = {"model": "Sampled", "time_samples": times.tolist(), "voltage_samples": values.tolist()}
    band = {"circuit.amplifier.bandwidth": None} if scenario.circuit.amplifier else {}
    found = scenario.replace({"drive": drive} | band)
    inside = (begins[:, None] + edge * np.array([0.25, 0.5, 0.75, 0.999])).ravel()
    trace = ev.simulate(found, time=np.unique(np.append(times, inside)))
    name = "amplifier_current" if "amplifier_current" in trace else "current"
    return float(np.max(np.abs(trace[name].values)))


@pytest.mark.parametrize(
    "case", [0, 4, 9, *(pytest.param(each, marks=pytest.mark.slow) for each in (1, 2, 3, 5, 6, 7, 8))]
)
def test_a_plan_and_an_export_state_the_current_of_what_is_played(case, tmp_path):
    """To 0.1 % of the current that the held samples give in another route: straight lines, simulated at all corners."""
    film, high, rise, edge, stray, resistance = CASES[case]
    scenario = of(film, high, rise, stray, resistance)
    plan = ev.plan_bench(scenario, bench=bench(edge, 1.0))
    volts = plan.codes / 2047 * plan.peak
    played = largest_current(scenario, volts, plan.duration / plan.codes.size, edge)
    assert plan.current == pytest.approx(played, rel=1e-3)
    path = tmp_path / "drive.csv"
    found = ev.export_waveform(
        scenario, path, limits={"voltage": 2e3, "current": 1.0}, instrument="hp_33120a",
        scaling=ev.Scaling(gain=200), largest_error=0.05, edge=edge or None,
    )  # fmt: skip
    times, voltages = read_back(path, found.full_scale)
    played = largest_current(scenario, voltages, times[1], edge)
    assert found.check.value("peak current") == pytest.approx(played, rel=1e-3)


def drawn(seed):
    """A random scenario, its edge [s], and a limit of the current near what the levels or the smooth drive take [A]."""
    draw = np.random.default_rng(seed)
    stray = float(draw.choice([0.0, 10 ** draw.uniform(-12, -9.5)]))
    resistance = float(draw.choice([0.0, 10 ** draw.uniform(2, 6)]))
    film = float(10 ** draw.uniform(-6.3, -4))
    scenario = of(
        film, float(draw.uniform(-900, 900)), float(10 ** draw.uniform(-3.5, -1.7)), stray, resistance
    )
    if draw.integers(2):
        own = {"bandwidth": float(10 ** draw.uniform(0, 4)), "stray_capacitance": stray}
        if draw.integers(2):
            own = {"source_current": float(10 ** draw.uniform(-9, -4)), "stray_capacitance": stray}
        scenario = scenario.replace({"circuit.amplifier": own})
    edge = float(draw.choice([0.0, 10 ** draw.uniform(-8, -4)]))
    return draw, scenario, edge, float(10 ** draw.uniform(-6.5, -2.5))


def refused_or_within(seed, tmp_path):
    """Return whether plan and export of a random set-up are accepted; what is accepted holds its limit."""
    draw, scenario, edge, limit = drawn(seed)
    plain = scenario
    if scenario.circuit.amplifier is not None:
        plain = scenario.replace(
            {f"circuit.amplifier.{each}": None for each in ("bandwidth", "source_current")}
        )
    accepted = []
    try:
        plan = ev.plan_bench(scenario, bench=bench(edge, limit))
    except InputError as error:
        assert "above" in str(error) or "generator would have" in str(error) or "infinite" in str(error), (
            error
        )
    else:
        volts = plan.codes / 2047 * plan.peak
        assert largest_current(plain, volts, plan.duration / plan.codes.size, edge) <= limit * 1.001
        accepted.append("plan")
    path = tmp_path / f"drive{seed}.csv"
    held = bool(draw.integers(2))
    options = {"instrument": "hp_33120a", "scaling": ev.Scaling(gain=200)} if held else {}
    declared = (edge or None) if held else (edge or "line")
    try:
        found = ev.export_waveform(
            scenario,
            path,
            limits={"voltage": 2e3, "current": limit},
            largest_error=0.05,
            edge=declared,
            **options,
        )
    except InputError:
        assert not path.exists()
    else:
        times, voltages = read_back(path, found.full_scale)
        lasting = times[1] if declared == "line" else edge
        assert largest_current(plain, voltages, times[1], lasting) <= limit * 1.001
        accepted.append("export")
    return accepted


@pytest.mark.parametrize("seed", range(4))
def test_what_is_accepted_holds_its_limit_as_it_is_played(seed, tmp_path):
    refused_or_within(seed, tmp_path)


@pytest.mark.slow
def test_no_plan_or_export_is_played_above_its_limit(tmp_path):
    accepted = [refused_or_within(1000 + seed, tmp_path) for seed in range(40)]
    assert sum("plan" in each for each in accepted) > 4
    assert sum("export" in each for each in accepted) > 4
    assert sum(not each for each in accepted) > 4
