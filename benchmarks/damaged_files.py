"""Damage files of every format at random and open them through the public functions.

    python benchmarks/damaged_files.py 2000 --seed 7 --kinds trace.nc,columns.csv

Each file has to be read or refused in one sentence, without another exception, without a crash of this process, within
ten times the size of the file plus 64 MB of memory, and within the time limits of its reader. The exit code is 1 otherwise.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
import time
import traceback
from pathlib import Path

import h5py
import numpy as np
import scipy.io
import xarray

from electrovib.core.errors import InputError
from electrovib.core.samples import Samples
from electrovib.core.signals import make_trace
from electrovib.data.registry import read_columns
from electrovib.data.traces import open_if_trace, save_mat, save_nc
from electrovib.scenario import read_scenario, sweep_of

TIME, VOLTAGE = np.arange(40) * 1e-3, np.sin(np.arange(40.0)) * 100
BY_NAME = {"t": ("time", "s"), "v": ("voltage", "V")}
BY_NUMBER = {"t": (0, "s"), "v": (1, "V")}
BY_FIELD = {"t": ("record[0]", "s"), "v": ("trial.force", "V")}
NATIVE = ("trace.nc", "columns.nc", "classic.nc", "new.mat")
SCENARIO = """schema = 1
drive = { model = DRIVE }
force = { model = "Vezzoli2014Causal" }
friction = { model = "Coulomb", coefficient = 0.5 }
contact = { model = "FixedArea", area = "1 cm2" }
[load]
normal_force = "0.5 N"
[circuit]
return_path = { model = "Grounded", resistance = "1 kohm" }
[time]
duration = "100 ms"
samples = 100
[stack.insulator]
thickness = "90 um"
material = { model = "Constant", permittivity = 3.35 }
[stack.stratum_corneum]
thickness = "200 um"
material = { model = "Constant", permittivity = 1560, conductivity = "1.79 uS/m" }
"""
LONGEST = 40.0
"""Wall time allowed for a small file in its own process [s], with a margin for a busy machine."""


def small_trace():
    scenario = read_scenario("vezzoli_2014/fig6").to_json()
    return make_trace(
        {
            "field": (("layer", "time"), np.outer([1.0, 2, 3], VOLTAGE)),
            "drive_voltage": (("time",), VOLTAGE),
            "impedance": (("frequency",), [1 + 2j, 3j]),
        },
        {"time": TIME, "frequency": [1.0, 10], "layer": ["insulator", "gap", "stratum_corneum"]},
        {"scenario": scenario, "over": json.dumps({"drive.rise": [1e-3, 2e-3]}), "steps": 3, "tau": 0.1},
    )


def make_files(folder):
    """Write one undamaged file of each kind; return how each is opened."""
    trace = small_trace()
    save_nc(trace, folder / "trace.nc")
    save_mat(trace, folder / "trace.mat")
    measured = xarray.Dataset(
        {"voltage": ("time", VOLTAGE, {"units": "V"})}, {"time": ("time", TIME, {"units": "s"})}
    )
    measured.to_netcdf(folder / "columns.nc", engine="h5netcdf", encoding={"voltage": {"zlib": True}})
    measured.to_netcdf(folder / "classic.nc", engine="scipy")
    rows = "".join(f"{t},{v}\n" for t, v in zip(TIME, VOLTAGE, strict=True))
    (folder / "columns.csv").write_text("# a record\ntime [s],voltage [V]\n" + rows)
    (folder / "blanks.txt").write_text(rows.replace(",", "  "))
    (folder / "wide.tsv").write_bytes(("time (s)\tvoltage [V]\n" + rows.replace(",", "\t")).encode("utf-16"))
    np.save(folder / "columns.npy", np.array([TIME, VOLTAGE]).T)
    fields = np.zeros(len(TIME), [("time", "f8"), ("voltage", "f4")])
    np.save(folder / "fields.npy", fields)
    content = {"record": np.array([TIME, VOLTAGE]).T, "trial": {"force": VOLTAGE}, "note": "x"}
    scipy.io.savemat(folder / "packed.mat", content, do_compression=True)
    scipy.io.savemat(folder / "plain.mat", content)
    with h5py.File(folder / "new.mat", "w", userblock_size=512) as file:
        file.create_dataset("record", data=np.array([TIME, VOLTAGE]), compression="gzip")
        file["record"].attrs["MATLAB_class"] = np.bytes_("double")
        file.create_group("trial").attrs["MATLAB_class"] = np.bytes_("struct")
        file["trial/force"] = VOLTAGE[None]
        file["trial/force"].attrs["MATLAB_class"] = np.bytes_("double")
    whole = (folder / "new.mat").read_bytes()
    (folder / "new.mat").write_bytes(b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM" + whole[128:])
    packed = f'time_samples = "{Samples(TIME).packed()}", voltage_samples = "{Samples(VOLTAGE).packed()}"'
    (folder / "scenario.toml").write_text(SCENARIO.replace("DRIVE", f'"Sampled", {packed}'))
    (folder / "plain.toml").write_text(
        SCENARIO.replace("DRIVE", '"Sine", amplitude = "100 V", frequency = 200')
    )
    opened = dict.fromkeys(("columns.nc", "classic.nc", "columns.csv", "wide.tsv", "fields.npy"), BY_NAME)
    opened |= dict.fromkeys(("blanks.txt", "columns.npy"), BY_NUMBER)
    opened |= dict.fromkeys(("packed.mat", "plain.mat", "new.mat"), BY_FIELD)
    return opened | dict.fromkeys(("trace.nc", "trace.mat", "scenario.toml", "plain.toml"))


def damaged(raw, random):
    """Return bytes with one to three changes, as by transfers, editors and forgery."""
    found = bytearray(raw)
    for _ in range(int(random.choice([1, 1, 1, 2, 3]))):
        place = int(random.integers(0, max(1, len(found))))
        size = int(random.integers(1, 1 + int(random.choice([1, 1, 4, 8, 64, 1024]))))
        match int(random.integers(0, 9)):
            case 0 | 1:
                if found:
                    found[place] ^= 1 << int(random.integers(0, 8))
            case 2:
                found[place : place + size] = random.bytes(size)
            case 3:
                del found[place : place + size]
            case 4:
                found[place:place] = found[place : place + size]
            case 5:
                del found[place:]
            case 6:
                found[place : place + size] = bytes([int(random.choice([0, 255, 127, 128]))]) * size
            case 7:
                number = int(random.choice([-1, 0, 1, 2**31 - 1, 2**31, 2**40, 2**62, 3 * 10**8]))
                width = int(random.choice([2, 4, 8]))
                found[place : place + width] = (number % 256**width).to_bytes(width, "little")
            case _:
                text = str(
                    random.choice(["[", "(", '"', "9" * 400, "nan", ",", "\n", "{", "1e999", "-", "é", "\0"])
                )
                found[place:place] = (text * int(random.choice([1, 1, 1, 300]))).encode()
    return bytes(found)


def open_one(path, wanted):
    """Open a file as a user does; return ``read`` or ``refused``."""
    try:
        if wanted is not None:
            read_columns(path, wanted)
        else:
            found = open_if_trace(path)
            read_scenario(found, before_sweep=True)
            if found is not path:
                sweep_of(found)
    except InputError as error:
        if any("\n" in problem.replace(str(path), "") for problem in error.problems):
            raise AssertionError(f"more than one line: {error.problems}") from None
        return "refused"
    return "read"


def memory(who):
    """Return the largest memory so far [bytes]; 0 where the system does not report it."""
    try:
        import resource
    except ImportError:
        return 0
    return resource.getrusage(getattr(resource, who)).ru_maxrss * 1024


def run(kind, wanted, whole, folder, count, seed):
    """Open damaged files of a kind, print the counts, and return the failures."""
    path = folder / f"damaged.{kind}"
    path.write_bytes(whole)
    if open_one(path, wanted) != "read":
        return [f"{kind}: the whole file is refused"]
    before = memory("RUSAGE_SELF"), memory("RUSAGE_CHILDREN")
    counts, wrong, slowest, largest = {"read": 0, "refused": 0}, [], 0.0, 0
    for number in range(count):
        random = np.random.default_rng([seed, number, *kind.encode()])
        path.write_bytes(raw := damaged(whole, random))
        largest = max(largest, len(raw))
        begin = time.perf_counter()
        try:
            counts[open_one(path, wanted)] += 1
        except Exception:  # noqa: BLE001  # any exception is a failure to report
            wrong.append(f"{kind} seed {seed} number {number}: {traceback.format_exc(limit=-3)}")
        slowest = max(slowest, time.perf_counter() - begin)
    grown = max(memory("RUSAGE_SELF") - before[0], memory("RUSAGE_CHILDREN") - before[1])
    if grown > 10 * largest + 64 * 1024**2:
        wrong.append(f"{kind} seed {seed}: memory grew by {grown / 1e6:.0f} MB")
    if slowest > LONGEST:
        wrong.append(f"{kind} seed {seed}: one file took {slowest:.0f} s")
    print(
        f"{kind:14} {count:6} files: {counts['read']:6} read, {counts['refused']:6} refused, slowest {slowest:6.2f} s,"
        f" memory {grown / 1e6:+6.1f} MB",
        flush=True,
    )
    return wrong


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("count", type=int, help="files of each kind")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--kinds", default="", help="names as printed, with commas; all if not given")
    given = parser.parse_args()
    wrong = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        kinds = make_files(folder)
        open_one(
            folder / "columns.nc", kinds["columns.nc"]
        )  # the memory of a reading process counts for no file
        chosen = given.kinds.split(",") if given.kinds else list(kinds)
        for kind in chosen:
            whole = (folder / kind).read_bytes()
            wrong += run(kind, kinds[kind], whole, folder, given.count, given.seed)
    print("\n".join(wrong[:20]))
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
