"""Errors that a user can cause, each with what to do next."""

from __future__ import annotations

import difflib
import re
import unicodedata
from contextlib import contextmanager
from traceback import FrameSummary, walk_tb
from typing import TYPE_CHECKING, Final, Self, TypeVar

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence

T = TypeVar("T")
R = TypeVar("R")
LONGEST_QUOTED: Final = 60
"""Most characters that are quoted from a file."""
_LONGEST_PROBLEM: Final = 1200
_LONGEST_LIST: Final = 600
_LONGEST_NAME: Final = 100
_MOST_NAMES: Final = 1000
_SENTENCE: Final = re.compile(r"([^\s:='\"]+)(?: = ([^:]{1,200}))?: (.+)", re.DOTALL)


class Problem(str):
    """One mistake in an input: the sentence ``path = value: reason`` for people, and its parts for programs.

    `path` is the dotted path of a parameter, the name of a file, or an option; empty for the whole input.
    Quoted text may come from a file: control characters are shown as their codes, and the middle of a long
    text is omitted.
    """

    __slots__ = ("path", "reason", "value")
    path: str
    reason: str
    value: str

    def __new__(cls, reason: str, *, path: object = "", value: str = "") -> Self:
        place = str(path)
        start = f"{place or 'the file'} = {value}: " if value else f"{place}: " if place else ""
        found = super().__new__(cls, shortened(printable(f"{start}{reason}"), _LONGEST_PROBLEM))
        found.path, found.value, found.reason = place, value, reason
        return found

    @classmethod
    def read(cls, sentence: str) -> Problem:
        """Read a sentence of the form ``path = value: reason`` or ``path: reason``."""
        if isinstance(sentence, Problem):
            return sentence
        parts = _SENTENCE.fullmatch(sentence)
        return cls(sentence) if parts is None else cls(parts[3], path=parts[1], value=parts[2] or "")

    def within(self, owner: str) -> Problem:
        """Return the problem with the path of the part in front, separated by a full stop."""
        path = f"{owner}.{self.path}" if self.path else owner
        return Problem(self.reason, path=path, value=self.value)

    def followed_by(self, words: str) -> Problem:
        """Return the problem with more words at its end."""
        return Problem(f"{self.reason}{words}", path=self.path, value=self.value)


class ElectrovibError(Exception):
    """A mistake that a user can correct; shown as one line for each problem, without a traceback.

    The attribute `problems` is a tuple of `Problem`, each made of a sentence; `path` and `value` are those of
    a single problem whose sentence does not contain them.
    """

    def __init__(self, problems: str | Iterable[str], *, path: object = "", value: str = "") -> None:
        if path or value:
            problems = Problem(str(problems), path=path, value=value)
        given = (problems,) if isinstance(problems, str) else problems
        self.problems = tuple(Problem.read(problem) for problem in given)
        super().__init__("\n".join(self.problems))

    def of_file(self, path: object) -> Self:
        """Put a file before each problem that names none."""
        self.problems = tuple(
            each if each.path == str(path) else Problem(str(each), path=path) for each in self.problems
        )
        self.args = ("\n".join(self.problems),)
        return self

    def _render_traceback_(self) -> list[str]:
        """Return what IPython prints instead of a traceback: the problems, and the user's line that met them."""
        package, theirs = __name__.partition(".")[0], list[FrameSummary]()
        for frame, number in walk_tb(self.__traceback__):
            if str(frame.f_globals.get("__name__")).partition(".")[0] == package:
                break
            theirs.append(FrameSummary(frame.f_code.co_filename, number, frame.f_code.co_name))
        line = f"in line {theirs[-1].lineno}: {theirs[-1].line}" if theirs and theirs[-1].line else ""
        lines = [f"{type(self).__name__}: {problem}" for problem in self.problems]
        return [*lines, line] if line else lines


class InputError(ElectrovibError):
    """One or several mistakes in an input, all listed at once."""


def refuse(problems: Sequence[str]) -> None:
    """Raise an `InputError` of all problems, where there are any."""
    if problems:
        raise InputError(problems)


class DataFileError(InputError):
    """A file that cannot be read as the kind of file that is needed."""


class NoColumnError(DataFileError):
    """A file without the column `column`, which is needed."""

    def __init__(self, problems: str | Iterable[str], *, column: str, path: object = "") -> None:
        super().__init__(problems, path=path)
        self.column = column


class NoHeadingsError(NoColumnError):
    """A file without headings, whose columns have numbers alone."""


class NotCausalError(ElectrovibError):
    """A time-domain response was requested of a law that has none."""


@contextmanager
def gathered(problems: list[str], *, within: str = "") -> Iterator[None]:
    """Add the InputError that ends a block to a list and continue, so that the rest of the input is checked too.

    `within` is the part of the input that the block reads.
    """
    try:
        yield
    except InputError as error:
        problems += [each.within(within) if within else each for each in error.problems]


def computed_or_refused(
    items: Mapping[str, T], compute: Callable[[str, T], R], *, reason: Callable[[ElectrovibError], str] = str
) -> tuple[dict[str, R], dict[str, str]]:
    """Compute each item by its name, and give the reason for each that cannot be computed."""
    found: dict[str, R] = {}
    refused: dict[str, str] = {}
    for name, item in items.items():
        try:
            found[name] = compute(name, item)
        except ElectrovibError as error:
            refused[name] = reason(error)
    return found, refused


def in_short(error: ElectrovibError) -> str:
    """Give the reasons of an error in one line."""
    return "; ".join(each if each.path else each.reason for each in error.problems)


@contextmanager
def located(owner: str) -> Iterator[None]:
    """Put the part of the input that a block reads in front of the paths of the InputError that ends it."""
    try:
        yield
    except InputError as error:
        raise InputError(each.within(owner) for each in error.problems) from None


def nearest(word: str, known: Iterable[str]) -> str:
    """Write ``" Did you mean 'x'?"`` with the closest known name, or the list of all known names."""
    names = sorted(known)
    listed = f" Known: {shortened(', '.join(names), _LONGEST_LIST)}." if names else ""
    return suggestion(word, names) or listed


def suggestion(word: str, known: Iterable[str]) -> str:
    """Write ``" Did you mean 'x'?"`` with the closest known name; empty if none is close."""
    close = closest(word, known)
    return question([] if close is None else [f"'{close}'"])


def question(shown: Sequence[str]) -> str:
    """Write ``" Did you mean a, b or c?"``; empty without anything to ask for."""
    listed = " or ".join(filter(None, (", ".join(shown[:-1]), *shown[-1:])))
    return f" Did you mean {listed}?" if shown else ""


def closest(word: str, known: Iterable[str]) -> str | None:
    """Find the known name that is most similar to a word; None if no name is similar."""
    names = sorted(known)
    close = difflib.get_close_matches(word[:_LONGEST_NAME], names[:_MOST_NAMES], n=1, cutoff=0.6)
    if not close:  # a difference in capitals only is the most frequent mistake
        close = [name for name in names if name.lower() == word.lower()]
    return close[0] if close else None


def closest_file(name: str, beside: Iterable[str]) -> str:
    """Write ``" Did you mean 'x'?"`` with the closest name of a file; a common ending alone makes no name close."""
    stem = name.rpartition(".")[0] or name
    stems = {each: each.rpartition(".")[0] or each for each in beside}
    near = [each for each, other in stems.items() if difflib.get_close_matches(stem, [other], cutoff=0.5)]
    return suggestion(name, near)


def printable(text: str) -> str:
    """Write control characters, and others that a terminal would obey or hide, as their codes."""
    if text.isprintable():
        return text
    return "".join(sign if sign.isprintable() else _code(sign) for sign in text)


def _code(sign: str) -> str:
    if unicodedata.category(sign) == "Zs":
        return " "
    return sign.encode("unicode_escape").decode("ascii")


def shortened(text: str, room: int) -> str:
    """Omit the middle of a text that has more than `room` characters."""
    if len(text) <= room:
        return text
    end = room // 3
    return f"{text[: room - end - 5]} ... {text[-end:]}"
