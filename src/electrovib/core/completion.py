"""Names that completion lists for a model."""

from __future__ import annotations

import functools
import inspect
from typing import Final

from pydantic import BaseModel

ABOUT: Final = frozenset({"equation", "reference", "status"})
"""Attributes of a class that are listed beside its parameters, if they are not empty."""


@functools.cache
def hidden_names(base: type[BaseModel]) -> frozenset[str]:
    """Return the names that a base class of models has for its subclasses, and not for the user of a model."""
    return frozenset(
        name
        for name in dir(base)
        if name in dir(BaseModel)
        or not callable(getattr(base, name))
        or isinstance(inspect.getattr_static(base, name), classmethod)
    )
