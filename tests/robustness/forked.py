"""Guarded readers in a forked process: the limits of the guarded one, without the time that a new interpreter takes."""

import faulthandler
import importlib
import multiprocessing
import resource
import warnings
from pathlib import Path

from electrovib.core.errors import DataFileError, InputError
from electrovib.data.guarded import DAMAGE, ReaderLimits, damaged

PROCESS = []
"""The process that reads, and this end of the pipe to it; none before the first file and after a crash."""


def read_forked(reader, path, *, limits=None, **arguments):
    """Return the items of a reader, as `electrovib.data.guarded.read_guarded`; a crash is an error of the file."""
    if not PROCESS:
        context = multiprocessing.get_context("fork")
        ours, theirs = context.Pipe()
        PROCESS[:] = context.Process(target=_serve, args=(theirs,), daemon=True), ours
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
    if isinstance(found, list):
        raise DataFileError(found)
    return found


def _serve(pipe):
    faulthandler.disable()  # a crash of the library is expected
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    warnings.simplefilter("ignore")  # which nobody sees
    while True:
        pipe.send(_answer(*pipe.recv()))


def _answer(reader, path, arguments, allowed):
    module, _, name = reader.function.partition(":")
    for needed in reader.needs:
        importlib.import_module(needed)
    used = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (used + allowed.memory, resource.getrlimit(resource.RLIMIT_AS)[1]))
    try:
        return dict(getattr(importlib.import_module(module), name)(path, **arguments))
    except InputError as error:
        return [str(problem) for problem in error.problems]
    except MemoryError:
        return [f"{path}: is damaged, or packed too tightly"]
    except DAMAGE as error:
        return [str(each) for each in damaged(path, "a MATLAB file", ValueError(str(error))).problems]
