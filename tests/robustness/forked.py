"""Guarded readers in a forked process: the limits of the guarded one, without the time that a new interpreter takes."""

import faulthandler
import importlib
import os
import pickle
import resource
import warnings
from pathlib import Path

from electrovib.core.errors import DataFileError, InputError
from electrovib.data.guarded import DAMAGE, ReaderLimits, damaged


def read_forked(reader, path, *, limits=None, **arguments):
    """Return the items of a reader, as `electrovib.data.guarded.read_guarded`; a crash is an error of the file."""
    module, _, name = reader.function.partition(":")
    function = getattr(importlib.import_module(module), name)
    for needed in reader.needs:
        importlib.import_module(needed)
    allowed = limits or ReaderLimits.for_file(path)
    receive, send = os.pipe()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of threads, which the child does not use
        child = os.fork()
    if not child:
        status = 3
        try:
            os.close(receive)
            with os.fdopen(send, "wb") as answers:
                pickle.dump(_answer(function, path, arguments, allowed), answers)
            status = 0
        finally:
            os._exit(status)
    os.close(send)
    with os.fdopen(receive, "rb") as answers:
        raw = answers.read()
    status = os.waitpid(child, 0)[1]
    if status:
        raise DataFileError(f"is damaged: its reader crashed ({status}).", path=path)
    found = pickle.loads(raw)
    if isinstance(found, list):
        raise DataFileError(found)
    return found


def _answer(function, path, arguments, allowed):
    faulthandler.disable()  # a crash of the library is expected
    used = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (used + allowed.memory, resource.getrlimit(resource.RLIMIT_AS)[1]))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    warnings.simplefilter("ignore")  # which nobody sees
    try:
        return dict(function(path, **arguments))
    except InputError as error:
        return [str(problem) for problem in error.problems]
    except MemoryError:
        return [f"{path}: is damaged, or packed too tightly"]
    except DAMAGE as error:
        return [str(each) for each in damaged(path, "a MATLAB file", ValueError(str(error))).problems]
