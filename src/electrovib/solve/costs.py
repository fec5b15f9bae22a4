"""Computing time of one step of each solver on one core of a common computer, measured through `electrovib.simulate`.

Estimates use these values, so that a scenario is refused or accepted alike on every machine. `benchmarks/` measures
them again.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Callable

SAMPLE: Final = 1e-6
"""An output time of a stack without relaxations [s]."""
SAMPLE_OF_MODE: Final = 3e-7
"""Added for each relaxation [s]."""
AMPLITUDE_OF_MODE: Final = 3e-8
"""Added for each relaxation that only an amplitude of the force law has [s]."""
CORNER: Final = 1e-6
"""A corner of the drive [s]."""
PIECE: Final = 2e-7
"""A piece of time of filters behind a force, without the computation of the force [s]."""
BRISTLE_STEP: Final = 5e-6
"""A compiled step of Radau's method for bristles, with or without a skin [s]."""
SMOOTH_STEP: Final = 2e-5
"""A step through a drive that is a formula [s]."""
LIMIT_WINDOW: Final = 2e-3
"""A window of evaluation times of an amplifier with limits, apart from these times, and the change at its end [s]."""
CASE: Final = 5e-3
"""The simplest case of a sweep [s]."""
CASE_MEMORY: Final = 4e4
"""Scenario and numbers of a case [bytes]."""

FEWER_SAMPLES: Final = "ask for fewer time.samples"
SHORTER: Final = "choose a shorter time.duration, a slower drive or one with fewer corners"
"""Remedy for a run with too many steps."""

NUMBERS_AT_STEP: Final = 14


@dataclass(frozen=True, kw_only=True)
class March:
    """Cost of a time-stepping solver.

    Parameters
    ----------
    name : str
        What is stepped, as messages name it.
    step : callable
        Computing time of a step [s] as a function of the number of modes.
    at_corner, in_cycle, for_sample : float
        Number of steps after a corner of the drive, in a cycle of an oscillation, and for an output time.
    numbers : int
        Numbers stored for each step.
    """

    name: str
    step: Callable[[int], float]
    at_corner: float
    in_cycle: float
    for_sample: float
    numbers: int = NUMBERS_AT_STEP


def leak_step(modes: int) -> float:
    """Return the computing time of a step of a leaking layer in a stack of so many modes [s]."""
    return 3e-5 + 1.5e-6 * modes


def limit_look(modes: int) -> float:
    """Return the computing time of an evaluation of an amplifier with limits before a stack of so many modes [s]."""
    return 1e-7 + 6e-8 * modes


def gap_step(states: int) -> float:
    """Return the computing time of a step with a moving gap and so many states [s]: each step solves a matrix."""
    return 2e-5 + 1e-8 * states**3


def radau_step(equations: int) -> float:
    """Return the computing time of a step of Radau's method for so many equations [s]."""
    return 4e-4 + 1e-4 * equations
