"""Scenario and space as TOML text that needs no other file."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from electrovib.core.own_models import origins
from electrovib.core.samples import Samples
from electrovib.scenario.space.origin import KEYS as ORIGIN_KEYS
from electrovib.scenario.toml import SCHEMA

if TYPE_CHECKING:
    from electrovib.scenario import Scenario
    from electrovib.scenario.space import Space


def scenario_text(scenario: Scenario) -> str:
    """Write a scenario as TOML, with the samples of measured series in the text."""
    import tomlkit

    content = {"schema": SCHEMA} | scenario.to_dict()
    return tomlkit.dumps(_plain(content))


def numbers_of(space: Space) -> str:
    """Write what the draws of a space depend on, without titles and sources, as JSON with sorted keys."""
    return json.dumps(_without_origins(_plain(space.as_table())), sort_keys=True)


def _without_origins(content: Any) -> Any:
    if not isinstance(content, Mapping):
        return content
    return {
        key: _without_origins(each) for key, each in content.items() if key not in {"title", *ORIGIN_KEYS}
    }


def own_model_files(scenario: Scenario) -> str:
    """List the files of models that are not part of electrovib, with their SHA-256, as JSON."""
    return json.dumps(origins(scenario), sort_keys=True)


def _plain(content: Any) -> Any:
    """Return tables, lists, texts and numbers alone; a value that is absent is omitted, which is how TOML writes it."""
    if isinstance(content, Samples):
        return _plain(content.packed())
    if isinstance(content, Mapping):
        return {str(key): _plain(value) for key, value in content.items() if value is not None}
    if isinstance(content, (list, tuple)):
        return [_plain(each) for each in content]
    return content
