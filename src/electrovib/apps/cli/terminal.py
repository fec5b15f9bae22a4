"""Output of the commands: no control characters of a file, and only characters that the terminal can show."""

from __future__ import annotations

import codecs
import inspect
import os
import sys
import unicodedata
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Final, TypeVar

from electrovib.core.diagnostics import diagnostics_of, warning_lines
from electrovib.core.errors import printable

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator
    from typing import TextIO

    from electrovib.apps.cli.options import AnswerOptions
    from electrovib.core.answer import Answer
    from electrovib.scenario import Scenario


_PLAIN: Final = {
    "µ": "u", "μ": "u", "Ω": "ohm", "·": " ", "–": "-", "—": "-", "−": "-", "×": "x", "°": " deg",
    "…": "...", "≤": "<=", "≥": ">=", "≈": "~", "‘": "'", "’": "'", "“": '"', "”": '"', "ß": "ss", "ø": "o", "æ": "ae",
    "τ": "tau", "ε": "epsilon", "σ": "sigma", "ω": "omega",
}  # fmt: skip
_HANDLER: Final = "electrovib.plain"
_UNPRINTED: Final[list[str]] = []
"""Why the output could not be printed completely."""


def say(*lines: str) -> None:
    """Print each text as one line; a control character is shown as its code."""
    put("".join(f"{printable(line)}\n" for line in lines))


def put(text: str) -> None:
    """Print a text as it is; a full disk or a closed pipe ends no command, because its files are still to be written."""
    with _held(sys.stdout):
        print(text, end="")


_COLOURS: Final = {"pass": 32, "unknown": 33, "fail": 31}
"""Code of the colour in which a terminal shows the outcome of a check: green, yellow, red."""


def say_state(state: str, line: str) -> None:
    """Print one line, in the colour of its state, if it has one, where a terminal shows colours."""
    if state and sys.stdout.isatty() and not os.environ.get("NO_COLOR") and os.environ.get("TERM") != "dumb":
        put(f"\033[{_COLOURS[state]}m{printable(line)}\033[0m\n")
    else:
        say(line)


def unprinted() -> bool:
    """Return whether the output was not printed completely, after saying so on the error output."""
    with _held(sys.stdout):
        print(end="", flush=True)
    if _UNPRINTED:
        complain(f"the output could not be printed completely: {_UNPRINTED[0]}")
    found = bool(_UNPRINTED)
    _UNPRINTED.clear()
    return found


@contextmanager
def _held(stream: TextIO) -> Iterator[None]:
    """Note that a stream takes no more text, and let the rest of it go nowhere."""
    try:
        yield
    except OSError as error:
        if stream is sys.stdout:
            _UNPRINTED.append(error.strerror or str(error))
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, stream.fileno())
        os.close(nowhere)


def warned(result: object) -> list[str]:
    """Return the warnings of what a result was computed from, each sentence once."""
    return warning_lines(diagnostics_of(result), brief=True)


def show(text: str) -> None:
    """Print a text of several lines, such as a table."""
    say(*text.split("\n"))


def show_answer(found: Answer, *, everything: bool = False, state: str = "") -> None:
    """Print an answer, its first line in the colour of a `state`; with `everything` what a brief one omits, and explanations."""
    document = found.document
    text = document.shown(everything=everything)
    first, *others = text.split("\n")
    say_state(state, first)
    say(*others)
    if document.brief and not everything:
        left = document.shown(everything=True).count("\n") - text.count("\n")
        say(*([f"--all prints {left} more lines."] if left else []))


def chosen(scenario: Scenario, source: str, *, without: Iterable[object] = ()) -> list[str]:
    """List the parameters whose values the paper does not give, in one line; none for a scenario of one's own.

    `source` is what the user named; `without` are dotted paths that are swept, which are omitted.
    """
    from electrovib.scenario import not_in_paper, paper_of_preset

    paper = paper_of_preset(source)
    found = not_in_paper(scenario, paper) if paper else {}
    swept = set(without)
    paths = ", ".join(path for path in found if path not in swept)
    line = f"values not from {paper}: {paths} ('electrovib list {paper}' states their sources)"
    return [line] if paths else []


def complain(*lines: str) -> None:
    """Print lines on the error output, each after the name of the program."""
    with _held(sys.stderr):
        for line in lines:
            print(f"electrovib: {printable(line)}", file=sys.stderr)


def prepare() -> None:
    """Replace characters that a terminal cannot show by plain letters, where Python would end the command."""
    codecs.register_error(_HANDLER, _plain)
    chosen = next((os.environ[name] for name in ("LC_ALL", "LC_CTYPE", "LANG") if os.environ.get(name)), "")
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors=_HANDLER)
            if chosen in {"C", "POSIX"} and stream.isatty():  # where Python itself would write UTF-8
                stream.reconfigure(encoding="ascii", errors=_HANDLER)


def _plain(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    signs = error.object[error.start : error.end]
    return "".join(_plain_sign(sign) for sign in signs), error.end


def _plain_sign(sign: str) -> str:
    if sign in _PLAIN:
        return _PLAIN[sign]
    parts = unicodedata.normalize("NFKD", sign)
    return "".join(part for part in parts if part.isascii()) or "?"


Found = TypeVar("Found", bound="Answer")


def answered(
    kind: type[Answer],
    compute: Callable[..., Found],
    words: str,
    given: dict[str, Any],
    saved: AnswerOptions,
    *,
    show: Callable[..., object] = show_answer,
    check: Callable[..., object] | None = None,
    write: Callable[..., Iterable[str]] | None = None,
) -> Found:
    """Compute, show and write an answer; the output is checked before the computation, and that it replaces no input after.

    `given` has what `compute` takes; progress is reported if it can be, and `words` say what is done. `check` and `write` take
    the place of those of any answer; what `write` returns is printed.
    """
    from electrovib.apps.progress import tracked
    from electrovib.core.files import inputs_noted
    from electrovib.view.files import check_answer

    check, write = check or check_answer, write or _saved
    if saved.output:
        check(kind, saved.output, force=saved.force)
    with inputs_noted() as inputs, tracked(words) as progress:
        can_report = "progress" in inspect.signature(compute).parameters
        found = compute(**given, **({"progress": progress} if can_report else {}))
    if saved.output:
        check(type(found), saved.output, inputs=inputs, force=saved.force)
    show(found, everything=saved.all)
    if saved.output:
        say(*write(found, saved.output, force=saved.force))
    return found


def finish(found: Answer, saved: AnswerOptions) -> None:
    """Show an answer that its function has written already."""
    from electrovib.view.files import written

    show_answer(found, everything=saved.all)
    if saved.output:
        say(written(saved.output, lambda: found.document, found.files))


def _saved(found: Answer, output: str, *, force: bool) -> list[str]:
    """Write an answer."""
    from electrovib.exports.save import save
    from electrovib.view.files import written

    save(found, output, force=force)
    return [written(output, lambda: found.document, found.files)]


def is_map(trace: Any) -> bool:
    """Return whether a Trace is a sweep over two parameters or more."""
    return sum(path in trace.attrs.get("over", "") for path in trace.sizes) > 1
