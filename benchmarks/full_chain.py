"""Electrics, force, friction and sensor together, compared with the electrics alone.

Run from the root of the repository with ``python -m benchmarks.full_chain``.
"""

from collections.abc import Callable
from functools import partial
from statistics import median
from time import perf_counter
from typing import NamedTuple

import numpy as np
from benchmarks.one_finger import DIRECT, GAINS, POLES, SAMPLES, STEP, roots, trapezoidal_pulse
from benchmarks.table import surroundings, write
from numpy.typing import NDArray
from tests.reference.plain_recursion import march_loop

from electrovib.solve.mechanics.filters import march_through, second_order
from electrovib.solve.recursion import hold_weights, march

Array = NDArray[np.float64]

KEEP = 80
STATIC = 1e-7  # force per volt squared [N/V2]
LOAD, FRICTION = 0.5, 0.4  # normal force [N], coefficient
SENSOR = second_order(
    natural_frequency=4400.0, damping_ratio=0.44
)  # a published closed-loop rig (code of Grigorii and Colgate)
REST = np.zeros(POLES.size)
ROUNDS = 41


class Contender(NamedTuple):
    """One method: its name, its number of rounds, the work, and the result of the plain loops."""

    name: str
    rounds: int
    work: Callable[[], Array]
    exact: Array
    remark: str = ""


def electrics(drive: Array) -> Array:
    """Return the voltage at every sample."""
    return march(POLES, [GAINS], [DIRECT], drive[:-1], drive[1:], STEP, REST)[0][0]


def electrics_kept(drive: Array) -> Array:
    """Return the voltage at every 80th sample, computed at all samples."""
    return electrics(drive)[::KEEP].copy()


def into_friction(voltage: Array) -> None:
    """Overwrite the voltage by the friction mu (f_n + c v^2)."""
    np.multiply(voltage, voltage, out=voltage)
    voltage *= FRICTION * STATIC
    voltage += FRICTION * LOAD


def chain(drive: Array) -> Array:
    """Return the lateral sensor's signal at every 80th sample, settled under the first force."""
    force = electrics(drive)
    into_friction(force)
    state = SENSOR.state(float(force[0]))
    return march_through(SENSOR, force[:-1], force[1:], steps=STEP, state=state)[::KEEP].copy()


def reference(drive: Array) -> tuple[Array, Array]:
    """Return voltage and sensor signal of the plain loops at every 80th sample."""
    voltage = march_loop(POLES, [GAINS], [DIRECT], drive[:-1], drive[1:], STEP, REST)[0][0]
    force = FRICTION * (LOAD + STATIC * voltage**2)
    poles, gains, start = SENSOR.poles, [SENSOR.gains], SENSOR.state(force[0])
    reading, _ = march_loop(poles, gains, [0.0], force[:-1], force[1:], STEP, start)
    return voltage[::KEEP], reading[0][::KEEP]


def contenders(drive: Array) -> list[Contender]:
    """Return all methods; the first is the reference for the ratios."""
    voltage, reading = reference(drive)
    own = [
        ("electrics alone, every 80th kept", electrics_kept, voltage, "the reference"),
        ("full chain (numpy)", chain, reading, "`march`, formula, `march_through`"),
    ]
    found = [Contender(name, ROUNDS, partial(work, drive), exact, say) for name, work, exact, say in own]
    found.append(Contender("sosfilt and lfilter chain", 15, _biquads(drive), reading, "filters prepared"))
    found.append(Contender("two scipy.signal.lsim", 1, _lsim(drive), reading))
    return found


def _biquads(drive: Array) -> Callable[[], Array]:
    """Return the work of six biquads, numpy and one biquad for the sensor, all exact for piecewise linear inputs."""
    from scipy.signal import lfilter, sosfilt, zpk2sos

    sections = zpk2sos(*roots())
    numerator, denominator = _sensor_section()

    def work() -> Array:
        force = sosfilt(sections, drive)
        into_friction(force)
        base = force[0]
        force -= base  # settled under the first force, for which the sensor's gain is 1
        return lfilter(numerator, denominator, force)[::KEEP] + base

    return work


def _sensor_section() -> tuple[Array, Array]:
    """Return the sensor as one discrete biquad."""
    decay, first, last = (complex(each[0]) for each in hold_weights(SENSOR.poles * STEP))
    gain = complex(SENSOR.gains[0])
    b0, b1 = gain * last, gain * first  # (b0 + b1/z)/(1 - a/z) and its conjugate
    numerator = [2 * b0.real, 2 * (b1 - b0 * np.conj(decay)).real, -2 * (b1 * np.conj(decay)).real]
    return np.array(numerator), np.array([1.0, -2 * decay.real, abs(decay) ** 2])


def _lsim(drive: Array) -> Callable[[], Array]:
    from scipy.signal import lsim

    stamps = np.arange(drive.size) * STEP
    stack = np.diag(POLES), -POLES[:, np.newaxis], GAINS[np.newaxis], np.array([[DIRECT]])
    pole = complex(SENSOR.poles[0])
    size = abs(pole) ** 2
    sensor = (
        np.array([[0.0, 1.0], [-size, 2 * pole.real]]),
        np.array([[0.0], [size]]),
        np.array([[1.0, 0.0]]),
        np.zeros((1, 1)),
    )

    def work() -> Array:
        force = lsim(stack, drive, stamps)[1]
        into_friction(force)
        return lsim(sensor, force, stamps, X0=[force[0], 0.0])[1][::KEEP].copy()

    return work


def measure(methods: list[Contender]) -> list[list[float]]:
    """Return wall times from rounds in which every method runs once, so that other load affects all of them alike."""
    for method in methods:
        method.work()
    times: list[list[float]] = [[] for _ in methods]
    for round_ in range(ROUNDS):
        for method, found in zip(methods, times, strict=True):
            if round_ < method.rounds:
                begin = perf_counter()
                method.work()
                found.append(perf_counter() - begin)
    return times


def main() -> None:
    """Time every method, compute every error, and write the table."""
    methods = contenders(trapezoidal_pulse())
    times = measure(methods)
    middles = [median(found) for found in times]
    rows = []
    for method, found, middle in zip(methods, times, middles, strict=True):
        error = np.abs(method.work() - method.exact).max() / np.ptp(method.exact)
        numbers = [middle * 1e3, min(found) * 1e3, middle / middles[0]]
        rows.append(
            [
                method.name,
                *(f"{number:.3g}" for number in numbers),
                f"{error:.1e}",
                str(method.rounds),
                method.remark,
            ]
        )
    head = [
        "method",
        "time, ms",
        "shortest, ms",
        "ratio to row 1",
        "error",
        "rounds",
        "remark",
    ]
    write("full_chain.md", "Full chain", _notes(), head, rows)


def _notes() -> list[str]:
    setting = f"""{SAMPLES} samples of 1 us of the drive of `one_finger`, {POLES.size} electrical poles, force
c v^2, friction mu (f_n + c v^2), lateral sensor of second order (4400 Hz, damping 0.44); every {KEEP}th sample kept."""
    how = """Rounds in which every method runs once, after one unmeasured round; median wall time and ratios of medians.
Error: largest deviation from the plain loops, as a share of the range. Rows are comparable only within this table."""
    return [setting, how, surroundings(["numpy", "scipy"])]


if __name__ == "__main__":
    main()
