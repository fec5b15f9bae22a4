"""Errors that a user can cause, each with the next thing to do."""

from __future__ import annotations

import difflib
import unicodedata
from contextlib import contextmanager
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator


LONGEST_QUOTED: Final = 60
"""Signs of what is quoted from a file."""
_LONGEST_PROBLEM: Final = 1200
_LONGEST_LIST: Final = 600
_LONGEST_NAME: Final = 100
_MOST_NAMES: Final = 1000


class ElectrovibError(Exception):
    """A mistake a user can mend; shown as one line, never as a traceback."""


class InputError(ElectrovibError):
    """One or several things wrong with an input, all listed at once.

    Parameters
    ----------
    problems : iterable of str
        One sentence each, naming the dotted path, the value, what is allowed and the nearest name. What is quoted in it
        may come from a file: control characters are shown as their codes, and the middle of a long one is left out.
    """

    def __init__(self, problems: str | Iterable[str]) -> None:
        given = (problems,) if isinstance(problems, str) else problems
        self.problems = tuple(shortened(printable(problem), _LONGEST_PROBLEM) for problem in given)
        super().__init__("\n".join(self.problems))


class DataFileError(InputError):
    """A file that cannot be read as what it was given for."""


class NotCausalError(ElectrovibError):
    """A law without a time-domain form was asked for one."""


@contextmanager
def gathered(problems: list[str]) -> Iterator[None]:
    """Add what is wrong with an input to a list and go on, so that the rest is looked at too.

    Parameters
    ----------
    problems : list of str
        Grows by the sentences of an InputError raised in the block; other errors pass.

    Yields
    ------
    None
        The block leaves at its first error.
    """
    try:
        yield
    except InputError as error:
        problems += error.problems


def nearest(word: str, known: Iterable[str]) -> str:
    """Give ``" Did you mean 'x'?"`` for the closest known name, or the list of all of them.

    Parameters
    ----------
    word : str
        What was written.
    known : iterable of str
        What is allowed.

    Returns
    -------
    str
        A sentence that starts with a blank, or an empty text when nothing is known.
    """
    names = sorted(known)
    close = difflib.get_close_matches(word[:_LONGEST_NAME], names[:_MOST_NAMES], n=1, cutoff=0.6)
    if not close:  # a difference in capitals only is the commonest slip
        close = [name for name in names if name.lower() == word.lower()][:1]
    if close:
        return f" Did you mean '{close[0]}'?"
    return f" Known: {shortened(', '.join(names), _LONGEST_LIST)}." if names else ""


def printable(text: str) -> str:
    """Show control characters, and others that a terminal would obey or hide, as their codes.

    Parameters
    ----------
    text : str
        From anywhere.

    Returns
    -------
    str
        One line of signs that can be seen.
    """
    if text.isprintable():
        return text
    return "".join(sign if sign.isprintable() else _code(sign) for sign in text)


def _code(sign: str) -> str:
    if unicodedata.category(sign) == "Zs":
        return " "
    return sign.encode("unicode_escape").decode("ascii")


def shortened(text: str, room: int) -> str:
    """Leave out the middle of a text that is longer than this many signs."""
    if len(text) <= room:
        return text
    end = room // 3
    return f"{text[: room - end - 5]} ... {text[-end:]}"
