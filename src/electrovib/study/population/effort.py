"""Computing time and memory of a study, estimated before it begins."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from electrovib.core.budget import Work, refuse_beyond
from electrovib.solve.costs import CASE
from electrovib.solve.effort import works
from electrovib.study.population.declared import BLOCK

if TYPE_CHECKING:
    from electrovib.study.population.tile import Evaluator

_STREAMED: Final = 1e-8
"""A sample of a finger whose signals are not stored, with its statistics, in arrays over fingers [s]."""
_IN_ARRAYS: Final = 3e-8
"""A sample of a finger in arrays, with its statistics [s]."""
_WORKER: Final = 4.0
"""Computing time until a worker process has started [s]."""
_WORKER_MEMORY: Final = 2.5e8
"""Memory of a worker process [bytes]."""


def refuse_large(evaluator: Evaluator, workers: int) -> None:
    """Refuse a study that would exceed the budget, before anything is written or started."""
    fingers = evaluator.declared.fingers
    each = (_STREAMED if evaluator.streamed else _IN_ARRAYS) * evaluator.numbers
    if not evaluator.in_arrays:
        axis = evaluator.axis if evaluator.declared.axis == "time" else None
        each = CASE + sum(work.time for work in works(evaluator.declared.scenario, axis))
    refuse_beyond(
        [
            Work(
                what=f"{fingers:.3g} fingers",
                time=fingers * each,
                memory=16.0 * min(BLOCK, fingers) * evaluator.numbers,
                remedy="draw fewer fingers",
            ),
            Work(
                what=f"{workers} workers",
                time=workers * _WORKER,
                memory=workers * _WORKER_MEMORY,
                remedy="start fewer workers",
            ),
        ],
        what="this study",
    )
