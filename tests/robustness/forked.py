"""Guarded readers in a forked process: the limits of the guarded one, without the time that a new interpreter takes."""

import faulthandler
import importlib
import math
import multiprocessing
import resource
import time
import warnings
from contextlib import suppress
from pathlib import Path

import numpy as np

from electrovib.core.errors import DataFileError, InputError, NoColumnError, Problem
from electrovib.data.guarded import ReaderLimits, damaged, packed

PROCESS = []
"""The process that reads, and this end of the pipe to it; none before the first file and after a crash."""


def read_forked(reader, path, *, limits=None, **arguments):
    """Return the items of a reader, as `electrovib.data.guarded.read_guarded`; a crash is an error of the file."""
    if not PROCESS:
        context = multiprocessing.get_context("fork")
        ours, theirs = context.Pipe()
        PROCESS[:] = context.Process(target=_serve, args=(theirs, ours), daemon=True), ours
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of threads, which the child does not use
            PROCESS[0].start()
        theirs.close()
    process, pipe = PROCESS
    pipe.send((reader, path, arguments, limits or ReaderLimits.for_file(path)))
    try:
        found = pipe.recv()
    except EOFError:
        process.join()
        PROCESS.clear()
        raise DataFileError(
            f"is damaged: its reader crashed (exit code {process.exitcode}).", path=path
        ) from None
    if isinstance(found, dict):
        return found
    problems, column = [Problem(**each) for each in found[0]], found[1]
    raise DataFileError(problems) if column is None else NoColumnError(problems, column=column)


def _serve(pipe, other):
    other.close()  # of the tests, so that this process ends with them
    faulthandler.disable()  # a crash of the library is expected
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    warnings.simplefilter("ignore")  # which nobody sees
    with suppress(EOFError):
        while True:
            pipe.send(_answer(*pipe.recv()))


def _answer(reader, path, arguments, allowed):
    """Return the items, or what the error of the file is made of."""
    module, _, name = reader.function.partition(":")
    for needed in reader.needs:
        importlib.import_module(needed)
    used = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0]) * resource.getpagesize()
    seconds = math.ceil(time.process_time() + allowed.processor_time) + 1
    for kind, value in ((resource.RLIMIT_AS, used + allowed.memory), (resource.RLIMIT_CPU, seconds)):
        resource.setrlimit(kind, (value, resource.getrlimit(kind)[1]))
    try:
        found = dict(getattr(importlib.import_module(module), name)(path, **arguments))
    except InputError as error:
        return _told(error)
    except MemoryError:
        return _told(packed(path, "its content does not fit into memory"))
    except Exception as error:  # noqa: BLE001  # as the guarded process
        return _told(damaged(path, reader.format_name, ValueError(str(error) or type(error).__name__)))
    size = sum(each.nbytes for each in found.values() if isinstance(each, np.ndarray))
    return _told(packed(path, "its content is too large")) if size > allowed.content else found


def _told(error):
    """Return what an error is made of again, with the column that a file has not."""
    parts = ("reason", "path", "value")
    problems = [{part: getattr(each, part) for part in parts} for each in error.problems]
    return problems, getattr(error, "column", None)
