"""The fit of chosen parameters to a recording, with progress and cancel."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

from electrovib.apps.explorer.controls import controls
from electrovib.apps.explorer.limits import LARGEST_RUN, LONGEST_RUN
from electrovib.apps.explorer.runner import SERVER_ENDS, InterruptedWorkError, interruptible
from electrovib.core.budget import budget
from electrovib.core.errors import ElectrovibError, InputError

if TYPE_CHECKING:
    import xarray

    from electrovib.scenario import Scenario
    from electrovib.view.fitted import FitResult

MOST_FREE: Final = 6
"""Parameters that a page fits at once."""
LONGEST_FIT: Final = 120.0
"""Seconds after which a fit is ended."""
MOST_FITS: Final = 2
"""Fits of all visitors that run at the same time."""
_WITHOUT_EFFECT: Final = frozenset({"perception", "limits", "time", "frequency"})
"""Sections whose parameters change no signal."""
_FREE: Final = threading.BoundedSemaphore(MOST_FITS)


def fittable(scenario: Scenario) -> list[str]:
    """Return the paths of the parameters that a page offers to fit: those with a value that changes a signal."""
    return [each.path for each in controls(scenario) if each.section not in _WITHOUT_EFFECT]


@dataclass
class RunningFit:
    """A fit that runs in a thread, can be observed, and can be cancelled.

    `free` are the dotted paths of the unknown parameters; `evaluations` counts the predictions so far, and
    `squares` is the weighted sum of squares of the last one.
    """

    scenario: Scenario
    measured: xarray.Dataset
    free: Sequence[str]
    evaluations: int = 0
    squares: float = float("nan")
    _cancelled: threading.Event = field(default_factory=threading.Event)

    def __post_init__(self) -> None:
        """Refuse what a page does not fit."""
        if not 1 <= len(self.free) <= MOST_FREE:
            raise InputError(
                f"{len(self.free)} parameters are chosen; a page fits one to {MOST_FREE} at once."
            )

    @property
    def progress(self) -> str:
        """What is known while the fit runs, in words."""
        return f"{self.evaluations} evaluations, sum of squares {self.squares:.4g}"

    def cancel(self) -> None:
        """End the fit at its next evaluation."""
        self._cancelled.set()

    def run(self) -> FitResult:
        """Fit the parameters to the recording, as `electrovib.fit`.

        An error is raised if the fit was cancelled, takes too long, does not find the parameters, or would be
        one fit too many.
        """
        if not _FREE.acquire(blocking=False):
            raise InputError(
                f"{MOST_FITS} fits run on this server; start this one again when one of them has ended."
            )
        try:
            return self._fit()
        finally:
            _FREE.release()

    def _fit(self) -> FitResult:
        from time import monotonic

        from electrovib.apps.fit import fit

        end = monotonic() + LONGEST_FIT

        def is_over() -> bool:
            return self._cancelled.is_set() or SERVER_ENDS.is_set() or monotonic() > end

        def progress(evaluations: int, squares: float) -> bool:
            self.evaluations, self.squares = evaluations, squares
            return is_over()

        with budget(time=LONGEST_RUN, memory=LARGEST_RUN):
            try:
                with interruptible(is_over):
                    return fit(self.scenario, self.measured, free=self.free, progress=progress)
            except (ElectrovibError, InterruptedWorkError):
                if self._cancelled.is_set():
                    raise InputError("The fit was cancelled.") from None
                if is_over():
                    raise InputError(
                        f"The fit was ended after {LONGEST_FIT:g} s; free fewer parameters."
                    ) from None
                raise
