"""Damage files of instruments at random and import them, each reader for a given time.

    python benchmarks/damaged_records.py 60 --seed 7 --kinds a.isf,preamble.csv

Each file has to be imported or refused in one sentence, without another exception, without a crash of this process, and within
ten times the size of the file plus 64 MB of memory. The exit code is 1 otherwise, and the first failing files are kept.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
import traceback
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent / "tests" / "robustness"))
from damaged_files import memory
from damaged_records import mutated, read_damaged, whole_files


def run(name, whole, folder, seconds, seed):
    """Import damaged files of a kind for some time, print the counts, and return the failures."""
    path = folder / name
    path.write_bytes(whole)
    if read_damaged(path) != "read":
        return [f"{name}: the whole file is refused"]
    before = memory("RUSAGE_SELF"), memory("RUSAGE_CHILDREN")
    counts, wrong, number, slowest = {"read": 0, "refused": 0}, [], 0, 0.0
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        path.write_bytes(raw := mutated(whole, np.random.default_rng([seed, number, *name.encode()])))
        begin = time.monotonic()
        try:
            counts[read_damaged(path)] += 1
        except Exception:  # noqa: BLE001  # any exception is a failure to report
            wrong.append(f"{name} seed {seed} number {number}: {traceback.format_exc(limit=-3)}")
            if len(wrong) <= 3:
                Path(f"failed-{number}-{name}").write_bytes(raw)
        slowest = max(slowest, time.monotonic() - begin)
        number += 1
    grown = max(memory("RUSAGE_SELF") - before[0], memory("RUSAGE_CHILDREN") - before[1])
    if grown > 10 * len(whole) + 64 * 1024**2:
        wrong.append(f"{name} seed {seed}: memory grew by {grown / 1e6:.0f} MB")
    print(
        f"{name:14} {number:6} files: {counts['read']:6} read, {counts['refused']:6} refused, {len(wrong):3} failed,"
        f" slowest {slowest:5.2f} s, memory {grown / 1e6:+6.1f} MB",
        flush=True,
    )
    return wrong


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("seconds", type=float, help="time for each kind [s]")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--kinds", default="", help="names as printed, with commas; all if not given")
    given = parser.parse_args()
    files, wrong = whole_files(), []
    with tempfile.TemporaryDirectory() as name:
        for kind in given.kinds.split(",") if given.kinds else files:
            wrong += run(kind, files[kind], Path(name), given.seconds, given.seed)
    print("\n".join(wrong[:20]))
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
