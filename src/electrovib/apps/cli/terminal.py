"""Output of the commands: no control characters of a file, and only characters that the terminal can show."""

from __future__ import annotations

import codecs
import os
import sys
import unicodedata
from typing import Final

from electrovib.core.errors import printable

_PLAIN: Final = {
    "µ": "u", "μ": "u", "Ω": "ohm", "·": " ", "–": "-", "—": "-", "−": "-", "×": "x", "°": " deg",
    "…": "...", "≤": "<=", "≥": ">=", "≈": "~", "‘": "'", "’": "'", "“": '"', "”": '"', "ß": "ss", "ø": "o", "æ": "ae",
    "τ": "tau", "ε": "epsilon", "σ": "sigma", "ω": "omega",
}  # fmt: skip
_HANDLER: Final = "electrovib.plain"


def say(*lines: str) -> None:
    """Print each text as one line; a control character is shown as its code."""
    for line in lines:
        print(printable(line))


def show(text: str) -> None:
    """Print a text of several lines, such as a table."""
    say(*text.split("\n"))


def complain(*lines: str) -> None:
    """Print lines on the error output, each after the name of the program."""
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
