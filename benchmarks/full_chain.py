"""Electrics, force, friction and sensor at once, against the electrics alone.

Run from the root of the repository with ``python -m benchmarks.full_chain``.
"""

from collections.abc import Callable
from statistics import median
from time import perf_counter
from typing import NamedTuple

import numpy as np
from benchmarks.one_finger import DIRECT, GAINS, POLES, SAMPLES, STEP, trapezium
from benchmarks.table import surroundings, write
from numpy.typing import NDArray

from electrovib.solve.filters import second_order
from electrovib.solve.recursion import hold_weights, march, march_loop, march_pairs, march_pairs_loop

Array = NDArray[np.float64]

KEEP = 80
STATIC = 1e-7  # force per volt squared [N/V2]
LOAD, FRICTION = 0.5, 0.4  # normal force [N], coefficient
SENSOR = second_order(4400.0, 0.44)  # a published closed-loop rig (code of Grigorii and Colgate)
REST = np.zeros(POLES.size)
ROUNDS = 41


class Contender(NamedTuple):
    """One way: its name, the rounds it takes part in, and the work from samples to every 80th output."""

    name: str
    rounds: int
    work: Callable[[], Array]
    exact: Array
    remark: str = ""


def electrics(drive: Array) -> Array:
    """Voltage at every sample."""
    return march(POLES, [GAINS], [DIRECT], drive[:-1], drive[1:], STEP, REST)[0][0]


def electrics_kept(drive: Array) -> Array:
    """Voltage at all samples, every 80th kept."""
    return electrics(drive)[::KEEP].copy()


def electrics_decimated(drive: Array) -> Array:
    """Voltage at every 80th sample, nothing computed between."""
    return march(POLES, [GAINS], [DIRECT], drive[:-1], drive[1:], STEP, REST, keep=KEEP)[0][0]


def into_friction(voltage: Array) -> Array:
    """Friction mu (f_n + c v^2) in the place of the voltage."""
    np.multiply(voltage, voltage, out=voltage)
    voltage *= STATIC  # the attraction
    voltage += LOAD
    voltage *= FRICTION
    return voltage


def chain(drive: Array) -> Array:
    """Reading of the lateral sensor at every 80th sample, settled under the first force."""
    force = into_friction(electrics(drive))
    start = SENSOR.state(force[0])
    return march_pairs(SENSOR.poles, [SENSOR.gains], [0.0], force[:-1], force[1:], STEP, start, keep=KEEP)[0][
        0
    ]


def reference(drive: Array) -> tuple[Array, Array]:
    """Voltage and reading by the plain loops."""
    voltage = march_loop(POLES, [GAINS], [DIRECT], drive[:-1], drive[1:], STEP, REST)[0][0]
    force = FRICTION * (LOAD + STATIC * voltage**2)
    start = SENSOR.state(force[0])
    reading = march_pairs_loop(SENSOR.poles, [SENSOR.gains], [0.0], force[:-1], force[1:], STEP, start)[0][0]
    return voltage[::KEEP], reading[::KEEP]


def contenders(drive: Array) -> list[Contender]:
    """Build all ways; the first is what the others are measured by."""
    voltage, reading = reference(drive)
    return [
        Contender(
            "electrics alone, all outputs, every 80th kept",
            ROUNDS,
            lambda: electrics_kept(drive),
            voltage,
            "what the square needs",
        ),
        Contender(
            "electrics alone, only every 80th output",
            ROUNDS,
            lambda: electrics_decimated(drive),
            voltage,
            "a shortcut that no square can use",
        ),
        Contender("**full chain (numpy)**", ROUNDS, lambda: chain(drive), reading),
        Contender("sosfilt chain", 11, _biquads(drive), reading, "filters prepared"),
        Contender("two scipy.signal.lsim", 1, _lsim(drive), reading),
    ]


def _biquads(drive: Array) -> Callable[[], Array]:
    """Six biquads, numpy between, one biquad for the sensor, all as exact holds of straight pieces."""
    from benchmarks.one_finger import _roots
    from scipy.signal import lfilter, sosfilt, zpk2sos

    sections = zpk2sos(*_roots())
    numerator, denominator = _sensor_section()

    def work() -> Array:
        force = into_friction(sosfilt(sections, drive))
        force -= force[0]  # settled under the first force
        return lfilter(numerator, denominator, force)[::KEEP] + FRICTION * LOAD_AT_START

    LOAD_AT_START = LOAD
    return work


def _sensor_section() -> tuple[Array, Array]:
    """Sensor as one discrete biquad."""
    from electrovib.solve.recursion import hold_weights_complex

    decay, first, last = (complex(each[0]) for each in hold_weights_complex(SENSOR.poles * STEP))
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
        force = into_friction(lsim(stack, drive, stamps)[1])
        return lsim(sensor, force, stamps, X0=[force[0], 0.0])[1][::KEEP].copy()

    return work
