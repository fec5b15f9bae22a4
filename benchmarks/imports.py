"""Import of large files compared with the libraries that read them: a text of numbers, and a packed netCDF.

Run from the root of the repository with ``python -m benchmarks.imports``, or for a packed file of fewer than 1e8 values with
``python -m benchmarks.imports 1e7``. Each side reads in fresh processes, in turn with the other; libraries and the package are
imported before the time and the memory are measured.
"""

from __future__ import annotations

import json
import resource
import subprocess
import sys
import tempfile
from pathlib import Path
from time import perf_counter

import numpy as np
from benchmarks.table import surroundings, write

ROUNDS = 5
ROWS = 1_000_000
VALUES = 100_000_000
STEP = 1e-5
SIGNALS = {
    "drive_voltage": ("Drive", "V", 100.0),
    "lateral_force": ("Force", "N", 0.3),
    "current": ("Current", "A", 2e-3),
}
PACKED = {**SIGNALS, "normal_force": ("Load", "N", 2.0)}
WANTED = {"text": (1.3, 2.0), "netcdf": (1.2, 2.0)}
"""Largest ratios of time and of memory."""


def wave(amplitude: float, rows: int) -> np.ndarray:
    """Return a sine with noise."""
    noise = np.random.default_rng(1).standard_normal(rows)
    return amplitude * (np.sin(2 * np.pi * 125 * STEP * np.arange(rows)) + 0.01 * noise)


def write_text(path: Path, rows: int) -> None:
    """Write a time and three signals, with units in the headings."""
    import pandas as pd

    columns = {"Time [s]": np.arange(rows) * STEP}
    columns |= {f"{name} [{unit}]": wave(size, rows) for name, unit, size in SIGNALS.values()}
    pd.DataFrame(columns).to_csv(path, index=False, float_format="%.6g")


def write_netcdf(path: Path, values: int) -> None:
    """Write four signals as integers of 16 bits with scale and offset, some missing, over a time of 64 bits."""
    import h5py

    rows = values // len(PACKED)
    with h5py.File(path, "w") as file:
        file["time"] = np.arange(rows) * STEP
        file["time"].make_scale("time")
        file["time"].attrs["units"] = "s"
        for name, unit, size in PACKED.values():
            counts = np.round(wave(size, rows) / (size * 1e-4)).astype("i2")
            counts[::1000] = -32768
            variable = file.create_dataset(name, data=counts)
            variable.dims[0].attach_scale(file["time"])
            variable.attrs.update({"units": unit, "scale_factor": size * 1e-4, "add_offset": 0.0})
            variable.attrs["_FillValue"] = np.int16(-32768)


def ours(path: Path) -> object:
    """Import every signal of a file."""
    from electrovib.recordings.importing.import_file import import_file

    signals = SIGNALS if path.suffix == ".csv" else PACKED
    return import_file(path, {signal: name for signal, (name, _, _) in signals.items()})


def reading(path: Path) -> object:
    """Read every column of a file, without making signals of them."""
    from electrovib.data.registry import read_recorded

    return read_recorded(path)


def peer(path: Path) -> object:
    """Read a file with the library for it alone."""
    if path.suffix == ".csv":
        import pandas as pd

        return pd.read_csv(path)
    import xarray

    return xarray.open_dataset(path, engine="h5netcdf").load()


SIDES = {"import": ours, "reading": reading, "peer": peer}


def memory() -> int:
    """Return the most memory that this process or one that it has started has held [B]."""
    return 1024 * max(
        resource.getrusage(who).ru_maxrss for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    )


def one(side: str, path: Path, small: Path) -> None:
    """Read a file in this process, after a small one that has everything imported; print time [s] and memory [B]."""
    read = SIDES[side]
    read(small)
    before = memory()
    begin = perf_counter()
    found = read(path)
    spent = perf_counter() - begin
    print(json.dumps({"time": spent, "memory": memory() - before, "held": found is not None}))


def measured(path: Path, small: Path, rounds: int) -> dict[str, dict[str, float]]:
    """Return the least time and memory of each side, several processes each, in turn."""
    found: dict[str, list[dict[str, float]]] = {side: [] for side in SIDES}
    for _ in range(rounds):
        for side, each in found.items():
            command = [sys.executable, "-m", "benchmarks.imports", side, str(path), str(small)]
            said = subprocess.run(command, check=True, capture_output=True, text=True).stdout
            each.append(json.loads(said.splitlines()[-1]))
    return {side: {key: min(each[key] for each in all_) for key in all_[0]} for side, all_ in found.items()}


def rows_of(kind: str, title: str, found: dict[str, dict[str, float]]) -> list[list[str]]:
    """Return the rows of the table of one kind of file: the import, and the reading that is part of it."""
    peer_ = found["peer"]
    rows = []
    for side, what in (("import", title), ("reading", "of it, the reading of the columns")):
        time, held = (found[side][key] / peer_[key] for key in ("time", "memory"))
        wanted = [str(each) if side == "import" else "" for each in WANTED[kind]]
        cells = [f"{found[side]['time']:.2f}", f"{peer_['time']:.2f}", f"{time:.2f}", wanted[0]]
        cells += [
            f"{found[side]['memory'] / 1e6:.0f}",
            f"{peer_['memory'] / 1e6:.0f}",
            f"{held:.2f}",
            wanted[1],
        ]
        rows.append([what, *cells])
    return rows


def main(values: int = VALUES) -> None:
    """Write both files, measure, and write the table; what a process has held counts for those that it starts."""
    rows = []
    with tempfile.TemporaryDirectory() as name:
        for kind, suffix, size in (("text", ".csv", ROWS), ("netcdf", ".nc", values)):
            large, small = Path(name) / f"large{suffix}", Path(name) / f"small{suffix}"
            for path, count in ((large, size), (small, 400)):
                command = [sys.executable, "-m", "benchmarks.imports", "write", str(path), str(count)]
                subprocess.run(command, check=True)
            titles = {
                "text": f"text of {size:g} rows of 4 columns, pandas.read_csv",
                "netcdf": f"packed netCDF of {size:g} values, xarray.open_dataset(...).load()",
            }
            rows += rows_of(kind, titles[kind], measured(large, small, ROUNDS if size < VALUES else 3))
            large.unlink()
    notes = (
        "Fresh processes in turn, the least of each; memory is what the most that was held exceeds what was held after a small"
        " file of the same kind. `import_file` also checks the samples and takes the checksum of the file.",
        surroundings(("numpy", "pandas", "xarray", "h5netcdf")),
    )
    heads = ["file, peer", "ours, s", "peer, s", "ratio", "wanted, at most", "ours, MB", "peer, MB"]
    write("imports.md", "Import", notes, [*heads, "ratio", "wanted, at most"], rows)


if __name__ == "__main__":
    match sys.argv[1:]:
        case ["write", path, count]:
            (write_text if path.endswith(".csv") else write_netcdf)(Path(path), int(count))
        case [side, path, small]:
            one(side, Path(path), Path(small))
        case given:
            main(round(float(given[0])) if given else VALUES)
