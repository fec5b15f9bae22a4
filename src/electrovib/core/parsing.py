"""TOML and JSON from outside: any text is either read or refused with a reason."""

from __future__ import annotations

import itertools
import re
from typing import TYPE_CHECKING, Any, Final

from electrovib.core.budget import megabytes
from electrovib.core.errors import InputError, shortened
from electrovib.core.file_kinds import other_kind
from electrovib.core.files import kind_of, note_input

if TYPE_CHECKING:
    from pathlib import Path


_DEEPEST: Final = 50
"""Most levels of nested tables and lists; a scenario needs about ten."""
MOST_KEYS: Final = 10_000
"""Most keys and tables of a file: as many are read in a second, and no scenario, space or recipe has a tenth of them."""
_KEY: Final = re.compile(r"=|^[ \t]*\[{1,2}[ \t]*[A-Za-z_]", re.MULTILINE)


def truth(value: object, path: str) -> bool:
    """Read yes or no: a truth, or a text or number as every parameter of a model takes it; anything else is refused."""
    from pydantic import TypeAdapter, ValidationError

    try:
        return TypeAdapter(bool).validate_python(value.strip() if isinstance(value, str) else value)
    except ValidationError:
        raise InputError("expected true or false", path=path, value=shortened(str(value), 40)) from None


def read_toml(text: str) -> dict[str, Any]:
    """Read a text as TOML."""
    import tomllib

    if sum(1 for _ in itertools.islice(_KEY.finditer(text), MOST_KEYS + 1)) > MOST_KEYS:
        raise ValueError(f"it has more than {MOST_KEYS} keys")
    try:
        content = tomllib.loads(text)
    except RecursionError:
        raise _too_deep() from None
    except tomllib.TOMLDecodeError as error:
        raise ValueError(f"{error}{_advice(text, str(error))}") from None
    except ValueError:
        raise _too_long() from None
    _check_depth(content)
    return content


def read_json(text: object) -> Any:
    """Read a text as JSON."""
    import json

    if not isinstance(text, str):
        msg = f"it is of type {type(text).__name__}, not a text"
        raise ValueError(msg)  # noqa: TRY004  # one kind of error for one kind of mistake
    try:
        content = json.loads(text)
    except RecursionError:
        raise _too_deep() from None
    except json.JSONDecodeError:
        raise
    except ValueError:
        raise _too_long() from None
    _check_depth(content)
    return content


def _check_depth(content: Any) -> None:
    """Refuse nesting that would exceed the recursion limit later on."""
    level = [content]
    for _ in range(_DEEPEST):
        level = [
            inner
            for item in level
            if isinstance(item, (dict, list))
            for inner in (item.values() if isinstance(item, dict) else item)
            if isinstance(inner, (dict, list))
        ]
        if not level:
            return
    raise _too_deep()


def _too_long() -> ValueError:
    return ValueError("it has a whole number of thousands of digits")


def _too_deep() -> ValueError:
    return ValueError(f"its tables and lists are nested more than {_DEEPEST} deep")


def _advice(text: str, reason: str) -> str:
    """Write how a value with a unit is quoted, if the line of an error has one that is not; empty otherwise."""
    place = re.search(r"\(at line (\d+), ", reason)
    lines = text.splitlines()
    line = lines[int(place[1]) - 1] if place and int(place[1]) <= len(lines) else ""
    # a name begins where none is before, or the search would take the square of the length of the line
    bare = re.search(
        r"(?<![\w.-])([\w.-]+)\s*=\s*([-+]?[\d.]+(?:[eE][-+]?\d+)?\s*[A-Za-z%µμΩ/#][\w/^µμΩ ]{0,20}|True|False)",
        line,
    )
    if bare and bare[2] in {"True", "False"}:
        return f"; truths are written in small letters: {bare[1]} = {bare[2].lower()}"
    if bare and "#" in bare[2]:
        return f"; '#' begins a comment, which ends the line: {bare[1]} = {bare[2].partition('#')[0].strip()}"
    return f'; a value with a unit is a text in quotes: {bare[1]} = "{bare[2].strip()}"' if bare else ""


_LARGEST: Final = 64_000_000
"""Bytes of a file, at most: a scenario with a million samples of a drive takes half of them."""


def read_toml_file(path: Path, *, kind: str, advice: str) -> dict[str, Any]:
    """Read the tables of an ordinary file; what else a name may stand for is not opened."""
    note_input(path)
    try:
        if (found := kind_of(path)) in ("folder", "other"):
            what = "a folder" if found == "folder" else "not an ordinary file"
            raise InputError(other_kind(path, kind) or f"is {what}. {advice}", path=path)
        with path.open("rb") as file:
            content = file.read(_LARGEST + 1)
    except (OSError, ValueError) as error:  # a name with a zero byte is no OSError
        why = other_kind(path, kind) or f"{getattr(error, 'strerror', '') or error}. {advice}"
        raise InputError(why, path=path) from None
    if len(content) > _LARGEST:
        raise InputError(f"is larger than {megabytes(_LARGEST)}, the most that {kind} may take", path=path)
    try:
        tables = read_toml(content.decode("utf-8-sig"))  # editors of Windows begin with a byte-order mark
    except UnicodeDecodeError:
        why = other_kind(path, kind) or f"not a text in UTF-8; {kind} is TOML, saved as UTF-8"
        raise InputError(why, path=path) from None
    except ValueError as error:
        raise InputError(other_kind(path, kind) or f"not valid TOML: {error}", path=path) from None
    if why := other_kind(path, kind, tables):
        raise InputError(why, path=path)
    return tables
