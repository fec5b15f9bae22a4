"""Time of the command line compared with importing the libraries of a run.

Run from the root of the repository with ``python -m benchmarks.start_up``, with all extras installed.
"""

import resource
import subprocess
import sys
import tempfile
from pathlib import Path
from time import perf_counter

from benchmarks.table import surroundings, write

ROUNDS = 9
LIBRARIES = "import numpy, xarray, h5netcdf"
COMMANDS = {
    "python, nothing imported": ("-c", "pass"),
    "python -c 'import electrovib'": ("-c", "import electrovib"),
    "electrovib --help": ("-m", "electrovib", "--help"),
    "electrovib list": ("-m", "electrovib", "list"),
    "electrovib list parylene": ("-m", "electrovib", "list", "parylene"),
    "electrovib run vezzoli_2014/fig6": ("-m", "electrovib", "run", "vezzoli_2014/fig6"),
    "electrovib run vezzoli_2014/fig6 -o out.nc": (
        "-m",
        "electrovib",
        "run",
        "vezzoli_2014/fig6",
        "-o",
        "out.nc",
    ),
    f"python -c '{LIBRARIES}'": ("-c", LIBRARIES),
}
"""What is timed; the last one is the reference for the ratios."""
WANTED = {"electrovib list": 0.8, "electrovib run vezzoli_2014/fig6": 1.6}
"""Largest ratios."""


def processor_time() -> float:
    """Return the time that ended processes have computed, in programs and in the operating system [s]."""
    spent = resource.getrusage(resource.RUSAGE_CHILDREN)
    return spent.ru_utime + spent.ru_stime


def times(command: tuple[str, ...], folder: Path) -> tuple[float, float]:
    """Return processor time and wall time of one fresh process [s]."""
    (folder / "out.nc").unlink(missing_ok=True)
    begin, before = perf_counter(), processor_time()
    answer = subprocess.run(
        [sys.executable, *command], cwd=folder, capture_output=True, text=True, check=False
    )
    found = processor_time() - before, perf_counter() - begin
    if answer.returncode:
        sys.exit(f"{' '.join(command)} failed:\n{answer.stderr}")
    return found


def main() -> None:
    """Run all commands in turn, several rounds after one unmeasured round, and write the table."""
    found: dict[str, list[tuple[float, float]]] = {title: [] for title in COMMANDS}
    with tempfile.TemporaryDirectory() as name:
        for measured in [False] + [True] * ROUNDS:
            for title, command in COMMANDS.items():
                both = times(command, Path(name))
                if measured:
                    found[title].append(both)
    best = {title: [min(each) for each in zip(*both, strict=True)] for title, both in found.items()}
    unit = best[list(COMMANDS)[-1]]
    rows = [
        [
            f"`{title}`",
            *(f"{each * 1e3:.0f}" for each in both),
            f"{both[0] / unit[0]:.2f}",
            f"{both[1] / unit[1]:.2f}",
            str(WANTED.get(title, "")),
        ]
        for title, both in best.items()
    ]
    heads = ["command", "processor, ms", "wall, ms", "ratio, processor", "ratio, wall", "wanted, at most"]
    write("start_up.md", "Start-up", _notes(), heads, rows)


def _notes() -> list[str]:
    measure = f"""Fresh processes in turn, {ROUNDS} rounds after one unmeasured round, the least of each, compiled files and files
in the cache of the operating system; all extras are installed. The ratios are to importing the libraries that a Trace needs."""
    return [measure, surroundings(["numpy", "xarray", "h5netcdf", "pydantic", "typer"])]


if __name__ == "__main__":
    main()
