"""What one step of each solver costs on one core of a common computer, measured through `electrovib.simulate`.

Estimates count in these, so that a scenario is refused or accepted alike on every machine. `benchmarks/` measures
them again.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Callable

SAMPLE: Final = 1e-6
"""Of an output time of a stack without relaxations [s]."""
SAMPLE_OF_MODE: Final = 3e-7
"""More for each relaxation [s]."""
AMPLITUDE_OF_MODE: Final = 3e-8
"""More for each relaxation of an amplitude of the force law alone [s]."""
CORNER: Final = 1e-6
"""Of a corner of the drive [s]."""
PIECE: Final = 2e-7
"""Of a piece in which a force is followed by filters, without the force [s]."""
BRISTLE_STEP: Final = 5e-6
"""Of Radau's method on bristles, compiled, with or without a skin [s]."""
SMOOTH_STEP: Final = 2e-5
"""Of the march beneath a drive that is a formula [s]."""
LIMIT_WINDOW: Final = 2e-3
"""Of a window of looks at an amplifier with limits beside its looks, and of the change it ends with [s]."""
CASE: Final = 5e-3
"""Of the simplest case of a sweep [s]."""
CASE_MEMORY: Final = 4e4
"""Of the scenario and the numbers of a case [bytes]."""

FEWER_SAMPLES: Final = "ask for fewer time.samples"
SHORTER: Final = "choose a shorter time.duration, a slower drive or one with fewer corners"
"""What makes a march shorter."""

NUMBERS_AT_STEP: Final = 14


@dataclass(frozen=True, kw_only=True)
class March:
    """What a solver that goes from step to step needs.

    Parameters
    ----------
    name : str
        What is marched, for people.
    step : callable
        Computing time of a step [s], of the number of modes.
    at_corner, in_cycle, for_sample : float
        Steps after a corner of the drive, in a cycle of what oscillates, and for an output time.
    numbers : int
        Held for each step.
    """

    name: str
    step: Callable[[int], float]
    at_corner: float
    in_cycle: float
    for_sample: float
    numbers: int = NUMBERS_AT_STEP


def leak_step(modes: int) -> float:
    """Time of a step of a leaking layer [s] in a stack of so many modes."""
    return 3e-5 + 1.5e-6 * modes


def limit_look(modes: int) -> float:
    """Time of a look at an amplifier with limits [s] before a stack of so many modes."""
    return 1e-7 + 6e-8 * modes


def gap_step(states: int) -> float:
    """Time of a step beneath a gap that is moved [s] with so many states: a matrix is solved in each."""
    return 2e-5 + 1e-8 * states**3


def radau_step(equations: int) -> float:
    """Time of a step of Radau's method [s] on so many equations."""
    return 4e-4 + 1e-4 * equations
