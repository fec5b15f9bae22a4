"""Options that commands took and take no more: they are read with a warning of what to use, and no help shows them."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Final

from electrovib.apps.cli.options import read_number, refuse_blank_text, use_models
from electrovib.apps.cli.terminal import complain
from electrovib.core.deprecation import Former
from electrovib.core.errors import InputError

_EVERY: Final = "run study find-value value-for-share drive-for-force texture-drive plan-plate check export explore report"


@dataclass(frozen=True)
class GoneOption(Former):
    """An option that has left a command: how its value is read, None for a flag, and whether it may be given again."""

    read: Callable[[str], Any] | None
    repeatable: bool


def _gone(now: str, read: Callable[[str], Any] | None = str, *, repeatable: bool = False) -> GoneOption:
    return GoneOption(now, since="1.0.0", goes="2.0.0", read=read, repeatable=repeatable)


_MODELS: Final = {
    "--models": _gone("electrovib --models FILE.py, before the command", use_models, repeatable=True)
}
_IMPORT: Final = "electrovib import, and report the Trace that it writes"
GONE: Final[dict[str, dict[str, GoneOption]]] = {
    **dict.fromkeys(
        (*_EVERY.split(), "evidence", "fit", "fit-laws", "fit-separately", "fit-contact"), _MODELS
    ),
    "bench run": _MODELS,
    "export": {
        **_MODELS,
        "--amplifier-present": _gone("--set circuit.amplifier.hardware='MAKER MODEL'", None),
        "--largest-error": _gone(
            "a higher --rate; 1 % of the largest voltage is allowed",
            functools.partial(read_number, "--largest-error", float),
        ),
    },
    "fit-contact": {
        **_MODELS,
        "--points": _gone(
            "electrovib.fit_contact(points=...) in Python", functools.partial(read_number, "--points", int)
        ),
    },
    "fit-material": {"--recipe": _gone("--set and --column")},
    "fit-power-law": {"--recipe": _gone("--set")},
    "import": {"--layer": _gone("the name of the table in the file that is written")},
    "report": {
        **_MODELS,
        "--column": _gone(_IMPORT, repeatable=True),
        "--recipe": _gone(_IMPORT),
        "--set": _gone(_IMPORT, repeatable=True),
    },
    "study": {
        **_MODELS,
        "--budget-memory": _gone("electrovib --budget MEMORY, of which percentiles take a quarter"),
        "--report": _gone("--output FILE.html"),
    },
    "texture-drive": {**_MODELS, "--frequency": _gone("--carrier; without one the gain is that at 100 Hz")},
    "times": {
        "--exponentials": _gone(
            "electrovib.measure_times(exponentials=...) in Python",
            functools.partial(read_number, "--exponentials", int),
        )
    },
}
"""Options by command, whose values functions read by `electrovib.core.deprecation.former_value`."""


def taken(gone: Mapping[str, GoneOption], words: list[str]) -> tuple[list[str], dict[str, Any]]:
    """Take the options that a command takes no more out of its arguments; return the other words, and the values by name."""
    left, values, rest = list[str](), dict[str, Any](), iter(words)
    for word in rest:
        flag, sign, text = word.partition("=")
        if flag not in gone:
            left.append(word)
            continue
        option, name = gone[flag], flag.strip("-").replace("-", "_")
        if name not in values:
            complain(
                f"{flag} is deprecated since electrovib {option.since} and goes in {option.goes}: use {option.now}"
            )
        elif not option.repeatable:
            raise InputError(f"{flag}: given twice; give it once")
        if option.read is None and sign:
            raise InputError("takes no value; omit it", path=flag, value=text)
        value = True if option.read is None else option.read(_value(flag, text if sign else None, rest))
        values[name] = [*values.get(name, ()), value] if option.repeatable else value
    return left, values


def _value(flag: str, text: str | None, rest: Iterator[str]) -> str:
    """Return the value of an option, which follows it after an equals sign or as the next word."""
    value = next(rest, None) if text is None else text
    if value is None:
        raise InputError("needs a value", path=flag)
    refuse_blank_text(flag, value)
    return value
