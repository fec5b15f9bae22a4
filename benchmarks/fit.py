"""Five parameters of a scenario from 10 000 samples, compared with finite differences on ``scipy.signal.lsim``.

Run from the root of the repository with ``python -m benchmarks.fit``.
"""

import numpy as np
from benchmarks.table import surroundings, timed, write
from scipy.optimize import least_squares
from scipy.signal import lsim

import electrovib as ev
from electrovib.core.constants import eps0
from electrovib.core.trace import make_trace
from electrovib.recordings.fit import fit_scenario

SAMPLES, NOISE = 10_000, 0.01
FREE = (
    "stack.gap.thickness",
    "stack.gap.material.conductivity",
    "stack.insulator.thickness",
    "contact.area",
    "circuit.return_path.resistance",
)
START = (4e-6, 4e-9, 1.3e-6, 1.2e-4, 1.5e6)


def plate() -> ev.Scenario:
    """Return a step of 100 V through 1 Mohm on an insulator of 1 um, a conducting gap of 3 um and skin."""
    return ev.load("bau_2010/sine").replace(
        {
            "drive": {
                "model": "Trapezium",
                "high": "100 V",
                "rise": "10 us",
                "hold": "20 ms",
                "fall": "10 us",
            },
            "time": {"model": "TimeGrid", "duration": "30 ms"},
            "stack.gap.material.conductivity": "2e-9 S/m",
            "circuit.return_path.resistance": "1 Mohm",
        }
    )


def recording():
    """Return force and current over time, with 1 % of noise."""
    scenario, time = plate(), np.linspace(0, 30e-3, SAMPLES)
    names = ("electrostatic_force", "current")
    signals = ev.prepare(scenario, free=FREE).signals({}, names=names, time=time)
    rng = np.random.default_rng(1)
    rows = {
        name: (("time",), signals[name] + NOISE * np.abs(signals[name]).max() * rng.normal(size=SAMPLES))
        for name in names
    }
    return make_trace(rows, {"time": time}, {})


def by_lsim(trace):
    """Fit the same circuit as three layers in series with a resistor, by finite differences on lsim."""
    time = trace["time"].values
    drive = np.interp(time, [0, 10e-6, 20.01e-3, 20.02e-3], [0, 100, 100, 0])
    data = [trace[name].values for name in ("electrostatic_force", "current")]
    weights = [1 / (NOISE * np.abs(row).max()) for row in data]
    skin = (1560.0, 1.7938354529828572e-06, 2e-4)

    def residual(logarithms):
        gap, leak, film, area, resistance = np.exp(logarithms)
        layers = [(3.9, 0.0, film), (1.0, leak, gap), skin]
        capacitance = np.array([eps0 * eps * area / d for eps, _, d in layers])
        conductance = np.array([sigma * area / d for _, sigma, d in layers])
        a = -np.full((3, 3), 1 / resistance) / capacitance[:, None] - np.diag(conductance / capacitance)
        b = (1 / (resistance * capacitance))[:, None]
        c = np.vstack([np.eye(3)[1], np.full(3, -1 / resistance)])
        _, out, _ = lsim((a, b, c, np.array([[0.0], [1 / resistance]])), drive, time)
        force = 0.5 * eps0 * area * (out[:, 0] / gap) ** 2
        return np.concatenate([(force - data[0]) * weights[0], (out[:, 1] - data[1]) * weights[1]])

    return least_squares(residual, np.log(START), x_scale="jac", ftol=1e-9, xtol=1e-9)


def main() -> None:
    """Measure both, and write the page."""
    trace, start = recording(), dict(zip(FREE, START, strict=True))
    fit_scenario(plate(), trace, free=FREE, start=start)
    ours, found = timed(lambda: fit_scenario(plate(), trace, free=FREE, start=start), 9)
    theirs, other = timed(lambda: by_lsim(trace), 1)
    apart = max(
        abs(value / found.estimate.values[name] - 1)
        for name, value in zip(FREE, np.exp(other.x), strict=True)
    )
    write(
        "fit.md",
        "Five parameters from 10 000 samples",
        [
            "Force and current of a step, 1 % of noise: thickness and conductivity of the gap, thickness of the insulator,"
            " contact area, resistance. Both methods start from the same values; their estimates differ by"
            f" {apart:.1g} at most.",
            surroundings(["numpy", "scipy", "lmfit", "electrovib"]),
        ],
        ("method", "time [s]", "ratio"),
        [
            ("electrovib", f"{ours:.3f}", "1"),
            ("finite differences on scipy.signal.lsim", f"{theirs:.1f}", f"{theirs / ours:.0f}"),
        ],
    )


if __name__ == "__main__":
    main()
