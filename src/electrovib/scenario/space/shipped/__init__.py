"""Populations that the package ships: one TOML file each, with sources."""

from __future__ import annotations

import functools
from importlib import resources
from typing import Any

from electrovib.core.parsing import read_toml


@functools.cache
def shipped_names() -> tuple[str, ...]:
    """List the names of the populations.

    Returns
    -------
    names : tuple of str
        In alphabetical order, as `electrovib.read_space` takes them.
    """
    files = resources.files(__name__).iterdir()
    return tuple(sorted(each.name.removesuffix(".toml") for each in files if each.name.endswith(".toml")))


def read_shipped(name: str) -> dict[str, Any]:
    """Return the tables of a population.

    Parameters
    ----------
    name : str
        One of `shipped_names`.

    Returns
    -------
    tables : dict
        As its TOML file has them.
    """
    text = (resources.files(__name__) / f"{name}.toml").read_text(encoding="utf-8")
    return read_toml(text)
