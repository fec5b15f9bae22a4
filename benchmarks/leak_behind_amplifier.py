"""A leak behind an amplifier, with and without limits, compared with scipy's Radau on the same equations.

Run from the root of the repository with ``python -m benchmarks.leak_behind_amplifier``.
"""

from collections.abc import Callable
from itertools import pairwise
from time import process_time

import numpy as np
from benchmarks.table import surroundings, write
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

import electrovib as ev
from electrovib.core.constants import eps0
from electrovib.scenario import Scenario
from electrovib.solve.nonlinear.electrics import stretch_after

Array = NDArray[np.float64]

TIME = np.linspace(0.0, 30e-3, 601)
TOLERANCES = (1e-6, 1e-9)
TIGHT = 1e-11
AT_ONCE = 1e9  # rate at which a plate follows an amplifier without a pole, for the peer [1/s]

SINE = {"model": "Sine", "amplitude": 50.0, "frequency": 100.0}
SQUARE = {"model": "Square", "high": 60.0, "low": -20.0, "frequency": 100.0}
GROWS = {"model": "FieldConduction", "conductivity": 1e-9, "onset_field": 2e6}
STRONG = {"model": "FieldConduction", "conductivity": 1e-6, "onset_field": 1e5}
TURNS = {"model": "PolarityConduction", "conductivity_positive": 4e-9, "conductivity_negative": 1e-9}
HARD = {"model": "PolarityConduction", "conductivity_positive": 4e-6, "conductivity_negative": 1e-8}
AMPLIFIERS = {
    "gain": {"gain": 2.0},
    "pole": {"gain": 2.0, "bandwidth": 1e3},
    "largest voltage": {"gain": 2.0, "saturation": 70.0},
    "largest voltage, pole": {"gain": 2.0, "bandwidth": 800.0, "saturation": 45.0},
    "largest current": {"source_current": 12e-6, "sink_current": 8e-6},
    "largest current, stray": {"gain": 1.5, "source_current": 15e-6, "stray_capacitance": 5e-11},
    "all": {
        "gain": 1.8,
        "bandwidth": 1500.0,
        "saturation": 70.0,
        "source_current": 12e-6,
        "sink_current": 9e-6,
        "stray_capacitance": 3e-11,
    },
}
LEAKS = {
    "film, grows, sine": ("insulator", GROWS, SINE),
    "gap, rectifies, square": ("gap", TURNS, SQUARE),
    "gap, strong, sine": ("gap", STRONG, SINE),
    "gap, strong and rectifies, square": ("gap", HARD, SQUARE),
}


class Peer:
    """Charges, series resistance and plate as a plain system of equations, piece by piece of the drive."""

    def __init__(self, scenario: Scenario) -> None:
        layers = list(scenario.stack.layers.values())
        assert scenario.circuit.amplifier is not None
        self.drive, self.amplifier = scenario.drive, scenario.circuit.amplifier
        self.area, self.resistance = scenario.contact_area, scenario.circuit.return_path.resistance
        self.thickness = np.array([layer.thickness for layer in layers])
        self.eps = eps0 * np.array([layer.material.permittivity for layer in layers])
        self.sigma = np.array([layer.material.conductivity for layer in layers])
        self.leaks = [(place, layer.leak) for place, layer in enumerate(layers) if layer.leak is not None]
        self.gap = list(scenario.stack.layers).index("gap")
        self.limits = self.amplifier.current_limits
        band, stray = self.amplifier.bandwidth, self.amplifier.stray_capacitance
        self.corner = AT_ONCE if band is None else 2 * np.pi * band
        self.lags = band is not None or (stray > 0 and bool(np.isfinite(self.limits[1])))

    def rate(self, voltage: Callable[[float], float]) -> Callable[[float, Array], Array]:
        """Return the rate of change of charges and plate under a smooth piece of the drive."""
        amplifier, (lowest, highest) = self.amplifier, self.limits
        largest = np.inf if amplifier.saturation is None else amplifier.saturation
        stray = amplifier.stray_capacitance

        def of(time: float, state: Array) -> Array:
            field = state[:-1] / self.eps
            flow = self.sigma * field
            for place, leak in self.leaks:
                flow[place] += leak.current_density(field[place])
            aim = min(max(amplifier.gain * voltage(time), -largest), largest)
            plate = float(state[-1]) if self.lags else aim
            current, slope = (plate - float(self.thickness @ field)) / self.resistance, 0.0
            if self.lags:
                slope = self.corner * (aim - plate)
                if stray > 0:
                    slope = (min(max(stray * slope + current, lowest), highest) - current) / stray
            else:
                current = min(max(current, lowest), highest)
            return np.append(current / self.area - flow, slope)

        return of

    def solve(self, times: Array, tolerance: float) -> Array:
        """Return the field of the gap [V/m] at increasing times."""
        marks = np.unique([0.0, *self.drive.corners(float(times[-1]))[0], times[-1]])
        size = np.append(np.full(len(self.eps), 100.0 / np.sum(self.thickness / self.eps)), 100.0)
        state, found = np.zeros(len(size)), np.zeros(len(times))
        for first, last in pairwise(marks.tolist()):
            piece = stretch_after(self.drive, time=first, following=last)
            inside = (times >= first) & ((times < last) | (last == marks[-1]))
            solved = solve_ivp(
                self.rate(lambda time, piece=piece: piece.voltage(time)[0]),
                (first, last),
                state,
                method="Radau",
                t_eval=np.union1d(times[inside], last),
                rtol=tolerance,
                atol=tolerance * size,
            )
            assert solved.success, solved.message
            state = solved.y[:, -1]
            found[inside] = solved.y[self.gap, : np.count_nonzero(inside)] / self.eps[self.gap]
        return found


def timed(work: Callable[[], Array]) -> tuple[float, Array]:
    """Return the processor time [s] and the result."""
    begin = process_time()
    found = work()
    return process_time() - begin, found


def row(amplifier: str, leak: str) -> list[str]:
    """Return one row of the table: times, errors, and the ratio of the times."""
    layer, law, drive = LEAKS[leak]
    changes = {f"stack.{layer}.leak": law, "drive": drive, "circuit.amplifier": AMPLIFIERS[amplifier]}
    scenario = ev.load("vezzoli_2014/fig6_gap").replace(changes)
    peer = Peer(scenario)
    exact = peer.solve(TIME, TIGHT)

    def error(found: Array) -> float:
        return float(np.max(np.abs(found - exact)) / np.max(np.abs(exact)))

    ours, field = timed(lambda: ev.simulate(scenario, time=TIME).field.sel(layer="gap").values)
    missed = error(field)
    peers = [timed(lambda each=each: peer.solve(TIME, each)) for each in TOLERANCES]
    errors = [error(found) for _, found in peers]
    equal = next(
        (time for (time, _), each in zip(peers, errors, strict=True) if each <= missed), peers[-1][0]
    )
    said = [f"{time:.2f} ({each:.0e})" for (time, _), each in zip(peers, errors, strict=True)]
    return [amplifier, leak, f"{ours:.2f} ({missed:.0e})", *said, f"{ours / equal:.2f}"]


def main() -> None:
    """Measure all amplifiers before all leaks and write the table."""
    ev.simulate("vezzoli_2014/fig6_gap", time=TIME[:9])
    rows = [row(amplifier, leak) for amplifier in AMPLIFIERS for leak in LEAKS]
    notes = [
        "Figure 6 of Vezzoli et al. 2014 with a gap, with a non-ohmic leak behind an amplifier, 30 ms at 601 output"
        " times: processor time of one run of `ev.simulate`, and of `scipy.integrate.solve_ivp` with its method Radau"
        " on the same equations between the corners of the drive, with relative tolerances of 1e-6 and 1e-9. In brackets"
        " the error of the field of the gap over its largest value, against scipy at 1e-11. The ratio is that to the"
        " faster of the two that is at least as accurate, or else to the more accurate one; below 1 electrovib is faster.",
        surroundings(["numpy", "scipy"]),
    ]
    head = ["amplifier", "leak and drive", "electrovib, s", "scipy at 1e-6, s", "scipy at 1e-9, s", "ratio"]
    write(
        "leak_behind_amplifier.md",
        "A leak behind an amplifier, compared with scipy's Radau",
        notes,
        head,
        rows,
    )


if __name__ == "__main__":
    main()
