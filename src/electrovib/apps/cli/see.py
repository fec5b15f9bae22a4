"""``electrovib explore``, ``report``, ``list`` and ``init``: what is there to see, and to start from."""

from __future__ import annotations

import sys
from contextlib import suppress
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

from electrovib.apps.cli.import_ import OF_TRACE, recipe_of
from electrovib.apps.cli.options import Arguments, takes
from electrovib.apps.cli.terminal import is_map, judged, put, say, show, warned

if TYPE_CHECKING:
    from collections.abc import Mapping

    import xarray


@takes("""
scenario  [default: vezzoli_2014/fig6]
--port N        Port of the page. Default: the first that is free from 8080 on.
--host ADDRESS  Address at which the page is served; any other than 127.0.0.1 can be reached from other machines and needs the
    token of the printed address. [default: 127.0.0.1]
--no-browser    Do not open a browser.
--set
--models
""")
def explore(given: Arguments) -> None:
    """Open a page in the browser: sliders, curves and limits.

    Change parameters and see their effect at once.
    """
    from electrovib.apps.explorer.server import explore

    given.read_set()
    serving = False

    def announce(line: str) -> None:
        nonlocal serving
        serving = True
        say(line)
        sys.stdout.flush()  # a log or a pipe would hold the address back until the page is closed

    browser = not given.pop("no_browser", False)
    try:
        explore(**given, browser=browser, say=announce)
    except KeyboardInterrupt:
        if not serving:
            raise
    say("The page is closed.")


@takes("""
traces...           Trace files, overlaid in one report.
-o, --output FILE|DIR  A page (.html), a figure (.pdf, .svg, .png), tables (.csv, .tex), or a folder with all.
    [default: report.html]
--style
--column
--set KEY=VALUE     Entry of the recipe of an import: time='t [us]', scale.SIGNAL='4/9 N/V'; repeatable.
--recipe
--models
--force
""")
def report(given: Arguments) -> None:
    """Write one report of several Traces, overlaid.

    With --column other files are imported as measurements.
    """
    from electrovib.apps.progress import tracked
    from electrovib.view.report import reported

    traces, output = given["traces"], given["output"]
    found = _imported(traces, recipe_of(given, only=OF_TRACE, of="a Trace"))
    with tracked("drawing the report"):
        shown = reported(found or traces, output, force="force" in given)
    say(*_answers(shown, output), *_without_parameters(traces), f"written: {output}")


def _answers(shown: Mapping[str, xarray.Dataset], output: str) -> list[str]:
    """Return a line with the answer of each result that the report shows, then the warnings of all, each once."""
    from electrovib.core.signals import is_study_result
    from electrovib.studies.population.result import signal_words
    from electrovib.view.summary import opening

    lines, warnings = [], []
    for label, found in shown.items():
        if is_study_result(found):
            answer = "; ".join(line for name in found.attrs["signals"] for line in signal_words(found, name))
        else:
            answer = opening(found).replace("µ", "u")  # as every other number on the terminal
        lines += [f"{label}: {answer}"] if answer else []
        warnings += judged(found, None, output) if is_map(found) else warned(found)
    return [*lines, *dict.fromkeys(warnings)]


def _imported(names: list[str], recipe: dict[str, Any]) -> dict[str, Any]:
    """Import the files that are neither Traces nor scenarios; label to Trace or file name, empty without columns."""
    from electrovib.core.errors import DataFileError, InputError
    from electrovib.core.files import kind_of
    from electrovib.data.traces import open_if_trace
    from electrovib.recordings.importing import import_file

    if not recipe:
        return {}
    if "columns" not in recipe:
        raise InputError(f"{next(iter(recipe))}: belongs to --column SIGNAL=COLUMN, which is missing")
    found: dict[str, Any] = {}
    for name in names:
        label = Path(name).stem if Path(name).stem not in found else name
        found[label] = name
        if kind_of(name) == "file" and Path(name).suffix.lower() != ".toml":
            with suppress(DataFileError):
                found[label] = open_if_trace(name)
            if found[label] is name:
                found[label] = import_file(name, **recipe)
    return found


def _without_parameters(traces: list[str]) -> list[str]:
    """Explain for which Traces the report shows signals only, because a model of their scenario is missing."""
    from electrovib.core.errors import InputError
    from electrovib.core.signals import is_trace
    from electrovib.data.traces import open_if_trace
    from electrovib.scenario import scenario_of

    lines: list[str] = []
    for name in traces:
        try:
            found = open_if_trace(name)
        except InputError:  # a file of an instrument
            continue
        if not is_trace(found) or "scenario" not in found.attrs:
            continue
        try:
            scenario_of(found)
        except InputError as error:
            lines += [f"{name}: shown without its parameters: {problem}" for problem in error.problems]
    return lines


@takes("""
[query]... [KIND] [WORD]...  A name or words to search for, after 'scenarios' or 'spaces' among these alone; without one, an
    overview.
--all     List every entry on a line of its own.
--bibtex  Print BibTeX: of one paper, or of all.
""")
def list_(given: Arguments) -> None:
    """List or search models, materials, papers and scenarios.

    Without a word an overview; with the name of one entry everything about it; else what the words find.
    """
    from electrovib.studies import catalogue

    kind, *rest = given.get("query", [""])
    words, after = " ".join([kind, *rest]), " ".join(rest)
    if "bibtex" in given:
        show(_bibtex(words))
    elif kind == "scenarios":
        show(str(catalogue.scenarios(after)))
    elif kind == "spaces" or (words and _is_space(words)):
        from electrovib.studies.catalogue.populations import spaces

        show(str(spaces(words if kind != "spaces" else after)))
    elif words in ("", "models") and "all" not in given:
        show(catalogue.overview().rstrip())
    else:
        show(str(catalogue.models(after if kind == "models" else words, complete="all" in given)))


def _is_space(words: str) -> bool:
    """Return whether words are the name of a population."""
    from electrovib.scenario.space.shipped import shipped_names

    return words in shipped_names()


def _bibtex(name: str) -> str:
    from electrovib.core.discovery import paper_of, papers
    from electrovib.core.errors import InputError
    from electrovib.studies import catalogue

    wanted = list(papers())
    if name:
        found = catalogue.find(name)
        wanted = [name if isinstance(found, ModuleType) else paper_of(found)]
        if wanted == [""]:
            raise InputError(f"'{name}' belongs to no paper; its reference: {found.reference or 'none'}")
    return "\n\n".join(catalogue.bibtex(papers()[key], key) for key in wanted)


@takes("""
scenario  [default: vezzoli_2014/fig6]
--set
-o, --output FILE  The TOML file to write.
--force
""")
def init(given: Arguments) -> None:
    """Write a scenario as a commented TOML file to start from."""
    from electrovib.apps.init import init

    given.read_set()
    text = init(**given)
    if "output" in given:
        say(f"written: {given['output']}")
    else:
        put(as_toml(text, sys.stdout.encoding))


def as_toml(text: str, encoding: str | None) -> str:
    """Write characters that an encoding does not have as TOML escapes, so that the output reads back equal."""
    codes = ((sign, f"\\U{ord(sign):08x}") for sign in dict.fromkeys(text) if not _has(encoding, sign))
    return text.translate({ord(sign): code for sign, code in codes})


def _has(encoding: str | None, sign: str) -> bool:
    try:
        sign.encode(encoding or "utf-8")
    except UnicodeError:
        return False
    return True
