"""Entry point of the command line: it imports little at first, so that Ctrl-C is handled from the start."""

from __future__ import annotations

import gc
import os
import signal
import sys
from typing import TYPE_CHECKING, Final, NoReturn

from electrovib.apps.exit_codes import INTERRUPTED
from electrovib.core.budget import ONE_THREAD

if TYPE_CHECKING:
    from types import FrameType

_AGAIN: Final = 1.0
"""Time after which an interrupt is raised again [s]: Python only prints an exception that a callback raises."""
_INTERRUPTS: Final[list[int]] = []
"""Signals that were received."""
_YOUNG: Final = (
    10_000  # new objects after which unused ones are sought: at the start thousands are made, none unused
)


def main() -> None:
    """Run the command line."""
    _open_closed()
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _interrupt)
    os.environ.update(
        ONE_THREAD | {"PYDANTIC_DISABLE_PLUGINS": "__all__"} | os.environ
    )  # to seek plugins takes long
    gc.set_threshold(_YOUNG)
    try:
        from electrovib.apps.cli import main as command_line

        command_line()
    except KeyboardInterrupt:
        sys.stderr.write("electrovib: interrupted before anything was done\n")
        sys.exit(INTERRUPTED)
    except Exception:
        if not _INTERRUPTS:
            raise
        # a compiled library whose import is interrupted raises an ImportError instead
        sys.stderr.write("electrovib: interrupted, nothing was left half written\n")
        sys.exit(INTERRUPTED)
    finally:
        _be_silent()
        gc.freeze()  # the process ends: what is left is not searched once more


def _open_closed() -> None:
    """Let an output that the caller closed go nowhere, so that no file takes its number and its text."""
    while (number := os.open(os.devnull, os.O_RDWR)) <= 2:  # input, output, error output
        os.set_inheritable(number, True)
    os.close(number)
    sys.stdin, sys.stdout, sys.stderr = (
        stream or open(number, mode, encoding="utf-8", closefd=False)  # noqa: SIM115  # for the whole command
        for number, (stream, mode) in enumerate([(sys.stdin, "r"), (sys.stdout, "w"), (sys.stderr, "w")])
    )


def _interrupt(number: int, frame: FrameType | None) -> NoReturn:
    """Raise KeyboardInterrupt, repeatedly until the command has ended."""
    del frame
    _INTERRUPTS.append(number)
    if hasattr(signal, "setitimer"):
        signal.signal(signal.SIGALRM, _interrupt)
        signal.setitimer(signal.ITIMER_REAL, _AGAIN)
    raise KeyboardInterrupt


def _be_silent() -> None:
    """Stop raising; a further Ctrl-C ends the process without a message, because nothing is left to clean up."""
    if hasattr(signal, "setitimer"):
        signal.setitimer(signal.ITIMER_REAL, 0.0)
    if signal.getsignal(signal.SIGINT) is _interrupt:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
