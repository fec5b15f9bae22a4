"""``electrovib report``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from electrovib.apps.cli.options import Arguments, takes
from electrovib.apps.cli.recipe import OF_TRACE, recipe_of
from electrovib.apps.cli.terminal import say, warned

if TYPE_CHECKING:
    from collections.abc import Mapping

    import xarray


@takes("""
traces...           Trace files, overlaid in one report.
-o, --output FILE   The HTML file to write. [default: report.html]
--column
--set KEY=VALUE     Entry of the recipe of an import: time='t [us]', scale.SIGNAL='4/9 N/V'; repeatable.
--recipe
--models
--force
""")
def command(given: Arguments) -> None:
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
    from electrovib.apps.cli.map_lines import is_map, judged
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
    from electrovib.data.traces import open_if_trace
    from electrovib.recordings.importing import import_file

    if recipe and "columns" not in recipe:
        raise InputError(f"{next(iter(recipe))}: belongs to --column SIGNAL=COLUMN, which is missing")
    if not recipe:
        return {}
    found: dict[str, Any] = {}
    for name in names:
        label = Path(name).stem if Path(name).stem not in found else name
        found[label] = name
        if Path(name).is_file() and Path(name).suffix.lower() != ".toml":
            try:
                found[label] = open_if_trace(name)
                if found[label] is name:
                    found[label] = import_file(name, **recipe)
            except DataFileError:
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
