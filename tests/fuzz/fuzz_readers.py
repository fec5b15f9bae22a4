"""Fuzz one reader of files of instruments with atheris, guided by coverage.

    pip install atheris
    python tests/fuzz/fuzz_readers.py text --seconds 300 --corpus /tmp/corpus

Each input has to be read or refused in one sentence, within 5 s of processor time and within ten times its size plus 64 MB of
memory. An input that is not is written to ``fuzz-crash-...`` or ``fuzz-timeout-...`` in the current folder; once mended it
becomes a file of ``tests/fuzz/regressions``, which an ordinary test reads. Readers that run in a guarded process are called in
this one, under the same limit of memory, because coverage is measured here. The HDF5 library does not return from some damaged
files: inputs for it are first read in a forked process with a limit of time, and those that it does not survive are counted and
passed over, because the guarded process ends them for a user.
"""

import argparse
import contextlib
import importlib
import json
import os
import resource
import signal
import sys
import tempfile
import time
from pathlib import Path

FOLDER = Path(__file__).parent
sys.path.insert(0, str(FOLDER.parent / "robustness"))

TARGETS = {
    "text": (".csv", ("preamble.csv", "commas.txt", "wide.tsv", "dates.csv", "steps.csv")),
    "spectrum": (".csv", ("spectrum.csv", "spectra.csv")),
    "tables": (".dta", ("tables.dta",)),
    "touchstone": (".s1p", ("a.s1p", "a.ts")),
    "isf": (".isf", ("a.isf", "words.isf")),
    "spice": (".raw", ("sweep.raw", "words.raw", "wide.raw")),
    "wav": (".wav", ("a.wav",)),
    "numpy": (".npy", ("a.npy",)),
    "matlab": (".mat", ("packed.mat", "plain.mat")),
    "hdf5": (".h5", ("a.h5",)),
    "mat73": (".mat", ("new.mat",)),
    "tdms": (".tdms", ("a.tdms",)),
    "xlsx": (".xlsx", ("a.xlsx", "stored.xlsx")),
    "lecroy": (".trc", ("a.trc",)),
    "scope": (".bin", ("a.trc",)),
    "wfm": (".wfm", ("a.wfm",)),
    "zplot": (".z", ("a.z",)),
}
"""Name of a target to the suffix of its files and to the names of its seeds among `whole_files`."""
NATIVE = ("hdf5", "mat73", "matlab")
"""Targets whose library may not return."""
FOREIGN = ("nptdms", "openpyxl", "RigolWFM", "impedance.preprocessing")
SECONDS = 5.0


def read_in_this_process(reader, path, *, limits=None, **arguments):
    """Call the function of a guarded reader here, with the messages of the guarded process."""
    from electrovib.core.errors import DataFileError
    from electrovib.data import guarded
    from electrovib.data.guarded import damaged

    module, _, name = reader.function.partition(":")
    function = getattr(importlib.import_module(module), name)
    allowed = (limits or guarded.ReaderLimits.for_file(path)).memory
    usual = resource.getrlimit(resource.RLIMIT_AS)
    resource.setrlimit(resource.RLIMIT_AS, (pages(0) + allowed, usual[1]))
    try:
        return dict(function(path, **arguments))
    except DataFileError:
        raise
    except Exception as error:  # noqa: BLE001  # the guarded process reports it as a crash of the reader
        raise damaged(path, reader.format_name, ValueError(str(error))) from None
    finally:
        resource.setrlimit(resource.RLIMIT_AS, usual)


def without_processes():
    """Replace the guarded process of every reader."""
    from electrovib.data import guarded

    original = guarded.read_guarded
    for name, module in list(sys.modules.items()):
        if name.startswith("electrovib.") and getattr(module, "read_guarded", None) is original:
            module.read_guarded = read_in_this_process


def pages(which):
    """Return the address space (0) or the resident memory (1) of this process now [bytes]."""
    return int(Path("/proc/self/statm").read_text().split()[which]) * os.sysconf("SC_PAGE_SIZE")


def peak():
    """Return the largest memory of this process since `forget_peak` [bytes]."""
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(int(line.split()[1]) * 1024 for line in lines if line.startswith("VmHWM:"))


def forget_peak():
    """Begin the largest memory of this process anew, where the kernel allows it."""
    with contextlib.suppress(OSError):
        Path("/proc/self/clear_refs").write_text("5")


def survives(path):
    """Return whether a forked process reads a file within 3 s of processor time, without a signal."""
    child = os.fork()
    if not child:
        for deadly in (signal.SIGSEGV, signal.SIGABRT, signal.SIGBUS, signal.SIGFPE, signal.SIGILL):
            signal.signal(deadly, signal.SIG_DFL)  # libFuzzer's handlers end with a status, and write a file
        resource.setrlimit(resource.RLIMIT_CPU, (3, 3))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        try:
            from damaged_records import read_damaged

            read_damaged(path)
        finally:
            os._exit(0)  # whatever Python raises is met again in the process that measures coverage
    end = time.monotonic() + 60
    while time.monotonic() < end:
        done, status = os.waitpid(child, os.WNOHANG)
        if done:
            return os.waitstatus_to_exitcode(status) == 0
        time.sleep(1e-3)
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    return False


def check_native(path, raw, ended):
    """Check one input that a forked process survives; count and keep the others."""
    path.write_bytes(raw)
    if survives(path):
        check(path, raw)
        return
    ended.append(raw)
    Path(f"fuzz-ended-{len(ended)}{path.suffix}").write_bytes(raw)
    print(json.dumps({"ended in the guarded process": len(ended)}), flush=True)


def check(path, raw):
    """Read one input, and fail if it takes too long or too much memory.

    An input that took too much is read a second time: what a library loads on its first use is no memory of an input.
    """
    path.write_bytes(raw)
    allowed = 10 * len(raw) + 64 * 1024**2
    if all(memory_of_reading(path, raw) > allowed for _ in range(2)):
        raise AssertionError(f"more than {allowed / 1e6:.0f} MB for {len(raw)} bytes")


def memory_of_reading(path, raw):
    """Return by how much the memory of this process grew at most while it read a file [bytes]."""
    from damaged_records import read_damaged

    forget_peak()
    before, highest, begin = pages(1), peak(), time.process_time()
    with contextlib.suppress(NotImplementedError):
        read_damaged(path)
    spent = time.process_time() - begin
    if spent > SECONDS:
        raise AssertionError(f"{spent:.1f} s of processor time for {len(raw)} bytes")
    return peak() - before if peak() > highest else 0


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("target", choices=sorted(TARGETS), nargs="?")
    parser.add_argument("--list", action="store_true", help="print the names of the targets, and stop")
    for name, default, words in (
        ("seconds", 300, "duration [s]"),
        ("runs", -1, "inputs to try at most; as many as the duration allows"),
        ("seed", 0, "seed of the random changes; 0 for another one each time"),
        ("corpus", "", "folder that keeps the inputs found; a temporary one if not given"),
        ("seeds", "", "folder of further files to begin with"),
        ("longest", 1 << 16, "longest input [bytes]"),
    ):
        parser.add_argument(f"--{name}", type=type(default), default=default, help=words)
    given = parser.parse_args()
    if given.list or given.target is None:
        print(*TARGETS, sep="\n")
        return

    import atheris

    with atheris.instrument_imports(include=["electrovib.data", "electrovib.recordings", *FOREIGN]):
        for name in ("electrovib.data.registry", "electrovib.recordings.importing.import_file", *FOREIGN):
            with contextlib.suppress(ImportError):
                importlib.import_module(name)
    import scipy.io  # noqa: F401  # loaded before memory is measured
    from damaged_records import whole_files

    without_processes()
    suffix, seeds = TARGETS[given.target]
    whole = whole_files()
    with tempfile.TemporaryDirectory() as scratch:
        corpus = Path(given.corpus or f"{scratch}/corpus")
        corpus.mkdir(parents=True, exist_ok=True)
        for name in seeds:
            (corpus / name).write_bytes(whole[name])
        further = Path(given.seeds).iterdir() if given.seeds else ()
        for seed in (*(FOLDER / "regressions").glob(f"*{suffix}"), *further):
            (corpus / seed.name).write_bytes(seed.read_bytes())
        path = Path(scratch) / f"input{suffix}"
        for known in corpus.iterdir():
            check(path, known.read_bytes())  # what libraries load on first use is no memory of an input
        print(json.dumps({"target": given.target, "seeds": len(list(corpus.iterdir()))}), flush=True)
        options = [
            sys.argv[0], str(corpus), f"-max_total_time={given.seconds}", f"-runs={given.runs}", f"-seed={given.seed}",
            f"-max_len={given.longest}", "-timeout=60",
            "-rss_limit_mb=4096", "-artifact_prefix=fuzz-", "-print_final_stats=1", "-verbosity=1", "-close_fd_mask=0",
        ]  # fmt: skip
        ended = []
        native = given.target in NATIVE
        one = (lambda raw: check_native(path, raw, ended)) if native else (lambda raw: check(path, raw))
        atheris.Setup(options, one, enable_python_coverage=True)
        atheris.Fuzz()


if __name__ == "__main__":
    main()
