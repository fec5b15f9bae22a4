"""Question, number and time of each example, taken from the run that made its page."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Final, NamedTuple

from gallery import NUMBERS, QUESTIONS, TABLE
from rst import grid, plain
from sphinx.application import Sphinx

OUTPUT: Final = re.compile(
    r"\.\. rst-class:: sphx-glr-script-out\n\n \.\. code-block:: none\n\n((?:    .*\n|\n)+)"
)
NOTICE: Final = re.compile(r"^    electrovib: simulated: .*\n", re.MULTILINE)
"""Line on the error output of a simulated bench, which every burst writes."""
TIME: Final = re.compile(r"Total running time of the script:\*\* \((\d+) minutes ([\d.]+) seconds\)")
TITLE: Final = re.compile(r"^(.+)\n=+\n", re.MULTILINE)
INTRODUCTION: Final = (
    "Each example is a script or a notebook of the folder ``examples``. A test runs it and asserts a number, and the build of"
    " this site runs it again: the number and the time are those of the build."
)


class Result(NamedTuple):
    """What the page of an example shows."""

    title: str
    number: str
    """Lines that it prints about its question; empty if it was not run."""
    time: str
    """Running time in seconds, with its unit; empty if it was not run."""


def result_of(page: str, name: str) -> Result:
    """Read title, number and time from the page of an example, in reStructuredText."""
    title, output, time = (pattern.search(page) for pattern in (TITLE, OUTPUT, TIME))
    shown = number = ""
    if time and output:
        lines = [line.strip() for line in NOTICE.sub("", output[1]).splitlines() if line.strip()]
        wanted = [next(line for line in lines if line.startswith(each)) for each in NUMBERS.get(name, ())]
        number = "; ".join(wanted or lines[:1])
        seconds = 60 * int(time[1]) + float(time[2])
        shown = f"{seconds:.0f} s" if seconds >= 10 else f"{seconds:.1g} s"
    return Result(title[1] if title else "", number, shown)


def question_of(name: str) -> str:
    """Return the question that an example answers; empty for one that is not listed."""
    return next((names[name] for names in QUESTIONS.values() if name in names), "")


def headed(page: str, name: str) -> str:
    """Return the page of an example with its question, number and time below the title."""
    page = NOTICE.sub("", page)
    found = result_of(page, name)
    pairs = (
        ("Question", plain(question_of(name))),
        ("Number", f"``{found.number}``" if found.number else ""),
        ("Time to run", found.time),
    )
    lines = "\n".join(f":{label}: {text}" for label, text in pairs if text)
    return TITLE.sub(lambda match: f"{match[0]}\n{lines}\n", page, count=1)


def table(folder: Path) -> str:
    """Write the table of all examples, from the pages in the folder of the gallery."""
    rows = []
    for page in sorted(folder.glob("*/*.rst")):
        if page.stem == "index":
            continue
        found = result_of(page.read_text(encoding="utf-8"), page.stem)
        link = f":doc:`{plain(question_of(page.stem) or found.title)} <{page.parent.name}/{page.stem}>`"
        number = f"``{found.number}``" if found.number else "not run in this build"
        rows.append((page, (link, number, found.time)))
    order = [name for names in QUESTIONS.values() for name in names]
    rows.sort(key=lambda row: (row[0].parent.name, order.index(row[0].stem) if row[0].stem in order else 99))
    return f"{INTRODUCTION}\n\n" + grid(
        ("question", "number", "time to run"), [cells for _, cells in rows], "45 43 12"
    )


def show(app: Sphinx, docname: str, source: list[str]) -> None:
    """Add question, number and time to the pages of the gallery as they are read."""
    folder, _, name = docname.rpartition("/")
    if docname == "gallery/index":
        source[0] = source[0].replace(TABLE, table(Path(app.srcdir) / "gallery"))
    elif folder.startswith("gallery/") and name != "index":
        source[0] = headed(source[0], name)


def setup(app: Sphinx) -> dict[str, bool]:
    """Add the results when a page of the gallery is read."""
    app.connect("source-read", show)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
