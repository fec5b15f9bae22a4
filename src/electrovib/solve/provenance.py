"""What a Trace says of its own making: the scenario, its hash and the version."""

from __future__ import annotations

import contextlib
import functools
import json
from importlib.metadata import version
from typing import TYPE_CHECKING, Any, Final

from electrovib.core.model import Model
from electrovib.core.own_models import ATTRIBUTE as OWN_MODELS
from electrovib.core.own_models import origins
from electrovib.scenario import Scenario

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator


_MANY: Final = 100_000
"""Times from which on a record takes longer to be written and hashed than a thread to begin."""


def provenance(scenario: Scenario) -> dict[str, Any]:
    """Say what was computed, and by which version."""
    stated = {
        "title": scenario.title,
        "electrovib": _version(),
        "scenario": scenario.to_json(),
        "scenario_hash": scenario.digest(),
        "dropped_samples": _dropped(scenario.drive),
    }
    others = origins(scenario)
    return stated | {OWN_MODELS: json.dumps(others)} if others else stated


@contextlib.contextmanager
def beside(count: int, work: Callable[[], dict[str, Any]]) -> Iterator[Callable[[], dict[str, Any]]]:
    """Let a second thread do some work beside a run of very many times.

    Parameters
    ----------
    count : int
        Output times of the run.
    work : callable
        What to do.

    Yields
    ------
    callable
        Waits for the result, and gives it.
    """
    if count < _MANY:
        yield work
        return
    from concurrent.futures import ThreadPoolExecutor

    with ThreadPoolExecutor(max_workers=1) as pool:
        yield pool.submit(work).result


@functools.cache
def _version() -> str:
    return version("electrovib")


def _dropped(model: Model) -> int:
    """Count the samples that measured drives inside a drive have dropped."""
    inner = [item for _, value in model for item in (value if isinstance(value, tuple) else (value,))]
    return getattr(model, "dropped", 0) + sum(_dropped(each) for each in inner if isinstance(each, Model))
