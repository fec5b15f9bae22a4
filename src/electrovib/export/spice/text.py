"""How ngspice wants its words: numbers, names that differ in more than capitals, lines of a readable length."""

from __future__ import annotations

import re
import textwrap
import unicodedata
from dataclasses import dataclass, field

WIDTH = 110
"""Characters in a line, where it can be broken."""


def number(value: float) -> str:
    """Write a number [any unit] with 15 digits, more than ngspice keeps of a voltage."""
    return f"{float(value):.15g}"


def continued(line: str) -> str:
    """Break a long element at blanks, with the sign that continues it."""
    return "\n".join(textwrap.wrap(line, WIDTH, subsequent_indent="+ ", break_long_words=False))


def remark(text: str) -> str:
    """Write a comment: one line for each of the text's, broken where it gets long, nothing unprintable in it."""
    lines = []
    for paragraph in text.splitlines():
        plain = "".join(sign for sign in paragraph if sign.isprintable())
        lines += textwrap.wrap(plain, WIDTH, initial_indent="* ", subsequent_indent="*   ") or ["*"]
    return "\n".join(lines)


@dataclass
class Names:
    """Names in use: ngspice knows no capitals, so each is lower case and unlike all others.

    Parameters
    ----------
    taken : set of str
        Names that are used already.
    """

    taken: set[str] = field(default_factory=set)

    def new(self, wanted: str) -> str:
        """Give a free name of letters a to z, digits and underscores, as near to the wanted one as possible."""
        plain = unicodedata.normalize("NFKD", wanted).encode("ascii", "ignore").decode().lower()
        plain = re.sub(r"[^a-z0-9_]", "_", plain).strip("_") or "layer"
        name, count = plain, 1
        while name in self.taken:
            count += 1
            name = f"{plain}_{count}"
        self.taken.add(name)
        return name
