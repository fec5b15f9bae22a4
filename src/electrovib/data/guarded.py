"""Faults of files, one sentence each; readers of HDF5 and MATLAB files in a separate process with limits on time and memory.

Of the libraries that read files these two do not survive damage: HDF5 does not return from some damaged files, and SciPy ends the
interpreter at some of MATLAB's version 5. The process receives a request as JSON on standard input. It returns on standard
output a line of JSON for each item, and behind that of an array its bytes; nothing is unpickled on either side.
"""

from __future__ import annotations

import importlib
import io
import json
import math
import os
import signal
import struct
import subprocess
import sys
import threading
import tokenize
import warnings
import zlib
from contextlib import AbstractContextManager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, TypeVar, cast

import numpy as np

from electrovib.core.budget import ONE_THREAD, content_allowed, megabytes, memory_allowed
from electrovib.core.errors import DataFileError, InputError, NoColumnError, Problem, closest_file
from electrovib.core.file_kinds import foreign, is_address

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping

T = TypeVar("T")
DAMAGE: Final = (
    OSError, RuntimeError, ValueError, LookupError, TypeError, AttributeError, EOFError, MemoryError,
    ArithmeticError, SyntaxError, AssertionError, struct.error, tokenize.TokenError, zlib.error,
)  # fmt: skip
"""Exceptions that the NumPy, SciPy and HDF5 libraries raise for damaged files."""


def check_file(path: Path) -> None:
    """Refuse anything but an ordinary file that is not empty."""
    try:
        if path.is_dir():
            raise DataFileError("is a folder; give the name of a file in it.", path=path)
        if is_address(path):
            raise DataFileError(f"{foreign(path)}.", path=path)
        if not path.exists():
            siblings = [p.name for p in path.parent.iterdir()] if path.parent.is_dir() else []
            raise DataFileError(f"there is no such file.{closest_file(path.name, siblings)}", path=path)
        if not path.is_file():
            raise DataFileError("is not an ordinary file.", path=path)
        with path.open("rb") as file:
            if not file.read(1):
                raise DataFileError("the file is empty.", path=path)
    except (OSError, ValueError) as error:
        raise DataFileError(f"cannot be read: {error}.", path=path) from None


def packed(
    path: Path, what: str, advice: str = "If it is whole, save it without compression."
) -> DataFileError:
    """Return the error for a file that states, or unfolds to, more than one of its size may hold."""
    return DataFileError(f"is damaged, or packed too tightly: {what}. {advice}".rstrip(), path=path)


def damaged(path: Path, what: str, error: BaseException) -> DataFileError:
    """Return the error for a damaged file, with the first line of the message of the library."""
    said = (str(error).splitlines() or [""])[0][:160] or type(error).__name__
    return DataFileError(f"is damaged or not {what} ({said}).", path=path)


def read_by_library(read: Callable[[], T], path: Path, what: str) -> T:
    """Return what a library reads from a file; whatever it raises is a fault of the file."""
    check_file(path)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return read()
    except InputError as error:
        raise error.of_file(path) from None
    except MemoryError:
        raise packed(path, "its content does not fit into memory") from None
    except Exception as error:  # noqa: BLE001  # packages have many kinds, of which none derives from a common one
        raise damaged(path, what, error) from None


_START: Final = (
    "import json, sys; request = json.load(sys.stdin.buffer); sys.path[:] = request['search'];"
    " from electrovib.data.guarded import serve; serve(request)"
)
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


class GuardedReading(AbstractContextManager["GuardedReading"]):
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
        self._is_late = False
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
            self._process = subprocess.Popen(  # noqa: S603  # this interpreter and this module
                [sys.executable, "-P", "-c", _START],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                env=os.environ | ONE_THREAD,
                creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0),
            )
        except OSError as error:
            raise DataFileError(f"no process could be started to read it: {error}.", path=path) from None
        self._input = cast("io.BufferedWriter", self._process.stdin)
        self._output = cast("io.BufferedReader", self._process.stdout)
        self._clock = threading.Timer(self._limits.waiting_time, self._stop_late)
        self._clock.daemon = True
        try:
            self._clock.start()
            with suppress(OSError), self._input:  # if it has ended already, that is reported with the content
                self._input.write(json.dumps(request).encode())
        except BaseException:
            self.__exit__()
            raise

    def _stop_late(self) -> None:
        self._is_late = True
        self._process.kill()

    def __exit__(self, *_: object) -> None:
        self._clock.cancel()
        self._process.kill()
        self._output.close()
        self._process.wait()

    def stop(self) -> None:
        """Kill the process, from any thread; the thread that waits for its content then meets a `DataFileError`."""
        self._process.kill()

    def content(self) -> dict[Any, Any]:
        """Wait for the reader and return its items; a fault of the file, a limit and a crash are DataFileErrors."""
        found: dict[Any, Any] = {}
        left = self._limits.content
        while True:
            line = self._output.readline(left + 1)
            left = self._less(left, len(line))
            if not line.endswith(b"\n"):
                raise self._ended()
            message = json.loads(line)
            if "name" not in message:
                self._refuse(message)
                return found
            value = message.get("value")
            if "dtype" in message:
                kind, shape = np.dtype(message["dtype"]), tuple(map(int, message["shape"]))
                if kind.kind not in _KINDS:
                    raise damaged(self._path, self._reader.format_name, ValueError("it holds no numbers"))
                left = self._less(left, math.prod(shape) * kind.itemsize)
                value = np.empty(shape, kind)
                if self._output.readinto(value.reshape(-1).view(np.uint8).data) < value.nbytes:
                    raise self._ended()
            name = message["name"]
            found[tuple(name) if isinstance(name, list) else name] = value

    def _less(self, left: int, size: int) -> int:
        if size > left:
            raise self._too_much()
        return left - size

    def _refuse(self, last: Mapping[str, Any]) -> None:
        """Refuse the file for the fault that the last message of the reader states, if any."""
        if "problems" in last:
            problems = [Problem(**problem) for problem in last["problems"]]
            missing = last["column"]
            found = DataFileError(problems) if missing is None else NoColumnError(problems, column=missing)
            raise found.of_file(self._path)
        if "memory" in last:
            raise self._too_much()
        if "damaged" in last:
            raise damaged(self._path, self._reader.format_name, ValueError(last["damaged"]))

    def _too_much(self) -> DataFileError:
        content, size = megabytes(self._limits.content), megabytes(self._path.stat().st_size)
        return packed(self._path, f"{size} would unfold to more than {content}")

    def _ended(self) -> DataFileError:
        """Return the error of a process that ended without a last message."""
        code = self._process.wait()
        stopped = {-getattr(signal, name, 0) for name in ("SIGXCPU", "SIGKILL")} - {0}
        if self._is_late:
            why = f"reading it took more than {self._limits.waiting_time:.0f} s and was stopped."
        elif code in stopped:
            why = (
                f"is damaged: reading it did not end within {self._limits.processor_time:.0f} s of computing."
            )
        else:
            why = f"is damaged or not {self._reader.format_name}: its reader crashed (exit code {code})."
        return DataFileError(f"{why} {_ADVICE}", path=self._path)


def read_guarded(
    reader: Reader, path: Path, *, limits: ReaderLimits | None = None, **arguments: Any
) -> dict[Any, Any]:
    """Read a file in a separate process, and wait for it."""
    with GuardedReading(reader, path, limits=limits, **arguments) as reading:
        return reading.content()


def serve(request: Mapping[str, Any]) -> None:
    """Read, in the separate process, the file that a request names, and end this process."""
    signal.signal(
        signal.SIGINT, signal.SIG_DFL
    )  # Ctrl-C reaches the whole group: end at once, without a message
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # output printed by a library must not mix with the answers
    module, _, name = request["function"].partition(":")
    function = getattr(importlib.import_module(module), name)
    for needed in request["needs"]:
        importlib.import_module(needed)
    _limit(memory=request["memory"], processor_time=request["processor_time"])
    answers.writelines(_answers(function, request))
    answers.flush()
    os._exit(0)  # no clean-up of libraries that a damaged file may have upset


def _answers(function: Callable[..., Any], request: Mapping[str, Any]) -> Iterator[Any]:
    """Iterate over the lines and arrays to be sent, of which the last line states the fault that the reader found, if any."""
    try:
        for name, value in function(Path(request["path"]), **request["arguments"]):
            if isinstance(value, np.ndarray):
                yield _line({"name": name, "dtype": value.dtype.str, "shape": value.shape})
                yield np.ascontiguousarray(value).reshape(-1).view(np.uint8).data
            else:
                yield _line({"name": name, "value": value})
        last: dict[str, Any] = {}
    except InputError as error:
        parts = ("reason", "path", "value")
        last = {"problems": [{part: getattr(problem, part) for part in parts} for problem in error.problems]}
        last["column"] = getattr(error, "column", None)
    except MemoryError:
        last = {"memory": True}
    except Exception as error:  # noqa: BLE001  # packages have many kinds, of which none derives from a common one
        last = {"damaged": str(error) or type(error).__name__}
    yield _line(last)


def _line(message: Mapping[str, Any]) -> bytes:
    return json.dumps(message).encode() + b"\n"


def _limit(*, memory: int, processor_time: float) -> None:
    """Limit memory and processor time from here on, as far as the system supports it."""
    try:
        import resource
    except ImportError:  # no such limits here; the clock of the caller remains
        return
    used = resource.getrusage(resource.RUSAGE_SELF)
    seconds = int(used.ru_utime + used.ru_stime + processor_time) + 1
    wanted = {resource.RLIMIT_CORE: 0, resource.RLIMIT_CPU: seconds}
    try:
        pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
        wanted[resource.RLIMIT_AS] = pages * resource.getpagesize() + memory
    except (OSError, ValueError):  # the size so far is not known: room for the libraries
        wanted[resource.RLIMIT_AS] = memory + (1 << 30)
    for kind, value in wanted.items():
        hard = resource.getrlimit(kind)[1]
        with suppress(OSError, ValueError):
            resource.setrlimit(kind, (value if hard < 0 else min(value, hard), hard))
