"""One finger, one drive: the exact recursion compared with common tools that give the same response.

Run from the root of the repository with ``python -m benchmarks.one_finger``.
"""

from collections.abc import Callable
from itertools import pairwise
from typing import NamedTuple

import mpmath
import numpy as np
from benchmarks.table import surroundings, timed, write
from numpy.typing import NDArray
from tests.reference.plain_recursion import march_loop

from electrovib.solve.recursion import hold_weights, march

Array = NDArray[np.float64]

SAMPLES = 1_000_000
STEP = 1e-6
POLES = -1.0 / np.logspace(-5, 0, 12)  # skin-like: relaxation times of 10 us to 1 s
GAINS = 0.9 * np.linspace(1.0, 2.0, 12) / np.linspace(1.0, 2.0, 12).sum()
DIRECT = 0.1
AMPLITUDE, HALF_PERIOD, RAMP = 100, 4000, 100  # +-100 V, 125 Hz, ramps of 100 us; in samples


class Contender(NamedTuple):
    """One method: its name, its number of repeats, and the work from samples to output."""

    name: str
    repeats: int
    work: Callable[[], Array]
    remark: str = ""


def corners() -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the corners of the drive in samples and volts; it begins in the middle of a ramp, at zero."""
    middles = np.arange(0, SAMPLES + HALF_PERIOD, HALF_PERIOD)
    sides = AMPLITUDE * (-1) ** np.arange(middles.size)
    ends = np.column_stack([middles + RAMP // 2, middles + HALF_PERIOD - RAMP // 2])
    return np.append(0, ends), np.append(0, np.repeat(sides, 2))


def trapezoidal_pulse() -> Array:
    """Return the sampled drive; every value is a whole number of volts, so the straight pieces are exact."""
    return np.round(np.interp(np.arange(SAMPLES), *corners()))


def reference(places: NDArray[np.int64]) -> Array:
    """Return the output at some samples to 40 digits, from the closed form of every straight piece."""
    with mpmath.workdps(40):
        poles = [mpmath.mpf(pole) * mpmath.mpf(STEP) for pole in POLES]  # time in samples
        states, answer = [mpmath.mpf(0)] * len(poles), []
        for (begin, start), (end, finish) in pairwise(np.transpose(corners()).tolist()):
            slope = mpmath.mpf(finish - start) / (end - begin)
            for place in places[(places >= begin) & (places < end)]:
                since = int(place) - begin
                inside = _after(states, poles, since, start, slope)
                level = start + slope * since
                answer.append(DIRECT * level + sum(g * x for g, x in zip(GAINS, inside, strict=True)))
            states = _after(states, poles, end - begin, start, slope)
        return np.array([float(each) for each in answer])


def _after(states: list, poles: list, since: int, start: int, slope: mpmath.mpf) -> list:
    """Return the states ``since`` samples into a piece: the particular solution and the decaying deviation from it."""
    return [
        (x - start - slope / pole) * mpmath.exp(pole * since) + start + slope * since + slope / pole
        for x, pole in zip(states, poles, strict=True)
    ]


def contenders(drive: Array) -> list[Contender]:
    """Return all methods; work that is possible once per set of poles is done here, except for ours."""
    return [
        Contender("electrovib march (numpy)", 25, _ours(drive), "weights included"),
        Contender("scipy.signal.sosfilt, 6 biquads by zpk2sos", 15, _biquads(drive), "filter prepared"),
        Contender("scipy.signal.sosfilt, 12 first-order sections", 15, _singles(drive), "filter prepared"),
        Contender("scipy.signal.lfilter, 12 sections in parallel", 7, _parallel(drive), "filter prepared"),
        Contender("scipy.fft, exact hold, zero padded", 7, _fourier(drive), "transfer prepared"),
        Contender("electrovib march_loop", 1, _loop(drive), "the readable reference"),
        Contender("scipy.signal.lsim", 3, _lsim(drive)),
        Contender("control.forced_response", 3, _forced(drive)),
    ]


def _ours(drive: Array) -> Callable[[], Array]:
    rest = np.zeros(POLES.size)
    return lambda: march(POLES, [GAINS], [DIRECT], drive[:-1], drive[1:], STEP, rest)[0][0]


def _loop(drive: Array) -> Callable[[], Array]:
    rest = np.zeros(POLES.size)
    return lambda: march_loop(POLES, [GAINS], [DIRECT], drive[:-1], drive[1:], STEP, rest)[0][0]


def _state_space() -> tuple[Array, Array, Array, Array]:
    return np.diag(POLES), -POLES[:, np.newaxis], GAINS[np.newaxis], np.array([[DIRECT]])


def _lsim(drive: Array) -> Callable[[], Array]:
    from scipy.signal import lsim

    stamps = np.arange(drive.size) * STEP
    return lambda: lsim(_state_space(), drive, stamps)[1]


def _forced(drive: Array) -> Callable[[], Array]:
    import control

    stamps = np.arange(drive.size) * STEP
    system = control.ss(*_state_space())
    return lambda: control.forced_response(system, stamps, drive).outputs


def _sections() -> tuple[Array, Array, Array]:
    """Return discrete sections: y = sum of (b0 + b1/z)/(1 - a/z) over poles, plus the direct share."""
    decay, first, last = hold_weights(POLES * STEP)
    return decay, GAINS * last, GAINS * first


def _parallel(drive: Array) -> Callable[[], Array]:
    from scipy.signal import lfilter

    decay, now, before = _sections()

    def work() -> Array:
        total = DIRECT * drive
        for a, b0, b1 in zip(decay, now, before, strict=True):
            total += lfilter([b0, b1], [1.0, -a], drive)
        return total

    return work


def roots() -> tuple[Array, Array, float]:
    """Return zeros, poles and gain of the same discrete transfer function, zeros and poles in rising order."""
    decay, now, before = _sections()
    gain = DIRECT + now.sum()
    residues = now * decay + before  # b0 + b1/z over 1 - a/z is b0 + (b0 a + b1)/(z - a)
    zeros = np.linalg.eigvals(np.diag(decay) - np.outer(np.ones(decay.size), residues) / gain)
    return np.sort(zeros.real), np.sort(decay), gain


def _biquads(drive: Array) -> Callable[[], Array]:
    from scipy.signal import sosfilt, zpk2sos

    sections = zpk2sos(*roots())
    return lambda: sosfilt(sections, drive)


def _singles(drive: Array) -> Callable[[], Array]:
    """Return the work with one pole and the nearest zero in every section: the most accurate series form, twice the work."""
    from scipy.signal import sosfilt

    zeros, poles, gain = roots()
    sections = np.array([[1.0, -zero, 0.0, 1.0, -pole, 0.0] for zero, pole in zip(zeros, poles, strict=True)])
    sections[0, :3] *= gain
    return lambda: sosfilt(sections, drive)


def _fourier(drive: Array) -> Callable[[], Array]:
    """Return the work with the impulse response truncated after one record, without aliasing in twice its length."""
    from scipy.fft import irfft, next_fast_len, rfft

    size = next_fast_len(2 * drive.size, real=True)
    bins, (decay, now, before) = np.arange(size // 2 + 1), _sections()
    turn = -2j * np.pi * bins / size
    whole = np.exp(-2j * np.pi * (bins * drive.size % size) / size)
    transfer = np.full(bins.size, DIRECT, complex)
    for pole, a, b0, b1 in zip(POLES * STEP, decay, now, before, strict=True):
        cut = 1 - np.exp(pole * drive.size) * whole
        transfer += b0 + (b0 * a + b1) * np.exp(turn) * cut / -np.expm1(pole + turn)
    return lambda: irfft(transfer * rfft(drive, size), size)[: drive.size]


def main() -> None:
    """Time every method, compute every error, and write the table."""
    drive = trapezoidal_pulse()
    places = np.unique(np.concatenate([np.arange(0, SAMPLES, 2477), [1, RAMP, 2 * RAMP, SAMPLES - 1]]))
    exact = reference(places)
    found = []
    for contender in contenders(drive):
        contender.work()
        time, output = timed(contender.work, contender.repeats)
        error = np.abs(output[places] - exact).max() / np.abs(exact).max()
        found.append((contender, time, error))
    slowest = next(time for contender, time, _ in found if contender.name == "scipy.signal.lsim")
    rows = [
        [c.name, f"{time * 1e3:.3g}", f"{slowest / time:.3g}", f"{error:.1e}", str(c.repeats), c.remark]
        for c, time, error in found
    ]
    write("one_finger.md", "One finger", _notes(len(places)), _HEAD, rows)


_HEAD = ["method", "time, ms", "times faster than lsim", "error", "repeats", "remark"]


def _notes(places: int) -> list[str]:
    setting = f"""{SAMPLES} samples of 1 us, {POLES.size} poles (relaxation times 10 us to 1 s, log-spread),
double precision, trapezoidal pulses of +-100 V, 125 Hz, ramps of 100 us, from rest."""
    measure = f"""Median wall time after one unmeasured run. Error: largest deviation at {places} samples from
a closed form to 40 digits, as a share of the largest value there. Rows are comparable only within this table."""
    return [setting, measure, surroundings(["numpy", "scipy", "control"])]


if __name__ == "__main__":
    main()
