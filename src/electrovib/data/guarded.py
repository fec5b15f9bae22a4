"""Readers of foreign binary formats, run in a separate process with limits on time and memory."""

from __future__ import annotations

import json
import math
import os
import struct
import subprocess
import sys
import threading
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Self

import numpy as np

from electrovib.core.budget import ONE_THREAD, content_allowed, megabytes, memory_allowed
from electrovib.core.errors import DataFileError, NoColumnError, Problem
from electrovib.data.faults import check_file, damaged, packed

if TYPE_CHECKING:
    from collections.abc import Iterator
    from types import TracebackType
    from typing import IO

_CHILD: Final = Path(__file__).with_name("guarded_child.py")
_KINDS: Final = "fiucb"
_ADVICE: Final = "Copy it again from where it was made, or export it there as .csv."


@dataclass(frozen=True, kw_only=True)
class ReaderLimits:
    """Resources that a reader may use: memory beyond its libraries [bytes], content [bytes] that it returns, times [s]."""

    memory: int
    content: int
    processor_time: float
    waiting_time: float

    @classmethod
    def for_file(cls, path: Path) -> ReaderLimits:
        """Return the limits for the size of a file: processor time 3 s and 1 s per 10 MB, elapsed time ten times that."""
        size = path.stat().st_size
        seconds = 3 + size / 10e6
        return cls(
            memory=memory_allowed(size),
            content=content_allowed(size),
            processor_time=seconds,
            waiting_time=10 * seconds,
        )


@dataclass(frozen=True)
class Reader:
    """A reader, named so that another process can import it.

    `function` is ``"module:name"`` of a generator that takes the path and further arguments by name, and
    yields pairs of a name, or a tuple of numbers and texts, and an array or JSON content; it may raise
    DataFileError with a sentence for the user. The modules `needs` are loaded before the memory is limited.
    `format_name` is for messages: ``"a netCDF file"``.
    """

    function: str
    needs: tuple[str, ...]
    format_name: str


class GuardedReading:
    """A file that another process reads; to be used in a ``with`` statement, at whose end the process is ended.

    The reader starts at once, so that the caller can continue before it requests the content. Without
    `limits` those for the size of the file hold; `arguments` of the reader are anything that JSON can hold.
    """

    def __init__(
        self, reader: Reader, path: Path, *, limits: ReaderLimits | None = None, **arguments: Any
    ) -> None:
        check_file(path)
        self._reader, self._path = reader, path
        self._limits = limits or ReaderLimits.for_file(path)
        self._late = threading.Event()
        request = {
            "search": [place or os.getcwd() for place in sys.path],  # noqa: PTH109  # a text, as the list has
            "function": reader.function,
            "needs": reader.needs,
            "path": str(path),
            "arguments": arguments,
            "memory": self._limits.memory,
            "processor_time": self._limits.processor_time,
        }
        try:
            self._process = subprocess.Popen(  # noqa: S603  # this interpreter and a file of this package
                [sys.executable, "-P", str(_CHILD)],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                env=os.environ | ONE_THREAD,
                creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0),
            )
        except OSError as error:
            raise DataFileError(f"no process could be started to read it: {error}.", path=path) from None
        self._clock = threading.Timer(self._limits.waiting_time, self._stop_late)
        self._clock.daemon = True
        try:
            self._clock.start()
            self._ask(request)
        except BaseException:
            self.close()
            raise

    def _ask(self, request: dict[str, Any]) -> None:
        assert self._process.stdin is not None
        try:
            with self._process.stdin as stream:
                stream.write(json.dumps(request).encode())
        except OSError:  # it has ended already, which is reported when the content is requested
            pass

    def _stop_late(self) -> None:
        self._late.set()
        self._process.kill()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """End the process, whether or not it has finished."""
        self._clock.cancel()
        self._process.kill()
        if self._process.stdout is not None:
            self._process.stdout.close()
        self._process.wait()

    def stop(self) -> None:
        """Kill the process, from any thread; the thread that waits for its content then meets a `DataFileError`."""
        self._process.kill()

    def content(self) -> dict[Any, Any]:
        """Wait for the reader and return its items; a fault of the file, a limit and a crash are DataFileErrors."""
        return dict(self._items())

    def _items(self) -> Iterator[tuple[Any, Any]]:
        """Iterate over the items that the reader yields, up to its last message."""
        assert self._process.stdout is not None
        stream, left = self._process.stdout, self._limits.content
        while True:
            size = struct.unpack("<Q", self._exactly(stream, 8))[0]
            left = self._less(left, size)
            message = json.loads(self._exactly(stream, size))
            if "end" in message:
                return
            self._check(message)
            value = message.get("value")
            if "dtype" in message:
                kind, shape = np.dtype(message["dtype"]), tuple(map(int, message["shape"]))
                left = self._less(left, math.prod(shape) * kind.itemsize)
                value = np.empty(shape, kind)
                self._fill(stream, value)
            name = message["name"]
            yield tuple(name) if isinstance(name, list) else name, value

    def _less(self, left: int, size: int) -> int:
        if size > left:
            raise self._too_much()
        return left - size

    def _check(self, message: dict[str, Any]) -> None:
        if "problems" in message:
            problems = [Problem(**problem) for problem in message["problems"]]
            missing = message["column"]
            raise DataFileError(problems) if missing is None else NoColumnError(problems, column=missing)
        if "memory" in message:
            raise self._too_much()
        if "damaged" in message:
            raise damaged(self._path, self._reader.format_name, ValueError(message["damaged"]))
        if np.dtype(message.get("dtype", float)).kind not in _KINDS:
            raise damaged(self._path, self._reader.format_name, ValueError("it holds no numbers"))

    def _exactly(self, stream: IO[bytes], size: int) -> bytes:
        raw = stream.read(size)
        if len(raw) < size:
            raise self._ended()
        return raw

    def _fill(self, stream: IO[bytes], array: np.ndarray[Any, Any]) -> None:
        place = array.reshape(-1).view(np.uint8).data if array.size else memoryview(b"")
        while place:
            count = stream.readinto(place)  # type: ignore[attr-defined]  # a buffered reader has it
            if not count:
                raise self._ended()
            place = place[count:]

    def _too_much(self) -> DataFileError:
        content, size = megabytes(self._limits.content), megabytes(self._path.stat().st_size)
        return packed(self._path, f"{size} would unfold to more than {content}")

    def _ended(self) -> DataFileError:
        """Return the error of a process that ended without a last message."""
        code = self._process.wait()
        if self._late.is_set():
            why = f"reading it took more than {self._limits.waiting_time:.0f} s and was stopped."
        elif code in _stopped_by("SIGXCPU", "SIGKILL"):
            why = (
                f"is damaged: reading it did not end within {self._limits.processor_time:.0f} s of computing."
            )
        else:
            why = f"is damaged or not {self._reader.format_name}: its reader crashed (exit code {code})."
        return DataFileError(f"{why} {_ADVICE}", path=self._path)


def _stopped_by(*names: str) -> set[int]:
    """Return the exit codes of a process ended by one of these signals, as far as the system has them."""
    import signal

    return {-getattr(signal, name) for name in names if hasattr(signal, name)}


def read_guarded(
    reader: Reader, path: Path, *, limits: ReaderLimits | None = None, **arguments: Any
) -> dict[Any, Any]:
    """Read a file in a separate process, and wait for it."""
    with GuardedReading(reader, path, limits=limits, **arguments) as reading:
        return reading.content()
