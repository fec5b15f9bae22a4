"""The process in which a foreign binary file is read; it is run by its path and receives a request on standard input.

It returns on standard output JSON messages, each preceded by its length, and arrays as plain bytes; nothing is unpickled
on either side.
"""

from __future__ import annotations

import importlib
import json
import os
import signal
import struct
import sys
from pathlib import Path
from typing import IO, Any

_BLOCK = 1 << 20


def main() -> None:
    """Read the file that the request names."""
    signal.signal(
        signal.SIGINT, signal.SIG_DFL
    )  # Ctrl-C reaches the whole group: end at once, without a message
    request = json.load(sys.stdin.buffer)
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # output printed by a library must not mix with the answers
    sys.path[:] = request["search"]
    module, _, name = request["function"].partition(":")
    function = getattr(importlib.import_module(module), name)
    for needed in (*request["needs"], "electrovib.data.registry"):
        importlib.import_module(needed)
    limit(memory=request["memory"], processor_time=request["processor_time"])
    answer(answers, function, request)
    answers.flush()
    os._exit(0)  # no clean-up of libraries that a damaged file may have upset


def answer(answers: IO[bytes], function: Any, request: dict[str, Any]) -> None:
    """Send the items of the reader, or the fault that it found."""
    from electrovib.core.errors import InputError

    try:
        for name, value in function(Path(request["path"]), **request["arguments"]):
            send(answers, name, value)
        last: dict[str, Any] = {"end": True}
    except InputError as error:
        parts = ("reason", "path", "value")
        last = {"problems": [{part: getattr(problem, part) for part in parts} for problem in error.problems]}
        last["column"] = getattr(error, "column", None)
    except MemoryError:
        last = {"memory": True}
    except Exception as error:  # noqa: BLE001  # packages have many kinds, of which none derives from a common one
        last = {"damaged": str(error) or type(error).__name__}
    write(answers, last)


def send(answers: IO[bytes], name: str, value: Any) -> None:
    """Send one item: an array as its bytes in memory, anything else as JSON."""
    import numpy as np

    if not isinstance(value, np.ndarray):
        write(answers, {"name": name, "value": value})
        return
    write(answers, {"name": name, "dtype": value.dtype.str, "shape": value.shape})
    flat = np.ascontiguousarray(value).reshape(-1).view(np.uint8)
    for start in range(0, len(flat), _BLOCK):
        answers.write(flat[start : start + _BLOCK].data)


def write(answers: IO[bytes], message: dict[str, Any]) -> None:
    """Send a JSON message, preceded by its length."""
    raw = json.dumps(message).encode()
    answers.write(struct.pack("<Q", len(raw)) + raw)


def limit(*, memory: int, processor_time: float) -> None:
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
        try:
            resource.setrlimit(kind, (value if hard < 0 else min(value, hard), hard))
        except (OSError, ValueError):
            continue


if __name__ == "__main__":
    main()
