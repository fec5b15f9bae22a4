"""Provenance of a Trace: scenario, hash and version."""

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
"""Number of times above which writing and hashing a record take longer than starting a thread."""


def provenance(scenario: Scenario) -> dict[str, Any]:
    """Return what was computed, and by which version."""
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
    """Run some work in a second thread during a run of very many times."""
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
    """Return the number of samples that were dropped from the measured drives in a drive."""
    inner = [item for _, value in model for item in (value if isinstance(value, tuple) else (value,))]
    return getattr(model, "dropped", 0) + sum(_dropped(each) for each in inner if isinstance(each, Model))
