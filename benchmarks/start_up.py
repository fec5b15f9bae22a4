"""Wall time of a run at the command line compared with importing its libraries.

Run from the root of the repository with ``python -m benchmarks.start_up``.
"""

import subprocess
import sys
import tempfile
from pathlib import Path
from statistics import median, quantiles
from time import perf_counter

from benchmarks.table import surroundings, write

ROUNDS = 11
LIBRARIES = "import numpy, xarray, h5netcdf, h5py, scipy.optimize"


def commands(folder: Path) -> dict[str, list[str]]:
    """Return the command lines to compare; the last one is the reference for the ratios."""
    return {
        "python, nothing imported": [sys.executable, "-c", "pass"],
        "electrovib --help": [sys.executable, "-m", "electrovib", "--help"],
        "electrovib run -o out.nc": [sys.executable, "-m", "electrovib", "run", "-o", str(folder / "out.nc")],
        f"python -c '{LIBRARIES}'": [sys.executable, "-c", LIBRARIES],
    }


def wall_time(command: list[str], folder: Path) -> float:
    """Return the wall time of one fresh process [s]."""
    (folder / "out.nc").unlink(missing_ok=True)
    begin = perf_counter()
    answer = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    time = perf_counter() - begin
    if answer.returncode:
        sys.exit(f"{' '.join(command)} failed:\n{answer.stderr}")
    return time


def main() -> None:
    """Run all commands in turn, several rounds after one unmeasured round, and write the table."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        lines = commands(folder)
        times: dict[str, list[float]] = {title: [] for title in lines}
        for measured in [False] + [True] * ROUNDS:
            for title, command in lines.items():
                time = wall_time(command, folder)
                if measured:
                    times[title].append(time)
    unit = median(times[list(lines)[-1]])
    rows = [[f"`{title}`", *_numbers(found, unit)] for title, found in times.items()]
    write("start_up.md", "Start-up", _notes(), ["command", "time, ms", "middle half, ms", "ratio"], rows)


def _numbers(found: list[float], unit: float) -> list[str]:
    """Return the median, the quartiles, and the median as a multiple of ``unit``."""
    low, _, high = quantiles(found, n=4)
    return [
        f"{median(found) * 1e3:.0f}",
        f"{low * 1e3:.0f} to {high * 1e3:.0f}",
        f"{median(found) / unit:.2f}",
    ]


def _notes() -> list[str]:
    measure = f"""Fresh processes in turn, {ROUNDS} rounds after one unmeasured round, median wall time, files in the cache
of the operating system. The ratio is to the time of importing the libraries that a run needs."""
    return [measure, surroundings(["numpy", "xarray", "h5netcdf", "h5py", "scipy"])]


if __name__ == "__main__":
    main()
