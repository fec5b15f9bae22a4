"""Electrovibration: the force between a finger and a charged plate, from drive voltage to friction.

Public names are loaded on first use, so that ``import electrovib`` takes no time; ``__init__.pyi`` lists them.
"""

from __future__ import annotations

import importlib
import re
import sys
from typing import Any

with open(f"{__file__}i", encoding="utf-8") as _list:  # noqa: PTH123 - pathlib takes longer than the rest of this import
    _PLACES = {
        name: (module, own)
        for module, own, name in re.findall(r"^from (\S+) import (\w+) as (\w+)$", _list.read(), re.MULTILINE)
    }


def __getattr__(name: str) -> Any:
    if name == "__version__":
        from importlib.metadata import version

        return version("electrovib")
    if name not in _PLACES:
        from electrovib.core.deprecation import FORMER

        if name not in FORMER:
            raise AttributeError(f"module 'electrovib' has no attribute '{name}'")
        name = FORMER[name].warn(f"electrovib.{name}")
    module, own = _PLACES[name]
    if name == "plot":
        return importlib.import_module(f"{module}.{own}")
    found = getattr(importlib.import_module(module), own)
    if isinstance(found, type):
        return found
    from electrovib.apps.calls import public

    return public(found, name)


def __dir__() -> list[str]:
    return sorted([*_PLACES, "__version__"])


if "IPython" in sys.modules:  # a notebook or an IPython terminal: results show themselves there
    importlib.import_module("electrovib.view.notebook").register()
