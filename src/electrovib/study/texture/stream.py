"""Texture as a stream: blocks of samples while the finger moves, each checked against the limits."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.errors import InputError
from electrovib.physics.limits import MEAN_SQUARES
from electrovib.scenario import Source
from electrovib.study.check import cleared_for_output, sampled, with_drive
from electrovib.study.texture.reading import TextureSource
from electrovib.study.texture.set_up import FREQUENCY, RAMP, AllLimits, Amount, RenderingSetUp, amount

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from electrovib.core.arrays import Real
    from electrovib.scenario import Scenario
    from electrovib.study.check import CheckResult
    from electrovib.study.texture.synthesis import Synthesis

LONGEST: Final = 600.0
"""Longest stream [s], by default; a choice."""
UNBOUNDED: Final = ("charge", "stored_energy", *MEAN_SQUARES)
"""Limits with which a block of a stream cannot be compared."""
_TICK: Final = 1e-6
"""Share of a sample by which a time stamp may be early or late."""
_CHECKED: Final = 0.05
"""Time at the largest amplitude for which a stream is checked before it begins [s]; a choice."""
_IN_CYCLE: Final = 64


class StreamClosedError(InputError):
    """Samples were requested of a stream that has ended at 0 V."""


class TextureStream:
    """Stream of samples that render a texture, made by `electrovib.texture_stream`.

    Parameters
    ----------
    synthesis : Synthesis
        Of every sample from position and velocity.
    block : int
        Samples of a block.
    dimensions : int
        1 for positions along x (of a picture along its middle), 2 for x and y.
    longest : float
        Longest duration [s].
    check : CheckResult
        Comparison of the largest amplitude with the limits.

    Attributes
    ----------
    error : InputError or None
        Why the stream ends or has ended; None while it runs.

    Notes
    -----
    A block renders the movement up to its time stamp and is played after it: a sample is played `latency` seconds after the
    time to which it belongs, plus the computing time and the delay of the output device. Samples are those of a continuous
    waveform, to which the limits are applied; between them an output has to follow straight lines or a reconstruction filter.
    """

    def __init__(
        self, synthesis: Synthesis, *, block: int, dimensions: int, longest: float, check: CheckResult
    ) -> None:
        self._synthesis, self._block, self._dimensions = synthesis, block, dimensions
        self._last = math.floor(longest * synthesis.rate) - synthesis.ramp_samples
        self.check = check
        self.error: InputError | None = None
        self._next, self._amplitude = 0, 0.0
        self._origin, self._time = math.nan, math.nan
        self._place: Real = np.zeros(2)
        self._sample_place: Real | None = None
        self._fallen, self._fall_from = 0, 0.0

    @property
    def rate(self) -> float:
        """Samples per second [Hz]."""
        return self._synthesis.rate

    @property
    def latency(self) -> float:
        """Delay from the position of the finger to the sample that belongs to it, one block [s]."""
        return self._block / self.rate

    @property
    def largest_force(self) -> float:
        """Largest attraction that the limits allow [N]."""
        return self._synthesis.hardware.largest_force

    @property
    def largest_voltage(self) -> float:
        """Largest amplitude that the limits allow [V], of the drive."""
        return self._synthesis.hardware.largest_amplitude

    @property
    def samples(self) -> int:
        """Samples rendered so far."""
        return self._next

    def render(self, position: ArrayLike, time: float) -> Real:
        """Render the samples since the call before, up to the time of a position.

        Parameters
        ----------
        position : float or array_like
            Finger at this time [m]: a number, or (x, y) in two dimensions, interpolated from that of the call before; or several
            positions, shape (m,) or (m, 2), evenly spaced between the two calls, the last one at this time.
        time : float
            In the clock of the samples [s], at most one block after that of the call before. The first call renders one
            block that ends at this time, with the finger at rest at its position.

        Returns
        -------
        voltage : ndarray, shape (n,)
            Samples [V] after the time of the call before, up to this time. After a violation they fall to 0 V by the ramp.

        Raises
        ------
        StreamClosedError
            If the stream has ended at 0 V, with the reason.

        Notes
        -----
        A violation of a limit, of the longest block or of the longest duration, or a position or time that is no number, sets
        `error`; the samples that are returned from there on fall to 0 V within the limits, and once 0 V is reached every further
        call raises.
        """
        if self.error is not None:
            return self._ending(self._block)
        try:
            places, now = self._read(position, time)
            count, places = self._at_samples(places, now)
        except (TypeError, ValueError, InputError) as error:
            self.error = InputError(f"{error}. The stream ends at 0 V")
            return self._ending(self._block)
        before = places[:1] if self._sample_place is None else self._sample_place
        velocity = (places - np.concatenate((before, places[:-1]))) * self.rate
        return self._checked(count, places, velocity)

    def close(self) -> Real:
        """End the stream by its ramp.

        Returns
        -------
        voltage : ndarray, shape (n,)
            Samples [V] down to 0 V; none if 0 V is reached already.
        """
        if self.error is None:
            self.error = InputError("the stream was closed")
            self._fall_from = self._amplitude
        left = self._synthesis.ramp_samples - self._fallen
        return self._ending(left) if left > 0 else np.zeros(0)

    def _checked(self, count: int, places: Real, velocity: Real) -> Real:
        """Return the samples of a block within the limits, or those up to the first violation and the ramp after them."""
        synthesis = self._synthesis
        forces = synthesis.forces(places, velocity)
        ramped = synthesis.rising(self._next, synthesis.amplitudes(forces))
        place, why = synthesis.first_fault(forces, ramped, self._amplitude)
        if self._next + count > self._last and place < 0:
            place, why = max(0, self._last - self._next), "the declared longest duration is reached"
        if place < 0:
            found = synthesis.voltages(self._next, ramped)
            if count:
                self._next += count
                self._amplitude = float(ramped[-1])
                self._sample_place = places[-1:]
            return found
        self.error = InputError(f"{why}. The stream ends at 0 V", path="texture")
        kept = ramped[:place]
        found = synthesis.voltages(self._next, kept)
        self._next += place
        self._amplitude = float(kept[-1]) if place else self._amplitude
        return np.concatenate([found, self._ending(count - place)])

    def _ending(self, count: int) -> Real:
        """Return samples of the ramp to 0 V; raise once it is complete."""
        synthesis = self._synthesis
        if self._fallen == 0:
            self._fall_from = self._amplitude
            if self._fall_from == 0.0:
                self._fallen = synthesis.ramp_samples
                if self._next:
                    return np.zeros(count)
        elif self._fallen >= synthesis.ramp_samples:
            raise StreamClosedError(self.error.problems if self.error else "the stream has ended")
        found = synthesis.voltages(self._next, synthesis.falling(self._fallen, count, self._fall_from))
        self._next += count
        self._fallen += count
        return found

    def _read(self, position: ArrayLike, time: float) -> tuple[Real, float]:
        """Return positions of shape (m, 2) and the time; refuse what is no number or comes too late."""
        now, given = float(time), np.asarray(position, dtype=float)
        wide = self._dimensions == 2
        if (
            given.ndim not in ((1, 2) if wide else (0, 1))
            or not given.size
            or (wide and given.shape[-1] != 2)
        ):
            shapes = "(2,) or (m, 2)" if wide else "() or (m,)"
            raise ValueError(f"the position has the shape {given.shape}, and {shapes} is needed")
        if not (math.isfinite(now) and np.isfinite(given).all()):
            raise ValueError("position and time have to be finite numbers")
        if wide:
            places = given.reshape(-1, 2)
        else:
            places = np.full((given.size, 2), self._synthesis.texture.across)
            places[:, 0] = given
        if math.isnan(self._time):
            self._origin = now - (self._block - 1) / self.rate
            self._time, self._place = now - self._block / self.rate, places[0]
        elif not now > self._time:
            raise ValueError(f"the time {now:.9g} s is not after that of the call before, {self._time:.9g} s")
        if (now - self._time) * self.rate > self._block + _TICK:
            late = now - self._time
            raise ValueError(
                f"{late:.4g} s have passed since the call before, and a block has {self.latency:.4g} s"
            )
        return places, now

    def _at_samples(self, places: Real, now: float) -> tuple[int, Real]:
        """Return the number of samples up to a time and the positions at them, on straight lines."""
        rate, before, last = self.rate, self._time, self._place
        count = math.floor((now - self._origin) * rate + _TICK) - self._next + 1
        since = self._origin - before + np.arange(self._next, self._next + count) / rate
        shares = since * (len(places) / (now - before))
        if len(places) == 1:
            found = last + shares[:, None] * (places[0] - last)
        else:
            knots = np.arange(len(places) + 1)
            found = np.empty((count, 2))
            for axis in (0, 1):
                found[:, axis] = np.interp(
                    shares, knots, np.concatenate((last[axis : axis + 1], places[:, axis]))
                )
        self._time, self._place = now, places[-1]
        return count, found


def texture_stream(
    scenario: Source,
    *,
    texture: TextureSource,
    carrier: Amount | None = None,
    frequency: Amount = FREQUENCY,
    rate: Amount = 10e3,
    block: Amount = 1e-3,
    ramp: Amount = RAMP,
    dimensions: int = 1,
    longest: Amount = LONGEST,
    limits: AllLimits = None,
    set: Mapping[str, Any] | None = None,  # noqa: A002 - the name of the option
) -> TextureStream:
    """Return a stream of samples that render a texture while a finger moves.

    Parameters
    ----------
    scenario, texture, carrier, frequency, ramp, limits, set
        As for `electrovib.texture_drive`.
    rate : float or str
        Samples per second [Hz], 2.5 times the carrier at least.
    block : float or str
        Longest time between two calls of `render` [s], which is also the latency.
    dimensions : int
        1 for positions along x (of a picture along its middle), 2 for x and y.
    longest : float or str
        Duration at which the stream ends at 0 V [s].

    Returns
    -------
    TextureStream
        With ``render(position, time)``, which returns the samples of a block, and ``close()``.

    Raises
    ------
    InputError
        Unless the largest voltage and the largest current are declared, the layers respond linearly, and the largest amplitude
        passes every limit and breakdown.

    Notes
    -----
    Before the stream begins, a burst at the largest amplitude is compared with every limit and with breakdown. Each block is
    compared with the limits of voltage and current, the latter from the slope of the voltage and the charge that the stack and
    the stray capacitance can take up. Limits of charge, of stored energy and of root mean squares have no such bound, and a
    stream is refused where they are declared. A stream is never passed on to the bench.
    """
    found = RenderingSetUp.read(scenario, texture, set, limits, "a stream of a texture")
    if unbounded := [name for name in UNBOUNDED if name in found.declared]:
        raise InputError(
            "a stream cannot be compared with this limit; compute the drive of a path with electrovib.texture_drive, which is",
            path=f"limits.{unbounded[0]}",
        )
    if dimensions not in (1, 2):
        raise InputError("must be 1 or 2", path="dimensions", value=str(dimensions))
    tone = 0.0 if carrier is None else amount(carrier, "Hz", "carrier", low=1e-3, high=1e7)
    per_second = amount(rate, "Hz", "rate", low=1.0, high=1e7)
    span = amount(block, "s", "block", low=1 / per_second, high=1.0)
    lasting = amount(longest, "s", "longest", low=1e-3, high=86400.0)
    synthesis = found.synthesis(
        carrier=tone,
        frequency=amount(frequency, "Hz", "frequency", low=1e-3, high=1e7),
        ramp=amount(ramp, "s", "ramp", low=1e-6, high=10.0),
        rate=per_second,
    )
    check = _cleared(found.scenario, synthesis, limits)
    return TextureStream(
        synthesis, block=round(span * per_second), dimensions=dimensions, longest=lasting, check=check
    )


def _cleared(scenario: Scenario, synthesis: Synthesis, limits: AllLimits) -> CheckResult:
    """Check a burst at the largest amplitude, or refuse the stream."""
    hardware = synthesis.hardware
    held = max(_CHECKED, 5 / hardware.carrier) if hardware.carrier else _CHECKED
    step = 1 / (_IN_CYCLE * hardware.carrier) if hardware.carrier else hardware.ramp
    count = round((held + 2 * hardware.ramp) / step) + 1
    times = np.arange(count, dtype=np.float64) * np.float64(step)
    envelope = np.minimum(1.0, np.minimum(times, times[-1] - times) / hardware.ramp)
    wave = np.sin(2 * math.pi * hardware.carrier * times) if hardware.carrier else np.ones(len(times))
    voltages = np.asarray(hardware.largest_amplitude * envelope * wave, dtype=np.float64)
    return cleared_for_output(
        with_drive(scenario, sampled(times, voltages)),
        limits=limits,
        what="a stream of a texture",
        name="a burst at the largest amplitude of the stream",
        consequence="No stream was made; declare a lower limits.voltage",
    )
