"""Words of the field that are called otherwise here, or are not modelled: the table `words.toml`."""

from __future__ import annotations

import functools
import re
from pathlib import Path
from typing import Any

from electrovib.core.parsing import read_toml


@functools.cache
def meanings() -> dict[str, list[dict[str, Any]]]:
    """Read the table: ``here`` and ``missing``, each with its words, a sentence, and the names that belong to it."""
    return read_toml(Path(__file__).with_name("words.toml").read_text(encoding="utf-8"))


def missing() -> str:
    """Name what is not modelled."""
    return ", ".join(each["words"][0] for each in meanings()["missing"])


def meaning(query: str, *, within: bool = False) -> tuple[str, list[str]]:
    """Say what a query means that has exactly the words of an entry, or with `within` some; empty if nothing has them.

    Beside the sentence are the names that belong to it.
    """
    asked = _words(query)
    for label, kind in (("", "here"), ("not modelled: ", "missing")):
        for each in meanings()[kind]:
            known = set(map(_words, each["words"]))
            if asked in known or (within and any(words <= asked for words in known)):
                return f"{query}: {label}{each['says']}.", each["see"]
    return "", []


def _words(text: str) -> frozenset[str]:
    """Split a text into words in small letters, without the s of a plural."""
    return frozenset(word.removesuffix("s") for word in re.findall(r"[^\W_]+", text.casefold()))
