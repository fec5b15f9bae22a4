"""Text of a netlist: numbers, names that differ without regard to case, and lines of a readable length."""

from __future__ import annotations

import re
import textwrap
import unicodedata
from dataclasses import dataclass, field

WIDTH = 110
"""Largest number of characters in a line that can be broken."""


def number(value: float) -> str:
    """Return a number [any unit] with 15 digits, more than the precision of a voltage in ngspice."""
    return f"{float(value):.15g}"


def continued(line: str) -> str:
    """Return a long element broken at blanks, with the continuation sign of ngspice."""
    return "\n".join(textwrap.wrap(line, WIDTH, subsequent_indent="+ ", break_long_words=False))


def remark(text: str) -> str:
    """Return a text as comment lines, long lines broken and unprintable characters removed."""
    lines = []
    for paragraph in text.splitlines():
        plain = "".join(sign for sign in paragraph if sign.isprintable())
        lines += textwrap.wrap(plain, WIDTH, initial_indent="* ", subsequent_indent="*   ") or ["*"]
    return "\n".join(lines)


@dataclass
class Names:
    """Names in use, all lower case and different, because ngspice ignores case."""

    taken: set[str] = field(default_factory=set)

    def new(self, wanted: str) -> str:
        """Return an unused name of letters a to z, digits and underscores, as near to the wanted one as possible."""
        plain = unicodedata.normalize("NFKD", wanted).encode("ascii", "ignore").decode().lower()
        plain = re.sub(r"[^a-z0-9_]", "_", plain).strip("_") or "layer"
        name, count = plain, 1
        while name in self.taken:
            count += 1
            name = f"{plain}_{count}"
        self.taken.add(name)
        return name
