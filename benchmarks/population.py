"""Many fingers, compared with plain numpy and JAX in one run.

Run from the root of the repository with ``python -m benchmarks.population``; rows of JAX need JAX to be installed.
"""

import gc
import os
from collections.abc import Callable
from statistics import median
from time import perf_counter, process_time
from typing import NamedTuple

import numpy as np
from benchmarks.population_peers import batched_eigenvalues, by_jax, plain_numpy
from benchmarks.table import surroundings, write_page

from electrovib.physics.drive.parts import Linear
from electrovib.solve.electrics.transient import Response
from electrovib.solve.population.percentiles import quantiles
from electrovib.solve.stack.secular import secular_roots
from electrovib.solve.stack.transfer import Transfer
from electrovib.studies.population.tiles import Statistics

FINGERS, SAMPLES, MODES, STEP = 10_000, 2_000, 12, 5e-6
TOGETHER = 250


class Measured(NamedTuple):
    """Median wall and processor time of one method [s], how often it ran, and its result."""

    name: str
    wall: float
    processor: float
    repeats: int
    result: object


def measure(name: str, work: Callable[[], object], repeats: int) -> Measured:
    """Run some work once unmeasured and then several times, one after the other."""
    result = work()
    wall, processor = [], []
    gc.collect()
    gc.disable()
    for _ in range(repeats):
        result = None
        begin, used = perf_counter(), process_time()
        result = work()
        wall.append(perf_counter() - begin)
        processor.append(process_time() - used)
    gc.enable()
    return Measured(name, median(wall), median(processor), repeats, result)


class Population(NamedTuple):
    """Fingers with private modes and one trapezoidal drive."""

    rates: np.ndarray
    residues: np.ndarray
    direct: np.ndarray
    state: np.ndarray
    voltage: np.ndarray
    time: np.ndarray


def population() -> tuple[Population, np.ndarray]:
    """Return fingers like skin, relaxation times of 10 us to 1 s with a spread, and force over squared voltage."""
    random = np.random.default_rng(1)
    rates = 10 ** (np.linspace(0, 5, MODES) + random.normal(0, 0.2, (FINGERS, MODES)))
    shares = random.dirichlet(np.ones(MODES), FINGERS)
    time = np.arange(SAMPLES) * STEP
    voltage = np.clip(500 * np.sin(2 * np.pi * 125 * time), -100, 100)
    fingers = Population(rates, 0.9 * shares * rates, np.full(FINGERS, 0.1), 0 * rates, voltage, time)
    return fingers, random.lognormal(0, 0.3, FINGERS) * 1e-6


def ratio_rows(found: list[Measured], unit: float, count: float, remarks: dict[str, str]) -> list[list[str]]:
    """Return rows with times in all, for one unit of work, and in comparison with the first row."""
    first = found[0]
    return [
        [
            each.name,
            f"{each.wall * 1e3:.3g}",
            f"{each.processor * 1e3:.3g}",
            f"{each.wall / count / unit:.3g}",
            f"{each.wall / first.wall:.3g}",
            f"{each.processor / first.processor:.3g}",
            str(each.repeats),
            remarks.get(each.name, ""),
        ]
        for each in found
    ]


def head(unit: str) -> list[str]:
    """Return the names of the columns of `ratio_rows`."""
    times = ["wall time, ms", "processor time, ms", f"wall time, {unit}"]
    return ["method", *times, "wall time over row 1", "processor time over row 1", "repeats", "remark"]


def stepping() -> list[list[object]]:
    """Return the tables of stepping, with mean and variance, and with exact percentiles."""
    fingers, factor = population()

    def forces() -> np.ndarray:
        drive = Linear(fingers.time, fingers.voltage, fingers.voltage, step=STEP)
        found = np.empty((FINGERS, SAMPLES))
        for first in range(0, FINGERS, TOGETHER):
            some = slice(first, first + TOGETHER)
            rates = fingers.rates[some]
            gains, direct = fingers.residues[some] / rates, fingers.direct[some, np.newaxis]
            one = Transfer(rates=rates, gains=gains, direct=direct)
            found[some] = Response({"voltage": one}, [drive]).at(fingers.time)["voltage"]
        return factor[:, np.newaxis] * found**2

    def table() -> np.ndarray:
        return forces().astype(np.float32)

    statistics = Statistics((), SAMPLES)

    def moments() -> tuple:
        statistics.add(forces())
        return statistics.mean, statistics.variance()

    ours = measure("electrovib", moments, 5)
    peers = [
        measure("numpy, all fingers at once", plain_numpy(fingers, factor), 3),
        *[measure(name, work, 5) for name, work in by_jax(fingers, factor)],
    ]
    mean = ours.result[0]
    means = [np.max(np.abs(each.result[0] - mean)) / np.max(mean) for each in peers]
    remarks = {each.name: f"means differ by {off:.0e}" for each, off in zip(peers, means, strict=True)}
    speed = FINGERS * SAMPLES / ours.wall
    remarks[ours.name] = f"{speed:.3g} finger-samples/s"
    alone = measure("electrovib: responses squared, float32", table, 9)
    bands = [
        measure("the same, and exact 5 and 95 %", lambda: quantiles(table(), [0.05, 0.95]), 7),
        measure("the same, and exact 5, 50 and 95 %", lambda: quantiles(table(), [0.05, 0.5, 0.95]), 7),
        measure("the same, and np.percentile", lambda: np.percentile(table(), [5, 95], axis=0), 1),
    ]
    size = (
        f"{FINGERS} fingers of {MODES} modes, {SAMPLES} samples, force proportional to the squared response."
    )
    counted = FINGERS * SAMPLES
    return [
        [
            "Mean and variance of a force",
            [size],
            head("ns/sample"),
            ratio_rows([ours, *peers], 1e-9, counted, remarks),
        ],
        ["Exact percentiles", [size], head("ns/sample"), ratio_rows([alone, *bands], 1e-9, counted, {})],
    ]


def poles() -> list[object]:
    """Return the table of the poles of stacks."""
    random = np.random.default_rng(2)
    nodes = 10 ** (np.linspace(0, 5, MODES) + random.normal(0, 0.1, (FINGERS, MODES)))
    given = np.sort(nodes, axis=1), nodes * random.lognormal(size=nodes.shape), random.lognormal(size=FINGERS)
    constant = given[2][:, None]
    found = [
        measure("electrovib", lambda: secular_roots(*given[:2], constant=constant), 15),
        measure("numpy.linalg.eigvalsh, batched", batched_eigenvalues(*given), 3),
    ]
    notes = [
        f"Zeros of the impedance of {FINGERS} stacks with {MODES} poles; eigenvalues lose the slow modes to rounding."
    ]
    return ["Poles of stacks", notes, head("us/finger"), ratio_rows(found, 1e-6, FINGERS, {})]


def main() -> None:
    """Measure all and write the page."""
    before = os.getloadavg()[0]
    tables = [*stepping(), poles()]
    notes = [
        surroundings(["numpy", "scipy", "jax"]),
        "Medians of repeats one after the other, after an unmeasured one; garbage is not collected meanwhile.",
        f"Load average of the machine {before:.1f} at the beginning and "
        f"{os.getloadavg()[0]:.1f} at the end: on a busy machine wall times of what uses two threads suffer most, and "
        "processor times are the more reliable ones. Rows are comparable only within a table.",
    ]
    write_page("population.md", "Many fingers", notes, tables)


if __name__ == "__main__":
    main()
