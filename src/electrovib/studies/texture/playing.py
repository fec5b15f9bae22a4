"""Stream of a texture played to its end: whatever raises, the ramp to 0 V is written."""

from __future__ import annotations

import signal
import threading
from contextlib import contextmanager
from typing import TYPE_CHECKING, Final

from electrovib.core.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator
    from types import FrameType

    from numpy.typing import ArrayLike

    from electrovib.core.arrays import Real
    from electrovib.studies.texture.stream import TextureStream

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
        before = stream.state
        try:
            block = stream.render(position, time)
            write(block)
        except BaseException:
            stream.state = before
            raise
        stream.blocks.append(block)


def _words(error: BaseException) -> str:
    return f"{type(error).__name__}: {error}" if str(error) else type(error).__name__
