"""Populations that the package ships: one TOML file each, with sources."""

from __future__ import annotations

import functools
from importlib import resources
from typing import Any

from electrovib.core.parsing import read_toml


@functools.cache
def shipped_names() -> tuple[str, ...]:
    """List the names of the populations."""
    files = resources.files(__name__).iterdir()
    return tuple(sorted(each.name.removesuffix(".toml") for each in files if each.name.endswith(".toml")))


def read_shipped(name: str) -> dict[str, Any]:
    """Return the tables of a population."""
    text = (resources.files(__name__) / f"{name}.toml").read_text(encoding="utf-8")
    return read_toml(text)
