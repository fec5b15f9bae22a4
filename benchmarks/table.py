"""A table of measured times, with the versions and the processor of the measurement."""

import os
import platform
from collections.abc import Callable, Sequence
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from statistics import median
from time import perf_counter

HERE = Path(__file__).parent


def timed(work: Callable[[], object], repeats: int) -> tuple[float, object]:
    """Return the median wall time of several repeats [s] and the last result."""
    times, result = [], None
    for _ in range(repeats):
        result = None  # so that every repeat can reuse the memory of the previous one
        begin = perf_counter()
        result = work()
        times.append(perf_counter() - begin)
    return median(times), result


def surroundings(packages: Sequence[str]) -> str:
    """Return one sentence with versions, processor family and number of cores, without the name of a machine."""
    found = [f"Python {platform.python_version()}"]
    for package in packages:
        try:
            found.append(f"{package} {version(package)}")
        except PackageNotFoundError:
            found.append(f"{package} missing")
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    return f"{', '.join(found)}; {platform.system()} on {platform.machine()}, {cores} cores."


def write(
    name: str, title: str, notes: Sequence[str], head: Sequence[str], rows: Sequence[Sequence[str]]
) -> None:
    """Print a markdown page and write it to the folder of this file."""
    lines = [f"# {title}", ""]
    for note in notes:
        lines += [note, ""]
    lines += ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    lines += ["| " + " | ".join(row) + " |" for row in rows]
    text = "\n".join(lines) + "\n"
    (HERE / name).write_text(text, encoding="utf-8")
    print(text)


def write_page(name: str, title: str, notes: Sequence[str], tables: Sequence[Sequence[object]]) -> None:
    """Print a markdown page with several tables, (title, notes, head, rows) each, and write it to the folder of this file."""
    lines = [f"# {title}", ""]
    for note in notes:
        lines += [note, ""]
    for heading, said, head, rows in tables:
        lines += [f"## {heading}", ""]
        for note in said:
            lines += [note, ""]
        lines += ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
        lines += ["| " + " | ".join(row) + " |" for row in rows]
        lines += [""]
    text = "\n".join(lines).rstrip() + "\n"
    (HERE / name).write_text(text, encoding="utf-8")
    print(text)
