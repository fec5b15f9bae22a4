"""``electrovib init``."""

from __future__ import annotations

import sys
from typing import Annotated

from electrovib.apps.cli import options
from electrovib.apps.cli.options import Text, output
from electrovib.apps.cli.terminal import put, say


def command(
    scenario: options.Scenario = "vezzoli_2014/fig6",
    changes: options.Changes = None,
    file: Annotated[Text, output("The TOML file to write.")] = None,
    force: options.Force = False,
) -> None:
    """Write a scenario as a commented TOML file to start from."""
    from electrovib.apps.changes import read_changes
    from electrovib.apps.init import init

    text = init(scenario, set=read_changes(changes or []), output=file, force=force)
    if file is None:
        put(as_toml(text, sys.stdout.encoding))
    else:
        say(f"written: {file}")


def as_toml(text: str, encoding: str | None) -> str:
    """Write characters that an encoding does not have as TOML escapes, so that the output reads back equal."""
    codes = ((sign, f"\\U{ord(sign):08x}") for sign in dict.fromkeys(text) if not _has(encoding, sign))
    return text.translate({ord(sign): code for sign, code in codes})


def _has(encoding: str | None, sign: str) -> bool:
    try:
        sign.encode(encoding or "utf-8")
    except UnicodeError:
        return False
    return True
