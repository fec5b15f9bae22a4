"""Errors of a run on a bench."""

from __future__ import annotations

from electrovib.core.errors import ElectrovibError


class BenchError(ElectrovibError):
    """A run on a bench that was stopped, with the instrument, the reason and the state in which the bench was left."""


class BenchStopped(BaseException):  # a signal, not a mistake: no handler of Exception may stop it
    """A signal that asks the process to end."""
