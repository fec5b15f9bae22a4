"""The option ``--set``, read as values by dotted path."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from electrovib.core.errors import refuse
from electrovib.core.parsing import read_toml


def read_changes(texts: Iterable[str] | None) -> dict[str, Any]:
    """Read ``path=value`` texts; a value that begins with a brace or a bracket is TOML, any other stays a text.

    Texts that cannot be read are refused all at once.
    """
    found, problems = readable_changes(texts or ())
    refuse(problems)
    return found


def readable_changes(changes: Mapping[str, Any] | Iterable[str]) -> tuple[dict[str, Any], list[str]]:
    """Read the texts that can be read, and describe in one sentence each what is wrong with the others.

    A mapping of values by path is returned as it is.
    """
    if isinstance(changes, Mapping):
        return dict(changes), []
    found: dict[str, Any] = {}
    problems = []
    for text in changes:
        path, sign, value = (part.strip() for part in text.partition("="))
        if not sign or not path:
            problems.append(f"--set {text}: expected PATH=VALUE, for instance drive.high='150 V'")
        elif path in found:
            problems.append(f"--set {text}: '{path}' is set twice")
        else:
            try:
                found[path] = read_toml(f"value = {value}")["value"] if value[:1] in {"{", "["} else value
            except ValueError as error:
                problems.append(f"--set {text}: not valid TOML: {error}")
    return found, problems
