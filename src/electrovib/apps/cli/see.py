"""``electrovib explore``, ``report``, ``list`` and ``init``: what is there to see, and to start from."""

import sys
from contextlib import suppress
from pathlib import Path
from types import ModuleType
from typing import Annotated, Any

import typer

from electrovib.apps.cli import options
from electrovib.apps.cli.import_ import OF_TRACE, recipe_of
from electrovib.apps.cli.terminal import put, say, show
from electrovib.core.deprecation import former_value


def explore(
    *,
    experiment: options.DefaultScenarioOptions,
    port: Annotated[int | None, options.number("--port", int)] = None,
    no_browser: options.Flag = False,
) -> None:
    """Open a page in the browser: sliders, curves and limits.

    Change parameters and see their effect at once.

    Parameters
    ----------
    port : N
        Port of the page. Default: the first that is free from 8080 on.
    no_browser
        Do not open a browser.
    """
    from electrovib.apps.explorer.server import explore

    asked = experiment.asked
    serving = False

    def announce(line: str) -> None:
        nonlocal serving
        serving = True
        say(line)
        sys.stdout.flush()  # a log or a pipe would hold the address back until the page is closed

    try:
        explore(**asked, port=port, browser=not no_browser, say=announce)
    except KeyboardInterrupt:
        if not serving:
            raise
    say("The page is closed.")


def report(
    *,
    traces: options.Files,
    output: Annotated[str, typer.Option("--output", "-o", rich_help_panel=options.ANSWER)] = "report.html",
    style: options.Style = None,  # noqa: ARG001  # which `Command.invoke` reads
    force: options.Force = False,
) -> None:
    """Write one report of several Traces, overlaid.

    Parameters
    ----------
    traces
        Trace files, overlaid in one report.
    """
    from electrovib.apps.progress import tracked
    from electrovib.view.files import written
    from electrovib.view.report import reported

    recipe, changes, columns = (former_value(name, None) for name in ("recipe", "set", "column"))
    found = _imported(traces, recipe_of(recipe, changes, columns, only=OF_TRACE, of="a Trace"))
    with tracked("drawing the report"):
        document = reported(found or traces, output, force=force)
    lines = [*document.sentences, *document.warnings]
    say(*(line.replace("µ", "u") for line in lines), written(output, lambda: document))


def _imported(names: list[str], recipe: dict[str, Any]) -> dict[str, Any]:
    """Import the files that are neither Traces nor scenarios; label to Trace or file name, empty without columns."""
    from electrovib.core.errors import DataFileError, InputError
    from electrovib.core.files import kind_of
    from electrovib.data.traces import open_if_trace
    from electrovib.recordings.importing.import_file import import_file

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


def list_(
    *,
    query: Annotated[list[str] | None, typer.Argument(autocompletion=options.model_names)] = None,
    all: options.Details = False,
    bibtex: options.Flag = False,
) -> None:
    """List or search models, materials, papers and scenarios.

    Without a word an overview; with the name of one entry everything about it; else what the words find.

    Parameters
    ----------
    query : [KIND] [WORD]...
        A name or words to search for, after 'scenarios' or 'spaces' among these alone; without one, an overview.
    all
        List every entry on a line of its own.
    bibtex
        Print BibTeX: of one paper, or of all.
    """
    from electrovib.studies import catalogue

    kind, *rest = query or [""]
    words, after = " ".join([kind, *rest]), " ".join(rest)
    if bibtex:
        show(_bibtex(words))
    elif kind == "scenarios":
        show(str(catalogue.scenarios(after)))
    elif kind == "spaces" or (words and _is_space(words)):
        from electrovib.studies.catalogue.found import spaces

        show(str(spaces(words if kind != "spaces" else after)))
    elif words in ("", "models") and not all:
        show(catalogue.overview().rstrip())
    else:
        show(str(catalogue.models(after if kind == "models" else words, complete=all)))


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


def init(
    *,
    experiment: options.DefaultScenarioOptions,
    into: options.FileOptions,
) -> None:
    """Write a scenario as a commented TOML file to start from.

    Parameters
    ----------
    output : FILE
        The TOML file to write.
    """
    from electrovib.apps.init import init

    text = init(**experiment.asked, output=into.output, force=into.force)
    if into.output:
        say(f"written: {into.output}")
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
