"""Instances that are not changed in place."""

from __future__ import annotations

from typing import Any, NoReturn

from pydantic import BaseModel

from electrovib.core.errors import InputError

_COPY = 'replace returns a changed copy, as in scenario.replace({"drive.high": "150 V"})'


class Immutable(BaseModel):
    """A pydantic model that refuses assignments to its instances and names the call that returns a changed copy."""

    def __setattr__(self, name: str, value: Any) -> NoReturn:
        """Refuse an assignment."""
        raise InputError(f"{type(self).__name__}.{name}: is not changed in place; {_COPY}")

    def __delattr__(self, name: str) -> NoReturn:
        """Refuse a deletion."""
        raise InputError(f"{type(self).__name__}.{name}: is not deleted in place; {_COPY}")
