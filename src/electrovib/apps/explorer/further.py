"""What a page shows beside the Trace, computed in slices: a band of fingers, other laws, what is felt, limits."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Final

from electrovib.apps.explorer.computed import Computed, compute
from electrovib.apps.explorer.limits import FINGERS
from electrovib.core.discovery import find_members
from electrovib.core.errors import ElectrovibError
from electrovib.physics.force import ForceLaw

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from electrovib.study.check.result import CheckResult
    from electrovib.study.percept import Percept

TIME, FREQUENCY, LAWS, FELT, SAFETY, RECORDING = TABS = (
    "Over time",
    "Over frequency",
    "Force laws",
    "Felt",
    "Safety",
    "Recording",
)
POPULATION: Final = "fingers"
SEED: Final = 1
"""Of the draws from the population: the same fingers at every position of a slider, so that the band moves smoothly."""


@dataclass(frozen=True)
class Further:
    """Results beside the Trace; each is None, or empty, until it is computed.

    Parameters
    ----------
    band : mapping of str to ndarray, optional
        ``frequency`` [Hz], ``low``, ``middle``, ``high`` [N]: 5, 50 and 95 % of the fingers of a population, each shape (n,).
    laws : mapping of str to Computed
        Other force laws on the same finger and plate, by name.
    left_out : mapping of str to str
        Laws that cannot run here, with the reason.
    percept : Percept, optional
        What is felt.
    check : CheckResult, optional
        Comparison with limits.
    problems : tuple of str
        Sentences on what could not be computed.
    """

    band: Mapping[str, NDArray[Any]] | None = None
    laws: Mapping[str, Computed] = field(default_factory=dict)
    left_out: Mapping[str, str] = field(default_factory=dict)
    percept: Percept | None = None
    check: CheckResult | None = None
    problems: tuple[str, ...] = ()


Slice = Callable[[Further], Further]


def slices(tab: str, found: Computed) -> Iterator[Slice]:
    """Return the pieces of work that a tab needs beside the Trace, each short.

    Parameters
    ----------
    tab : str
        One of `TABS`.
    found : Computed
        Scenario with its Trace.

    Yields
    ------
    callable
        Takes what is known so far and returns it with one more result. A mistake becomes a sentence in `problems`.
    """
    if tab == FREQUENCY:
        yield _guarded(lambda known: replace(known, band=_band(found)), "The band of fingers")
    elif tab == LAWS:
        for name in find_members(ForceLaw):
            if name != type(found.scenario.force).__name__:
                yield functools.partial(_with_law, found=found, name=name)
    elif tab == FELT:
        yield _guarded(lambda known: replace(known, percept=_percept(found)), "What is felt")
    elif tab == SAFETY:
        yield _guarded(lambda known: replace(known, check=_check(found)), "The comparison with limits")


def _guarded(slice_: Slice, what: str) -> Slice:
    def guarded(known: Further) -> Further:
        try:
            return slice_(known)
        except ElectrovibError as error:
            return replace(known, problems=(*known.problems, f"{what} is not shown: {error}"))

    return guarded


def _band(found: Computed) -> dict[str, NDArray[Any]]:
    from electrovib.study.population import study

    bands = study(found.scenario, POPULATION, n=FINGERS, seed=SEED, signal="mean_force")
    low, middle, high = (bands["mean_force_percentile"].sel(percentile=each).values for each in (5, 50, 95))
    return {"frequency": bands["frequency"].values, "low": low, "middle": middle, "high": high}


def _with_law(known: Further, *, found: Computed, name: str) -> Further:
    try:
        case = compute(found.scenario.replace({"force": {"model": name}}))
    except ElectrovibError as error:
        return replace(known, left_out={**known.left_out, name: str(error)})
    return replace(known, laws={**known.laws, name: case})


def _percept(found: Computed) -> Percept:
    from electrovib.study.perceive import perceive

    return perceive(found.scenario)


def _check(found: Computed) -> CheckResult:
    from electrovib.study.check import check

    return check(found.scenario)
