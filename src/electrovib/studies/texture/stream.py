"""Texture as a stream: blocks of samples while the finger moves, each checked, and a ramp to 0 V at the end whatever raises."""

from __future__ import annotations

import math
import signal
import threading
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.errors import InputError, shortened
from electrovib.core.own_results import at_line, failed

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator
    from types import FrameType

    from numpy.typing import ArrayLike

    from electrovib.core.arrays import Real
    from electrovib.core.diagnostics import Diagnostic
    from electrovib.physics.texture.base import RenderingPlate, Texture
    from electrovib.studies.check import CheckResult
    from electrovib.studies.texture.set_up import Synthesis


_TICK: Final = 1e-6
"""Share of a sample by which a time stamp may be early or late."""


@dataclass
class Progress:
    """How far the samples of a stream have come; what was not played is taken back by its copy from before."""

    next: int = 0
    amplitude: float = 0.0
    origin: float = math.nan
    time: float = math.nan
    place: Real = field(default_factory=lambda: np.zeros(2))
    sample_place: Real | None = None
    fallen: int = 0
    fall_from: float = 0.0


class StreamClosedError(InputError):
    """Samples were requested of a stream that has ended at 0 V."""


class TextureStream:
    """Stream of samples that render a texture, made by `electrovib.texture_stream`.

    - `synthesis`: every sample from position and velocity; `block`: samples of a block.
    - `dimensions`: 1 for positions along x (of a picture along its middle), 2 for x and y.
    - `longest`: longest duration [s]; `check`: comparison of the largest amplitude with the limits.
    - `error`: why the stream ends or has ended; None while it runs.
    - `blocks`: those that `play` has written [V].

    A block renders the movement up to its time stamp and is played after it: a sample is played `latency`
    seconds after the time to which it belongs, plus the computing time and the delay of the output device.
    Samples are those of a continuous waveform, to which the limits are applied; between them an output has to
    follow straight lines or a reconstruction filter.
    """

    def __init__(
        self, synthesis: Synthesis, *, block: int, dimensions: int, longest: float, check: CheckResult
    ) -> None:
        self._synthesis, self._block, self._dimensions = synthesis, block, dimensions
        self._last = math.floor(longest * synthesis.rate) - synthesis.ramp_samples
        self.check = check
        self.error: InputError | None = None
        self.blocks: list[Real] = []
        self._interruption: BaseException | None = None
        self._across = synthesis.texture.across
        self.state = Progress()

    @property
    def diagnostics(self) -> tuple[Diagnostic, ...]:
        """Diagnostics of a burst at the largest amplitude, beyond those that the check states."""
        return self.check.diagnostics

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
        return self.state.next

    def render(self, position: ArrayLike, time: float) -> Real:
        """Render the samples [V] after the call before, up to the time of a position.

        Parameters
        ----------
        position : float or array_like
            Finger at this time [m]: a number, or (x, y) in two dimensions, interpolated from that of the call before;
            or several positions, shape (m,) or (m, 2), evenly spaced between the two calls, the last at this time.
        time : float
            In the clock of the samples [s], at most one block after that of the call before. The first call renders
            one block that ends at this time, with the finger at rest at its position.

        Returns
        -------
        voltage : ndarray, shape (n,)
            Samples [V]; after a violation they fall to 0 V by the ramp.

        Raises
        ------
        StreamClosedError
            If the stream has ended at 0 V, with the reason.

        Notes
        -----
        A violation of a limit, of the longest block or of the longest duration, a position or time that is no number,
        and a texture that raises an exception or returns NaN, infinity or an array of another shape, set `error`: the
        samples fall to 0 V within the limits, and once 0 V is reached every further call raises. KeyboardInterrupt and
        SystemExit during the call are raised again by the first call after that; outside of it, only `play` makes sure
        that the ramp is written.
        """
        if self.error is not None:
            return self._ending(self._block)
        before = replace(self.state)
        try:
            return self._rendered(position, time)
        except BaseException as error:  # noqa: BLE001 - raised again at 0 V
            self.state = before
            self._interruption = error
            self.end(InputError(f"interrupted by {type(error).__name__}. The stream ends at 0 V"))
        return self._ending(self._block)

    def play(self, moves: Iterable[tuple[ArrayLike, float]], write: Callable[[Real], object]) -> Real:
        """Render and write blocks until the positions end, and the ramp to 0 V whatever ends the stream.

        Parameters
        ----------
        moves : iterable of (position, time)
            Arguments of `render`, one pair for each block; the iterable waits for the clock of the output.
        write : callable
            Takes the samples of a block [V] and passes them on to the output.

        Returns
        -------
        voltage : ndarray, shape (n,)
            All samples that were written [V], the ramp included.

        Raises
        ------
        StreamClosedError
            If the stream ended before the positions, with the reason.
        BaseException
            After the ramp: what `moves` or `write` raised, KeyboardInterrupt after SIGINT, SystemExit after another
            signal that asks the process to end. A note of the exception states if the ramp could not be written.

        Notes
        -----
        `played` has the samples also after an exception, without a block that `write` did not accept. Signals are
        handled in the main thread only. A process that is killed (SIGKILL) writes nothing further: the output itself
        has to return to 0 V when no samples arrive.
        """
        play(self, moves, write)
        return self.played

    @property
    def played(self) -> Real:
        """Samples that `play` has written [V]."""
        return np.concatenate([np.zeros(0), *self.blocks])

    def end(self, reason: InputError) -> None:
        """Let the samples that follow fall to 0 V, for a reason; an earlier reason is kept."""
        self.error = self.error or reason

    def closed(self) -> StreamClosedError:
        """Return the error of a stream that has ended, with the reason as its cause."""
        found = StreamClosedError(self.error.problems if self.error else "the stream has ended")
        found.__cause__ = self.error
        return found

    def close(self) -> Real:
        """End the stream by its ramp: samples [V] down to 0 V, none if 0 V is reached already."""
        self.end(InputError("the stream was closed"))
        left = self._synthesis.ramp_samples - self.state.fallen
        return self._ending(left) if left > 0 else np.zeros(0)

    def _rendered(self, position: ArrayLike, time: float) -> Real:
        """Return the samples of a block, or of the ramp after a position or a texture that failed."""
        count = self._block
        try:
            places, now = self._read(position, time)
            count, places = self._at_samples(places, now)
            before = places[:1] if self.state.sample_place is None else self.state.sample_place
            velocity = (places - np.concatenate((before, places[:-1]))) * self.rate
            forces = self._synthesis.forces(places, velocity)
        except Exception as error:  # noqa: BLE001 - whatever a position or a texture raises
            kind = (
                "" if isinstance(error, (TypeError, ValueError, InputError)) else f"{type(error).__name__}: "
            )
            self.error = InputError(f"{kind}{error}. The stream ends at 0 V")
            self.error.__cause__ = error.__cause__ or error
            return self._ending(count)
        return self._checked(count, places, forces)

    def _checked(self, count: int, places: Real, forces: Real) -> Real:
        """Return the samples of a block within the limits, or those up to the first violation and the ramp after them."""
        synthesis = self._synthesis
        ramped = synthesis.rising(self.state.next, synthesis.amplitudes(forces))
        place, why = synthesis.first_fault(forces, ramped, self.state.amplitude)
        if self.state.next + count > self._last and place < 0:
            place, why = max(0, self._last - self.state.next), "the declared longest duration is reached"
        if place < 0:
            found = synthesis.voltages(self.state.next, ramped)
            if count:
                self.state.next += count
                self.state.amplitude = float(ramped[-1])
                self.state.sample_place = places[-1:]
            return found
        self.error = InputError(f"{why}. The stream ends at 0 V", path="texture")
        kept = ramped[:place]
        found = synthesis.voltages(self.state.next, kept)
        self.state.next += place
        self.state.amplitude = float(kept[-1]) if place else self.state.amplitude
        return np.concatenate([found, self._ending(count - place)])

    def _ending(self, count: int) -> Real:
        """Return samples of the ramp to 0 V; raise once it is complete."""
        synthesis = self._synthesis
        if self.state.fallen == 0:
            self.state.fall_from = self.state.amplitude
            if self.state.fall_from == 0.0:
                self.state.fallen = synthesis.ramp_samples
                if self.state.next:
                    return np.zeros(count)
        elif self.state.fallen >= synthesis.ramp_samples:
            interruption, self._interruption = self._interruption, None
            raise interruption or self.closed()
        found = synthesis.voltages(
            self.state.next, synthesis.falling(self.state.fallen, count, self.state.fall_from)
        )
        self.state.next += count
        self.state.fallen += count
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
            places = np.full((given.size, 2), self._across)
            places[:, 0] = given
        if math.isnan(self.state.time):
            self.state.origin = now - (self._block - 1) / self.rate
            self.state.time, self.state.place = now - self._block / self.rate, places[0]
        elif not now > self.state.time:
            raise ValueError(
                f"the time {now:.9g} s is not after that of the call before, {self.state.time:.9g} s"
            )
        if (now - self.state.time) * self.rate > self._block + _TICK:
            late = now - self.state.time
            raise ValueError(
                f"{late:.4g} s have passed since the call before, and a block has {self.latency:.4g} s"
            )
        return places, now

    def _at_samples(self, places: Real, now: float) -> tuple[int, Real]:
        """Return the number of samples up to a time and the positions at them, on straight lines."""
        rate, before, last = self.rate, self.state.time, self.state.place
        count = math.floor((now - self.state.origin) * rate + _TICK) - self.state.next + 1
        since = self.state.origin - before + np.arange(self.state.next, self.state.next + count) / rate
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
        self.state.time, self.state.place = now, places[-1]
        return count, found


_STOPPING: Final = ("SIGINT", "SIGTERM", "SIGHUP", "SIGBREAK")


class Stopping:
    """Request to end, by a signal to the process, whose `number` is 0 without one.

    With `may_raise` a signal raises at once, because no block waits to be written; a second one does so at
    any time. `is_over` is set for the ramp, during which none raises.
    """

    def __init__(self) -> None:
        self.number, self.may_raise, self.is_over = 0, False, False

    def requested(self, number: int, frame: FrameType | None) -> None:
        """Note a signal."""
        del frame
        again, self.number = bool(self.number), self.number or number
        if not self.is_over and (self.may_raise or again):
            raise self.error()

    def error(self) -> BaseException:
        """Return what ends the caller: KeyboardInterrupt after SIGINT, else SystemExit with the code of a shell."""
        return KeyboardInterrupt() if self.number == signal.SIGINT else SystemExit(128 + self.number)

    def check(self) -> None:
        """Raise if an end was requested."""
        if self.number:
            raise self.error()


@contextmanager
def stopping_signals() -> Iterator[Stopping]:
    """Note signals that ask the process to end, in place of what they did before; in the main thread only."""
    found = Stopping()
    if threading.current_thread() is not threading.main_thread():
        yield found
        return
    known = [getattr(signal, name) for name in _STOPPING if hasattr(signal, name)]
    before = {number: signal.signal(number, found.requested) for number in known}
    try:
        yield found
    finally:
        for number, former in before.items():
            signal.signal(number, former)


def play(
    stream: TextureStream, moves: Iterable[tuple[ArrayLike, float]], write: Callable[[Real], object]
) -> None:
    """Render and write a stream until the positions end, and its ramp to 0 V, before anything is raised."""
    with stopping_signals() as stopping:
        ended: BaseException | None = None
        try:
            _blocks(stream, moves, write, stopping)
            if stream.error is not None:
                ended = stream.closed()
        except BaseException as error:  # noqa: BLE001 - raised again after the ramp
            ended = error
            reason = signal.Signals(stopping.number).name if stopping.number else _words(error)
            stream.end(InputError(f"interrupted by {reason}. The stream ends at 0 V"))
        stopping.is_over = True
        try:
            if len(last := stream.close()):
                write(last)
                stream.blocks.append(last)
        except BaseException as error:  # noqa: BLE001 - joined to the exception that came before it
            ended = ended or error
            ended.add_note(f"The output was not brought to 0 V by the ramp: {_words(error)}")
        if ended is None and stopping.number:
            ended = stopping.error()
        if ended is not None:
            raise ended


def _blocks(
    stream: TextureStream,
    moves: Iterable[tuple[ArrayLike, float]],
    write: Callable[[Real], object],
    stopping: Stopping,
) -> None:
    """Render and write block after block; a block that is not written does not count as rendered."""
    following = iter(moves)
    while True:
        stopping.may_raise = True
        try:
            stopping.check()
            position, time = next(following)
        except StopIteration:
            return
        finally:
            stopping.may_raise = False
        before = replace(stream.state)
        try:
            block = stream.render(position, time)
            write(block)
        except BaseException:
            stream.state = before
            raise
        stream.blocks.append(block)


def _words(error: BaseException) -> str:
    return f"{type(error).__name__}: {error}" if str(error) else type(error).__name__


def added_friction(texture: Texture, position: Real, velocity: Real, plate: RenderingPlate) -> Real:
    """Return the added friction of a texture, which is given copies; NaN where the model returned NaN or infinity."""
    kind = type(texture)
    try:
        found: Any = texture.added_friction(position.copy(), velocity.copy(), plate)
        force = np.asarray(found)
    except Exception as error:
        raise failed(kind, kind.added_friction, error) from error
    is_real = force.dtype.kind in "buif"
    if not is_real or force.shape != (len(position),):
        what = f"an array of shape {force.shape}" if is_real else shortened(repr(found), 40)
        why = f"returns {what}, and an array of real numbers, one force for each position, is needed"
        raise at_line(kind, kind.added_friction, why)
    force = force.astype(float)
    force[~np.isfinite(force)] = np.nan
    return force
