"""Five parameters of a scenario from 10 000 samples, compared with finite differences on ``scipy.signal.lsim``.

Run from the root of the repository with ``python -m benchmarks.fit``.
"""

import os
from collections.abc import Callable
from statistics import median
from time import perf_counter, process_time

import numpy as np
from benchmarks.table import surroundings, write
from scipy.optimize import least_squares
from scipy.signal import lsim

import electrovib as ev
from electrovib.core.constants import eps0
from electrovib.core.signals import make_trace
from electrovib.recordings.fit.of_scenario import fit_scenario

SAMPLES, NOISE = 10_000, 0.01
SKIN = (1560.0, 1.7938354529828572e-06)
"""Permittivity and conductivity of the skin of both problems."""

STEP_FREE = (
    "stack.gap.thickness",
    "stack.gap.material.conductivity",
    "stack.insulator.thickness",
    "contact.area",
    "circuit.return_path.resistance",
)
STEP_START = (4e-6, 4e-9, 1.3e-6, 1.2e-4, 1.5e6)
STEP_NAMES = ("electrostatic_force", "current")
CHAIN_FREE = (
    "friction.coefficient",
    "contact.area",
    "stack.stratum_corneum.thickness",
    "rig.lateral.natural_frequency",
    "rig.lateral.damping_ratio",
)
CHAIN_START = (0.6, 1.2e-4, 3e-4, 350.0, 0.15)
CHAIN_NAMES = ("lateral_force_measured",)


def plate() -> ev.Scenario:
    """Return a step of 100 V through 1 Mohm on an insulator of 1 um, a conducting gap of 3 um and skin."""
    return ev.load("bau_2010/sine").replace(
        {
            "drive": _pulse(rise="10 us", hold="20 ms"),
            "time": {"model": "TimeGrid", "duration": "30 ms"},
            "stack.gap.material.conductivity": "2e-9 S/m",
            "circuit.return_path.resistance": "1 Mohm",
        }
    )


def chain() -> ev.Scenario:
    """Return a pulse of 100 V on an insulator, a gap and skin, with friction and a sensor of 400 Hz behind the attraction."""
    sensor = {"model": "PiezoSensor", "natural_frequency": 2e3, "damping_ratio": 0.02, "time_constant": 10.0}
    return ev.load("bau_2010/sine").replace(
        {
            "drive": _pulse(rise="100 us", hold="4 ms"),
            "time": {"model": "TimeGrid", "duration": "10 ms"},
            "rig": {
                "model": "Tribometer",
                "lateral": {"model": "LateralSensor", "natural_frequency": 400.0, "damping_ratio": 0.1},
                "normal": sensor,
            },
        }
    )


def _pulse(*, rise: str, hold: str) -> dict[str, str]:
    return {"model": "Trapezium", "high": "100 V", "rise": rise, "hold": hold, "fall": rise}


def recording(scenario, names):
    """Return signals over time, with 1 % of noise."""
    time = np.linspace(0, scenario.time.duration, SAMPLES)
    signals = ev.prepare(scenario, free=[]).signals({}, names=names, time=time)
    rng = np.random.default_rng(1)
    rows = {
        name: (("time",), signals[name] + NOISE * np.abs(signals[name]).max() * rng.normal(size=SAMPLES))
        for name in names
    }
    return make_trace(rows, {"time": time}, {})


def step_by_lsim(trace):
    """Fit the circuit of the step as three layers in series with a resistor, by finite differences on lsim."""
    time = trace["time"].values
    drive = np.interp(time, [0, 10e-6, 20.01e-3, 20.02e-3], [0, 100, 100, 0])
    data = [trace[name].values for name in STEP_NAMES]
    weights = [1 / (NOISE * np.abs(row).max()) for row in data]

    def residual(logarithms):
        gap, leak, film, area, resistance = np.exp(logarithms)
        force, current = _circuit(
            time,
            drive,
            layers=[(3.9, 0.0, film), (1.0, leak, gap), (*SKIN, 2e-4)],
            area=area,
            resistance=resistance,
        )
        return np.concatenate([(force - data[0]) * weights[0], (current - data[1]) * weights[1]])

    return _searched(residual, STEP_START)


def chain_by_lsim(trace):
    """Fit circuit, friction and sensor of the chain, by finite differences on two calls of lsim."""
    time = trace["time"].values
    drive = np.interp(time, [0, 100e-6, 4.1e-3, 4.2e-3], [0, 100, 100, 0])
    data = trace[CHAIN_NAMES[0]].values
    weight = 1 / (NOISE * np.abs(data).max())

    def residual(logarithms):
        friction, area, skin, frequency, damping = np.exp(logarithms)
        force, _ = _circuit(
            time, drive, layers=[(3.9, 0.0, 1e-6), (1.0, 0.0, 3e-6), (*SKIN, skin)], area=area, resistance=1e3
        )
        lateral, w0 = friction * (0.5 + force), 2 * np.pi * frequency
        sensor = (
            np.array([[0, 1], [-(w0**2), -2 * damping * w0]]),
            np.array([[0], [w0**2]]),
            np.eye(2)[:1],
            np.zeros((1, 1)),
        )
        _, reading, _ = lsim(sensor, lateral, time, X0=[lateral[0], 0.0])
        return (reading - data) * weight

    return _searched(residual, CHAIN_START)


def _circuit(time, drive, *, layers, area, resistance):
    """Return force and current of layers in series with a resistor; the gap is the second layer."""
    count = len(layers)
    capacitance = np.array([eps0 * eps * area / d for eps, _, d in layers])
    conductance = np.array([sigma * area / d for _, sigma, d in layers])
    a = -np.full((count, count), 1 / resistance) / capacitance[:, None] - np.diag(conductance / capacitance)
    b = (1 / (resistance * capacitance))[:, None]
    c = np.vstack([np.eye(count)[1], np.full(count, -1 / resistance)])
    _, out, _ = lsim((a, b, c, np.array([[0.0], [1 / resistance]])), drive, time)
    return 0.5 * eps0 * area * (out[:, 0] / layers[1][2]) ** 2, out[:, 1]


def _searched(residual, start):
    return least_squares(residual, np.log(start), x_scale="jac", ftol=1e-9, xtol=1e-9)


def measured(work: Callable[[], object], repeats: int) -> tuple[float, float, object]:
    """Return the medians of wall time and processor time of several repeats [s], and the last result."""
    walls, processor, result = [], [], None
    for _ in range(repeats):
        wall, own = perf_counter(), process_time()
        result = work()
        walls.append(perf_counter() - wall)
        processor.append(process_time() - own)
    return median(walls), median(processor), result


def main() -> None:
    """Measure both problems, and write the page."""
    rows, apart = [], []
    problems = (
        ("step: force and current", plate(), STEP_FREE, STEP_START, STEP_NAMES, step_by_lsim),
        ("chain: one lateral force", chain(), CHAIN_FREE, CHAIN_START, CHAIN_NAMES, chain_by_lsim),
    )
    for name, scenario, free, begin, signals, by_lsim in problems:
        trace, start = recording(scenario, signals), dict(zip(free, begin, strict=True))

        def fit(scenario=scenario, trace=trace, free=free, start=start):
            return fit_scenario(scenario, trace, free=free, start=start)

        fit()
        wall, own, found = measured(fit, 9)
        other_wall, other, result = measured(lambda by_lsim=by_lsim, trace=trace: by_lsim(trace), 1)
        deviations = found.estimate.standard_deviations
        for path, value in zip(free, np.exp(result.x), strict=True):
            apart.append(abs(value - found.estimate.values[path]) / deviations[path])
        rows.append((name, "`ev.fit`", f"{wall:.3f}", f"{own:.3f}", "1"))
        rows.append(
            ("", "finite differences on lsim", f"{other_wall:.1f}", f"{other:.1f}", f"{other / own:.0f}")
        )
    write(
        "fit.md",
        "Five parameters from 10 000 samples",
        [
            "Recordings with 1 % of noise. Step: force and current; thickness and conductivity of the gap, thickness of the"
            " insulator, contact area, resistance. Chain: one record of a lateral force behind friction and a sensor; coefficient"
            " of friction, contact area, thickness of the stratum corneum, resonance and damping of the sensor.",
            f"Both methods begin with the same values; their estimates differ by {max(apart):.1g} standard deviations at most,"
            " because lsim is exact only for inputs that are straight from sample to sample. `ev.fit` estimates the noise as"
            " well, and gives covariance, bias and identifiability; the other method gives values only.",
            "Medians of 9 repeats, one of the other method; the ratio is that of the processor times."
            f" Load of the machine at the end: {os.getloadavg()[0]:.1f}.",
            surroundings(["numpy", "scipy", "electrovib"]),
        ],
        ("problem", "method", "wall time [s]", "processor time [s]", "ratio"),
        rows,
    )


if __name__ == "__main__":
    main()
