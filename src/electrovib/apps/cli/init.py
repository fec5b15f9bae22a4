"""``electrovib init``."""

from __future__ import annotations

import sys

from electrovib.apps.cli.options import Arguments, takes
from electrovib.apps.cli.terminal import put, say


@takes("""
scenario  [default: vezzoli_2014/fig6]
--set
-o, --output FILE  The TOML file to write.
--force
""")
def command(given: Arguments) -> None:
    """Write a scenario as a commented TOML file to start from."""
    from electrovib.apps.init import init

    given.read_set()
    text = init(**given)
    if "output" in given:
        say(f"written: {given['output']}")
    else:
        put(as_toml(text, sys.stdout.encoding))


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
